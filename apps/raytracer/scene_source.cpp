// SPDX-License-Identifier: Apache-2.0
#include "scene_source.hpp"

#include <fmt/format.h>
#include <atomic>
#include <triad/base/error.hpp>

#include "bsdf.hpp"
#include "kernel.hpp"

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace triad::raytracer {
namespace {

// Denormal numbers cost Embree a hundred cycles each: off while this lives, on this thread.
class FlushDenormals {
 public:
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;
#if defined(__SSE__)
  FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | kFlushToZero | kDenormalsAreZero); }
  ~FlushDenormals() { _mm_setcsr(before_); }

 private:
  static constexpr unsigned kFlushToZero = 0x8000, kDenormalsAreZero = 0x0040;  // bits of MXCSR
  unsigned before_;
#else
  FlushDenormals() = default;
#endif
};

const SourceOptions& checked(const Scene& scene, const SourceOptions& options) {
  if (options.width < 1 || options.height < 1)
    throw_usage(fmt::format("--size: {} x {} cells; both must be at least 1", options.width, options.height));
  if (options.max_depth < 0 || options.max_depth > 1000)
    throw_usage(fmt::format("--max-depth: {}; must be in 0 ... 1000", options.max_depth));
  const int cameras = static_cast<int>(scene.cameras.size());
  if (cameras == 0) throw_input(scene.file + ": the scene has no camera; it needs at least one");
  const int camera = options.camera < 0 ? scene.camera : options.camera;
  if (camera >= cameras)
    throw_usage(fmt::format("--camera: {}; the scene has cameras 0 ... {}", camera, cameras - 1));
  return options;
}

class PathTracer final : public SceneSource {
 public:
  PathTracer(std::shared_ptr<const Scene> scene, const SourceOptions& options)
      : owned_(std::move(scene)),
        options_(checked(*owned_, options)),
        analysis_(analyse_effects(*owned_, camera_number())),
        effects_(options.effects.value_or(analysis_.effects)),
        geometry_(*owned_, effects_, options),
        lights_(*owned_, geometry_, effects_),
        camera_(owned_->cameras[static_cast<size_t>(camera_number())], options, effects_),
        kernel_scene_{*owned_,
                      geometry_,
                      lights_,
                      camera_,
                      effects_,
                      {},
                      {},
                      effects_.has(Effect::kMotionBlur),
                      camera_.has_lens() || effects_.has(Effect::kMotionBlur) || effects_.has(Effect::kAlpha),
                      options.seed,
                      options.max_depth,
                      options.geometry} {
    const bool lit = effects_.has(Effect::kPointLight) || effects_.has(Effect::kAreaLight) ||
                     effects_.has(Effect::kIndirectDiffuse);
    for (const Material& material : owned_->materials) {
      LobeSet lobes = possible_lobes(material);
      lobes.diffuse = lobes.diffuse && lit;
      lobes.glossy = lobes.glossy && effects_.has(Effect::kGlossy);
      lobes.mirror = lobes.mirror && effects_.has(Effect::kMirror);
      lobes.refraction = lobes.refraction && effects_.has(Effect::kRefraction);
      if (lobes.glossy || lobes.mirror) mean_coat_albedo(1);  // makes its table now, not in the middle of a picture
      kernel_scene_.lobes.push_back(lobes);
    }
    for (const Mesh& mesh : owned_->meshes) kernel_scene_.looks.push_back(plain_look(mesh));
    bits_ = options.specialise ? kernel_bits(effects_) : kKernelCount - 1;
    kernel_ = kernel_for(bits_);
  }

  int width() const override { return options_.width; }
  int height() const override { return options_.height; }
  SourceAbilities abilities() const override { return {.geometry = options_.geometry}; }

  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const override {
    KernelCounts counts;
    {
      const FlushDenormals flush;
      kernel_(kernel_scene_, requests, samples, counts);
    }
    for (size_t i = 0; i < counts.rays.size(); ++i)
      if (counts.rays[i] != 0) rays_[i].fetch_add(counts.rays[i], std::memory_order_relaxed);
    if (counts.invalid != 0) invalid_.fetch_add(counts.invalid, std::memory_order_relaxed);
  }

  std::vector<WorkCount> work() const override {
    std::vector<WorkCount> work;
    for (int i = 0; i < kRayKindCount; ++i) {
      const RayKind kind = static_cast<RayKind>(i);
      work.push_back({ray_kind_name(kind), rays(kind)});
    }
    return work;
  }

  const EffectAnalysis& analysis() const override { return analysis_; }
  EffectSet effects() const override { return effects_; }
  EffectSet kernel_effects() const override { return raytracer::kernel_effects(bits_); }
  uint64_t rays(RayKind kind) const override { return rays_[static_cast<size_t>(kind)].load(); }
  uint64_t invalid_samples() const override { return invalid_.load(); }
  uint64_t memory_bytes() const override { return geometry_.memory_bytes() + lights_.memory_bytes(); }

 private:
  PlainLook plain_look(const Mesh& mesh) const {
    const Material& material = owned_->materials[static_cast<size_t>(mesh.material)];
    const LobeSet& lobes = kernel_scene_.lobes[static_cast<size_t>(mesh.material)];
    const bool pictures = effects_.has(Effect::kTexture);
    if (options_.geometry) return {};
    if (material.unlit) return {!pictures || material.base_color_texture.texture < 0, material.base_color};
    if (lobes.diffuse || lobes.glossy || lobes.mirror || lobes.refraction) return {};
    if (!material.emits()) return {true, {}};
    return {material.double_sided && (!pictures || material.emission_texture.texture < 0), material.emission};
  }

  int camera_number() const { return options_.camera < 0 ? owned_->camera : options_.camera; }

  std::shared_ptr<const Scene> owned_;
  SourceOptions options_;
  EffectAnalysis analysis_;
  EffectSet effects_;
  Geometry geometry_;
  Lights lights_;
  FilmCamera camera_;
  KernelScene kernel_scene_;
  uint32_t bits_ = 0;
  Kernel kernel_ = nullptr;
  mutable std::array<std::atomic<uint64_t>, kRayKindCount> rays_{};
  mutable std::atomic<uint64_t> invalid_{0};
};

}  // namespace

const char* ray_kind_name(RayKind kind) {
  constexpr std::array<const char*, kRayKindCount> kNames{"camera rays", "shadow rays", "diffuse rays",
                                                          "glossy rays", "mirror rays", "refraction rays"};
  return kNames[static_cast<size_t>(kind)];
}

std::unique_ptr<SceneSource> make_scene_source(std::shared_ptr<const Scene> scene, const SourceOptions& options) {
  return std::make_unique<PathTracer>(std::move(scene), options);
}

}  // namespace triad::raytracer
