// SPDX-License-Identifier: Apache-2.0
// glTF files that are broken, hostile or merely odd: each is one clear line, never a crash, never half a scene.
#include <gmock/gmock.h>

#include <limits>
#include <raytracer/gltf_loader.hpp>
#include <triad/base/error.hpp>

#include "gltf_files.hpp"
#include "picture_files.hpp"

using namespace triad::raytracer;
using gltf_files::Gltf;
using gltf_files::json;
using gltf_files::triangle;
using testing::HasSubstr;
using testing::Not;

namespace {

// The error of loading these bytes, "" for none; checks that it is one line that names the file.
std::string error_of_bytes(const std::string& bytes, Scene* scene = nullptr) {
  static const picture_files::Folder folder;
  const std::string path = folder / "bad.gltf";
  picture_files::put_bytes(path, bytes);
  try {
    Scene loaded = load_gltf(path);
    if (scene) *scene = std::move(loaded);
    return "";
  } catch (const triad::Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.kind(), triad::ErrorKind::kInput);
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_THAT(message, HasSubstr("'" + path));
    EXPECT_NE(message.back(), '.') << message;
    return message;
  }
}
std::string error_of(const Gltf& gltf) { return error_of_bytes(gltf.text()); }

std::string warnings_of(const Gltf& gltf) {
  Scene scene;
  EXPECT_EQ(error_of_bytes(gltf.text(), &scene), "");
  std::string text;
  for (const auto& warning : scene.warnings) text += warning + "\n";
  return text;
}

TEST(GltfErrors, EveryTruncationOfTheTextIsAnError) {
  const std::string text = triangle().text();
  for (size_t size = 0; size < text.size(); ++size)
    EXPECT_NE(error_of_bytes(text.substr(0, size)), "") << size << " bytes";
}

TEST(GltfErrors, EveryTruncationOfTheBinaryIsAnError) {
  const std::string bytes = triangle().glb();
  for (size_t size = 0; size < bytes.size(); ++size)
    EXPECT_NE(error_of_bytes(bytes.substr(0, size)), "") << size << " bytes";
  EXPECT_THAT(error_of_bytes(bytes.substr(0, bytes.size() - 1)), HasSubstr("cut short"));
}

TEST(GltfErrors, EveryChangedByteIsASceneOrAnError) {
  const std::string text = triangle().text(), binary = triangle().glb();
  for (const std::string& whole : {text, binary})
    for (size_t i = 0; i < whole.size(); ++i) {
      std::string bytes = whole;
      bytes[i] =
          "\0"
          "9\xff"[i % 3];
      Scene scene;
      if (error_of_bytes(bytes, &scene).empty()) {
        EXPECT_GT(scene.triangle_count(), 0u);
      }
    }
}

TEST(GltfErrors, NotASceneAtAll) {
  EXPECT_THAT(error_of_bytes("[]"), HasSubstr("not valid glTF"));
  EXPECT_THAT(error_of_bytes("hello, this is not a scene"), HasSubstr("not valid glTF"));
  EXPECT_THAT(error_of_bytes(""), HasSubstr("empty"));
  EXPECT_THROW(load_gltf("/nonexistent/scene.gltf"), triad::Error);
  Gltf one = triangle();
  one.root["asset"]["version"] = "1.0";
  EXPECT_THAT(error_of(one), HasSubstr("version '1.0'"));
  EXPECT_THAT(error_of_bytes(R"({"asset":{"version":"2.0"}})"), HasSubstr("no triangles"));
}

TEST(GltfErrors, MessagesStayShort) {
  Gltf gltf = triangle();  // what the parser quotes in full
  gltf.root["buffers"] = json::array(
      {{{"byteLength", 36}, {"uri", "data:application/octet-stream;base64," + std::string(1000000, 'A')}}});
  const std::string message = error_of(gltf);
  EXPECT_THAT(message, HasSubstr("data:application"));
  EXPECT_LT(message.size(), 600u);
}

TEST(GltfErrors, DeepNestingIsRefused) {
  const std::string deep(100000, '['), close(100000, ']');
  EXPECT_THAT(error_of_bytes(R"({"asset":{"version":"2.0"},"extras":)" + deep + close + "}"), HasSubstr("nested"));
}

TEST(GltfErrors, UnknownRequiredExtensionsAreNamed) {
  Gltf gltf = triangle();
  gltf.root["extensionsRequired"] = {"KHR_texture_transform", "KHR_draco_mesh_compression"};
  EXPECT_THAT(error_of(gltf), HasSubstr("requires the extension 'KHR_draco_mesh_compression'"));
  gltf.root["extensionsRequired"] = {"KHR_texture_transform"};
  EXPECT_EQ(error_of(gltf), "");
}

