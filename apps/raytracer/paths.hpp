// SPDX-License-Identifier: Apache-2.0
// The path tracing kernel: kLanes paths side by side, one surface after another, so that camera rays and the first
// shadow rays go in packets.
//
// The order of operations is the same for every set of bits: what a bit leaves out adds nothing where the scene does
// not need it. Random numbers have fixed places: pair kPairs * depth + purpose, whatever is drawn.
#pragma once

#include <bit>
#include <triad/base/random.hpp>
#include <triad/sampling/sobol.hpp>

#include "bsdf.hpp"
#include "kernel.hpp"
#include "texture.hpp"

namespace triad::raytracer {

// Purposes of pairs of random numbers, at each depth.
enum Pair : uint32_t { kPairLight, kPairDirection, kPairChoices, kPairLightChoice, kPairs };
constexpr uint32_t kPairLens = SampleRandom::kFirstSourceDimension, kPairTime = kPairLens + 1,
                   kPairFirstSurface = kPairLens + 2;
// Paths are ended at random from this depth on.
constexpr int kRouletteDepth = 3;

// Power heuristic with exponent 2 (Veach, Robust Monte Carlo Methods, 1997, section 9.2.4), for finite densities.
inline float power_heuristic(float a, float b) {
  if (!(a > 0)) return 0;
  const float ratio = b / a;
  return 1 / (1 + ratio * ratio);
}

template <uint32_t kBits>
class PathKernel {
 public:
  static void run(const KernelScene& scene, std::span<const SampleRequest> requests, std::span<Sample> samples,
                  KernelCounts& counts) {
    PathKernel kernel(scene, counts);
    for (size_t first = 0; first < requests.size(); first += kLanes) {
      const size_t n = std::min<size_t>(kLanes, requests.size() - first);
      kernel.chunk(requests.subspan(first, n), samples.subspan(first, n));
    }
  }

 private:
  static constexpr bool kHasAims = (kBits & kAims) != 0, kHasDiffuse = (kBits & kDiffuse) != 0,
                        kHasGlossy = (kBits & kGlossyBit) != 0, kHasSharp = (kBits & kSharp) != 0,
                        kHasPictures = (kBits & kPictures) != 0;
  static constexpr bool kBounces = kHasDiffuse || kHasGlossy || kHasSharp;
  // The matt base itself is part of every kernel that has any light to show it by.
  static constexpr LobeMask kLobes{kHasAims || kHasDiffuse, kHasGlossy, kHasSharp, kHasSharp};

  struct Path {
    Float3 radiance, throughput{1, 1, 1};
    float pdf = 0;           // of the last direction; 0: it came from the camera or a sharp lobe
    float squeeze = 1;       // how much of the throughput is due to refraction, which roulette shall not see
    bool sharp_only = true;  // seen directly or through mirrors and glass
  };
  struct Pairs {
    alignas(64) float u[kLanes], v[kLanes];
  };

  PathKernel(const KernelScene& scene, KernelCounts& counts) : scene_(scene), counts_(counts) {
    scene_.camera.prepare(camera_rays_);
  }

  std::array<float, 2> pair(int i, Pair purpose) const { return {pairs_[purpose].u[i], pairs_[purpose].v[i]}; }

  // Makes the pairs of random numbers of one purpose at one depth.
  void draw(uint32_t active, int depth, Pair purpose) {
    const uint32_t number = kPairFirstSurface + kPairs * static_cast<uint32_t>(depth) + purpose;
    Pairs& out = pairs_[purpose];
    constexpr int kWorthAVector = 4;
    if (std::popcount(active) < kWorthAVector)
      return for_lanes(active, [&](int i) {
        const auto [u, v] = sobol_owen_pair(index_[i], number, keys_[i]);
        out.u[i] = u;
        out.v[i] = v;
      });
    const uint64_t* keys = keys_;
    const uint32_t* index = index_;
    run_widest([&]() TRIAD_INLINE_BODY {
      for (int i = 0; i < kLanes; ++i) {
        const std::array<float, 2> pair = sobol_owen_pair(index[i], number, keys[i]);
        out.u[i] = pair[0];
        out.v[i] = pair[1];
      }
    });
  }

