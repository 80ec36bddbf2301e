// SPDX-License-Identifier: Apache-2.0
// Random numbers without state: each is a hash of what it is for, so that no picture depends on the order in
// which threads and tiles ask.
#pragma once

#include <cstdint>

namespace triad {

// The finaliser of SplitMix64 (Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators, OOPSLA 2014,
// with the constants of Stafford's variant 13): a bijection of 64 bits in which each input bit flips each output
// bit with probability near one half.
constexpr uint64_t mix_bits(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

// The odd number nearest to 2^64 divided by the golden ratio: SplitMix64's increment.
inline constexpr uint64_t kGoldenIncrement = 0x9e3779b97f4a7c15u;

// In [0, 1), a multiple of 2^-24, so that the float is exact and never rounds up to 1.
constexpr float unit_float(uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

// The numbers of one sample: for fixed (pixel, sample index, seed), dimension d gives the d-th output of a
// SplitMix64 generator whose starting state is a hash of the three. Pure and cheap to copy; making one costs three
// mixes, each number one more.
//
// Dimensions below kFirstSourceDimension belong to strategies (where in the pixel a sample lies); sources
// (lens, time, bounces) begin there.
class SampleRandom {
 public:
  static constexpr uint32_t kFirstSourceDimension = 16;

  constexpr SampleRandom(int32_t pixel_x, int32_t pixel_y, uint32_t index, uint64_t seed)
      : state_(mix_bits(pixel_key(pixel_x, pixel_y, seed) + kGoldenIncrement * (uint64_t{index} + 1))) {}

  constexpr uint64_t u64(uint32_t dimension) const {
    return mix_bits(state_ + kGoldenIncrement * (uint64_t{dimension} + 1));
  }
  constexpr uint32_t u32(uint32_t dimension) const { return static_cast<uint32_t>(u64(dimension) >> 32); }
  // In [0, 1).
  constexpr float uniform(uint32_t dimension) const { return unit_float(u32(dimension)); }

  // A hash of pixel and seed alone, for what all samples of a pixel share (the scrambling of a point set).
  static constexpr uint64_t pixel_key(int32_t pixel_x, int32_t pixel_y, uint64_t seed) {
    const uint64_t pixel = uint64_t{static_cast<uint32_t>(pixel_y)} << 32 | static_cast<uint32_t>(pixel_x);
    return mix_bits(mix_bits(seed + kGoldenIncrement) ^ pixel);
  }

 private:
  uint64_t state_;
};

}  // namespace triad
