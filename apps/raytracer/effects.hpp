// SPDX-License-Identifier: Apache-2.0
// The effects a scene calls for. An effect is a reason for work: rays, look-ups or memory that a scene without
// it shall not pay for.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace triad::raytracer {

struct Scene;

enum class Effect : uint32_t {
  kPointLight,       // direct light from points, spots and directions
  kAreaLight,        // direct light from triangles that emit
  kIndirectDiffuse,  // light that a matt surface receives from other surfaces or the surroundings
  kGlossy,           // blurred reflection
  kMirror,           // sharp reflection
  kRefraction,       // smooth glass
  kTexture,
  kAlpha,  // surfaces with holes
  kEnvironment,
  kDepthOfField,
  kMotionBlur
};
constexpr int kEffectCount = 11;

class EffectSet {
 public:
  constexpr EffectSet() = default;
  static constexpr EffectSet all() { return EffectSet((1u << kEffectCount) - 1); }

  constexpr bool has(Effect effect) const { return (bits_ & bit(effect)) != 0; }
  constexpr void add(Effect effect) { bits_ |= bit(effect); }
  constexpr void remove(Effect effect) { bits_ &= ~bit(effect); }
  constexpr uint32_t bits() const { return bits_; }
  constexpr bool operator==(const EffectSet&) const = default;

 private:
  constexpr explicit EffectSet(uint32_t bits) : bits_(bits) {}
  static constexpr uint32_t bit(Effect effect) { return 1u << static_cast<uint32_t>(effect); }
  uint32_t bits_ = 0;
};

// "area-light": how --effects and reports call it.
const char* effect_name(Effect effect);

// What `--effects` takes: names joined by commas, "all", or "none". Throws Error(kUsage) that names the option and
// lists the names.
EffectSet parse_effects(const std::string& text);
// The inverse: "area-light,mirror"; "none", "all".
std::string effects_text(EffectSet effects);

struct EffectReason {
  Effect effect;
  std::string what;  // "mesh 'lamp'": the first thing in the scene that calls for it
};

struct EffectAnalysis {
  EffectSet effects;
  std::vector<EffectReason> reasons;  // one for each effect of the set, in the order of Effect
  // "effects: area-light (mesh 'lamp'), mirror (material 'chrome')"; "effects: none".
  std::string text() const;
  // Lines for the user about what the ray tracer draws in another way than the file asks for.
  std::vector<std::string> warnings;
};

// What the scene, seen by its camera number `camera`, calls for. Reads each mesh's header and the materials that
// meshes use, not the triangles: takes microseconds.
EffectAnalysis analyse_effects(const Scene& scene, int camera);

}  // namespace triad::raytracer
