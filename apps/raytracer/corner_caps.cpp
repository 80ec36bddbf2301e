// SPDX-License-Identifier: Apache-2.0
#include "corner_caps.hpp"

#include <tbb/parallel_sort.h>

#include <cmath>
#include <numeric>

#include "vec.hpp"

namespace triad::raytracer {
namespace {

constexpr double kEpsilon = std::numeric_limits<float>::epsilon();
// Circumradius of a cap: this much of the longest edge that ends there, but no more than kCapMost of the shortest.
// Small, so that few rays ask about it; it suffices for rays from as far as some 4,000 of those edges.
constexpr double kCapSize = 1. / 128, kCapMost = 2;
constexpr double kGraze = 8 * kEpsilon;

Double3 minus(Float3 a, Float3 b) {
  return {static_cast<double>(a.x) - b.x, static_cast<double>(a.y) - b.y, static_cast<double>(a.z) - b.z};
}
Double3 times(Double3 a, Double3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
double inner(Double3 a, Double3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double size_of(Double3 a) { return std::sqrt(inner(a, a)); }
Double3 scaled(Double3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }

// Unit length, or 0 for a triangle without area.
Double3 unit_normal(const std::vector<Float3>& positions, const std::array<uint32_t, 3>& corner) {
  const Double3 normal =
      times(minus(positions[corner[1]], positions[corner[0]]), minus(positions[corner[2]], positions[corner[0]]));
  const double size = size_of(normal);
  return size > 0 ? scaled(normal, 1 / size) : Double3{};
}

// What the triangles around each cap's corner have in common.
struct Fan {
  Double3 normal;
  double shortest_m = std::numeric_limits<double>::infinity(), longest_m = 0;
};

std::vector<Fan> fans(const Mesh& mesh, const std::vector<Float3>& positions, const std::vector<uint32_t>& cap_of,
                      size_t count) {
  std::vector<Fan> list(count);
  for (const auto& corner : mesh.indices) {
    const Double3 normal = unit_normal(positions, corner);
    if (normal == Double3{}) continue;
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t a = corner[i], b = corner[(i + 1) % 3];
      const double edge_m = size_of(minus(positions[a], positions[b]));
      Double3& sum = list[cap_of[a]].normal;
      sum = {sum.x + normal.x, sum.y + normal.y, sum.z + normal.z};
      for (const uint32_t end : {a, b}) {
        Fan& fan = list[cap_of[end]];
        fan.shortest_m = std::min(fan.shortest_m, edge_m);
        fan.longest_m = std::max(fan.longest_m, edge_m);
      }
    }
  }
  return list;
}

}  // namespace

CornerCaps::CornerCaps(const Mesh& mesh, bool motion) : cap_of_vertex_(mesh.positions.size()) {
  std::vector<const std::vector<Float3>*> steps{&mesh.positions};
  if (motion)
    for (const auto& later : mesh.motion_positions) steps.push_back(&later);
  // -1, 0 or 1 as vertex a lies before, at or after vertex b.
  const auto compare = [&steps](uint32_t a, uint32_t b) {
    for (const auto* positions : steps) {
      const Float3 p = (*positions)[a], q = (*positions)[b];
      for (const auto& [s, t] : {std::pair{p.x, q.x}, {p.y, q.y}, {p.z, q.z}})
        if (s != t) return s < t ? -1 : 1;
    }
    return 0;
  };
  std::vector<uint32_t> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0u);
  tbb::parallel_sort(order.begin(), order.end(), [&compare](uint32_t a, uint32_t b) {
    const int by_place = compare(a, b);
    return by_place != 0 ? by_place < 0 : a < b;
  });
  for (size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || compare(order[i - 1], order[i]) != 0) caps_.push_back({order[i], kNone});
    cap_of_vertex_[order[i]] = static_cast<uint32_t>(caps_.size() - 1);
  }

  const std::vector<Fan> around = fans(mesh, mesh.positions, cap_of_vertex_, caps_.size());
  std::vector<double> likeness(caps_.size(), -std::numeric_limits<double>::infinity());
  for (size_t t = 0; t < mesh.indices.size(); ++t) {
    const Double3 normal = unit_normal(mesh.positions, mesh.indices[t]);
    if (normal == Double3{}) continue;
    for (const uint32_t vertex : mesh.indices[t]) {
      const uint32_t cap = cap_of_vertex_[vertex];
      const double like = inner(normal, around[cap].normal);
      if (!(like > likeness[cap])) continue;
      likeness[cap] = like;
      caps_[cap].triangle = static_cast<uint32_t>(t);
    }
  }

  std::vector<uint32_t> number(caps_.size());
  uint32_t kept = 0;
  for (size_t cap = 0; cap < caps_.size(); ++cap) {
    number[cap] = kept;
    if (caps_[cap].triangle != kNone) caps_[kept++] = caps_[cap];
  }
  caps_.resize(kept);
  // Vertices without a cap get any number: no triangle with an area asks for it.
  for (uint32_t& cap : cap_of_vertex_) cap = number[cap];
}

void CornerCaps::place(const Mesh& mesh, const std::vector<Float3>& positions, Float3* corners) const {
  const std::vector<Fan> around = fans(mesh, positions, cap_of_vertex_, caps_.size() + 1);
  for (size_t i = 0; i < caps_.size(); ++i) {
    const Float3 at = positions[caps_[i].vertex];
    const double size = size_of(around[i].normal);
    // A fan folded flat has no common normal: then any will do.
    const Double3 normal = size > 1e-6 ? scaled(around[i].normal, 1 / size) : Double3{0, 0, 1};
    const double largest = std::max(std::abs(double{at.x}), std::max(std::abs(double{at.y}), std::abs(double{at.z})));
    // Not smaller than what floats this large can tell apart.
    const double radius_m =
        std::max(std::min(kCapSize * around[i].longest_m, kCapMost * around[i].shortest_m), 4 * kEpsilon * largest);
    const Double3 aside = std::abs(normal.x) < .5 ? Double3{1, 0, 0} : Double3{0, 1, 0};
    const Double3 across = times(normal, aside), x = scaled(across, radius_m / size_of(across)), y = times(normal, x);
    constexpr double kHalfRoot3 = .86602540378443865;
    for (const auto& [s, t] : {std::pair{1., 0.}, {-.5, kHalfRoot3}, {-.5, -kHalfRoot3}})
      *corners++ = {static_cast<float>(at.x + s * x.x + t * y.x), static_cast<float>(at.y + s * x.y + t * y.y),
                    static_cast<float>(at.z + s * x.z + t * y.z)};
  }
}

bool grazes_corner(Double3 origin, Double3 direction, Float3 corner) {
  const Double3 way{corner.x - origin.x, corner.y - origin.y, corner.z - origin.z}, aside = times(way, direction);
  return inner(aside, aside) <= kGraze * kGraze * inner(way, way) * inner(direction, direction);
}

}  // namespace triad::raytracer
