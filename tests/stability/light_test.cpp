// SPDX-License-Identifier: Apache-2.0
// Light that is too near, too much, trapped, or not there; furnaces, in which no energy may appear or be lost.
#include <random>

#include "../statistical/raytracer_scenes.hpp"
#include "raytracer/bsdf.hpp"
#include "stability_table.hpp"

namespace triad::raytracer::testing {
namespace {

constexpr double kPiD = std::numbers::pi;

// The largest distance of a channel from 1 in a furnace (light of radiance 1 from everywhere) that holds a ball.
double off_one(const Material& material) {
  Scene scene;
  add_mesh(scene, ball(3), add_material(scene, material));
  scene.environment.radiance = {1, 1, 1};
  scene.cameras.push_back(looking({0, 0, 5}, {0, 0, 0}, 1.2));
  SourceOptions options;
  options.max_depth = 200;
  const auto source = source_of(scene, 32, 32, options);
  double worst = 0;
  for (const Sample& sample : evaluate(*source, requests(32, 32, 16)))
    for (const float channel : sample.rgb) {
      const double off = std::abs(static_cast<double>(channel) - 1);
      worst = sample.valid && off <= worst ? worst : off;
    }
  EXPECT_EQ(source->invalid_samples(), 0u);
  return worst;
}

void expect_invisible(const std::string& what, const Material& material) {
  stability::at_most("light", what + " in a furnace: distance from 1", off_one(material), 1e-4);
}

// Directional albedo of GGX without Fresnel, by its textbook formulas in double precision, midpoint rule over the
// hemisphere of half vectors: an integral other than the one that the ray tracer samples.
double ggx_albedo(double cosine, double alpha) {
  constexpr int kSteps = 1000;
  const double to_x = std::sqrt(1 - cosine * cosine);
  const auto lambda = [&](double c) { return (std::sqrt(1 + alpha * alpha * (1 - c * c) / (c * c)) - 1) / 2; };
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    // x: tan of the half vector's angle = alpha x / (1 - x); weight: the distribution's share per x.
    const double x = (i + .5) / kSteps, rest = 1 - x, both = rest * rest + x * x;
    const double tan2 = alpha * alpha * x * x / (rest * rest), weight = 2 * x * rest / (both * both);
    const double hz = 1 / std::sqrt(1 + tan2), hr = std::sqrt(1 - hz * hz);
    for (int j = 0; j < kSteps; ++j) {
      const double hx = hr * std::cos(2 * kPiD * (j + .5) / kSteps), to_half = to_x * hx + cosine * hz;
      const double from = 2 * to_half * hz - cosine;
      if (to_half <= 0 || from <= 0) continue;
      // Density of half vectors D hz; d from = 4 to_half d half; BSDF D G / (4 to from) times from.
      sum += weight * to_half / (cosine * hz) / (1 + lambda(cosine) + lambda(from));
    }
  }
  return sum / kSteps / kSteps;
}

// A large floor in a furnace, seen at an angle: its radiance is its directional albedo.
Estimate floor_in_furnace(const Material& material, double cosine) {
  Scene scene;
  add_mesh(scene, quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}), add_material(scene, material));
  scene.environment.radiance = {1, 1, 1};
  scene.cameras.push_back(looking({0, cosine, std::sqrt(1 - cosine * cosine)}, {0, 0, 0}, 1e-3));
  return estimate(evaluate(*source_of(scene, 32, 32), requests(32, 32, 256)), 256);
}

}  // namespace

TEST(LightStability, SmoothBallsInAFurnace) {
  expect_invisible("matt white", matt({1, 1, 1}));
  expect_invisible("mirror, roughness 0", metal({1, 1, 1}, 0));
  expect_invisible("mirror, roughness 1e-6", metal({1, 1, 1}, 1e-6f));
  expect_invisible("glass, ior 1.5", glass(1.5f));
}

TEST(LightStability, GlassOfNoIndexInAFurnace) {
  expect_invisible("glass, ior 1", glass(1));
  expect_invisible("glass, ior 1 + 1e-6", glass(1 + 1e-6f));
  expect_invisible("glass, ior 1 - 1e-6", glass(1 - 1e-6f));
}

TEST(LightStability, RoughMetalHasItsDirectionalAlbedo) {
  double worst = 0, most = 0;
  for (const float roughness : {.1f, .3f, .6f, 1.f})
    for (const double cosine : {.15, .5, .95}) {
      const double alpha = static_cast<double>(roughness) * static_cast<double>(roughness);
      const Estimate found = floor_in_furnace(metal({1, 1, 1}, roughness), cosine);
      worst = std::max(worst, (std::abs(found.mean - ggx_albedo(cosine, alpha)) - 2e-5) / found.standard_error);
      most = std::max(most, found.mean);
    }
  stability::at_most("light", "rough GGX: distance from its albedo in standard errors, of 12", worst, 3);
  stability::at_most("light", "rough GGX in a furnace: energy created", most - 1, 1e-4);
}

TEST(LightStability, WhiteBaseUnderARoughCoatReflectsAll) {
  double worst = 0;
  for (const float roughness : {0.f, .05f, .2f, .5f, 1.f})
    for (const double cosine : {.1, .5, .95}) {
      const Estimate found = floor_in_furnace(coated({1, 1, 1}, roughness), cosine);
      worst = std::max(worst, std::abs(found.mean - 1) - 3 * found.standard_error);
    }
  stability::at_most("light", "white under a coat in a furnace: distance from 1 past 3 standard errors", worst, 1e-3);
}