TEST(GltfErrors, AccessorsOutOfBounds) {
  Gltf gltf = triangle();
  auto& accessor = gltf.root["accessors"][0];
  accessor["count"] = 4;
  EXPECT_THAT(error_of(gltf), HasSubstr("POSITION of mesh 0 'leaf' is out of bounds: it needs 48 bytes"));
  accessor["count"] = 3;
  accessor["byteOffset"] = 1;
  EXPECT_THAT(error_of(gltf), HasSubstr("out of bounds"));
  accessor.erase("byteOffset");
  gltf.root["bufferViews"][0]["byteLength"] = 40;
  EXPECT_THAT(error_of(gltf), HasSubstr("out of bounds"));
  gltf.root["bufferViews"][0]["byteLength"] = 36;
  gltf.root["bufferViews"][0]["byteOffset"] = 4;
  EXPECT_THAT(error_of(gltf), HasSubstr("out of bounds"));
  gltf.root["bufferViews"][0]["byteOffset"] = 0;
  gltf.root["bufferViews"][0]["byteStride"] = 24;
  EXPECT_THAT(error_of(gltf), HasSubstr("out of bounds"));
}

TEST(GltfErrors, SizesThatOverflowAreRefusedBeforeMemoryIsTaken) {
  for (const uint64_t count : {uint64_t{1} << 31, uint64_t{1} << 33, uint64_t{1} << 62, ~uint64_t{0}}) {
    Gltf gltf = triangle();
    gltf.root["accessors"][0]["count"] = count;
    EXPECT_NE(error_of(gltf), "") << count;
    gltf.root["accessors"][0].erase("bufferView");  // zeros, which cost the file nothing
    EXPECT_NE(error_of(gltf), "") << count;
    gltf = triangle();
    gltf.root["bufferViews"][0]["byteOffset"] = count;
    EXPECT_NE(error_of(gltf), "") << count;
    gltf = triangle();
    gltf.root["accessors"][0]["byteOffset"] = count;
    EXPECT_NE(error_of(gltf), "") << count;
  }
  // Half a billion vertices by instancing a mesh of zeros.
  Gltf many = triangle();
  many.root["accessors"][0] = {{"componentType", 5126}, {"count", (1 << 20) - 1}, {"type", "VEC3"}};
  for (int i = 0; i < 512; ++i) many.node({{"mesh", 0}});
  EXPECT_THAT(error_of(many), HasSubstr("vertices"));
}

TEST(GltfErrors, IndicesPastTheEnd) {
  Gltf gltf = triangle();
  gltf.root["meshes"][0]["primitives"][0]["indices"] = gltf.accessor<uint16_t>({0, 1, 3}, 1);
  EXPECT_THAT(error_of(gltf), HasSubstr("entry 2 is 3, past the end (3 elements)"));
  gltf.root["meshes"][0]["primitives"][0]["indices"] = gltf.accessor<uint16_t>({0, 1, 2, 0}, 1);
  EXPECT_THAT(error_of(gltf), HasSubstr("4 vertices do not make whole triangles"));
  gltf.root["meshes"][0]["primitives"][0]["indices"] = gltf.accessor<float>({0, 1, 2}, 1);
  EXPECT_THAT(error_of(gltf), HasSubstr("unsigned integers"));
}

