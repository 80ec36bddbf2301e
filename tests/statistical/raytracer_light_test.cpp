// SPDX-License-Identifier: Apache-2.0
// How much light there is: form factors, two seeds, and a second estimator. Furnaces: tests/stability/light_test.cpp.
#include <gtest/gtest.h>

#include "raytracer/camera.hpp"
#include "raytracer/geometry.hpp"
#include "raytracer_scenes.hpp"

namespace triad::raytracer::testing {
namespace {

constexpr double kPiD = std::numbers::pi;

// A matt floor of albedo .5 at the origin, a lamp of radiance 1 above it that shines down, seen from the side.
Estimate floor_under(Mesh lamp_mesh) {
  Scene scene;
  add_mesh(scene, quad({-.1f, 0, .1f}, {.2f, 0, 0}, {0, 0, -.2f}), add_material(scene, matt({.5f, .5f, .5f})));
  add_mesh(scene, std::move(lamp_mesh), add_material(scene, lamp({1, 1, 1})));
  scene.cameras.push_back(looking({3, .6, 0}, {0, 0, 0}, 1e-5));
  return estimate(evaluate(*source_of(scene, 64, 64), requests(64, 64, 64)), 64);
}

TEST(FormFactor, Rectangle) {
  // Point under the rectangle's corner, from a and b, its sides over its height (Modest, Radiative Heat Transfer,
  // appendix D, configuration 11); four of them for the middle.
  for (const auto& [width, depth, height] : {std::tuple{2., 1., 1.}, {.5, .5, .25}, {.2, .2, 1.}}) {
    const double a = width / 2 / height, b = depth / 2 / height, ra = std::sqrt(1 + a * a), rb = std::sqrt(1 + b * b);
    const double factor = 4 / (2 * kPiD) * (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb));
    const float w = static_cast<float>(width), d = static_cast<float>(depth), h = static_cast<float>(height);
    const Estimate found = floor_under(quad({-w / 2, h, -d / 2}, {w, 0, 0}, {0, 0, d}));
    EXPECT_NEAR(found.mean, .5 * factor, 3 * found.standard_error) << width << " " << depth << " " << height;
    EXPECT_LT(found.standard_error, .005 * factor);
  }
}

TEST(FormFactor, Disc) {
  constexpr int kSides = 512;
  for (const auto& [radius, height] : {std::pair{1., 1.}, {.2, 1.}, {.5, .2}}) {
    Mesh disc;
    disc.positions.push_back({0, static_cast<float>(height), 0});
    for (uint32_t i = 0; i < kSides; ++i) {
      const double angle = 2 * kPiD * i / kSides;
      disc.positions.push_back({static_cast<float>(radius * std::cos(angle)), static_cast<float>(height),
                                static_cast<float>(radius * std::sin(angle))});
      disc.indices.push_back({0, i + 1, (i + 1) % kSides + 1});
    }
    const double factor = radius * radius / (radius * radius + height * height);
    const Estimate found = floor_under(std::move(disc));
    // A polygon of 512 sides is smaller than its circle by 2.5e-5.
    EXPECT_NEAR(found.mean, .5 * factor, 3 * found.standard_error + 2.5e-5 * factor) << radius << " " << height;
    EXPECT_LT(found.standard_error, .005 * factor);
  }
}

TEST(Estimator, TwoSeedsAgree) {
  constexpr int kSide = 12, kSpp = 256;
  for (const Scene& scene : {box(matt({.5f, .5f, .5f}), matt({.2f, .3f, .9f})),
                             box(metal({.9f, .8f, .5f}, .3f), coated({.5f, .1f, .1f}, .2f))}) {
    const auto source = source_of(scene, kSide, kSide);
    const auto a = evaluate(*source, requests(kSide, kSide, kSpp, 1));
    const auto b = evaluate(*source, requests(kSide, kSide, kSpp, 2));
    EXPECT_NE(a[kSpp * 70].rgb, b[kSpp * 70].rgb);
    // Paths are stratified, so the scatter of single samples overstates the error of the means, and no z is too
    // large.
    int beyond = 0;
    double difference = 0, total_variance = 0;
    for (int p = 0; p < kSide * kSide; ++p) {
      double sum[2] = {}, squares[2] = {};
      for (int i = 0; i < kSpp; ++i) {
        const double x = a[p * kSpp + i].rgb[1], y = b[p * kSpp + i].rgb[1];
        sum[0] += x, sum[1] += y, squares[0] += x * x, squares[1] += y * y;
      }
      const auto variance = [&](int s) { return (squares[s] - sum[s] * sum[s] / kSpp) / (kSpp - 1) / kSpp; };
      const double both = variance(0) + variance(1);
      difference += (sum[0] - sum[1]) / kSpp;
      total_variance += both;
      if (std::abs(sum[0] - sum[1]) / kSpp > 4 * std::sqrt(both) + 1e-12) ++beyond;
    }
    EXPECT_EQ(beyond, 0);
    EXPECT_LT(std::abs(difference), 4 * std::sqrt(total_variance));
  }
}

// A second estimator with nothing in common but the triangles: directions uniform over the hemisphere, no light is
// ever aimed at, no roulette, no stratification. Matt surfaces only.
double slow_path(const Scene& scene, const Geometry& geometry, Ray ray, uint64_t& state) {
  const auto uniform = [&] {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state >> 11) * 0x1p-53;
  };
  const uint64_t keys[kLanes] = {};
  double radiance = 0, throughput = 1;
  for (int depth = 0; depth < 12; ++depth) {
    HitId hit;
    geometry.intersect(&ray, 1, keys, false, &hit);
    if (hit.mesh == kMiss) return radiance;
    const Surface surface = geometry.surface(ray, hit, false);
    const Material& material = scene.materials[static_cast<size_t>(scene.meshes[hit.mesh].material)];
    const bool front = dot(ray.direction, surface.geometric_normal) < 0;
    const Float3 normal = front ? surface.geometric_normal : -surface.geometric_normal;
    if (front) radiance += throughput * static_cast<double>(material.emission.y);
    const double z = uniform(), angle = 2 * kPiD * uniform(), r = std::sqrt(1 - z * z);
    throughput *= static_cast<double>(material.base_color.y) * 2 * z;
    if (throughput <= 0) return radiance;
    const Float3 local{static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle)),
                       static_cast<float>(z)};
    ray.direction = normalise(Frame(normal).to_world(local));
    ray.origin = surface.position + normal * surface.offset_m;
  }
  return radiance;
}

