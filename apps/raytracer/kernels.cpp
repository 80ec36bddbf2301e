// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <utility>

#include "paths.hpp"

namespace triad::raytracer {
namespace {

template <size_t... kBits>
constexpr std::array<Kernel, sizeof...(kBits)> kernels(std::index_sequence<kBits...>) {
  return {&PathKernel<kBits>::run...};
}
constexpr std::array<Kernel, kKernelCount> kKernels = kernels(std::make_index_sequence<kKernelCount>());

constexpr std::array<std::pair<Effect, uint32_t>, 8> kNeeds{{{Effect::kPointLight, kAims},
                                                             {Effect::kAreaLight, kAims},
                                                             {Effect::kIndirectDiffuse, kDiffuse},
                                                             {Effect::kGlossy, kGlossyBit},
                                                             {Effect::kMirror, kSharp},
                                                             {Effect::kRefraction, kSharp},
                                                             {Effect::kTexture, kPictures},
                                                             {Effect::kAlpha, 0}}};

}  // namespace

uint32_t kernel_bits(EffectSet effects) {
  uint32_t bits = 0;
  for (const auto& [effect, bit] : kNeeds)
    if (effects.has(effect)) bits |= bit;
  return bits;
}

EffectSet kernel_effects(uint32_t bits) {
  EffectSet effects = EffectSet::all();
  for (const auto& [effect, bit] : kNeeds)
    if ((bits & bit) != bit) effects.remove(effect);
  return effects;
}

Kernel kernel_for(uint32_t bits) { return kKernels[bits]; }

}  // namespace triad::raytracer