TEST(GltfErrors, ReferencesToWhatIsNotThere) {
  const auto broken = [](const json::json_pointer& where, const json& value) {
    Gltf gltf = triangle();
    gltf.root[where] = value;
    return error_of(gltf);
  };
  using Pointer = json::json_pointer;
  EXPECT_THAT(broken(Pointer("/nodes/0/mesh"), 7), HasSubstr("node 0 'leaf' refers to mesh 7"));
  EXPECT_THAT(broken(Pointer("/nodes/0/mesh"), -2), HasSubstr("mesh -2"));
  EXPECT_THAT(broken(Pointer("/nodes/1/camera"), -2), HasSubstr("camera -2"));
  EXPECT_THAT(broken(Pointer("/meshes/0/primitives/0/material"), -2), HasSubstr("material -2"));
  EXPECT_THAT(broken(Pointer("/meshes/0/primitives/0/indices"), -2), HasSubstr("accessor -2"));
  EXPECT_THAT(broken(Pointer("/materials/0/emissiveTexture"), {{"index", -2}}), HasSubstr("texture -2"));
  EXPECT_THAT(broken(Pointer("/nodes/1/camera"), 1), HasSubstr("refers to camera 1, but there is only number 0"));
  EXPECT_THAT(broken(Pointer("/nodes/0/children"), {9}), HasSubstr("node 9"));
  EXPECT_THAT(broken(Pointer("/scene"), 3), HasSubstr("scene 3"));
  EXPECT_THAT(broken(Pointer("/meshes/0/primitives/0/material"), 5), HasSubstr("material 5"));
  EXPECT_THAT(broken(Pointer("/meshes/0/primitives/0/attributes/POSITION"), 5), HasSubstr("accessor 5"));
  EXPECT_THAT(broken(Pointer("/meshes/0/primitives/0/attributes/NORMAL"), -3), HasSubstr("accessor -3"));
  EXPECT_THAT(broken(Pointer("/accessors/0/bufferView"), 5), HasSubstr("buffer view 5"));
  EXPECT_THAT(broken(Pointer("/bufferViews/0/buffer"), 5), HasSubstr("buffer 5"));
  EXPECT_THAT(broken(Pointer("/materials/0/emissiveTexture"), {{"index", 2}}), HasSubstr("texture 2"));
  EXPECT_THAT(broken(Pointer("/nodes/0/extensions/KHR_lights_punctual/light"), 0), HasSubstr("light 0"));
  for (const double number : {.5, 1e300, -1e10})
    EXPECT_THAT(broken(Pointer("/nodes/0/extensions/KHR_lights_punctual/light"), number), HasSubstr("'light'"));
  EXPECT_THAT(broken(Pointer("/materials/0/extensions/KHR_materials_transmission/transmissionTexture/index"), 1e40),
              HasSubstr("'index'"));
}

TEST(GltfErrors, NumbersThatAreNotFinite) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  for (const float bad : {kNan, kInf, -kInf}) {
    Gltf gltf = triangle();
    gltf.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
        gltf.accessor<float>({0, 0, 0, 1, bad, 0, 0, 1, 0}, 3);
    EXPECT_THAT(error_of(gltf), HasSubstr("POSITION of mesh 0 'leaf' is not finite: element 1"));
  }
  Gltf far = triangle();  // finite as they are, not once they are multiplied
  far.root["nodes"][0]["scale"] = {1e200, 1e200, 1e200};
  const int parent = far.push("nodes", {{"children", {0}}, {"scale", {1e200, 1, 1}}});
  far.root["scenes"][0]["nodes"] = {parent};
  EXPECT_THAT(error_of(far), HasSubstr("not finite"));
  Gltf wide = triangle();  // fits a double, not a float
  wide.root["nodes"][0]["scale"] = {1e60, 1e60, 1e60};
  EXPECT_NE(error_of(wide), "");
}

TEST(GltfErrors, MissingOrBrokenPictures) {
  Gltf gltf = triangle();
  gltf.push("images", {{"uri", "nowhere.png"}});
  gltf.push("textures", {{"source", 0}});
  EXPECT_EQ(error_of(gltf), "") << "nobody uses it";
  gltf.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
  EXPECT_THAT(error_of(gltf), HasSubstr("nowhere.png"));
  gltf.root["images"][0]["uri"] = "data:image/png;base64," + gltf_files::base64("\x89PNG\r\n\x1a\n and nothing more");
  EXPECT_THAT(error_of(gltf), HasSubstr("image 0 cannot be decoded"));
  gltf.root["images"][0] = {{"bufferView", 0}, {"mimeType", "image/png"}, {"name", "wood"}};
  EXPECT_THAT(error_of(gltf), HasSubstr("image 0 'wood' cannot be decoded"));
  gltf.root["bufferViews"][0]["byteOffset"] = 1 << 20;
  EXPECT_THAT(error_of(gltf), HasSubstr("out of bounds"));
  Gltf buffer = triangle();
  buffer.root["buffers"] = json::array({{{"byteLength", 36}, {"uri", "nowhere.bin"}}});
  EXPECT_THAT(error_of(buffer), HasSubstr("nowhere.bin"));
}

TEST(GltfErrors, MeshesWithoutAreaAreLeftOut) {
  Gltf gltf = triangle();
  EXPECT_THAT(warnings_of(gltf), Not(HasSubstr("no area")));
  const int line = gltf.accessor<float>({0, 0, 0, 1, 1, 1, 2, 2, 2}, 3);
  gltf.push("meshes", {{"name", "line"}, {"primitives", {{{"attributes", {{"POSITION", line}}}}}}});
  gltf.node({{"mesh", 1}});
  EXPECT_THAT(warnings_of(gltf), HasSubstr("mesh 1 'line' has no area; it is left out"));
  gltf.root["scenes"][0]["nodes"] = {2};
  EXPECT_THAT(error_of(gltf), HasSubstr("none has an area"));
}

