// SPDX-License-Identifier: Apache-2.0
#include "lights.hpp"

#include <numbers>

#include "texture.hpp"

namespace triad::raytracer {
namespace {

constexpr double kPiD = std::numbers::pi;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

double area_of(const std::array<Float3, 3>& corners) {
  const auto edge = [&](int i) {
    return std::array<double, 3>{double{corners[i].x} - corners[0].x, double{corners[i].y} - corners[0].y,
                                 double{corners[i].z} - corners[0].z};
  };
  const auto a = edge(1), b = edge(2);
  const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
  return std::sqrt(x * x + y * y + z * z) / 2;
}

double mean_luminance(const Texture& texture) {
  double sum = 0;
  for (int y = 0; y < texture.height; ++y)
    for (int x = 0; x < texture.width; ++x) {
      const Texel t = texel_at(texture, x, y);
      sum += std::max(0., static_cast<double>(luminance({t[0], t[1], t[2]})));
    }
  return sum / texture.width / texture.height;
}

// Which entry of a cumulative distribution of `count` steps u falls in; on return u's place within it.
int find_step(const float* cdf, int count, float& u) {
  const int step = std::min(static_cast<int>(std::upper_bound(cdf, cdf + count, u) - cdf), count - 1);
  const float below = step > 0 ? cdf[step - 1] : 0, size = cdf[step] - below;
  u = size > 0 ? std::clamp((u - below) / size, 0.f, 0x1.fffffep-1f) : .5f;
  return step;
}

}  // namespace

AliasTable::AliasTable(const std::vector<double>& weights) {
  double sum = 0;
  const auto weight = [&](size_t i) { return std::isfinite(weights[i]) && weights[i] > 0 ? weights[i] : 0; };
  for (size_t i = 0; i < weights.size(); ++i) sum += weight(i);
  if (!(sum > 0) || !std::isfinite(sum)) return;
  const size_t n = weights.size();
  entries_.resize(n);
  std::vector<double> share(n);
  std::vector<uint32_t> small, large;
  for (size_t i = 0; i < n; ++i) {
    const double p = weight(i) / sum;
    share[i] = p * static_cast<double>(n);
    entries_[i] = {1, static_cast<float>(p), static_cast<uint32_t>(i)};
    (share[i] < 1 ? small : large).push_back(static_cast<uint32_t>(i));
  }
  while (!small.empty() && !large.empty()) {
    const uint32_t s = small.back(), l = large.back();
    small.pop_back();
    entries_[s].keep = static_cast<float>(share[s]);
    entries_[s].alias = l;
    share[l] -= 1 - share[s];
    if (share[l] >= 1) continue;
    large.pop_back();
    small.push_back(l);
  }
  // What rounding left over is full; an entry of no weight must not be drawn even so.
  for (const uint32_t i : small)
    if (entries_[i].probability == 0 && !large.empty()) entries_[i] = {0, 0, large.back()};
}

uint32_t AliasTable::draw(double& u) const {
  const double at = u * static_cast<double>(entries_.size());
  const uint32_t i = std::min(static_cast<uint32_t>(at), static_cast<uint32_t>(entries_.size() - 1));
  const double rest = at - i, keep = static_cast<double>(entries_[i].keep);
  const bool kept = rest < keep;
  constexpr double kBelowOne = 1 - 0x1p-53;
  u = std::min(kept ? rest / keep : (rest - keep) / (1 - keep), kBelowOne);
  return kept ? i : entries_[i].alias;
}

Float3 emitted_radiance(const Scene& scene, const Material& material, const std::array<Float2, 2>& uv,
                        bool textures) {
  if (!textures || material.emission_texture.texture < 0) return material.emission;
  const Texel texel = lookup(scene, material.emission_texture, uv);
  return material.emission * Float3{texel[0], texel[1], texel[2]};
}

Lights::Lights(const Scene& scene, const Geometry& geometry, EffectSet effects) : scene_(scene), geometry_(geometry) {
  std::vector<double> powers;  // in watts per nanometre, or whatever unit the scene's light has
  const Float3 extent = scene.bounds_max_m - scene.bounds_min_m;
  const double radius_m = std::max(1e-9, std::hypot(double{extent.x}, double{extent.y}, double{extent.z}) / 2);
  if (effects.has(Effect::kPointLight)) {
    for (size_t i = 0; i < scene.lights.size(); ++i) {
      const Light& light = scene.lights[i];
      const double intensity = static_cast<double>(max_component(light.intensity));
      if (!(intensity > 0)) continue;
      punctual_.push_back(static_cast<uint32_t>(i));
      switch (light.kind) {
        case LightKind::kPoint: powers.push_back(4 * kPiD * intensity); break;
        case LightKind::kSpot:
          powers.push_back(2 * kPiD * (1 - std::cos(static_cast<double>(light.outer_cone_rad))) * intensity);
          break;
        case LightKind::kDirectional: powers.push_back(kPiD * radius_m * radius_m * intensity); break;
      }
    }
  }
  if (effects.has(Effect::kAreaLight)) {
    for (size_t m = 0; m < scene.meshes.size(); ++m) {
      const Mesh& mesh = scene.meshes[m];
      const Material& material = scene.materials[mesh.material];
      if (!material.emits() || material.unlit || mesh.indices.empty()) continue;
      first_of_mesh_.resize(scene.meshes.size(), kNone);
      first_of_mesh_[m] = static_cast<uint32_t>(powers.size());
      double radiance = static_cast<double>(luminance(material.emission)) * (material.double_sided ? 2 : 1);
      const int picture = material.emission_texture.texture;
      if (picture >= 0 && effects.has(Effect::kTexture)) radiance *= mean_luminance(scene.textures[picture]);
      for (uint32_t t = 0; t < mesh.indices.size(); ++t) {
        const HitId id{static_cast<uint32_t>(m), t};
        Lamp lamp{{}, {}, 0, material.emission, material.double_sided, picture >= 0, geometry.moves(id.mesh), id};
        place_lamp(lamp, 0);
        lamps_.push_back(lamp);
        powers.push_back(kPiD * area_of(lamp.corners) * radiance);
      }
    }
  }
  make_environment(powers, radius_m, effects);
  choice_ = AliasTable(powers);
}

void Lights::make_environment(std::vector<double>& powers, double scene_radius_m, EffectSet effects) {
  // A constant background is best found by scattering: aiming at it gains nothing. An image is aimed at for the
  // sake of matt and glossy surfaces only.
  if (!effects.has(Effect::kEnvironment) || scene_.environment.texture < 0 || scene_.environment.black()) return;
  if (!effects.has(Effect::kIndirectDiffuse) && !effects.has(Effect::kGlossy)) return;
  const Texture& image = scene_.textures[scene_.environment.texture];
  std::vector<double> rows(image.height);
  row_cdf_.resize(image.height);
  column_cdf_.resize(static_cast<size_t>(image.height) * image.width);
  double total = 0;
  for (int y = 0; y < image.height; ++y) {
    std::vector<double> sums(image.width);
    double sum = 0;
    for (int x = 0; x < image.width; ++x) {
      const Texel t = texel_at(image, x, y);
      sum += std::max(0., static_cast<double>(luminance(scene_.environment.radiance * Float3{t[0], t[1], t[2]})));
      sums[x] = sum;
    }
    for (int x = 0; x < image.width; ++x)
      column_cdf_[static_cast<size_t>(y) * image.width + x] =
          static_cast<float>(sum > 0 ? sums[x] / sum : (x + 1.) / image.width);
    // Times the solid angle of the row's texels.
    total +=
        sum * 2 * kPiD / image.width * (std::cos(kPiD * y / image.height) - std::cos(kPiD * (y + 1) / image.height));
    rows[y] = total;
  }
  if (!(total > 0)) return;
  for (int y = 0; y < image.height; ++y) row_cdf_[y] = static_cast<float>(rows[y] / total);
  environment_entry_ = static_cast<uint32_t>(powers.size());
  powers.push_back(kPiD * scene_radius_m * scene_radius_m * total);
}

bool Lights::sample(Float3 point, float time, double u, float v, bool textures, LightSample& light) const {
  const uint32_t entry = choice_.draw(u);
  const float probability = choice_.probability(entry);
  if (!(probability > 0)) return false;
  if (entry < punctual_.size())
    return sample_punctual(scene_.lights[punctual_[entry]], point, 1 / probability, light);
  const float place = std::min(static_cast<float>(u), 0x1.fffffep-1f);  // the largest float below 1
  if (entry == environment_entry_) return sample_environment(place, v, light);
  const Lamp& lamp = lamps_[entry - punctual_.size()];
  if (!lamp.moves) return sample_triangle(lamp, point, place, v, probability, textures, light);
  Lamp moved = lamp;
  place_lamp(moved, time);
  return sample_triangle(moved, point, place, v, probability, textures, light);
}

void Lights::place_lamp(Lamp& lamp, float time) const {
  lamp.corners = geometry_.corners(lamp.id, time);
  const Float3 across = cross(lamp.corners[1] - lamp.corners[0], lamp.corners[2] - lamp.corners[0]);
  lamp.normal = normalise_safely(across);
  lamp.area_m2 = length(across) / 2;
}

bool Lights::sample_punctual(const Light& light, Float3 point, float scale, LightSample& out) const {
  out.pdf = 0;
  out.end = light.position_m;
  if (light.kind == LightKind::kDirectional) {
    out.towards = -light.direction;
    out.distance = kInfinity;
    out.radiance = light.intensity * scale;
    return true;
  }
  // In double, where the square of 1e-9 m is far from the smallest number; a light in the very point lights nothing.
  const double x = double{light.position_m.x} - point.x, y = double{light.position_m.y} - point.y,
               z = double{light.position_m.z} - point.z, square = x * x + y * y + z * z, distance = std::sqrt(square);
  if (!(distance > 0)) return false;
  out.towards = {static_cast<float>(x / distance), static_cast<float>(y / distance),
                 static_cast<float>(z / distance)};
  out.distance = static_cast<float>(distance);
  out.radiance = light.intensity * (scale * static_cast<float>(std::min(1 / square, 1e30)));
  if (light.kind == LightKind::kPoint) return true;
  // KHR_lights_punctual: a smooth step between the cones.
  const float outer = std::cos(light.outer_cone_rad), inner = std::cos(light.inner_cone_rad);
  const float edge =
      std::clamp((-dot(out.towards, light.direction) - outer) / std::max(.001f, inner - outer), 0.f, 1.f);
  out.radiance *= edge * edge;
  return edge > 0;
}

bool Lights::sample_triangle(const Lamp& lamp, Float3 point, float u, float v, float probability, bool textures,
                             LightSample& out) const {
  // Uniform on the triangle: Heitz, A Low-Distortion Map Between Triangle and Square, 2019.
  const float half_least = std::min(u, v) / 2, a = u - half_least, b = v - half_least, c = 1 - a - b;
  out.end = lamp.corners[0] * c + lamp.corners[1] * a + lamp.corners[2] * b;
  const Float3 way = out.end - point;
  const float square = dot(way, way);
  if (!(lamp.area_m2 > 0) || !(square > 0)) return false;
  out.distance = std::sqrt(square);
  out.towards = way / out.distance;
  float cosine = -dot(lamp.normal, out.towards);
  if (lamp.double_sided) cosine = std::abs(cosine);
  if (!(cosine > 0)) return false;
  // Two quotients that need not wait for each other.
  const float towards_point_m2 = cosine * lamp.area_m2, chosen_m2 = probability * square;
  out.pdf = chosen_m2 / towards_point_m2;
  const float per_pdf = towards_point_m2 / chosen_m2;
  if (!(out.pdf > 0) || !std::isfinite(out.pdf) || !std::isfinite(per_pdf)) return false;
  out.radiance = (textures && lamp.pictured ? pictured_emission(lamp.id, a, b, c) : lamp.emission) * per_pdf;
  return true;
}

Float3 Lights::pictured_emission(HitId triangle, float a, float b, float c) const {
  const Mesh& mesh = scene_.meshes[triangle.mesh];
  const auto& corner = mesh.indices[triangle.triangle];
  std::array<Float2, 2> uv{};
  for (int set = 0; set < 2; ++set) {
    const auto& at = mesh.texcoords[set];
    if (at.empty()) continue;
    uv[set] = {c * at[corner[0]].x + a * at[corner[1]].x + b * at[corner[2]].x,
               c * at[corner[0]].y + a * at[corner[1]].y + b * at[corner[2]].y};
  }
  return emitted_radiance(scene_, scene_.materials[mesh.material], uv, true);
}

bool Lights::sample_environment(float u, float v, LightSample& out) const {
  const Texture& image = scene_.textures[scene_.environment.texture];
  const int y = find_step(row_cdf_.data(), image.height, v);
  const int x = find_step(column_cdf_.data() + static_cast<size_t>(y) * image.width, image.width, u);
  const float top = std::cos(kPi * static_cast<float>(y) / static_cast<float>(image.height));
  const float bottom = std::cos(kPi * static_cast<float>(y + 1) / static_cast<float>(image.height));
  const float up = top + (bottom - top) * v, side = std::sqrt(std::max(0.f, 1 - up * up));
  const float angle = 2 * kPi * ((static_cast<float>(x) + u) / static_cast<float>(image.width) - .5f);
  out.towards = {side * std::sin(angle), up, -side * std::cos(angle)};
  out.distance = kInfinity;
  out.pdf = environment_pdf(out.towards);
  if (!(out.pdf > 0)) return false;
  out.radiance = environment_radiance(scene_, out.towards) / out.pdf;
  return true;
}

float Lights::environment_pdf(Float3 towards) const {
  if (environment_entry_ == kNone) return 0;
  const Texture& image = scene_.textures[scene_.environment.texture];
  const float u = .5f + std::atan2(towards.x, -towards.z) / (2 * kPi);
  const float v = std::acos(std::clamp(towards.y, -1.f, 1.f)) / kPi;
  const int x = std::clamp(static_cast<int>(u * static_cast<float>(image.width)), 0, image.width - 1);
  const int y = std::clamp(static_cast<int>(v * static_cast<float>(image.height)), 0, image.height - 1);
  const float* columns = column_cdf_.data() + static_cast<size_t>(y) * image.width;
  const float in_row = columns[x] - (x > 0 ? columns[x - 1] : 0), row = row_cdf_[y] - (y > 0 ? row_cdf_[y - 1] : 0);
  const float top = std::cos(kPi * static_cast<float>(y) / static_cast<float>(image.height));
  const float bottom = std::cos(kPi * static_cast<float>(y + 1) / static_cast<float>(image.height));
  const float solid_angle = 2 * kPi / static_cast<float>(image.width) * (top - bottom);
  return choice_.probability(environment_entry_) * row * in_row / solid_angle;
}

float Lights::pdf(HitId triangle, float area_m2, float distance_m, float cosine) const {
  if (first_of_mesh_.empty() || first_of_mesh_[triangle.mesh] == kNone || !(area_m2 > 0) || choice_.empty()) return 0;
  return choice_.probability(first_of_mesh_[triangle.mesh] + triangle.triangle) * distance_m * distance_m /
         (std::abs(cosine) * area_m2);
}

uint64_t Lights::memory_bytes() const {
  return choice_.memory_bytes() + punctual_.size() * sizeof(uint32_t) + lamps_.size() * sizeof(Lamp) +
         first_of_mesh_.size() * sizeof(uint32_t) + (row_cdf_.size() + column_cdf_.size()) * sizeof(float);
}

}  // namespace triad::raytracer
