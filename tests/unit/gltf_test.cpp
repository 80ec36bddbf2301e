// SPDX-License-Identifier: Apache-2.0
// What a glTF file means: geometry, transforms, motion, materials, cameras, lights. Expected values are those of
// the specification's formulas, worked out by hand.
#include "gltf_files.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <raytracer/gltf_loader.hpp>
#include <triad/base/error.hpp>

#include "picture_files.hpp"

using namespace triad::raytracer;
using gltf_files::Gltf;
using gltf_files::json;
using gltf_files::triangle;
using testing::ElementsAre;
using testing::HasSubstr;

namespace {

const double kPi = std::numbers::pi;

Scene load(const Gltf& gltf, const LoadOptions& options = {}) {
  const picture_files::Folder folder;
  return load_gltf(gltf.save(folder / "a.gltf"), options);
}

void expect_near(const Float3& a, const Float3& b, float tolerance = 1e-6f) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}
void expect_near(const Double3& a, const Double3& b, double tolerance = 1e-12) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

std::string all_warnings(const Scene& scene) {
  std::string text;
  for (const auto& warning : scene.warnings) text += warning + "\n";
  return text;
}

using Triangles = std::vector<std::array<uint32_t, 3>>;

TEST(Gltf, TellsHowMuchIsLoaded) {
  std::vector<double> told;
  load(triangle(), {"", [&told](double done) { told.push_back(done); }});
  ASSERT_GE(told.size(), 3u);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_GT(told.front(), 0);
  EXPECT_EQ(told.back(), 1);
}

TEST(Gltf, ReadsATriangleFromBothForms) {
  const picture_files::Folder folder;
  for (const char* name : {"a.gltf", "a.glb"}) {
    const Scene scene = load_gltf(triangle().save(folder / name));
    ASSERT_EQ(scene.meshes.size(), 1u) << name;
    const Mesh& mesh = scene.meshes[0];
    EXPECT_THAT(mesh.positions, ElementsAre(Float3{0, 0, 0}, Float3{1, 0, 0}, Float3{0, 1, 0}));
    EXPECT_EQ(mesh.indices, (Triangles{{0, 1, 2}}));
    EXPECT_TRUE(mesh.normals.empty());
    EXPECT_FALSE(mesh.moves());
    EXPECT_EQ(mesh.name, "leaf");
    EXPECT_EQ(mesh.object_id, 1u);
    EXPECT_TRUE(scene.materials.at(0).unlit);
    EXPECT_EQ(scene.cameras.at(0).name, "eye");
    EXPECT_EQ(scene.cameras[0].yfov_rad, .5);
    EXPECT_EQ(scene.bounds_max_m, (Float3{1, 1, 0}));
    EXPECT_EQ(scene.origin_m, Double3{});
    EXPECT_EQ(all_warnings(scene), "");
  }
}

