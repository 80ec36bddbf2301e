// SPDX-License-Identifier: Apache-2.0
// What the path tracing kernels share: their parameters, and how they are chosen.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "camera.hpp"
#include "geometry.hpp"
#include "lights.hpp"
#include "material.hpp"

namespace triad::raytracer {

// What a kernel is compiled for; a bit that is not set leaves the code out. Depth of field, motion blur and the
// background cost a kernel a branch for each ray, and are decided as it runs.
enum KernelBit : uint32_t {
  kAims = 1,       // shadow rays: point lights, area lights, environment image
  kDiffuse = 2,    // indirect diffuse light
  kGlossyBit = 4,  // glossy reflection
  kSharp = 8,      // mirrors and glass
  kPictures = 16   // textures
};
constexpr uint32_t kKernelCount = 32;

// What a camera ray sees of a mesh where neither its place nor its light matters.
class PlainLook {
 public:
  PlainLook() = default;
  PlainLook(bool plain, Float3 radiance) : plain_(plain) { sample_.rgb = {radiance.x, radiance.y, radiance.z}; }
  bool plain() const { return plain_; }
  // Sets rgb and valid, in one store, and leaves the rest as it is.
  void answer(Sample& sample) const {
    static_assert(offsetof(Sample, rgb) == 0 && offsetof(Sample, valid) == sizeof(Sample::rgb) &&
                  std::is_trivially_copyable_v<Sample>);
    std::memcpy(static_cast<void*>(&sample), &sample_, offsetof(Sample, distance));
  }

 private:
  bool plain_ = false;
  Sample sample_;
};

// A scene made ready. Read by all threads, written by none.
struct KernelScene {
  const Scene& scene;
  const Geometry& geometry;
  const Lights& lights;
  const FilmCamera& camera;
  EffectSet effects;
  std::vector<LobeSet> lobes;    // for each material, those that are drawn
  std::vector<PlainLook> looks;  // for each mesh; none is plain if samples tell geometry
  bool motion;
  bool camera_draws;  // lens, time or alpha: a camera ray alone needs random numbers
  uint64_t seed;
  int max_depth;
  bool tells_geometry;  // fill in a sample's distance, position, normal, albedo and ids
};

struct KernelCounts {
  std::array<uint64_t, kRayKindCount> rays{};
  uint64_t invalid = 0;
};

using Kernel = void (*)(const KernelScene&, std::span<const SampleRequest>, std::span<Sample>, KernelCounts&);

// The bits that a set of effects needs.
uint32_t kernel_bits(EffectSet effects);
Kernel kernel_for(uint32_t bits);
// The effects that a kernel can draw.
EffectSet kernel_effects(uint32_t bits);

}  // namespace triad::raytracer