TEST(LightStability, PointLightANanometreAway) {
  for (const float height_m : {1e-9f, 1e-6f, 1e-3f, 1.f}) {
    Scene scene;
    add_mesh(scene, quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}), add_material(scene, matt({.5f, .5f, .5f})));
    scene.lights.push_back({"", LightKind::kPoint, {0, height_m, 0}, {}, {1, 1, 1}});
    scene.cameras.push_back(looking({0, 2, 0}, {0, 0, 0}, 1e-12));
    const auto source = source_of(scene, 1, 1);
    const Sample sample = evaluate(*source, requests(1, 1, 1))[0];
    const double expected = .5 / kPiD / height_m / height_m;
    ASSERT_TRUE(sample.valid) << height_m;
    stability::at_most("light", fmt::format("point light {:g} m away: relative error", height_m),
                       std::abs(static_cast<double>(sample.rgb[0]) / expected - 1), 1e-5);
    EXPECT_EQ(source->invalid_samples(), 0u);
  }
}

TEST(LightStability, TotalInternalReflection) {
  // Past the critical angle asin(1 / 1.5) all is reflected, at it and just before it no more than all.
  double least = 1, most = 0, cosine = 0;
  const double critical = std::sqrt(1 - 1 / (1.5 * 1.5));
  for (int i = 0; i <= 1000; ++i) {
    float unused;
    const float reflected =
        fresnel_dielectric(static_cast<float>(critical * (i / 1000. * (1 - 1e-6))), 1 / 1.5f, unused);
    least = std::min(least, static_cast<double>(reflected));
    most = std::max(most, static_cast<double>(
                              fresnel_dielectric(static_cast<float>(critical * (1 + 3e-4 * i)), 1 / 1.5f, unused)));
    cosine = static_cast<double>(unused);
  }
  EXPECT_GT(cosine, 0);
  stability::equal("light", "total reflection: least reflectance past the critical angle", least, 1);
  stability::at_most("light", "total reflection: largest reflectance before it", most, 1);

  // A ray along the diagonal of a cube of glass meets every face at 54.7 degrees and never leaves: it must end, dark.
  Scene scene;
  const int material = add_material(scene, glass(1.5f));
  for (const auto& [corner, a, b] : {std::tuple{Float3{-1, -1, 1}, Float3{2, 0, 0}, Float3{0, 2, 0}},
                                     {{1, -1, -1}, {-2, 0, 0}, {0, 2, 0}},
                                     {{1, -1, 1}, {0, 0, -2}, {0, 2, 0}},
                                     {{-1, -1, -1}, {0, 0, 2}, {0, 2, 0}},
                                     {{-1, 1, 1}, {2, 0, 0}, {0, 0, -2}},
                                     {{-1, -1, -1}, {2, 0, 0}, {0, 0, 2}}})
    add_mesh(scene, quad(corner, a, b), material);
  scene.environment.radiance = {1, 1, 1};
  scene.cameras.push_back(looking({-.3, -.2, -.1}, {.7, .8, .9}, .01));
  const auto source = source_of(scene, 8, 8);
  const auto samples = evaluate(*source, requests(8, 8, 16));
  uint64_t lit = 0;
  for (const Sample& sample : samples) lit += !sample.valid || sample.rgb != std::array<float, 3>{};
  stability::never("light", "light trapped in a glass cube: samples lit", lit, samples.size());
}

TEST(LightStability, TenThousandLights) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> unit(0, 1);
  Scene scene;
  add_mesh(scene, quad({-.01f, 0, .01f}, {.02f, 0, 0}, {0, 0, -.02f}), add_material(scene, matt({.5f, .5f, .5f})));
  double expected = 0;
  for (int i = 0; i < 10'000; ++i) {
    const Float3 at{4 * unit(random) - 2, 1 + unit(random), 4 * unit(random) - 2};
    const float candela = unit(random);
    scene.lights.push_back({"", LightKind::kPoint, at, {}, {candela, candela, candela}});
    const double x = at.x, y = at.y, z = at.z, square = x * x + y * y + z * z;
    expected += .5 / kPiD * static_cast<double>(candela) * y / (square * std::sqrt(square));
  }
  scene.cameras.push_back(looking({0, 1, 0}, {0, 0, 0}, 1e-5));
  const Estimate found = estimate(evaluate(*source_of(scene, 32, 32), requests(32, 32, 64)), 64);
  EXPECT_LT(found.standard_error, .003 * expected);
  stability::at_most("light", "10^4 lights: distance from their sum in standard errors",
                     std::abs(found.mean - expected) / found.standard_error, 3);
}

TEST(LightStability, BlackSceneIsBlackAndCostsCameraRaysOnly) {
  Scene scene = box(matt({1, 1, 1}), metal({1, 1, 1}, .5f));
  scene.materials[3].emission = {};
  const auto source = source_of(scene, 16, 16);
  const auto samples = evaluate(*source, requests(16, 16, 4));
  uint64_t lit = 0;
  for (const Sample& sample : samples) lit += !sample.valid || sample.rgb != std::array<float, 3>{};
  stability::never("light", "black scene: samples lit", lit, samples.size());
  EXPECT_EQ(source->rays(RayKind::kCamera), 1024u);
  stability::equal("light", "black scene: rays other than the camera's",
                   static_cast<double>(source->rays(RayKind::kShadow) + source->rays(RayKind::kDiffuse) +
                                       source->rays(RayKind::kGlossy) + source->rays(RayKind::kMirror)),
                   0);
}

}  // namespace triad::raytracer::testing
