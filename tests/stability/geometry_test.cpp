// SPDX-License-Identifier: Apache-2.0
// Pictures of scenes whose triangles are hard: far away, of all sizes at once, thin, flat, on top of one another.
#include "../unit/gltf_files.hpp"

#include <triad/base/parallel.hpp>
#include <triad/sampling/strategy.hpp>

#include "../statistical/raytracer_scenes.hpp"
#include "raytracer/gltf_loader.hpp"
#include "stability_table.hpp"

namespace triad::raytracer::testing {
namespace {

using nlohmann::json;

constexpr int kSide = 48, kSpp = 16;

double mean_of(const std::vector<Sample>& samples) {
  double sum = 0;
  for (const Sample& sample : samples) sum += static_cast<double>(sample.rgb[1]);
  return sum / static_cast<double>(samples.size());
}

// Samples that are not finite, or whose light is farther than `tolerance` from `expected`.
uint64_t wrong(const std::vector<Sample>& samples, double expected, double tolerance) {
  uint64_t count = 0;
  for (const Sample& sample : samples)
    for (const float channel : sample.rgb)
      if (!sample.valid || !(std::abs(static_cast<double>(channel) - expected) <= tolerance)) {
        ++count;
        break;
      }
  return count;
}

// A ball on a floor under a lamp, `offset_m` away in all directions; vertices as in the file, which a node moves.
gltf_files::Gltf still_life(double offset_m) {
  gltf_files::Gltf gltf;
  json primitives = json::array();
  const auto add = [&](const Mesh& mesh, const json& material) {
    std::vector<float> positions;
    for (const Float3 p : mesh.positions) positions.insert(positions.end(), {p.x, p.y, p.z});
    std::vector<uint32_t> indices;
    for (const auto& triangle : mesh.indices) indices.insert(indices.end(), triangle.begin(), triangle.end());
    primitives.push_back({{"attributes", {{"POSITION", gltf.accessor(positions, 3)}}},
                          {"indices", gltf.accessor(indices, 1)},
                          {"material", gltf.push("materials", material)}});
  };
  const json matt{{"baseColorFactor", {.6, .5, .4, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 1}};
  add(quad({-2, 0, 2}, {4, 0, 0}, {0, 0, -4}), {{"pbrMetallicRoughness", matt}});
  add(ball(3, .5f, {0, .5f, 0}), {{"pbrMetallicRoughness", matt}});
  add(quad({-.5f, 2, -.5f}, {1, 0, 0}, {0, 0, 1}), {{"emissiveFactor", {1, 1, 1}}});
  gltf.push("meshes", {{"primitives", primitives}});
  gltf.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", .7}, {"znear", .1}}}});
  gltf.push("nodes", {{"mesh", 0}});
  gltf.push("nodes", {{"camera", 0}, {"translation", {0, .8, 4}}});
  gltf.node({{"children", {0, 1}}, {"translation", {offset_m, offset_m, -offset_m}}});
  return gltf;
}

Scene loaded(double offset_m) {
  const auto path = std::filesystem::path(TRIAD_BINARY_DIR) / fmt::format("still_life_{}.glb", offset_m);
  Scene scene = load_gltf(still_life(offset_m).save(path.string()));
  std::filesystem::remove(path);
  return scene;
}

std::vector<Sample> render(const Scene& scene, int spp = kSpp) {
  return evaluate(*source_of(scene, kSide, kSide), requests(kSide, kSide, spp));
}

}  // namespace

TEST(GeometryStability, SceneFarAwayRendersAsAtTheOrigin) {
  constexpr double kFar_m = 1e7;
  const Scene near = loaded(0), far = loaded(kFar_m);
  const double here = mean_of(render(near)), there = mean_of(render(far));
  ASSERT_GT(here, .01);
  stability::at_most("geometry", "scene 1e7 m away: mean light, relative to that at the origin",
                     std::abs(there / here - 1), 1e-3);
  const auto says = [](const Scene& scene) {
    return std::count_if(scene.warnings.begin(), scene.warnings.end(), [](const std::string& line) {
      return line.find("far from the origin; it is drawn relative to") != std::string::npos;
    });
  };
  stability::equal("geometry", "scene 1e7 m away: warnings that say so", static_cast<double>(says(far)), 1);
  EXPECT_EQ(says(near), 0);
  EXPECT_NEAR(far.origin_m.x, kFar_m, 3);

  // The naive way: the same coordinates as floats, whose step out there is 1 m.
  Scene moved = near;
  const auto shift = static_cast<float>(kFar_m);
  for (Mesh& mesh : moved.meshes)
    for (Float3& p : mesh.positions) p = {p.x + shift, p.y + shift, p.z - shift};
  Double3& eye = moved.cameras[0].poses[0].position_m;
  eye = {eye.x + kFar_m, eye.y + kFar_m, eye.z - kFar_m};
  stability::naive_fails("geometry", "scene 1e7 m away in floats: the same",
                         std::abs(mean_of(render(moved)) / here - 1), .01);
}

TEST(GeometryStability, MillionthsAndMillionsOfMetresTogether) {
  // White things in a white furnace: whatever is seen is 1, unless a surface stands in its own light.
  constexpr float kSmall_m = 1e-6f, kLarge_m = 1e6f;
  Scene scene;
  const int white = add_material(scene, matt({1, 1, 1}));
  add_mesh(scene, quad({-kLarge_m, 0, kLarge_m}, {2 * kLarge_m, 0, 0}, {0, 0, -2 * kLarge_m}), white);
  add_mesh(scene, ball(4, kSmall_m, {0, 4 * kSmall_m, 0}), white);
  scene.environment.radiance = {1, 1, 1};
  scene.cameras.push_back(looking({0, 1e-4, 0}, {0, 0, 0}, 2e-6));
  SourceOptions options;
  options.max_depth = 200;
  const auto samples = evaluate(*source_of(scene, kSide, kSide, options), requests(kSide, kSide, kSpp));
  stability::never("geometry", "objects of 1e-6 and 1e6 m in a furnace: samples off 1 by 1e-4",
                   wrong(samples, 1, 1e-4), samples.size());
  uint64_t seen = 0;
  for (const Sample& sample : samples) seen += sample.object_id == 2;
  // A disc of 1e-6 m in a square of 4e-6 m, at the pixels' centres: within a pixel's width along its rim.
  const double share = static_cast<double>(seen) / static_cast<double>(samples.size());
  stability::at_most("geometry", "ball of 1e-6 m on a floor of 1e6 m: area seen, relative error",
                     std::abs(share / (std::numbers::pi / 16) - 1), .03);
}

TEST(GeometryStability, NeedlesAndTrianglesWithoutArea) {
  // A floor cut into needles 1 : 100,000, with triangles of no area strewn in; beside it, two triangles.
  constexpr uint32_t kNeedles = 2000;
  const Mesh plain = quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2});
  Mesh needles;
  for (uint32_t i = 0; i <= kNeedles; ++i) {
    const float z = 1 - 1e-3f * static_cast<float>(i) * (2000.f / kNeedles);
    needles.positions.push_back({-1, 0, z});
    needles.positions.push_back({1, 0, z});
  }
  for (uint32_t i = 0; i < kNeedles; ++i) {
    const uint32_t a = 2 * i;
    needles.indices.insert(needles.indices.end(),
                           {{a, a + 1, a + 3}, {a, a + 3, a + 2}, {a, a, a + 1}, {a, a + 2, a}});
  }
  const auto picture = [](const Mesh& mesh, int max_depth) {
    Scene scene;
    add_mesh(scene, mesh, add_material(scene, matt({1, 1, 1})));
    scene.environment.radiance = {1, 1, 1};
    scene.cameras.push_back(looking({.3, 1, .2}, {0, 0, 0}, .6));
    SourceOptions options;
    options.max_depth = max_depth;
    return evaluate(*source_of(scene, kSide, kSide, options), requests(kSide, kSide, kSpp));
  };
  const auto cut = picture(needles, 32), whole = picture(plain, 32);
  stability::never("geometry", "needles 1e-3 m wide and flat triangles in a furnace: samples off 1 by 1e-4",
                   wrong(cut, 1, 1e-4), cut.size());
  double worst = 0;
  for (size_t i = 0; i < cut.size(); ++i)
    worst = std::max(worst, std::abs(static_cast<double>(cut[i].distance) - static_cast<double>(whole[i].distance)));
  stability::at_most("geometry", "the same floor of needles: distance to two triangles' in m", worst, 1e-6);
}

