// SPDX-License-Identifier: Apache-2.0
#include "bsdf.hpp"

#include <array>

namespace triad::raytracer {
namespace {

// Nodes of the table of coat albedos, over cosine and roughness, both from 0 to 1, and of its quadrature. Cosines lie
// at squares, close together near grazing incidence, where narrow lobes change within a hundredth.
constexpr int kCosines = 97, kRoughnesses = 33, kQuadrature = 16;

float cosine_at(int node) {
  const float x = static_cast<float>(node) / (kCosines - 1);
  return x * x;
}

struct CoatTable {
  std::array<std::array<CoatAlbedo, kCosines>, kRoughnesses> at;
  std::array<CoatAlbedo, kRoughnesses> mean;
};

CoatAlbedo integrate(float cosine, float roughness) {
  if (roughness == 0) return {1 - schlick_weight(cosine), schlick_weight(cosine)};
  const Ggx ggx{roughness * roughness};
  cosine = std::max(cosine, 1e-5f);  // stands for the limit at grazing incidence
  const Float3 to{std::sqrt(1 - cosine * cosine), 0, cosine};
  double at_normal = 0, at_grazing = 0;
  for (int i = 0; i < kQuadrature; ++i) {
    for (int j = 0; j < kQuadrature; ++j) {
      const Float3 half = ggx.sample_half(to, (static_cast<float>(i) + .5f) / kQuadrature,
                                          (static_cast<float>(j) + .5f) / kQuadrature);
      const Float3 from = half * (2 * dot(to, half)) - to;
      if (!(from.z > 0)) continue;
      const float weight = ggx.masking_shadowing(to, from) / ggx.masking(to);
      const float grazing = schlick_weight(dot(to, half));
      at_normal += static_cast<double>(weight * (1 - grazing));
      at_grazing += static_cast<double>(weight * grazing);
    }
  }
  constexpr double kPoints = kQuadrature * kQuadrature;
  return {static_cast<float>(at_normal / kPoints), static_cast<float>(at_grazing / kPoints)};
}

CoatTable make_table() {
  CoatTable table;
  for (int r = 0; r < kRoughnesses; ++r) {
    auto& row = table.at[r];
    for (int c = 0; c < kCosines; ++c) row[c] = integrate(cosine_at(c), static_cast<float>(r) / (kRoughnesses - 1));
    // Twice the integral of cosine times E, which is linear between nodes.
    double at_normal = 0, at_grazing = 0;
    for (int c = 0; c + 1 < kCosines; ++c) {
      const double a = cosine_at(c), b = cosine_at(c + 1), third = (b - a) / 3;
      at_normal += third * (row[c].at_normal * (2 * a + b) + row[c + 1].at_normal * (a + 2 * b));
      at_grazing += third * (row[c].at_grazing * (2 * a + b) + row[c + 1].at_grazing * (a + 2 * b));
    }
    table.mean[r] = {static_cast<float>(at_normal), static_cast<float>(at_grazing)};
  }
  return table;
}

const CoatTable& coat_table() {
  static const CoatTable table = make_table();
  return table;
}

CoatAlbedo mix(CoatAlbedo a, CoatAlbedo b, float t) {
  return {a.at_normal + (b.at_normal - a.at_normal) * t, a.at_grazing + (b.at_grazing - a.at_grazing) * t};
}

struct Node {
  int index;
  float fraction;
};

Node roughness_node(float roughness) {
  const float position = std::clamp(roughness, 0.f, 1.f) * (kRoughnesses - 1);
  const int index = std::min(static_cast<int>(position), kRoughnesses - 2);
  return {index, position - static_cast<float>(index)};
}

Node cosine_node(float cosine) {
  cosine = std::clamp(cosine, 0.f, 1.f);
  const int index = std::min(static_cast<int>(std::sqrt(cosine) * (kCosines - 1)), kCosines - 2);
  const float below = cosine_at(index);
  return {index, (cosine - below) / (cosine_at(index + 1) - below)};
}

}  // namespace

float fresnel_dielectric(float cos_i, float eta, float& cos_t) {
  cos_t = cos_i;
  if (eta == 1) return 0;
  const float sin2_t = (1 - cos_i) * (1 + cos_i) / (eta * eta);
  if (sin2_t >= 1) {
    cos_t = 0;
    return 1;
  }
  cos_t = std::sqrt(1 - sin2_t);
  const float parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const float perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  return (parallel * parallel + perpendicular * perpendicular) / 2;
}

Float3 Ggx::sample_half(Float3 to, float u, float v) const {
  const Float3 stretched = normalise({alpha * to.x, alpha * to.y, to.z});
  const float across2 = stretched.x * stretched.x + stretched.y * stretched.y;
  const Float3 t1 = across2 > 0 ? Float3{-stretched.y, stretched.x, 0} / std::sqrt(across2) : Float3{1, 0, 0};
  const Float3 t2 = cross(stretched, t1);
  const float radius = std::sqrt(u), angle = 2 * kPi * v;
  const float p1 = radius * std::cos(angle), s = (1 + stretched.z) / 2;
  const float p2 = (1 - s) * std::sqrt(std::max(0.f, 1 - p1 * p1)) + s * radius * std::sin(angle);
  const Float3 normal = t1 * p1 + t2 * p2 + stretched * std::sqrt(std::max(0.f, 1 - p1 * p1 - p2 * p2));
  return normalise({alpha * normal.x, alpha * normal.y, std::max(0.f, normal.z)});
}

CoatAlbedo coat_albedo(float cosine, float roughness) {
  if (roughness == 0) {  // the table's first row, as it is interpolated
    const Node c = cosine_node(cosine);
    const float below = schlick_weight(cosine_at(c.index)), above = schlick_weight(cosine_at(c.index + 1));
    const float grazing = below + (above - below) * c.fraction;
    return {1 - grazing, grazing};
  }
  const CoatTable& table = coat_table();
  const Node c = cosine_node(cosine), r = roughness_node(roughness);
  const auto &low = table.at[r.index], &high = table.at[r.index + 1];
  return mix(mix(low[c.index], low[c.index + 1], c.fraction), mix(high[c.index], high[c.index + 1], c.fraction),
             r.fraction);
}

CoatAlbedo mean_coat_albedo(float roughness) {
  const CoatTable& table = coat_table();
  const Node r = roughness_node(roughness);
  return mix(table.mean[r.index], table.mean[r.index + 1], r.fraction);
}

}  // namespace triad::raytracer
