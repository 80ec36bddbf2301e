// SPDX-License-Identifier: Apache-2.0
// Lights as something to aim at: chosen with probability proportional to their power, then a point on them.
#pragma once

#include <cstdint>
#include <vector>

#include "effects.hpp"
#include "geometry.hpp"

namespace triad::raytracer {

// Draws i with probability weights[i] / sum in constant time: Vose, A Linear Algorithm for Generating Random Numbers
// with a Given Distribution, IEEE TSE 17(9), 1991. Weights that are not positive and finite count as 0.
class AliasTable {
 public:
  AliasTable() = default;
  explicit AliasTable(const std::vector<double>& weights);
  bool empty() const { return entries_.empty(); }  // no weights, or all 0
  // u in [0, 1). What the choice leaves of it becomes a new uniform number in [0, 1): an interval of u belongs to
  // each entry (two, where it is an alias), so that points stratified in u are stratified on what is chosen.
  uint32_t draw(double& u) const;
  size_t size() const { return entries_.size(); }
  float probability(uint32_t i) const { return entries_[i].probability; }
  uint64_t memory_bytes() const { return entries_.size() * sizeof(Entry); }

 private:
  struct Entry {
    float keep, probability;
    uint32_t alias;
  };
  std::vector<Entry> entries_;
};

// Light that arrives at a point from one direction.
struct LightSample {
  Float3 towards;   // unit length, from the point to the light
  float distance;   // infinite for lights without a place
  Float3 radiance;  // over its density: radiance / pdf, or irradiance / probability for lights without size
  float pdf = 0;    // per solid angle, the choice of the light included; 0: a light without size, that no ray can hit
  Float3 end;       // of the shadow ray, if distance is finite
};

class Lights {
 public:
  Lights(const Scene& scene, const Geometry& geometry, EffectSet effects);

  bool empty() const { return choice_.empty(); }
  // Whether the 24 bits of a float are too few to choose a light and a place on it.
  bool many() const { return choice_.size() > 256; }
  // u, v in [0, 1): u chooses the light, and what the choice leaves of it is the first coordinate on the light. False
  // if no light reaches the point from there (a lamp's back, outside of a cone).
  bool sample(Float3 point, float time, double u, float v, bool textures, LightSample& light) const;

  // Density per solid angle of sample() for a direction that met this emitting triangle; 0: it never aims there.
  float pdf(HitId triangle, float area_m2, float distance_m, float cosine) const;
  // Likewise for a direction that met nothing.
  float environment_pdf(Float3 towards) const;
  bool aims_at_environment() const { return environment_entry_ != kNone; }
  uint64_t memory_bytes() const;

 private:
  static constexpr uint32_t kNone = ~0u;
  bool sample_punctual(const Light& light, Float3 point, float scale, LightSample& out) const;
  // An emitting triangle with all that aiming at it reads.
  struct Lamp {
    std::array<Float3, 3> corners;
    Float3 normal;  // unit length, or 0 where the area is
    float area_m2;
    Float3 emission;
    bool double_sided, pictured;  // pictured: its emission has a texture
    bool moves;                   // corners, normal and area are those at time 0
    HitId id;
  };
  void place_lamp(Lamp& lamp, float time) const;
  bool sample_triangle(const Lamp& lamp, Float3 point, float u, float v, float probability, bool textures,
                       LightSample& out) const;
  // a, b, c: the weights of the triangle's second, third and first corner.
  Float3 pictured_emission(HitId triangle, float a, float b, float c) const;
  bool sample_environment(float u, float v, LightSample& out) const;
  void make_environment(std::vector<double>& powers, double scene_radius_m, EffectSet effects);

  const Scene& scene_;
  const Geometry& geometry_;
  AliasTable choice_;
  std::vector<uint32_t> punctual_;       // entry -> index into Scene::lights; the first entries
  std::vector<Lamp> lamps_;              // the next entries
  std::vector<uint32_t> first_of_mesh_;  // mesh -> entry of its first triangle, or kNone
  uint32_t environment_entry_ = kNone;   // the last entry
  // Cumulative distributions of the environment image, by row and within each row; each ends in 1.
  std::vector<float> row_cdf_, column_cdf_;
};

// What a triangle sends out from its front (and back, if double-sided) at a point with these coordinates.
Float3 emitted_radiance(const Scene& scene, const Material& material, const std::array<Float2, 2>& uv, bool textures);

}  // namespace triad::raytracer