  void chunk(std::span<const SampleRequest> requests, std::span<Sample> samples) {
    const int n = static_cast<int>(requests.size());
    const uint32_t all = (1u << n) - 1;
    counts_.rays[static_cast<size_t>(RayKind::kCamera)] += static_cast<uint64_t>(n);
    aim_camera(requests);
    const uint32_t near_edge = scene_.geometry.first_hits(camera_rays_, n, lane_keys_);
    uint32_t active = all & ~plain_samples(n, near_edge, samples);
    const uint32_t traced = active;
    for_lanes(active, [&](int i) { start(i, requests[i]); });
    for (int depth = 0; active != 0; ++depth) {
      aimed_ = 0;
      uint32_t going = 0;
      if constexpr (kHasAims) {
        draw(active, depth, kPairLight);
        if (scene_.lights.many()) draw(active, depth, kPairLightChoice);
      }
      if constexpr (kBounces) {
        draw(active, depth, kPairDirection);
        draw(active, depth, kPairChoices);
      }
      for_lanes(active, [&](int i) {
        if (shade(i, depth, samples[i])) going |= 1u << i;
      });
      if constexpr (kHasAims) {
        if (aimed_ != 0) {
          const uint32_t blocked = scene_.geometry.occluded(shadow_rays_, aimed_, lane_keys_, depth == 0);
          for_lanes(aimed_ & ~blocked, [&](int i) { paths_[i].radiance += aims_[i]; });
        }
      }
      active = going;
      if constexpr (!kBounces) break;
      if (active == 0) break;
      for (int i = 0; i < n; ++i) lane_keys_[i] = mix_bits(lane_keys_[i] + kGoldenIncrement);
      scene_.geometry.intersect(rays_, active, lane_keys_, false, hits_);
    }
    for_lanes(traced, [&](int i) {
      Sample& sample = samples[i];
      const Float3 rgb = paths_[i].radiance;
      sample.valid = is_finite(rgb);
      sample.rgb = sample.valid ? std::array<float, 3>{rgb.x, rgb.y, rgb.z} : std::array<float, 3>{};
      counts_.invalid += sample.valid ? 0 : 1;
    });
  }

  template <class Body>
  static void for_lanes(uint32_t lanes, const Body& body) {
    for (; lanes != 0; lanes &= lanes - 1) body(std::countr_zero(lanes));
  }

  uint64_t path_key(const SampleRequest& request) const {
    return SampleRandom::pixel_key(request.pixel_x, request.pixel_y, request.seed + scene_.seed);
  }

  void aim_camera(std::span<const SampleRequest> requests) {
    const int n = static_cast<int>(requests.size());
    const bool plain = scene_.camera.is_plain();
    if (plain) scene_.camera.rays(requests, camera_rays_);
    if (!scene_.camera_draws) return;
    for (int i = 0; i < n; ++i) {
      const SampleRequest& request = requests[i];
      const uint64_t key = path_key(request);
      lane_keys_[i] = mix_bits(key + kGoldenIncrement * (uint64_t{request.index} + 1));
      std::array<float, 2> lens{}, time{};
      if (scene_.camera.has_lens()) lens = sobol_owen_pair(request.index, kPairLens, key);
      if (scene_.motion) time = sobol_owen_pair(request.index, kPairTime, key);
      if (!plain) {
        const Ray ray = scene_.camera.ray(request.x, request.y, lens[0], lens[1], time[0]);
        camera_rays_.set(i, ray.origin, ray.direction);
      }
      camera_rays_.set_time(i, time[0]);
    }
  }