TEST(Gltf, ReadsListsStripsAndFans) {
  Gltf gltf = triangle();
  const int positions = gltf.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, 3);
  gltf.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = positions;
  gltf.root["meshes"][0]["primitives"][0]["mode"] = 5;
  EXPECT_EQ(load(gltf).meshes[0].indices, (Triangles{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
  gltf.root["meshes"][0]["primitives"][0]["mode"] = 6;
  EXPECT_EQ(load(gltf).meshes[0].indices, (Triangles{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}}));
  gltf.root["meshes"][0]["primitives"][0]["mode"] = 4;
  gltf.root["meshes"][0]["primitives"][0]["indices"] = gltf.accessor<uint8_t>({0, 1, 2, 2, 1, 3}, 1);
  EXPECT_EQ(load(gltf).meshes[0].indices, (Triangles{{0, 1, 2}, {2, 1, 3}}));
}

TEST(Gltf, ReadsStridedNormalisedAndSparseAccessors) {
  Gltf gltf = triangle();
  // 16-bit positions, normalised, 8 bytes apart: 32767 is 1, and both -32767 and -32768 are -1.
  const int view =
      gltf.view(gltf_files::bytes_of_list<int16_t>({0, 0, -32768, 99, 32767, 0, 0, 99, 0, -32767, 0, 99}), 8);
  gltf.root["accessors"][0] = {
      {"bufferView", view}, {"componentType", 5122}, {"count", 3}, {"type", "VEC3"}, {"normalized", true}};
  EXPECT_THAT(load(gltf).meshes[0].positions, ElementsAre(Float3{0, 0, -1}, Float3{1, 0, 0}, Float3{0, -1, 0}));
  gltf.root["accessors"][0]["normalized"] = false;
  EXPECT_EQ(load(gltf).meshes[0].positions[1], (Float3{32767, 0, 0}));

  Gltf sparse = triangle();
  const int where = sparse.view(gltf_files::bytes_of_list<uint16_t>({1, 2}));
  const int what = sparse.view(gltf_files::bytes_of_list<float>({7, 8, 9, 4, 5, 6}));
  sparse.root["accessors"][0]["sparse"] = {{"count", 2},
                                           {"indices", {{"bufferView", where}, {"componentType", 5123}}},
                                           {"values", {{"bufferView", what}}}};
  EXPECT_THAT(load(sparse).meshes[0].positions, ElementsAre(Float3{0, 0, 0}, Float3{7, 8, 9}, Float3{4, 5, 6}));
  sparse.root["accessors"][0].erase("bufferView");  // over zeros: the first vertex happens to be 0 too
  EXPECT_THAT(load(sparse).meshes[0].positions, ElementsAre(Float3{0, 0, 0}, Float3{7, 8, 9}, Float3{4, 5, 6}));
}

TEST(Gltf, AppliesTheTransformsOfAllAncestors) {
  Gltf gltf = triangle();
  // A quarter turn about z takes (1,0,0) to (0,1,0); doubled before, moved after; the parent's matrix adds 100 to y.
  gltf.root["nodes"][0]["translation"] = {10, 0, 0};
  gltf.root["nodes"][0]["rotation"] = {0, 0, std::sqrt(.5), std::sqrt(.5)};
  gltf.root["nodes"][0]["scale"] = {2, 2, 2};
  const int parent =
      gltf.push("nodes", {{"children", {0}}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 100, 0, 1}}});
  gltf.root["scenes"][0]["nodes"] = {parent, 1};
  const Scene scene = load(gltf);
  ASSERT_EQ(scene.origin_m, (Double3{10 - 1, 101, 0})) << "far beside its size";
  expect_near(scene.meshes[0].positions[0], {1, -1, 0});
  expect_near(scene.meshes[0].positions[1], {1, 1, 0});
  expect_near(scene.meshes[0].positions[2], {-1, -1, 0});
}

TEST(Gltf, MirroredNodesKeepTheirFrontOutside) {
  Gltf gltf = triangle();
  gltf.root["nodes"][0]["scale"] = {-1, 1, 1};
  gltf.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      gltf.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 2}, 3);
  const Mesh mesh = load(gltf).meshes[0];
  EXPECT_EQ(mesh.indices, (Triangles{{0, 2, 1}}));  // counter-clockwise seen from +z again
  expect_near(mesh.normals[0], {0, 0, 1});
  expect_near(mesh.normals[2], {0, 0, 1});
}

TEST(Gltf, NormalsStayPerpendicularUnderUnevenScale) {
  Gltf gltf = triangle();
  gltf.root["nodes"][0]["scale"] = {4, 1, 1};
  const auto h = static_cast<float>(std::sqrt(.5));
  gltf.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      gltf.accessor<float>({h, h, 0, h, h, 0, 0, 0, 1}, 3);
  // (1,1,0) is normal to (1,-1,0), which becomes (4,-1,0), whose normal is (1,4,0).
  const Mesh mesh = load(gltf).meshes[0];
  expect_near(mesh.normals[0], {static_cast<float>(1 / std::sqrt(17)), static_cast<float>(4 / std::sqrt(17)), 0});
}

TEST(Gltf, RecentresWhatLiesFarAway) {
  Gltf gltf = triangle();
  const Scene here = load(gltf);
  for (const int i : {0, 1}) gltf.root["nodes"][i]["translation"] = {1e7, 0, i == 0 ? 0 : 5};
  const Scene there = load(gltf);
  EXPECT_THAT(all_warnings(there), HasSubstr("far from the origin"));
  const double dx = there.origin_m.x - 1e7;
  for (size_t i = 0; i < 3; ++i)  // distances survive exactly
    EXPECT_EQ(there.meshes[0].positions[i].x + dx, here.meshes[0].positions[i].x);
  EXPECT_EQ(there.cameras[0].poses[0].position_m.x + dx, here.cameras[0].poses[0].position_m.x);
}

Gltf turning(const char* path, const std::vector<float>& times_s, const std::vector<float>& values, int components,
             const char* interpolation = "LINEAR") {
  Gltf gltf = triangle();
  const int input = gltf.accessor(times_s, 1), output = gltf.accessor(values, components);
  gltf.push("animations", {{"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}},
                           {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}}});
  gltf.root["cameras"][0]["extras"]["shutter_s"] = {1, 2};
  return gltf;
}

