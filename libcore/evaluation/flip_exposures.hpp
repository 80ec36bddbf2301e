// SPDX-License-Identifier: Apache-2.0
// How HDR-FLIP shows pictures of any range: tone mappers and the range of exposures (Andersson et al. 2021).
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <span>

namespace triad {

enum class FlipToneMapper { kAces, kReinhard, kHable };

// aces and hable map each channel c to (n2 c^2 + n1 c + n0) / (d2 c^2 + d1 c + d0): K. Narkowicz's fit of the ACES
// curve (2015), with his exposure of .6 taken out, and J. Hable's of Uncharted 2 (2010). reinhard divides by
// 1 + luminance; as a curve, c / (1 + c).
struct FlipToneCurve {
  float n2, n1, n0, d2, d1, d0;
};
FlipToneCurve flip_tone_curve(FlipToneMapper mapper);

// Of linear light with sRGB's primaries.
inline float flip_luminance(const float* rgb) { return .2126f * rgb[0] + .7152f * rgb[1] + .0722f * rgb[2]; }

// The light of a code value of IEC 61966-2-1, and beyond [0, 1] where its formulas go on.
float flip_light(float code);

// The exposures of a comparison, in stops; all equally far apart.
struct FlipExposures {
  float start_stops = 0, stop_stops = 0;
  int count = 1;
  float at(int i) const;
};

// start, stop: where given, these. Else from the light that the tone mapper shows as .85: start puts the largest
// luminance of the reference there, stop the median. count 0: one exposure a stop, at least two. Luminances that are
// looked at must be above 0. Throws a usage error where stop lies below start, or if the exposures are no numbers.
FlipExposures flip_exposures(FlipToneMapper mapper, std::optional<float> start_stops, std::optional<float> stop_stops,
                             int count, float median, float largest);

// The exact element at `rank` of any number of floats in ascending order, with 2^16 counts in place of the floats:
// first count all by upper_key(), find the bin, then those in it by lower_key(). Zeros are alike, whatever their
// sign.
class FloatRank {
 public:
  static constexpr uint32_t kBins = 1u << 16;
  static uint32_t upper_key(float x) { return key(x) >> 16; }
  static uint32_t lower_key(float x) { return key(x) & 0xffff; }
  static float value(uint32_t upper, uint32_t lower) {
    const uint32_t k = upper << 16 | lower;
    return std::bit_cast<float>(k & 0x80000000u ? k ^ 0x80000000u : ~k);
  }

  // The bin that holds the element at `rank`, and the rank that it has there. counts must hold more than `rank`.
  struct Place {
    uint32_t bin;
    uint64_t rank;
  };
  static Place find(std::span<const uint64_t> counts, uint64_t rank);

 private:
  // The bits of a float, changed so that they are in the order of the numbers.
  static uint32_t key(float x) {
    const uint32_t bits = std::bit_cast<uint32_t>(x + 0.f);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
  }
};

}  // namespace triad