  // Answers the lanes that see a plain look, and returns them. Not those at an edge: which of two triangles a ray
  // meets there is decided with more care.
  uint32_t plain_samples(int n, uint32_t near_edge, std::span<Sample> samples) const {
    const bool empty_is_black = !scene_.tells_geometry && !scene_.effects.has(Effect::kEnvironment);
    // Neighbouring rays mostly see the same thing.
    const uint32_t first = camera_rays_.hit(0).mesh;
    uint32_t others = near_edge;
    for (int i = 1; i < kLanes; ++i) others |= camera_rays_.hit(i).mesh ^ first;
    if (others == 0 && first != kMiss && n == kLanes && scene_.looks[first].plain()) {
      const PlainLook look = scene_.looks[first];
      for (int i = 0; i < kLanes; ++i) look.answer(samples[i]);
      return (1u << kLanes) - 1;
    }
    uint32_t done = 0;
    for (int i = 0; i < n; ++i) {
      const uint32_t mesh = camera_rays_.hit(i).mesh;
      if (mesh == kMiss) {
        if (!empty_is_black) continue;
        PlainLook().answer(samples[i]);
      } else {
        const PlainLook& look = scene_.looks[mesh];
        if (!look.plain() || (near_edge >> i & 1) != 0) continue;
        look.answer(samples[i]);
      }
      done |= 1u << i;
    }
    return done;
  }

  void start(int i, const SampleRequest& request) {
    Path& path = paths_[i];
    path = {};
    if (kHasAims || kBounces) {
      keys_[i] = path_key(request);
      index_[i] = request.index;
      lane_keys_[i] = mix_bits(keys_[i] + kGoldenIncrement * (uint64_t{request.index} + 1));
    }
    rays_[i] = camera_rays_.ray(i);
    hits_[i] = camera_rays_.hit(i);
  }

  SurfaceMaterial read_material(const Material& material, const Surface& surface) const {
    SurfaceMaterial at{material.base_color, material.metallic, material.roughness, material.transmission,
                       material.ior};
    if constexpr (kHasPictures) {
      if (!scene_.effects.has(Effect::kTexture)) return at;
      if (material.base_color_texture.texture >= 0) {
        const Texel texel = lookup(scene_.scene, material.base_color_texture, surface.uv);
        at.base *= Float3{texel[0], texel[1], texel[2]};
      }
      if (material.metallic_roughness_texture.texture >= 0 && !material.unlit) {
        const Texel texel = lookup(scene_.scene, material.metallic_roughness_texture, surface.uv);
        at.roughness = std::clamp(at.roughness * texel[1], kSmoothRoughness, 1.f);
        at.metallic *= texel[2];
      }
      if (material.transmission_texture.texture >= 0 && !material.unlit)
        at.transmission *= lookup(scene_.scene, material.transmission_texture, surface.uv)[0];
    }
    return at;
  }

  // At what ray i has met: adds the light that comes from there, prepares a shadow ray, and the next ray. False if
  // the path ends.
  bool shade(int i, int depth, Sample& sample) {
    Path& path = paths_[i];
    Ray& ray = rays_[i];
    Surface surface;
    if (hits_[i].mesh != kMiss) surface = scene_.geometry.surface(ray, hits_[i], kHasPictures);
    if (depth == 0 && surface.to_edge < kOnEdge) {
      // Which of two triangles a ray on their common edge meets depends on its neighbours in the packet. Alone, it
      // depends on the ray.
      scene_.geometry.intersect(rays_, 1u << i, lane_keys_, false, hits_);
      if (hits_[i].mesh != kMiss) surface = scene_.geometry.surface(ray, hits_[i], kHasPictures);
    }
    const HitId hit = hits_[i];
    if (hit.mesh == kMiss) {
      if (depth == 0 && scene_.tells_geometry) sample = Sample{};
      miss(path, ray);
      return false;
    }
    const Mesh& mesh = scene_.scene.meshes[hit.mesh];
    const Material& material = scene_.scene.materials[mesh.material];
    const bool front = dot(ray.direction, surface.geometric_normal) <= 0;
    const Float3 facing = front ? surface.geometric_normal : -surface.geometric_normal;
    Float3 normal = front ? surface.shading_normal : -surface.shading_normal;
    const Float3 back = -ray.direction;
    // An interpolated normal that looks away from the viewer says nothing useful about what the viewer sees.
    if (!(dot(normal, back) > kLeastCosine)) normal = facing;
    const SurfaceMaterial at = read_material(material, surface);
    if (depth == 0 && scene_.tells_geometry) describe(sample, surface, mesh, normal, at);
    emission(path, material, surface, hit, front, at, -dot(ray.direction, facing));
    const LobeSet drawn = scene_.lobes[mesh.material];
    if (material.unlit || depth > scene_.max_depth) return false;
    if (!drawn.diffuse && !drawn.glossy && !drawn.mirror && !drawn.refraction) return false;

    const Frame frame(normal);
    Float3 to = frame.to_local(back);
    to.z = std::max(to.z, kLeastCosine);
    const bool follow_diffuse = kHasDiffuse && scene_.effects.has(Effect::kIndirectDiffuse);
    const Bsdf<kLobes> bsdf(at, to, front, {drawn.diffuse, drawn.glossy, drawn.mirror, drawn.refraction},
                            follow_diffuse);
    if constexpr (kHasAims) {
      if (bsdf.blurs() && !scene_.lights.empty()) aim(i, surface, facing, frame, bsdf, follow_diffuse);
    }
    if constexpr (!kBounces) return false;
    return scatter(i, depth, surface, facing, frame, bsdf);
  }