TEST(Gltf, SamplesLinearMotionAtTheEndsOfTheShutter) {
  const Scene scene = load(turning("translation", {0, 4}, {0, 0, 0, 8, 0, 0}, 3));
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.motion_positions.size(), 1u);
  expect_near(mesh.positions[0], {2, 0, 0});
  expect_near(mesh.motion_positions[0][0], {4, 0, 0});
  EXPECT_EQ(scene.cameras[0].shutter_open_s, 1);
  EXPECT_EQ(scene.cameras[0].shutter_close_s, 2);
}

TEST(Gltf, SamplesSplinesAndStepsAsTheSpecificationSays) {
  // With tangents 0 a cubic spline is 3t^2 - 2t^3: at 1/4 and 1/2 of the way 10/64 and 1/2.
  const Scene cubic =
      load(turning("translation", {0, 4}, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 64, 0, 0, 0, 0, 0}, 3, "CUBICSPLINE"));
  const double x = cubic.meshes[0].positions[0].x + cubic.origin_m.x;
  EXPECT_NEAR(x, 10, 1e-5);
  EXPECT_NEAR(cubic.meshes[0].motion_positions.back()[0].x + cubic.origin_m.x, 32, 1e-5);
  EXPECT_GT(cubic.meshes[0].motion_positions.size(), 1u) << "curved in time";
  const Scene step = load(turning("translation", {0, 1, 3}, {0, 0, 0, 5, 0, 0, 9, 0, 0}, 3, "STEP"));
  EXPECT_FALSE(step.meshes[0].moves());
  expect_near(step.meshes[0].positions[0], {5, 0, 0});
}

TEST(Gltf, FollowsARotationCloselyEnough) {
  const auto s = static_cast<float>(std::sqrt(.5));
  const Scene scene = load(turning("rotation", {1, 2}, {0, 0, 0, 1, 0, 0, s, s}, 4));  // a quarter turn about z
  const Mesh& mesh = scene.meshes[0];
  const size_t steps = mesh.motion_positions.size();
  ASSERT_GT(steps, 1u);
  for (size_t k = 0; k < steps; ++k) {
    const Float3& a = k == 0 ? mesh.positions[1] : mesh.motion_positions[k - 1][1];
    const Float3& b = mesh.motion_positions[k][1];
    const double angle = kPi / 2 * (static_cast<double>(k) + .5) / static_cast<double>(steps);
    const double error = std::hypot((a.x + b.x) / 2 - std::cos(angle), (a.y + b.y) / 2 - std::sin(angle));
    EXPECT_LT(error, 1e-3 * 2.9);  // 1e-3 of the box that the motion sweeps, whose diagonal is under 2.9
  }
  expect_near(mesh.motion_positions.back()[1], {0, 1, 0});
}

TEST(Gltf, WithoutAShutterThingsStandAsInTheFile) {
  Gltf gltf = turning("translation", {0, 4}, {7, 0, 0, 8, 0, 0}, 3);
  gltf.root["cameras"][0].erase("extras");
  const Scene scene = load(gltf);
  EXPECT_FALSE(scene.meshes[0].moves());
  expect_near(scene.meshes[0].positions[0], {0, 0, 0});
  EXPECT_THAT(all_warnings(scene), HasSubstr("shutter_s"));
}

TEST(Gltf, ACameraLooksAlongItsNode) {
  Gltf gltf = triangle();
  gltf.root["nodes"][1]["rotation"] = {0, std::sqrt(.5), 0, std::sqrt(.5)};  // a quarter turn about y: -z to -x
  gltf.root["nodes"][1]["scale"] = {3, 3, 3};                                // means nothing to a camera
  gltf.root["cameras"][0]["extras"] = {{"aperture_radius_m", .25}, {"focus_distance_m", 4}};
  const Camera camera = load(gltf).cameras[0];
  ASSERT_EQ(camera.poses.size(), 1u);
  expect_near(camera.poses[0].forward, {-1, 0, 0});
  expect_near(camera.poses[0].up, {0, 1, 0});
  expect_near(camera.poses[0].right, {0, 0, -1});
  expect_near(camera.poses[0].position_m, {0, 0, 5});
  EXPECT_EQ(camera.aperture_radius_m, .25);
  EXPECT_EQ(camera.focus_distance_m, 4);
}

