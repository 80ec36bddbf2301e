// SPDX-License-Identifier: Apache-2.0
// load_scene_seeds FOLDER: small scenes for load_scene_fuzz to begin with, one for each thing that the loader knows,
// as .gltf and as .glb, and the smaller bundled ones.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "gltf_files.hpp"
#include "scene_files.hpp"

namespace {

using gltf_files::Gltf;
using gltf_files::json;
using gltf_files::triangle;

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

json& attributes(Gltf& gltf) { return gltf.root["meshes"][0]["primitives"][0]["attributes"]; }
json& material(Gltf& gltf) { return gltf.root["materials"][0] = {{"name", "lit"}}; }

Gltf shaded() {
  Gltf gltf = triangle();
  attributes(gltf)["NORMAL"] = gltf.accessor<float>({0, 0, 1, 0, .1f, 1, .1f, 0, 1}, 3);
  gltf.root["meshes"][0]["primitives"][0]["indices"] = gltf.accessor<uint8_t>({0, 1, 2}, 1);
  material(gltf)["pbrMetallicRoughness"] = {{"metallicFactor", .5}, {"roughnessFactor", .3}};
  gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 9}},
                                                              {{"type", "directional"}},
                                                              {{"type", "spot"}, {"spot", {{"outerConeAngle", 1}}}}};
  for (int i = 0; i < 3; ++i)
    gltf.node({{"translation", {1, 1, 1 + i}}, {"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
  return gltf;
}

Gltf textured(const json& image, bool alpha) {
  Gltf gltf = triangle();
  attributes(gltf)["TEXCOORD_0"] = gltf.accessor<uint16_t>({0, 0, 65535, 0, 0, 65535}, 2, true);
  attributes(gltf)["TEXCOORD_1"] = gltf.accessor<float>({0, 0, 3, 0, 0, 3}, 2);
  attributes(gltf)["COLOR_0"] = gltf.accessor<uint8_t>({255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 128}, 4, true);
  gltf.push("images", image);
  gltf.push("samplers", {{"wrapS", 33648}, {"wrapT", 33071}, {"magFilter", 9728}});
  gltf.push("textures", {{"source", 0}, {"sampler", 0}});
  const json transform = {{"KHR_texture_transform", {{"offset", {.5, 0}}, {"rotation", 1}, {"scale", {2, 3}}}}};
  material(gltf) = {{"pbrMetallicRoughness",
                     {{"baseColorTexture", {{"index", 0}, {"extensions", transform}}},
                      {"metallicRoughnessTexture", {{"index", 0}, {"texCoord", 1}}}}},
                    {"normalTexture", {{"index", 0}}},
                    {"emissiveTexture", {{"index", 0}}},
                    {"emissiveFactor", {1, 1, 1}}};
  if (alpha) material(gltf)["alphaMode"] = "BLEND";
  return gltf;
}

Gltf glass() {
  Gltf gltf = triangle();
  material(gltf) = {{"extensions",
                     {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                      {"KHR_materials_ior", {{"ior", 1.3}}},
                      {"KHR_materials_emissive_strength", {{"emissiveStrength", 2}}}}},
                    {"emissiveFactor", {0, 0, 1}},
                    {"pbrMetallicRoughness", {{"roughnessFactor", 0}, {"metallicFactor", 0}}}};
  gltf.root["scenes"][0]["extras"] = {{"environment", "picture.exr"}, {"environment_strength", 2}};
  return gltf;
}

Gltf moving(const char* interpolation) {
  Gltf gltf = triangle();
  const bool cubic = std::string(interpolation) == "CUBICSPLINE";
  std::vector<float> values(cubic ? 18 : 6);
  for (size_t i = 0; i < values.size(); ++i) values[i] = .1f * static_cast<float>(i);
  const json sampler = {{"input", gltf.accessor<float>({0, 1}, 1)},
                        {"output", gltf.accessor(values, 3)},
                        {"interpolation", interpolation}};
  const json turn = {{"input", 1}, {"output", gltf.accessor<float>({0, 0, 0, 1, 0, 0, .7071f, .7071f}, 4)}};
  gltf.push("animations", {{"samplers", {sampler, turn}},
                           {"channels",
                            {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}},
                             {{"sampler", 1}, {"target", {{"node", 0}, {"path", "rotation"}}}}}}});
  gltf.root["cameras"][0]["extras"] = {{"shutter_s", {0, 1}}, {"aperture_radius_m", .1}, {"focus_distance_m", 4}};
  return gltf;
}