TEST(GeometryStability, CoplanarFacesAreDeterministic) {
  Scene scene;
  for (const Float3 colour : {Float3{1, 0, 0}, Float3{0, 1, 0}, Float3{0, 0, 1}}) {
    Material paper = matt(colour);
    paper.unlit = true;
    const float turn = .1f * static_cast<float>(scene.meshes.size());
    add_mesh(scene, quad({-1 + turn, 0, 1}, {2, 0, turn}, {turn, 0, -2}), add_material(scene, paper));
  }
  scene.cameras.push_back(looking({.3, 1, .2}, {0, 0, 0}, .6));
  const auto source = source_of(scene, kSide, kSide);
  const auto strategy = make_strategy("sobol-owen:spp=4", "strategy");
  const int threads_before = thread_limit();
  std::vector<std::array<double, 3>> first;
  uint64_t changed = 0, pixels = 0;
  for (const int threads : {1, 2, 7}) {
    set_thread_limit(threads);
    const RenderResult result = strategy->render(*source, {});
    for (size_t p = 0; p < result.film.pixels(); ++p) {
      if (threads == 1) first.push_back(result.film.mean(p));
      changed += result.film.mean(p) != first[p];
      ++pixels;
    }
  }
  set_thread_limit(threads_before);
  stability::never("geometry", "coplanar faces: pixels that change with the number of threads", changed, pixels);

  // Which of two faces at one distance a ray meets is a matter of rounding, which differs with the company that
  // Embree traces it in. It is always one of them.
  const auto list = requests(kSide, kSide, 4);
  const auto together = evaluate(*source, list, 1, list.size()), others_with = evaluate(*source, list, 1, 37);
  uint64_t others = 0, strange = 0;
  for (size_t i = 0; i < list.size(); ++i) {
    others += others_with[i].rgb != together[i].rgb;
    strange += others_with[i].rgb[0] + others_with[i].rgb[1] + others_with[i].rgb[2] != 1;
  }
  stability::never("geometry", "coplanar faces: samples of neither face", strange, list.size());
  stability::at_most("geometry", "coplanar faces: share of samples that depend on those asked for with them",
                     static_cast<double>(others) / static_cast<double>(list.size()), .05);
}