TEST(Gltf, ChoosesACameraByNameOrNumber) {
  Gltf gltf = triangle();
  gltf.push("cameras",
            {{"type", "orthographic"}, {"orthographic", {{"xmag", 3}, {"ymag", 2}, {"znear", 0}, {"zfar", 9}}}});
  gltf.node({{"camera", 1}, {"name", "flat"}});
  EXPECT_EQ(load(gltf).camera, 0);
  EXPECT_EQ(load(gltf, {"flat"}).camera, 1);
  const Scene scene = load(gltf, {"1"});
  EXPECT_EQ(scene.camera, 1);
  EXPECT_TRUE(scene.cameras[1].orthographic);
  EXPECT_EQ(scene.cameras[1].half_height_m, 2);
  EXPECT_EQ(scene.cameras[1].aspect_ratio, 1.5);
  try {
    load(gltf, {"flap"});
    FAIL() << "took a camera that is not there";
  } catch (const triad::Error& error) {
    EXPECT_EQ(error.kind(), triad::ErrorKind::kUsage);
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'flat'?"));
  }
}

TEST(Gltf, WithoutACameraTheSceneIsFramed) {
  Gltf gltf = triangle();
  gltf.root["scenes"][0]["nodes"] = {0};
  const Scene scene = load(gltf);
  EXPECT_THAT(all_warnings(scene), HasSubstr("no camera"));
  ASSERT_EQ(scene.cameras.size(), 1u);
  const CameraPose& pose = scene.cameras[0].poses[0];
  for (const Float3& p : scene.meshes[0].positions) {
    const double d[3] = {p.x - pose.position_m.x, p.y - pose.position_m.y, p.z - pose.position_m.z};
    const auto along = [&d](const Double3& axis) { return d[0] * axis.x + d[1] * axis.y + d[2] * axis.z; };
    const double depth = along(pose.forward), edge = depth * std::tan(scene.cameras[0].yfov_rad / 2);
    EXPECT_GT(depth, 0);
    EXPECT_LE(std::abs(along(pose.up)), edge);
    EXPECT_LE(std::abs(along(pose.right)), edge);
  }
}

TEST(Gltf, ReadsMaterialsAndTheirExtensions) {
  Gltf gltf = triangle();
  gltf.root["materials"][0] = {
      {"name", "m"},
      {"pbrMetallicRoughness",
       {{"baseColorFactor", {.1, .2, .3, .4}}, {"metallicFactor", .5}, {"roughnessFactor", .25}}},
      {"emissiveFactor", {1, .5, 0}},
      {"alphaMode", "MASK"},
      {"alphaCutoff", .75},
      {"doubleSided", true},
      {"extensions",
       {{"KHR_materials_emissive_strength", {{"emissiveStrength", 8}}},
        {"KHR_materials_ior", {{"ior", 1.25}}},
        {"KHR_materials_transmission", {{"transmissionFactor", .625}}}}}};
  const Material m = load(gltf).materials[0];
  expect_near(m.base_color, {.1f, .2f, .3f});
  EXPECT_FLOAT_EQ(m.alpha, .4f);
  EXPECT_EQ(m.metallic, .5f);
  EXPECT_EQ(m.roughness, .25f);
  EXPECT_EQ(m.emission, (Float3{8, 4, 0}));
  EXPECT_EQ(m.alpha_mode, AlphaMode::kMask);
  EXPECT_EQ(m.alpha_cutoff, .75f);
  EXPECT_TRUE(m.double_sided);
  EXPECT_EQ(m.ior, 1.25f);
  EXPECT_EQ(m.transmission, .625f);
  EXPECT_FALSE(m.unlit);
}

TEST(Gltf, DefaultsAreThoseOfTheSpecification) {
  Gltf gltf = triangle();
  gltf.root["meshes"][0]["primitives"][0].erase("material");
  const Scene scene = load(gltf);
  const Material& m = scene.materials.at(static_cast<size_t>(scene.meshes[0].material));
  EXPECT_EQ(m.base_color, (Float3{1, 1, 1}));
  EXPECT_EQ(m.metallic, 1);
  EXPECT_EQ(m.roughness, 1);
  EXPECT_EQ(m.emission, Float3{});
  EXPECT_EQ(m.ior, 1.5f);
  EXPECT_EQ(m.alpha_cutoff, .5f);
  EXPECT_THAT(all_warnings(scene), HasSubstr("nothing in it gives light"));
}

