// SPDX-License-Identifier: Apache-2.0
// Scenes in code for the ray tracer's tests, and what to do with their samples.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <span>
#include <thread>
#include <vector>

#include "raytracer/scene.hpp"
#include "raytracer/scene_source.hpp"

namespace triad::raytracer::testing {

inline Material matt(Float3 colour) {
  Material material;
  material.base_color = colour;
  material.metallic = 0;
  material.ior = 1;  // no coat
  return material;
}
inline Material metal(Float3 colour, float roughness) {
  Material material;
  material.base_color = colour;
  material.metallic = 1;
  material.roughness = roughness;
  return material;
}
inline Material coated(Float3 colour, float roughness) {
  Material material = matt(colour);
  material.ior = 1.5f;
  material.roughness = roughness;
  return material;
}
inline Material glass(float ior) {
  Material material = matt({1, 1, 1});
  material.ior = ior;
  material.transmission = 1;
  material.roughness = 0;
  return material;
}
inline Material lamp(Float3 radiance) {
  Material material = matt({0, 0, 0});
  material.emission = radiance;
  return material;
}

inline int add_material(Scene& scene, Material material) {
  scene.materials.push_back(std::move(material));
  return static_cast<int>(scene.materials.size()) - 1;
}

inline void add_mesh(Scene& scene, Mesh mesh, int material) {
  if (scene.meshes.empty()) scene.bounds_min_m = scene.bounds_max_m = mesh.positions[0];
  for (const Float3 p : mesh.positions) {
    scene.bounds_min_m = {std::min(scene.bounds_min_m.x, p.x), std::min(scene.bounds_min_m.y, p.y),
                          std::min(scene.bounds_min_m.z, p.z)};
    scene.bounds_max_m = {std::max(scene.bounds_max_m.x, p.x), std::max(scene.bounds_max_m.y, p.y),
                          std::max(scene.bounds_max_m.z, p.z)};
  }
  mesh.material = material;
  mesh.object_id = static_cast<uint32_t>(scene.meshes.size()) + 1;
  scene.meshes.push_back(std::move(mesh));
}

// A parallelogram; its front is where a x b points.
inline Mesh quad(Float3 corner, Float3 a, Float3 b) {
  const auto at = [&](float s, float t) {
    return Float3{corner.x + s * a.x + t * b.x, corner.y + s * a.y + t * b.y, corner.z + s * a.z + t * b.z};
  };
  Mesh mesh;
  mesh.positions = {at(0, 0), at(1, 0), at(1, 1), at(0, 1)};
  mesh.texcoords[0] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.indices = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

// A closed ball of 20 * 4^levels triangles, its front outside, flat shading.
inline Mesh ball(int levels, float radius = 1, Float3 centre = {}) {
  Mesh mesh;
  const float g = static_cast<float>(std::numbers::phi);
  std::vector<Float3> at{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                         {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.indices = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto key = std::minmax(a, b);
      const auto [found, fresh] = middles.try_emplace(key, static_cast<uint32_t>(at.size()));
      if (fresh) at.push_back({(at[a].x + at[b].x) / 2, (at[a].y + at[b].y) / 2, (at[a].z + at[b].z) / 2});
      return found->second;
    };
    std::vector<std::array<uint32_t, 3>> finer;
    for (const auto& t : mesh.indices) {
      const uint32_t a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {t[1], b, a}, {t[2], c, b}, {a, b, c}});
    }
    mesh.indices = std::move(finer);
  }
  for (const Float3 p : at) {
    const float scale = radius / std::hypot(p.x, p.y, p.z);
    mesh.positions.push_back({p.x * scale + centre.x, p.y * scale + centre.y, p.z * scale + centre.z});
  }
  return mesh;
}

