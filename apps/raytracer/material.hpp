// SPDX-License-Identifier: Apache-2.0
// Which ways of scattering light a material can need, before any texture is read.
#pragma once

#include "scene.hpp"

namespace triad::raytracer {

// Below this roughness (GGX's alpha below 1e-4, a lobe a hundredth of a degree wide) a reflection is a mirror's.
inline constexpr float kSmoothRoughness = .01f;

struct LobeSet {
  bool diffuse = false, glossy = false, mirror = false, refraction = false;
};

// A textured roughness never goes below kSmoothRoughness: such a material is glossy everywhere.
inline LobeSet possible_lobes(const Material& material) {
  LobeSet lobes;
  if (material.unlit) return lobes;
  const bool mixed = material.metallic_roughness_texture.texture >= 0;
  const bool dielectric = material.metallic < 1 || mixed;
  const bool black = material.base_color == Float3{};
  lobes.refraction = dielectric && material.transmission > 0;
  const bool opaque =
      !dielectric || material.metallic > 0 || material.transmission < 1 || material.transmission_texture.texture >= 0;
  if (!opaque) return lobes;
  lobes.diffuse = dielectric && !black && (material.transmission < 1 || material.transmission_texture.texture >= 0);
  // An ior of 1 has no coat, and a metal always reflects, a black one at grazing angles.
  if (material.metallic > 0 || material.ior != 1) {
    if (mixed || material.roughness >= kSmoothRoughness)
      lobes.glossy = true;
    else
      lobes.mirror = true;
  }
  return lobes;
}

}  // namespace triad::raytracer