// A picture of 2 x 1 pixels: half red at half alpha, and nothing of pure blue.
std::string small_png(const picture_files::Folder& folder) {
  const std::string path = folder / "small.png";
  OIIO::ImageSpec spec(2, 1, 4, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  const uint8_t pixels[] = {188, 0, 0, 128, 0, 0, 255, 0};
  picture_files::save(path, spec, OIIO::TypeDesc::UINT8, pixels);
  return path;
}

TEST(Gltf, DecodesTexturesFromFilesDataAndBuffers) {
  const picture_files::Folder folder;
  const std::string png = picture_files::bytes_of(small_png(folder));
  for (const int kind : {0, 1, 2}) {
    Gltf gltf = triangle();
    if (kind == 0) gltf.push("images", {{"uri", "small.png"}});
    if (kind == 1) gltf.push("images", {{"uri", "data:image/png;base64," + gltf_files::base64(png)}});
    if (kind == 2) gltf.push("images", {{"bufferView", gltf.view(png)}, {"mimeType", "image/png"}});
    gltf.push("samplers", {{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}});
    gltf.push("textures", {{"source", 0}, {"sampler", 0}});
    gltf.root["materials"][0]["pbrMetallicRoughness"] = {
        {"baseColorTexture", {{"index", 0}}}, {"metallicRoughnessTexture", {{"index", 0}, {"texCoord", 1}}}};
    const Scene scene = load_gltf(gltf.save(folder / "a.gltf"));
    ASSERT_EQ(scene.textures.size(), 2u) << "one linear, one as stored";
    const TextureUse& use = scene.materials[0].base_color_texture;
    const Texture& colour = scene.textures.at(static_cast<size_t>(use.texture));
    ASSERT_EQ(colour.texels.size(), 8u);
    EXPECT_EQ(colour.width, 2);
    // sRGB: ((188/255 + .055) / 1.055)^2.4 = .50289
    EXPECT_NEAR(colour.texels[0], .50289, 1e-5);
    EXPECT_NEAR(colour.texels[3], 128. / 255, 1e-6);
    EXPECT_EQ(colour.texels[6], 1) << "colour where alpha is 0 is kept";
    EXPECT_EQ(colour.texels[7], 0);
    EXPECT_EQ(use.wrap_u, Wrap::kClamp);
    EXPECT_EQ(use.wrap_v, Wrap::kMirror);
    EXPECT_TRUE(use.nearest);
    const TextureUse& data_use = scene.materials[0].metallic_roughness_texture;
    EXPECT_EQ(data_use.texcoord, 1);
    const Texture& data = scene.textures.at(static_cast<size_t>(data_use.texture));
    EXPECT_EQ(data.channels, 3);
    EXPECT_NEAR(data.texels[0], 188. / 255, 1e-6);
    EXPECT_EQ(data.texels[5], 1);
  }
}

TEST(Gltf, TransformsTextureCoordinates) {
  // The extension's own example: the lower left quarter of the picture, v running down, turned a quarter.
  const picture_files::Folder folder;
  small_png(folder);
  Gltf gltf = triangle();
  gltf.push("images", {{"uri", "small.png"}});
  gltf.push("textures", {{"source", 0}});
  gltf.root["materials"][0]["emissiveTexture"] = {
      {"index", 0},
      {"extensions",
       {{"KHR_texture_transform",
         {{"offset", {0, 1}}, {"rotation", kPi / 2}, {"scale", {.5, .5}}, {"texCoord", 1}}}}}};
  const Scene scene = load_gltf(gltf.save(folder / "a.gltf"));
  const TextureUse& use = scene.materials[0].emission_texture;
  EXPECT_EQ(use.texcoord, 1);
  EXPECT_EQ(use.wrap_u, Wrap::kRepeat);
  const auto at = [&use](float u, float v) {
    const auto& t = use.transform;
    return std::pair{t[0] * u + t[1] * v + t[2], t[3] * u + t[4] * v + t[5]};
  };
  const auto expect = [](std::pair<float, float> got, float u, float v) {
    EXPECT_NEAR(got.first, u, 1e-6f);
    EXPECT_NEAR(got.second, v, 1e-6f);
  };
  expect(at(0, 0), 0, 1);
  expect(at(1, 0), 0, .5f);
  expect(at(0, 1), .5f, 1);
  expect(at(1, 1), .5f, .5f);
}

TEST(Gltf, ReadsLights) {
  Gltf gltf = triangle();
  gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"name", "bulb"}, {"color", {1, .5, 0}}, {"intensity", 10}},
      {{"type", "spot"}, {"intensity", 2}, {"spot", {{"innerConeAngle", .25}, {"outerConeAngle", .5}}}},
      {{"type", "directional"}}};
  const auto hang = [&gltf](int light, json node) {
    node["extensions"]["KHR_lights_punctual"]["light"] = light;
    gltf.node(node);
  };
  hang(0, {{"translation", {1, 2, 3}}});
  hang(1, {{"rotation", {std::sqrt(.5), 0, 0, std::sqrt(.5)}}});  // about x: -z to +y
  hang(2, {{"scale", {2, 2, 2}}});
  const Scene scene = load(gltf);
  ASSERT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(scene.lights[0].kind, LightKind::kPoint);
  EXPECT_EQ(scene.lights[0].name, "bulb");
  EXPECT_EQ(scene.lights[0].position_m, (Float3{1, 2, 3}));
  EXPECT_EQ(scene.lights[0].intensity, (Float3{10, 5, 0}));
  EXPECT_EQ(scene.lights[1].kind, LightKind::kSpot);
  expect_near(scene.lights[1].direction, {0, 1, 0});
  EXPECT_EQ(scene.lights[1].inner_cone_rad, .25f);
  EXPECT_EQ(scene.lights[1].outer_cone_rad, .5f);
  EXPECT_EQ(scene.lights[2].kind, LightKind::kDirectional);
  expect_near(scene.lights[2].direction, {0, 0, -1});
  EXPECT_EQ(scene.lights[2].intensity, (Float3{1, 1, 1}));
}