TEST(GeometryStability, GrazingAngles) {
  // A white floor of many triangles, tilted so that no coordinate is round, seen at a ten-thousandth of a radian.
  Mesh floor;
  constexpr uint32_t kCells = 64;
  for (uint32_t j = 0; j <= kCells; ++j)
    for (uint32_t i = 0; i <= kCells; ++i) {
      const float x = static_cast<float>(i) / kCells - .5f, z = static_cast<float>(j) / kCells - .5f;
      floor.positions.push_back({x, .3f * x + .1f * z, z});
    }
  for (uint32_t j = 0; j < kCells; ++j)
    for (uint32_t i = 0; i < kCells; ++i) {
      const uint32_t a = j * (kCells + 1) + i, b = a + kCells + 1;
      floor.indices.insert(floor.indices.end(), {{a, b, a + 1}, {a + 1, b, b + 1}});
    }
  for (const double angle : {1e-2, 1e-3, 1e-4}) {
    Scene scene;
    add_mesh(scene, floor, add_material(scene, matt({1, 1, 1})));
    scene.environment.radiance = {1, 1, 1};
    // Along the floor, and up by the angle along its normal (-.3, 1, -.1).
    const double size = std::sqrt(1.1);
    scene.cameras.push_back(
        looking({3 - .3 / size * 3 * angle, .9 + 3 * angle / size, -.1 / size * 3 * angle}, {0, 0, 0}, angle * .2));
    const auto samples = render(scene);
    uint64_t met = 0;
    for (const Sample& sample : samples) met += sample.object_id == 1;
    EXPECT_GT(met, samples.size() * 9 / 10);
    stability::never("geometry", fmt::format("floor seen at {:g} rad in a furnace: samples off 1 by 1e-4", angle),
                     wrong(samples, 1, 1e-4), samples.size());
  }
}

TEST(GeometryStability, CameraInsideAWall) {
  // Between the faces of a wall, under a bright sky: dark, in every direction.
  Scene scene;
  Mesh wall;
  for (const float z : {0.f, -.2f})
    for (const float y : {-1.f, 1.f})
      for (const float x : {-1.f, 1.f}) wall.positions.push_back({x, y, z});
  wall.indices = {{0, 1, 3}, {0, 3, 2}, {5, 4, 6}, {5, 6, 7}, {4, 0, 2}, {4, 2, 6},
                  {1, 5, 7}, {1, 7, 3}, {2, 3, 7}, {2, 7, 6}, {4, 5, 1}, {4, 1, 0}};
  add_mesh(scene, wall, add_material(scene, matt({.8f, .8f, .8f})));
  scene.environment.radiance = {1e6f, 1e6f, 1e6f};
  Camera camera;
  camera.yfov_rad = 2.8;
  camera.poses[0].position_m = {0, 0, -.1};
  scene.cameras = {camera};
  const auto samples = render(scene);
  stability::never("geometry", "camera inside a wall under a bright sky: samples lit", wrong(samples, 0, 0),
                   samples.size());
  // And from inside of a ball that glows inwards, all is as bright as the ball.
  Scene glowing;
  Material glow = lamp({1, 1, 1});
  glow.double_sided = true;
  add_mesh(glowing, ball(4), add_material(glowing, glow));
  glowing.cameras = {camera};
  const auto seen = render(glowing);
  stability::never("geometry", "rays from inside a glowing ball: samples off 1 by 1e-6", wrong(seen, 1, 1e-6),
                   seen.size());
}

}  // namespace triad::raytracer::testing
