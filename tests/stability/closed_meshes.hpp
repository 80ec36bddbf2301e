// SPDX-License-Identifier: Apache-2.0
// Closed meshes, and rays aimed at their edges and corners.
#pragma once

#include <random>

#include "../statistical/raytracer_scenes.hpp"
#include "raytracer/geometry.hpp"

namespace triad::raytracer::testing {

// A globe of 2 * sectors * (rings - 1) triangles; at its poles, fans of `sectors` needles.
inline Mesh globe(int rings, int sectors, float radius, Float3 centre) {
  Mesh mesh;
  const auto put = [&](double polar, double azimuth) {
    const double across = std::sin(polar);
    mesh.positions.push_back({static_cast<float>(centre.x + radius * across * std::cos(azimuth)),
                              static_cast<float>(centre.y + radius * std::cos(polar)),
                              static_cast<float>(centre.z + radius * across * std::sin(azimuth))});
  };
  for (int r = 1; r < rings; ++r)
    for (int s = 0; s < sectors; ++s) put(std::numbers::pi * r / rings, 2 * std::numbers::pi * s / sectors);
  put(0, 0);
  put(std::numbers::pi, 0);
  const auto at = [&](int r, int s) { return static_cast<uint32_t>((r - 1) * sectors + s % sectors); };
  const uint32_t top = static_cast<uint32_t>(mesh.positions.size()) - 2, bottom = top + 1;
  for (int s = 0; s < sectors; ++s) {
    mesh.indices.push_back({top, at(1, s + 1), at(1, s)});
    mesh.indices.push_back({bottom, at(rings - 1, s), at(rings - 1, s + 1)});
    for (int r = 1; r < rings - 1; ++r) {
      mesh.indices.push_back({at(r, s), at(r, s + 1), at(r + 1, s)});
      mesh.indices.push_back({at(r, s + 1), at(r + 1, s + 1), at(r + 1, s)});
    }
  }
  return mesh;
}

// A cylinder around y, `sides` needles in each cap and a band of needles around; with `pointed` a cone.
inline Mesh drum(int sides, float radius, float height, Float3 centre, bool pointed) {
  Mesh mesh;
  const auto n = static_cast<uint32_t>(sides);
  for (const float y : {-height / 2, height / 2}) {
    if (!pointed || y < 0)
      for (uint32_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        mesh.positions.push_back({static_cast<float>(centre.x + radius * std::cos(angle)), centre.y + y,
                                  static_cast<float>(centre.z + radius * std::sin(angle))});
      }
    mesh.positions.push_back({centre.x, centre.y + y, centre.z});
  }
  const uint32_t bottom = n, upper = n + 1, top = pointed ? n + 1 : 2 * n + 1;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t j = (i + 1) % n;
    mesh.indices.push_back({bottom, i, j});
    if (pointed) {
      mesh.indices.push_back({i, top, j});
    } else {
      mesh.indices.insert(mesh.indices.end(),
                          {{i, upper + i, j}, {j, upper + i, upper + j}, {top, upper + j, upper + i}});
    }
  }
  return mesh;
}

enum class Way { kPackets, kSingly, kShadows };

struct Leaks {
  uint64_t at_edges = 0, at_corners = 0, rays = 0;
};

// Rays in packets of kLanes, half of them at places on edges, half at corners. From inside (around `centre`, within
// `reach_m` of it in each direction), one that meets nothing has leaked. From outside (`reach_m` away), only places
// that look towards the origin count, and a ray has leaked unless it meets something no farther than its aim and
// `slack_m`.
inline Leaks leaks(const Geometry& geometry, const Mesh& mesh, Float3 centre, Float3 reach_m, bool outside,
                   float slack_m, uint64_t shots, Way way, uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto unit = [&random] { return static_cast<float>(random() >> 40) * 0x1p-24f; };
  const uint64_t keys[kLanes] = {};
  Ray rays[kLanes];
  HitId hits[kLanes];
  float aim_m[kLanes];
  Leaks leaks;
  for (uint64_t shot = 0; shot < shots; shot += kLanes) {
    uint32_t active = 0;
    for (uint32_t i = 0; i < kLanes; ++i) {
      const auto& corner = mesh.indices[random() % mesh.indices.size()];
      const Float3 a = mesh.positions[corner[0]], b = mesh.positions[corner[1]];
      const Float3 aim = i % 2 == 0 ? lerp(a, b, unit()) : a;
      Float3 from{2 * unit() - 1, 2 * unit() - 1, 2 * unit() - 1};
      if (outside) from = normalise(from);
      rays[i].origin = centre + from * reach_m;
      aim_m[i] = length(aim - rays[i].origin);
      rays[i].direction = (aim - rays[i].origin) * (1 / aim_m[i]);
      rays[i].end = way == Way::kShadows && outside ? aim_m[i] + slack_m : std::numeric_limits<float>::infinity();
      constexpr float kLooksHere = -.1f;
      if (!outside || dot(normalise_safely(aim - centre), rays[i].direction) < kLooksHere) active |= 1u << i;
    }
    uint32_t met = 0;
    if (way == Way::kShadows) {
      met = geometry.occluded(rays, active, keys, true);
    } else {
      geometry.intersect(rays, active, keys, way == Way::kPackets, hits);
      for (uint32_t i = 0; i < kLanes; ++i) {
        if ((active >> i & 1) == 0 || hits[i].mesh == kMiss) continue;
        if (!outside || geometry.surface(rays[i], hits[i], false).distance <= aim_m[i] + slack_m) met |= 1u << i;
      }
    }
    for (uint32_t i = 0; i < kLanes; ++i) {
      leaks.rays += active >> i & 1;
      (i % 2 == 0 ? leaks.at_edges : leaks.at_corners) += (active & ~met) >> i & 1;
    }
  }
  return leaks;
}

// A scene of that one mesh, and its tree.
struct Closed {
  explicit Closed(Mesh mesh) {
    add_mesh(scene, std::move(mesh), add_material(scene, matt({1, 1, 1})));
    scene.cameras.push_back({});
    geometry = std::make_unique<Geometry>(scene, EffectSet{}, SourceOptions{});
  }
  Scene scene;
  std::unique_ptr<Geometry> geometry;
};

}  // namespace triad::raytracer::testing