// A camera at `from` that looks at `at`, seeing 2 * half_height_m upright, in parallel.
inline Camera looking(Double3 from, Double3 at, double half_height_m) {
  const auto unit = [](Double3 v) {
    const double size = std::hypot(v.x, v.y, v.z);
    return Double3{v.x / size, v.y / size, v.z / size};
  };
  const auto cross = [](Double3 a, Double3 b) {
    return Double3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  };
  Camera camera;
  camera.orthographic = true;
  camera.half_height_m = half_height_m;
  CameraPose& pose = camera.poses[0];
  pose.position_m = from;
  pose.forward = unit({at.x - from.x, at.y - from.y, at.z - from.z});
  const Double3 up = std::abs(pose.forward.y) > .99 ? Double3{0, 0, 1} : Double3{0, 1, 0};
  pose.right = unit(cross(pose.forward, up));
  pose.up = cross(pose.right, pose.forward);
  return camera;
}

// A room of 2 x 2 x 2 m around the origin, open towards the camera, with a lamp under the ceiling and two balls.
inline Scene box(Material first, Material second) {
  Scene scene;
  const int white = add_material(scene, matt({.7f, .7f, .7f})), red = add_material(scene, matt({.6f, .1f, .1f}));
  const int green = add_material(scene, matt({.1f, .5f, .1f})), light = add_material(scene, lamp({8, 7, 5}));
  add_mesh(scene, quad({-1, -1, 1}, {2, 0, 0}, {0, 0, -2}), white);
  add_mesh(scene, quad({-1, 1, -1}, {2, 0, 0}, {0, 0, 2}), white);
  add_mesh(scene, quad({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}), white);
  add_mesh(scene, quad({-1, -1, 1}, {0, 0, -2}, {0, 2, 0}), red);
  add_mesh(scene, quad({1, -1, -1}, {0, 0, 2}, {0, 2, 0}), green);
  add_mesh(scene, quad({-.3f, .98f, -.3f}, {.6f, 0, 0}, {0, 0, .6f}), light);
  add_mesh(scene, ball(2, .4f, {-.4f, -.6f, -.3f}), add_material(scene, std::move(first)));
  add_mesh(scene, ball(2, .35f, {.45f, -.65f, .2f}), add_material(scene, std::move(second)));
  Camera camera;
  camera.yfov_rad = .7;
  camera.poses[0].position_m = {0, 0, 3.8};
  scene.cameras = {camera};
  return scene;
}

inline std::vector<SampleRequest> requests(int width, int height, int spp, uint64_t seed = 0) {
  std::vector<SampleRequest> list;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int i = 0; i < spp; ++i) list.push_back({x + .5, y + .5, 1, x, y, static_cast<uint32_t>(i), seed});
  return list;
}

// In pieces of `piece` requests on `threads` threads.
inline std::vector<Sample> evaluate(const Source& source, const std::vector<SampleRequest>& list, int threads = 2,
                                    size_t piece = 4096) {
  std::vector<Sample> samples(list.size());
  std::atomic<size_t> next{0};
  const auto work = [&] {
    for (size_t first; (first = next.fetch_add(piece)) < list.size();) {
      const size_t n = std::min(piece, list.size() - first);
      source.eval(std::span(list).subspan(first, n), std::span(samples).subspan(first, n));
    }
  };
  std::vector<std::jthread> pool;
  for (int i = 1; i < threads; ++i) pool.emplace_back(work);
  work();
  return samples;
}

// Mean of the green channel over pixels, and its standard error from the scatter of the pixels' means: right even
// though the samples of one pixel are not independent, as long as all pixels see the same.
struct Estimate {
  double mean = 0, standard_error = 0;
};
inline Estimate estimate(const std::vector<Sample>& samples, int spp) {
  const size_t pixels = samples.size() / static_cast<size_t>(spp);
  double sum = 0, squares = 0;
  for (size_t p = 0; p < pixels; ++p) {
    double pixel = 0;
    for (int i = 0; i < spp; ++i) pixel += static_cast<double>(samples[p * spp + i].rgb[1]) / spp;
    sum += pixel;
    squares += pixel * pixel;
  }
  const double n = static_cast<double>(pixels), mean = sum / n;
  return {mean, std::sqrt(std::max(0., squares / n - mean * mean) / (n - 1))};
}

inline std::unique_ptr<SceneSource> source_of(const Scene& scene, int width, int height, SourceOptions options = {}) {
  options.width = width;
  options.height = height;
  return make_scene_source(std::make_shared<const Scene>(scene), options);
}

}  // namespace triad::raytracer::testing
