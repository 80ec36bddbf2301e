// SPDX-License-Identifier: Apache-2.0
// What keeps closed meshes closed at their corners.
//
// Embree's robust test (Pluecker coordinates) signs an edge alike for both of its triangles, so nothing passes
// between them. Around a corner, though, where a ray comes within rounding of the ends of all edges, their signs may
// by chance all agree, and then none of the triangles is hit: 1 % of the rays aimed at a corner to the last bit find
// such a pinhole, if the triangles are small beside their distance. So each corner gets a tiny triangle of its own, a
// cap across the fan, that counts only for rays that pass within those roundings of the corner.
// Growing the triangles until they overlap is no remedy: grown edges no longer coincide, and leak themselves.
#pragma once

#include <cstdint>
#include <vector>

#include "scene.hpp"

namespace triad::raytracer {

struct CornerCap {
  uint32_t vertex;    // of the mesh, one of those at this place
  uint32_t triangle;  // of those that meet here, the one most like all of them together: what a hit counts as
};

// The caps of one mesh. Vertices at the same place (over the shutter's time, too) share one; corners that touch no
// triangle with an area have none.
class CornerCaps {
 public:
  // Without motion, only the mesh's first positions count. Takes some .3 s for a million triangles.
  CornerCaps(const Mesh& mesh, bool motion);

  const std::vector<CornerCap>& caps() const { return caps_; }
  // Three corners for each cap, from the mesh's positions at one step of the motion.
  void place(const Mesh& mesh, const std::vector<Float3>& positions, Float3* corners) const;

 private:
  static constexpr uint32_t kNone = ~0u;
  std::vector<uint32_t> cap_of_vertex_;
  std::vector<CornerCap> caps_;
};

// Whether a ray's line passes so close by a corner that rounding may make it miss all triangles there: 8 ulps of
// their distance (Embree forms corners relative to the origin, their products and sums of three of those).
bool grazes_corner(Double3 origin, Double3 direction, Float3 corner);

}  // namespace triad::raytracer
