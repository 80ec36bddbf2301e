// SPDX-License-Identifier: Apache-2.0
// Histograms of floats by their upper 16 bits, from which sums are exact and order statistics known to one part in
// 128.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <triad/numeric/exact_sum.hpp>

namespace triad {

// Floats as integers in the same order (the usual trick: set the sign bit of positive ones, invert negative ones).
// Both zeros are one key, that of +0. Infinities are the least and the largest; not-a-number lies outside of them.
constexpr uint32_t float_key(float value) {
  const uint32_t bits = std::bit_cast<uint32_t>(value);
  const uint32_t sign = bits >> 31;
  const uint32_t key = bits ^ ((0u - sign) | 0x80000000u);
  return key == 0x7fffffffu ? 0x80000000u : key;  // -0
}
constexpr uint32_t key_bits(uint32_t key) { return key >> 31 ? key ^ 0x80000000u : ~key; }
constexpr float key_float(uint32_t key) { return std::bit_cast<float>(key_bits(key)); }
inline constexpr uint32_t kLeastKey = 0x007fffffu;    // -infinity
inline constexpr uint32_t kZeroKey = 0x80000000u;     // 0
inline constexpr uint32_t kLargestKey = 0xff800000u;  // +infinity
inline constexpr size_t kFloatBins = 65536;           // a bin for each value of a key's upper 16 bits

// What one thread counts: 1.5 MiB, of which little is touched.
class FloatBins {
 public:
  static constexpr uint32_t kMostWeight = 65535;
  static constexpr int64_t kMostValues = int64_t{1} << 31;  // twice as many, of the largest weight, still fit

  FloatBins();
  void add(uint32_t key, uint32_t weight) {
    const uint32_t bin = key >> 16;
    least_ = bin < least_ ? bin : least_;
    largest_ = bin > largest_ ? bin : largest_;
    bins_[bin].weight += weight;
    bins_[bin].low += static_cast<uint64_t>(weight) * (key & 0xffffu);
  }
  // All of weight 1 and within [least, largest].
  void add(const uint32_t* keys, size_t count, uint32_t least, uint32_t largest);
  void clear();

 private:
  friend class FloatHistogram;
  struct Bin {
    uint64_t weight = 0, low = 0;  // low: sum of weight times the key's lower 16 bits
  };
  void unpack();

  std::unique_ptr<Bin[]> bins_;
  // Of values of weight 1, one addition for both: their number times 2^40, plus the sum of their lower 16 bits.
  std::unique_ptr<uint64_t[]> packed_;
  size_t packed_count_ = 0;
  uint32_t least_ = kFloatBins, largest_ = 0;  // bins; what is outside of them is 0
};

// The whole: 2 MiB. Merging is exact and so may happen in any order. Of at most 2^40 values.
class FloatHistogram {
 public:
  FloatHistogram();
  void merge(const FloatBins& part);

  uint64_t weight(size_t bin) const { return weight_[bin]; }
  // The exact sum of a bin's values, each times its weight; its values must be finite.
  void add_sum(size_t bin, ExactSum& sum) const;
  uint64_t total() const;
  // Sum over the total, correct to the last bit or two. Infinite where one infinity is in it, not a number where both
  // are or the total is 0.
  double mean() const;
  // Of all finite values.
  ExactSum sum() const;

 private:
  std::unique_ptr<uint64_t[]> weight_;
  std::unique_ptr<Uint128[]> low_;
};

}  // namespace triad