TEST(GltfErrors, SingularMatrices) {
  Gltf gltf = triangle();
  gltf.root["nodes"][0]["scale"] = {1, 1, 0};  // flattens what is flat already
  EXPECT_THAT(warnings_of(gltf), HasSubstr("node 0 'leaf' has a singular matrix"));
  gltf.root["nodes"][0]["scale"] = {0, 0, 0};
  EXPECT_THAT(error_of(gltf), HasSubstr("none has an area"));
  gltf = triangle();
  gltf.root["nodes"][1]["scale"] = {1, 0, 1};
  EXPECT_THAT(error_of(gltf), HasSubstr("the camera of node 1 'eye' has a singular matrix"));
  gltf = triangle();
  gltf.root["nodes"][0]["rotation"] = {0, 0, 0, 0};
  EXPECT_THAT(error_of(gltf), HasSubstr("rotation of length 0"));
  gltf.root["nodes"][0]["rotation"] = {0, 0, 1};
  EXPECT_THAT(error_of(gltf), HasSubstr("rotation of 3 numbers"));
}

TEST(GltfErrors, NodesThatAreNoTree) {
  Gltf cycle = triangle();
  cycle.root["nodes"][0]["children"] = {2};
  cycle.push("nodes", {{"children", {0}}});
  EXPECT_THAT(error_of(cycle), HasSubstr("is its own ancestor"));
  Gltf self = triangle();
  self.root["nodes"][0]["children"] = {0};
  EXPECT_THAT(error_of(self), HasSubstr("is its own ancestor"));
  Gltf twice = triangle();
  twice.push("nodes", {{"children", {0}}});
  twice.root["scenes"][0]["nodes"] = {2, 0};
  EXPECT_THAT(error_of(twice), HasSubstr("has two parents"));
}

TEST(GltfErrors, ALongChainOfNodesIsFine) {
  Gltf gltf = triangle();
  constexpr int kLength = 20000;
  for (int i = 0; i < kLength; ++i) gltf.push("nodes", {{"children", {i == 0 ? 0 : i + 1}}});
  gltf.root["scenes"][0]["nodes"] = {kLength + 1, 1};
  EXPECT_EQ(error_of(gltf), "");
}

TEST(GltfErrors, Animations) {
  const auto animated = [](const std::vector<float>& times, const std::vector<float>& values, const json& sampler) {
    Gltf gltf = triangle();
    json whole = {{"input", gltf.accessor(times, 1)}, {"output", gltf.accessor(values, 3)}};
    whole.update(sampler);
    gltf.push("animations", {{"samplers", {whole}},
                             {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}});
    return error_of(gltf);
  };
  EXPECT_EQ(animated({0, 1}, {0, 0, 0, 1, 1, 1}, json::object()), "");
  EXPECT_THAT(animated({1, 1}, {0, 0, 0, 1, 1, 1}, json::object()), HasSubstr("do not increase"));
  EXPECT_THAT(animated({0, 1}, {0, 0, 0}, json::object()), HasSubstr("2 times but values for 1"));
  EXPECT_THAT(animated({0, 1}, {0, 0, 0, 1, 1, 1}, {{"interpolation", "WAVY"}}), HasSubstr("'WAVY'"));
  EXPECT_THAT(animated({0, 1}, {0, 0, 0, 1, 1, 1}, {{"input", 99}}), HasSubstr("accessor 99"));
}