TEST(Gltf, ReadsWhatLiesBehind) {
  Gltf gltf = triangle();
  gltf.root["scenes"][0]["extras"]["background"] = {.25, .5, 2};
  EXPECT_EQ(load(gltf).environment.radiance, (Float3{.25f, .5f, 2}));

  const picture_files::Folder folder;
  const float pixels[] = {5, 6, 7, 1, 2, 3};
  picture_files::save(folder / "sky.exr", OIIO::ImageSpec(2, 1, 3, OIIO::TypeDesc::FLOAT), OIIO::TypeDesc::FLOAT,
                      pixels);
  gltf.root["scenes"][0]["extras"] = {{"environment", "sky.exr"}, {"environment_strength", 3}};
  const Scene scene = load_gltf(gltf.save(folder / "a.gltf"));
  EXPECT_EQ(scene.environment.radiance, (Float3{3, 3, 3}));
  EXPECT_THAT(scene.textures.at(static_cast<size_t>(scene.environment.texture)).texels,
              ElementsAre(5, 6, 7, 1, 2, 3));
}

TEST(Gltf, WarnsOfWhatItLeavesOut) {
  Gltf gltf = triangle();
  gltf.root["extensionsUsed"] = {"KHR_materials_unlit", "KHR_materials_sheen"};
  gltf.root["meshes"][0]["primitives"].push_back({{"mode", 1}, {"attributes", {{"POSITION", 0}}}});
  gltf.root["nodes"][0]["skin"] = 0;
  const std::string warnings = all_warnings(load(gltf));
  EXPECT_THAT(warnings, HasSubstr("KHR_materials_sheen"));
  EXPECT_THAT(warnings, HasSubstr("points or lines"));
  EXPECT_THAT(warnings, HasSubstr("skin"));
}

TEST(Gltf, AMillionTrianglesLoad) {
  constexpr uint32_t kSide = 708;  // 2 * 708^2 = 1,002,528 triangles
  Gltf gltf = triangle();
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  for (uint32_t y = 0; y <= kSide; ++y)
    for (uint32_t x = 0; x <= kSide; ++x)
      positions.insert(positions.end(), {static_cast<float>(x), static_cast<float>(y), 0});
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) {
      const uint32_t a = y * (kSide + 1) + x, b = a + kSide + 1;
      indices.insert(indices.end(), {a, a + 1, b, b, a + 1, b + 1});
    }
  auto& primitive = gltf.root["meshes"][0]["primitives"][0];
  primitive["attributes"]["POSITION"] = gltf.accessor(positions, 3);
  primitive["indices"] = gltf.accessor(indices, 1);
  const picture_files::Folder folder;
  const std::string path = gltf.save(folder / "a.glb");
  const Scene scene = load_gltf(path);
  EXPECT_EQ(scene.triangle_count(), 2u * kSide * kSide);
  EXPECT_EQ(scene.bounds_max_m.x, static_cast<float>(kSide));
}

}  // namespace