TEST(Estimator, AgreesWithOneThatNeverAimsAtLights) {
  constexpr int kSide = 6, kSpp = 1024, kSlow = 8192;
  Scene scene = box(matt({.5f, .5f, .5f}), matt({.2f, .3f, .9f}));
  scene.meshes[5] = quad({-.8f, .98f, -.8f}, {1.6f, 0, 0}, {0, 0, 1.6f});
  scene.meshes[5].material = 3;
  const Geometry geometry(scene, {}, {});
  SourceOptions options;
  options.max_depth = 10;
  const auto source = source_of(scene, kSide, kSide, options);
  auto list = requests(kSide, kSide, kSpp);
  for (SampleRequest& request : list) request.x += .07;  // no ray into the room's edges, where two answers are right
  const auto fast = evaluate(*source, list);
  SourceOptions film;
  film.width = film.height = kSide;
  const FilmCamera camera(scene.cameras[0], film, {});
  uint64_t state = 7;
  double difference = 0, variance = 0;
  for (int p = 0; p < kSide * kSide; ++p) {
    double mean = 0, sum = 0, squares = 0;
    for (int i = 0; i < kSpp; ++i) mean += static_cast<double>(fast[p * kSpp + i].rgb[1]) / kSpp;
    const Ray ray = camera.ray(list[p * kSpp].x, list[p * kSpp].y, 0, 0, 0);
    for (int i = 0; i < kSlow; ++i) {
      const double x = slow_path(scene, geometry, ray, state);
      sum += x, squares += x * x;
    }
    const double of_mean = (squares / kSlow - sum * sum / kSlow / kSlow) / kSlow;
    EXPECT_NEAR(mean, sum / kSlow, 4.5 * std::sqrt(of_mean) + .03 * mean) << p;
    difference += mean - sum / kSlow;
    variance += of_mean;
  }
  EXPECT_LT(std::abs(difference), 4 * std::sqrt(variance));
}

}  // namespace
}  // namespace triad::raytracer::testing