TEST(GltfErrors, CamerasLightsAndExtras) {
  const auto broken = [](const char* where, const json& value) {
    Gltf gltf = triangle();
    gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}, {"spot", json::object()}}};
    gltf.root["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    gltf.root[json::json_pointer(where)] = value;
    return error_of(gltf);
  };
  EXPECT_EQ(broken("/extras", 1), "");
  EXPECT_THAT(broken("/cameras/0/perspective/yfov", 4), HasSubstr("yfov"));
  EXPECT_THAT(broken("/cameras/0/extras", {{"aperture_radius_m", -1}}), HasSubstr("aperture_radius_m below 0"));
  EXPECT_THAT(broken("/cameras/0/extras", {{"focus_distance_m", 0}}), HasSubstr("focus_distance_m"));
  EXPECT_THAT(broken("/cameras/0/extras", {{"shutter_s", "long"}}), HasSubstr("'shutter_s'"));
  EXPECT_THAT(broken("/cameras/0/extras", {{"shutter_s", {2, 1}}}), HasSubstr("closes before it opens"));
  EXPECT_THAT(broken("/scenes/0/extras", {{"background", "blue"}}), HasSubstr("'background'"));
  EXPECT_THAT(broken("/scenes/0/extras", {{"background", {1, 1, -1}}}), HasSubstr("below 0"));
  EXPECT_THAT(broken("/scenes/0/extras", {{"environment", "nowhere.exr"}}), HasSubstr("nowhere.exr"));
  EXPECT_THAT(broken("/extensions/KHR_lights_punctual/lights/0/type", "laser"), HasSubstr("'laser'"));
  EXPECT_THAT(broken("/extensions/KHR_lights_punctual/lights/0/spot", {{"innerConeAngle", 1}}), HasSubstr("cone"));
  EXPECT_THAT(broken("/extensions/KHR_lights_punctual/lights/0/intensity", -1), HasSubstr("intensity"));
}

// What lies beyond these would end the program inside Embree, which asserts that coordinates stay below 1.8e18.
TEST(GltfErrors, PlacesTooFarForAFloat) {
  const auto broken = [](const char* where, const json& value) {
    Gltf gltf = triangle();
    gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
    gltf.node({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    gltf.root[json::json_pointer(where)] = value;
    return error_of(gltf);
  };
  EXPECT_THAT(broken("/nodes/1/translation", {1.8e19, 0, 5}), HasSubstr("the camera of node 1 'eye'"));
  EXPECT_THAT(broken("/nodes/2/translation", {0, -1e16, 0}), HasSubstr("node 2 has a place more than 1e15 m"));
  EXPECT_THAT(broken("/nodes/0/scale", {1e16, 1, 1}), HasSubstr("1e+16 m across; at most 1e15 m"));
  EXPECT_THAT(broken("/cameras/0/extras", {{"aperture_radius_m", 1e10}}), HasSubstr("aperture_radius_m"));
  EXPECT_THAT(broken("/cameras/0/extras", {{"focus_distance_m", 1e16}}), HasSubstr("focus_distance_m"));
  EXPECT_THAT(broken("/cameras/0/extras", {{"focus_distance_m", 1e-200}}), HasSubstr("focus_distance_m"));
  const json view = {{"xmag", 1}, {"ymag", 1e10}, {"znear", .1}, {"zfar", 9}};
  EXPECT_THAT(broken("/cameras/0", {{"type", "orthographic"}, {"orthographic", view}}), HasSubstr("ymag"));
  EXPECT_EQ(broken("/nodes/0/scale", {1e14, 1, 1}), "");
}

// Half way between two opposite directions there is none to look along.
TEST(GltfErrors, CamerasThatTurnHalfRoundBetweenTwoInstants) {
  const auto turning = [](int half_turns) {
    Gltf gltf = triangle();
    std::vector<float> times, turns;
    for (int i = 0; i <= half_turns; ++i) {
      times.push_back(static_cast<float>(i) / static_cast<float>(half_turns));
      const std::vector<float> turn =
          i % 2 == 0 ? std::vector<float>{0, 0, 0, 1} : std::vector<float>{0, 1, 0, 0};  // about y
      turns.insert(turns.end(), turn.begin(), turn.end());
    }
    const json sampler = {{"input", gltf.accessor(times, 1)}, {"output", gltf.accessor(turns, 4)}};
    gltf.push("animations", {{"samplers", {sampler}},
                             {"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "rotation"}}}}}}});
    gltf.root["cameras"][0]["extras"]["shutter_s"] = {0, 1};
    return error_of(gltf);
  };
  EXPECT_EQ(turning(4), "");
  EXPECT_THAT(turning(64), HasSubstr("the camera of node 1 'eye' turns too fast"));
}

TEST(GltfErrors, MaterialValuesOutOfRangeAreClampedAndSaid) {
  Gltf gltf = triangle();
  gltf.root["materials"][0]["pbrMetallicRoughness"] = {{"metallicFactor", 3}, {"baseColorFactor", {2, 1, 1, 1}}};
  const std::string warnings = warnings_of(gltf);
  EXPECT_THAT(warnings, HasSubstr("metallicFactor of material 0 'paper' is 3; 1 is used"));
  EXPECT_THAT(warnings, HasSubstr("baseColorFactor of material 0 'paper' is 2; 1 is used"));
  gltf.root["materials"][0]["alphaMode"] = "GLOW";
  EXPECT_THAT(error_of(gltf), HasSubstr("'GLOW'"));
}

}  // namespace