Gltf strip(int mode) {
  Gltf gltf = triangle();
  const int positions = gltf.accessor<int16_t>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, 3);
  gltf.root["meshes"][0]["primitives"][0]["attributes"] = {{"POSITION", positions}};
  gltf.root["meshes"][0]["primitives"][0]["mode"] = mode;
  gltf.root["extensionsRequired"] = {"KHR_mesh_quantization"};
  gltf.root["cameras"][0] = {{"type", "orthographic"},
                             {"orthographic", {{"xmag", 2}, {"ymag", 1}, {"znear", .1}, {"zfar", 10}}}};
  return gltf;
}

Gltf sparse() {
  Gltf gltf = triangle();
  const int places = gltf.view(gltf_files::bytes_of_list<uint16_t>({2}));
  const int values = gltf.view(gltf_files::bytes_of_list<float>({0, 2, 0}));
  gltf.root["accessors"][0]["sparse"] = {{"count", 1},
                                         {"indices", {{"bufferView", places}, {"componentType", 5123}}},
                                         {"values", {{"bufferView", values}}}};
  gltf.root["nodes"][1] = {{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1e7, 0, 0, 1}}, {"mesh", 0}};
  return gltf;
}

void put(const std::string& folder, const std::string& name, const Gltf& gltf) {
  gltf.save(folder + "/" + name + ".gltf");
  gltf.save(folder + "/" + name + ".glb");
}

void put_all(const std::string& folder) {
  scene_files::put(folder);
  const std::string png = bytes_of(folder + "/" + scene_files::kPictures[0]);
  for (const char* name : scene_files::kPictures) std::filesystem::remove(folder + "/" + name);
  std::filesystem::remove(folder + "/" + scene_files::kBuffer);
  put(folder, "triangle", triangle());
  put(folder, "shaded", shaded());
  put(folder, "file", textured({{"uri", "picture.png"}}, true));
  put(folder, "data", textured({{"uri", "data:image/png;base64," + gltf_files::base64(png)}}, false));
  Gltf embedded = textured({{"mimeType", "image/png"}}, true);
  embedded.root["images"][0]["bufferView"] = embedded.view(png);
  put(folder, "embedded", embedded);
  put(folder, "glass", glass());
  put(folder, "linear", moving("LINEAR"));
  put(folder, "cubic", moving("CUBICSPLINE"));
  put(folder, "strip", strip(5));
  put(folder, "fan", strip(6));
  put(folder, "sparse", sparse());
  Gltf buffer = triangle();
  buffer.root["buffers"] = json::array({{{"byteLength", 36}, {"uri", scene_files::kBuffer}}});
  buffer.save(folder + "/buffer.gltf");
  constexpr uintmax_t kMostBytes = 40000;  // of a bundled scene: larger ones would slow every try down
  for (const auto& entry : std::filesystem::directory_iterator(TRIAD_SOURCE_DIR "/data/scenes"))
    if (entry.path().extension() == ".gltf" && entry.file_size() <= kMostBytes)
      std::filesystem::copy_file(entry.path(), folder + "/" + entry.path().filename().string(),
                                 std::filesystem::copy_options::overwrite_existing);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: load_scene_seeds FOLDER\n", stderr);
    return 2;
  }
  try {
    put_all(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "load_scene_seeds: %s\n", error.what());
    return 1;
  }
  return 0;
}