  void describe(Sample& sample, const Surface& surface, const Mesh& mesh, Float3 normal,
                const SurfaceMaterial& at) const {
    sample.distance = surface.distance;
    sample.position = {surface.position.x, surface.position.y, surface.position.z};
    sample.normal = {normal.x, normal.y, normal.z};
    const auto unit = [](float x) { return std::clamp(x, 0.f, 1.f); };
    sample.albedo = {unit(at.base.x), unit(at.base.y), unit(at.base.z)};
    sample.object_id = mesh.object_id;
    sample.material_id = static_cast<uint32_t>(mesh.material) + 1;
  }

  void miss(Path& path, const Ray& ray) const {
    if (!scene_.effects.has(Effect::kEnvironment)) return;
    float weight = 1;
    if constexpr (kHasAims) {
      if (path.pdf > 0 && scene_.lights.aims_at_environment())
        weight = power_heuristic(path.pdf, scene_.lights.environment_pdf(ray.direction));
    }
    path.radiance += path.throughput * environment_radiance(scene_.scene, ray.direction) * weight;
  }

  void emission(Path& path, const Material& material, const Surface& surface, HitId hit, bool front,
                const SurfaceMaterial& at, float cosine) const {
    if (material.unlit) {  // neither lights nor is lit: shows where it is seen, not in what it would shine on
      if (path.sharp_only) path.radiance += path.throughput * at.base;
      return;
    }
    if (!material.emits() || (!front && !material.double_sided)) return;
    float weight = 1;
    if (!scene_.effects.has(Effect::kAreaLight)) {
      if (!path.sharp_only) return;
    } else if (kHasAims && path.pdf > 0) {
      weight = power_heuristic(path.pdf, scene_.lights.pdf(hit, surface.area_m2, surface.distance, cosine));
    }
    const bool pictures = kHasPictures && scene_.effects.has(Effect::kTexture);
    path.radiance += path.throughput * emitted_radiance(scene_.scene, material, surface.uv, pictures) * weight;
  }

