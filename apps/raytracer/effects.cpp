// SPDX-License-Identifier: Apache-2.0
#include "effects.hpp"

#include <algorithm>
#include <array>
#include <triad/base/error.hpp>

#include "material.hpp"
#include "scene.hpp"

namespace triad::raytracer {
namespace {

constexpr std::array<const char*, kEffectCount> kNames{"point-light", "area-light",     "indirect-diffuse", "glossy",
                                                       "mirror",      "refraction",     "texture",          "alpha",
                                                       "environment", "depth-of-field", "motion-blur"};

std::string all_names() {
  std::string names;
  for (const char* name : kNames) names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

// Keeps the first reason given for each effect.
class Reasons {
 public:
  void add(Effect effect, const std::string& what) {
    if (found_.has(effect)) return;
    found_.add(effect);
    reasons_.push_back({effect, what});
  }
  EffectAnalysis take() {
    std::ranges::sort(reasons_, {}, &EffectReason::effect);
    return {found_, std::move(reasons_), {}};
  }

 private:
  EffectSet found_;
  std::vector<EffectReason> reasons_;
};

std::string called(const char* kind, const std::string& name, size_t index) {
  return std::string(kind) + (name.empty() ? " " + std::to_string(index) : " '" + name + "'");
}

}  // namespace

const char* effect_name(Effect effect) { return kNames[static_cast<size_t>(effect)]; }

EffectSet parse_effects(const std::string& text) {
  if (text == "all") return EffectSet::all();
  if (text == "none") return {};
  EffectSet set;
  for (size_t start = 0; start <= text.size();) {
    const size_t end = std::min(text.find(',', start), text.size());
    const std::string name = text.substr(start, end - start);
    const auto found = std::ranges::find_if(kNames, [&](const char* known) { return name == known; });
    if (found == kNames.end())
      throw_usage("--effects: unknown effect '" + name + "'; give all, none, or names joined by commas out of " +
                  all_names());
    set.add(static_cast<Effect>(found - kNames.begin()));
    start = end + 1;
  }
  return set;
}

std::string effects_text(EffectSet effects) {
  if (effects == EffectSet::all()) return "all";
  std::string text;
  for (int i = 0; i < kEffectCount; ++i)
    if (effects.has(static_cast<Effect>(i))) text += (text.empty() ? "" : ",") + std::string(kNames[i]);
  return text.empty() ? "none" : text;
}

std::string EffectAnalysis::text() const {
  std::string line;
  for (const EffectReason& reason : reasons)
    line += (line.empty() ? "" : ", ") + std::string(effect_name(reason.effect)) + " (" + reason.what + ")";
  return "effects: " + (line.empty() ? "none" : line);
}

EffectAnalysis analyse_effects(const Scene& scene, int camera) {
  Reasons reasons;
  std::vector<std::string> warnings;
  std::vector<bool> used(scene.materials.size(), false);
  std::string lit_by;
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    if (scene.lights[i].intensity == Float3{}) continue;
    lit_by = called("light", scene.lights[i].name, i);
    reasons.add(Effect::kPointLight, lit_by);
  }
  if (!scene.environment.black()) {
    lit_by = scene.environment.texture < 0 ? "background" : "environment image";
    reasons.add(Effect::kEnvironment, lit_by);
  }
  const Camera& seen_by = scene.cameras[static_cast<size_t>(camera)];
  const bool shutter = seen_by.shutter_close_s > seen_by.shutter_open_s;
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    if (mesh.indices.empty()) continue;
    const size_t number = static_cast<size_t>(mesh.material);
    used[number] = true;
    if (scene.materials[number].emits() && !scene.materials[number].unlit) {
      lit_by = called("mesh", mesh.name, i);
      reasons.add(Effect::kAreaLight, lit_by);
    }
    if (shutter && mesh.moves()) reasons.add(Effect::kMotionBlur, called("mesh", mesh.name, i));
  }
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    if (!used[i]) continue;
    const Material& material = scene.materials[i];
    const std::string what = called("material", material.name, i);
    const LobeSet lobes = possible_lobes(material);
    const bool blend = material.alpha_mode == AlphaMode::kBlend;
    const TextureUse& picture = material.base_color_texture;
    const bool alpha_picture =
        picture.texture >= 0 && scene.textures[static_cast<size_t>(picture.texture)].channels == 4;
    if (material.alpha_mode != AlphaMode::kOpaque &&
        (alpha_picture || material.alpha < (blend ? 1.f : material.alpha_cutoff)))
      reasons.add(Effect::kAlpha, what);
    if (picture.texture >= 0 ||
        (!material.unlit && (material.metallic_roughness_texture.texture >= 0 ||
                             (material.emission_texture.texture >= 0 && material.emits()) ||
                             (material.transmission_texture.texture >= 0 && lobes.refraction))))
      reasons.add(Effect::kTexture, what);
    if (lit_by.empty()) continue;  // nothing but unlit surfaces shows; no need to follow light that is not there
    if (lobes.diffuse) reasons.add(Effect::kIndirectDiffuse, what);
    if (lobes.glossy) reasons.add(Effect::kGlossy, what);
    if (lobes.mirror) reasons.add(Effect::kMirror, what);
    if (lobes.refraction) reasons.add(Effect::kRefraction, what);
    if (lobes.refraction &&
        (material.roughness >= kSmoothRoughness || material.metallic_roughness_texture.texture >= 0))
      warnings.push_back(scene.file + ": " + what + ": rough transmission is drawn smooth");
  }
  if (seen_by.aperture_radius_m > 0)
    reasons.add(Effect::kDepthOfField, called("camera", seen_by.name, static_cast<size_t>(camera)));
  if (shutter && seen_by.poses.size() > 1)
    reasons.add(Effect::kMotionBlur, called("camera", seen_by.name, static_cast<size_t>(camera)));
  EffectAnalysis analysis = reasons.take();
  analysis.warnings = std::move(warnings);
  return analysis;
}

}  // namespace triad::raytracer
