// SPDX-License-Identifier: Apache-2.0
// The mean without the largest values, exactly, of more values than memory holds: they are seen twice. The first pass
// counts them by the upper half of their bits, which finds the half that holds the limit; the second adds up what
// lies below, and counts what lies there by the lower half.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <triad/numeric/sum.hpp>

namespace triad {

// Where the largest values begin: what pass 1 found, and pass 2 and the result need.
struct TrimLimit {
  uint32_t upper_bits = 0;            // of the limit
  double weight_below = 0, kept = 0;  // of all values with smaller upper bits; of all that count
};

// Sums of one pass over values >= 0, finite where their weight is not 0. Values that round to the same float are
// alike: of those at the limit, the part that counts counts by their mean. A plain record of 1 MiB: all bytes zero is
// empty, and it may be copied as bytes. Bits depend on how values are grouped into records: keep that fixed.
struct TrimmedSums {
  static constexpr size_t kBins = 65536;
  NeumaierSum below;     // pass 2: of weight * value with smaller upper bits than the limit's
  double weight[kBins];  // pass 1: by upper bits; pass 2: of those at the limit, by lower bits
  double rest[kBins];    // pass 2: of weight * (value - the float it rounds to)

  // weights: one >= 0 for each value, or null for all 1.
  void add_first(const double* values, const float* weights, size_t count) {
    for (size_t i = 0; i < count; ++i) {
      const double w = weights ? static_cast<double>(weights[i]) : 1;
      if (w > 0) weight[bits_of(values[i]) >> 16] += w;
    }
  }
  void add_second(const double* values, const float* weights, size_t count, const TrimLimit& limit) {
    constexpr size_t kBlock = 64;  // a plain sum of so few loses no more than 1e-14 of it
    for (size_t first = 0; first < count; first += kBlock) {
      double block = 0;
      for (size_t i = first; i < std::min(count, first + kBlock); ++i) {
        const double w = weights ? static_cast<double>(weights[i]) : 1;
        if (!(w > 0)) continue;
        const uint32_t bits = bits_of(values[i]), upper = bits >> 16;
        if (upper < limit.upper_bits) block += w * values[i];
        if (upper != limit.upper_bits) continue;
        weight[bits & 0xffff] += w;
        rest[bits & 0xffff] += w * (values[i] - static_cast<double>(std::bit_cast<float>(bits)));
      }
      below.add(block);
    }
  }
  void merge(const TrimmedSums& later) {
    below.merge(later.below);
    for (size_t i = 0; i < kBins; ++i) weight[i] += later.weight[i];
    for (size_t i = 0; i < kBins; ++i) rest[i] += later.rest[i];
  }

  // After pass 1, for the mean without the share `trim` of all weight, 0 <= trim < 1.
  TrimLimit limit(double trim) const {
    double total = 0;
    for (const double w : weight) total += w;
    TrimLimit found{0, 0, total * (1 - trim)};
    double sum = 0;
    for (uint32_t i = 0; i < kBins; ++i) {
      if (!(weight[i] > 0)) continue;
      found.upper_bits = i;
      found.weight_below = sum;
      sum += weight[i];
      if (sum >= found.kept) break;
    }
    return found;
  }
  // After pass 2. Not a number when no value had weight.
  double mean(const TrimLimit& limit) const {
    NeumaierSum sum = below;
    double left = limit.kept - limit.weight_below;
    for (uint32_t i = 0; i < kBins && left > 0; ++i) {
      if (!(weight[i] > 0)) continue;
      const double part = std::min(1., left / weight[i]);
      sum.add(part * weight[i] * static_cast<double>(std::bit_cast<float>(limit.upper_bits << 16 | i)));
      sum.add(part * rest[i]);
      left -= weight[i];
    }
    return sum.value() / limit.kept;
  }

 private:
  // Floats from 0 on are in the order of their bits.
  static uint32_t bits_of(double value) {
    return std::bit_cast<uint32_t>(
        static_cast<float>(std::min(value, static_cast<double>(std::numeric_limits<float>::max()))));
  }
};

}  // namespace triad