  // Next-event estimation: a light, a point on it, and a shadow ray to be traced with those of the other lanes.
  void aim(int i, const Surface& surface, Float3 facing, const Frame& frame, const Bsdf<kLobes>& bsdf,
           bool follow_diffuse) {
    const Path& path = paths_[i];
    const Ray& ray = rays_[i];
    const auto on_light = pair(i, kPairLight);
    LightSample light;
    const bool pictures = kHasPictures && scene_.effects.has(Effect::kTexture);
    const double more_bits = scene_.lights.many() ? 0x1p-24 * double{pair(i, kPairLightChoice)[0]} : 0;
    if (!scene_.lights.sample(surface.position, ray.time, on_light[0] + more_bits, on_light[1], pictures, light))
      return;
    if (!(dot(light.towards, facing) > 0)) return;  // behind the triangle, whatever its shading normal says
    const BsdfValue value = bsdf.eval(frame.to_local(light.towards));
    const float weight = light.pdf > 0 ? power_heuristic(light.pdf, value.pdf()) : 1;
    const Float3 arriving = value.diffuse * (follow_diffuse ? weight : 1) + value.glossy * weight;
    const Float3 radiance = path.throughput * arriving * light.radiance;
    if (!(max_component(radiance) > 0)) return;
    ++counts_.rays[static_cast<size_t>(RayKind::kShadow)];
    Ray& shadow = shadow_rays_[i];
    shadow.time = ray.time;
    shadow.origin = surface.position + facing * surface.offset_m;
    shadow.direction = light.towards;
    shadow.end = std::numeric_limits<float>::infinity();
    if (std::isfinite(light.distance)) {
      // From the ray's own start to just before the light; a light nearer than the start is beyond every obstacle.
      const Float3 way = light.end - shadow.origin;
      if (dot(way, facing) > 0) {
        shadow.direction = way;
        shadow.end = kBeforeLight;
      } else {
        shadow.end = light.distance;
      }
    }
    aims_[i] = radiance;
    aimed_ |= 1u << i;
  }

  bool scatter(int i, int depth, const Surface& surface, Float3 facing, const Frame& frame,
               const Bsdf<kLobes>& bsdf) {
    Path& path = paths_[i];
    Ray& ray = rays_[i];
    const auto choices = pair(i, kPairChoices);
    const auto direction = pair(i, kPairDirection);
    const BsdfSample next = bsdf.sample(choices[0], direction[0], direction[1]);
    if (next.lobe == Lobe::kNone) return false;
    const Float3 towards = frame.to_world(next.from);
    const bool through = next.from.z < 0;
    const float side = dot(towards, facing);
    if (through ? !(side < 0) : !(side > 0)) return false;  // the triangle's own plane forbids it
    path.throughput *= next.weight;
    if (!(max_component(path.throughput) > 0)) return false;
    path.pdf = next.pdf;
    path.sharp_only = path.sharp_only && next.pdf == 0;
    if (through) path.squeeze *= bsdf.squeeze();
    if (depth >= kRouletteDepth) {
      const float survives = max_component(path.throughput) * path.squeeze;
      if (survives < 1) {
        if (choices[1] >= survives) return false;
        path.throughput = path.throughput / survives;
      }
    }
    ++counts_.rays[static_cast<size_t>(next.lobe == Lobe::kDiffuse  ? RayKind::kDiffuse
                                       : next.lobe == Lobe::kGlossy ? RayKind::kGlossy
                                       : next.lobe == Lobe::kMirror ? RayKind::kMirror
                                                                    : RayKind::kRefraction)];
    ray.origin = surface.position + facing * (through ? -surface.offset_m : surface.offset_m);
    ray.direction = normalise(towards);
    return true;
  }

  static constexpr float kLeastCosine = 1e-6f;   // towards the viewer; keeps the BSDF's divisions finite
  static constexpr float kOnEdge = 1e-5f;        // barycentric; far above what Embree's rounding can decide
  static constexpr float kBeforeLight = .9999f;  // of the way to the light: do not meet the light itself

  const KernelScene& scene_;
  KernelCounts& counts_;
  LaneRays camera_rays_;
  Path paths_[kLanes];
  Ray rays_[kLanes], shadow_rays_[kLanes];
  HitId hits_[kLanes];
  Float3 aims_[kLanes];
  uint64_t lane_keys_[kLanes] = {};
  alignas(64) uint64_t keys_[kLanes] = {};  // with index_: what a path's random numbers hash from
  alignas(64) uint32_t index_[kLanes] = {};
  Pairs pairs_[kPairs];
  uint32_t aimed_ = 0;
};

}  // namespace triad::raytracer
