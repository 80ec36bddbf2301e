// SPDX-License-Identifier: Apache-2.0
// CIELAB and its colour differences for many pixels at a time, as fast as the machine goes. In double precision, the
// same bits on every machine. One pixel at a time, and from the definition: cielab.hpp.
#pragma once

#include <array>
#include <cstddef>

namespace triad {

inline constexpr size_t kLabBlock = 256;  // pixels; what is worked on at a time stays in the first cache
struct LabBlock {
  alignas(64) double L[kLabBlock], a[kLabBlock], b[kLabBlock];
};

// Linear RGB to CIELAB (ISO/CIE 11664-4) under the RGB's own white, (1, 1, 1). Immutable and thread-safe.
class RgbToLab {
 public:
  // Row-major, its white with all of X, Y, Z above 0.
  explicit RgbToLab(const std::array<double, 9>& rgb_to_xyz);

  // rgb: `count` interleaved triples, count <= kLabBlock. Light below 0 goes on along CIELAB's straight piece, light
  // above 1 along its cube root: nothing is clamped. L, a and b to 1e-11, for light of up to a few times white.
  void convert(const float* rgb, size_t count, LabBlock& out) const;

 private:
  std::array<double, 9> relative_xyz_;
};

// CIE76, the distance in CIELAB: delta_e[i] of pixel i, i < count <= kLabBlock.
void cie76(const LabBlock& one, const LabBlock& other, size_t count, double* delta_e);

// CIEDE2000 with kL = kC = kH = 1: ISO/CIE 11664-6, in the notation and with the wrapping of hues of G. Sharma, W. Wu
// and E. N. Dalal, "The CIEDE2000 color-difference formula: implementation notes, supplementary test data, and
// mathematical observations" (Color Research and Application 30(1), 2005). To 1e-9; less where two hues are opposite
// to a thousandth of a degree, for there the formula itself jumps.
void ciede2000(const LabBlock& one, const LabBlock& other, size_t count, double* delta_e);

}  // namespace triad
