// SPDX-License-Identifier: Apache-2.0
// A scene as a source of samples: path tracing over Embree.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <triad/sampling/source.hpp>

#include "effects.hpp"
#include "scene.hpp"

namespace triad::raytracer {

enum class RayKind { kCamera, kShadow, kDiffuse, kGlossy, kMirror, kRefraction };
constexpr int kRayKindCount = 6;
// "camera rays".
const char* ray_kind_name(RayKind kind);

struct SourceOptions {
  int width = 0, height = 0;  // the film: cells, for a wide render
  // Width of the whole picture over its height, as seen. 0: width / height, that is square pixels.
  double picture_aspect = 0;
  int camera = -1;                   // index into Scene::cameras; -1: the scene's own choice
  std::optional<EffectSet> effects;  // what to draw; nothing: what the scene calls for
  bool geometry = true;              // whether samples shall say more than colour: distance, normal, ids ...
  bool specialise = true;            // false: run the kernel with everything compiled in, to compare
  uint64_t seed = 0;                 // added to that of each request
  // Times that a path may be scattered after the first surface, at most 1000; past it only light that is met
  // directly counts. 0: direct light, and mirrors that show lamps alone.
  int max_depth = 32;
  // Embree's report of progress while it builds, 0 to 1, from any thread; returning false cancels.
  bool (*build_progress)(void* user, double fraction) = nullptr;
  void* build_progress_user = nullptr;
};

// Thread-safe as Source asks. rgb of a sample that is not finite is set to 0 and the sample marked invalid;
// invalid_samples() counts them.
class SceneSource : public Source {
 public:
  virtual const EffectAnalysis& analysis() const = 0;
  // What is drawn (the analysis or the override), and all that the kernel was compiled for.
  virtual EffectSet effects() const = 0;
  virtual EffectSet kernel_effects() const = 0;
  virtual uint64_t rays(RayKind kind) const = 0;
  virtual uint64_t invalid_samples() const = 0;
  // Bytes that Embree and the tables beside the scene hold.
  virtual uint64_t memory_bytes() const = 0;
};

// Builds Embree's tree; the scene is kept for as long as the source lives. Throws Error(kUsage) for options out of
// range and Error(kCancelled) when build_progress said so.
std::unique_ptr<SceneSource> make_scene_source(std::shared_ptr<const Scene> scene, const SourceOptions& options);

}  // namespace triad::raytracer
