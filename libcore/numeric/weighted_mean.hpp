// SPDX-License-Identifier: Apache-2.0
// The mean of an error over pixels of which some count less, or not at all.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <triad/numeric/sum.hpp>

namespace triad {

// Weighted sums of values, to 1e-13 of the mean over 10^9 and more. A plain record: all bytes zero is empty, and it
// may be copied as bytes. Bits depend on how values are grouped into calls and records: keep that fixed.
struct WeightedMean {
  NeumaierSum sum, weight;
  int64_t counted, nonfinite;  // of weight above 0; of these, the infinite ones and those that are not a number

  // Adds `count` values. weights: one >= 0 for each, or null for all 1. What has weight 0 may be anything; values
  // that are not finite are counted and left out.
  void add(const double* values, const float* weights, size_t count) {
    constexpr size_t kBlock = 64;  // a plain sum of so few loses no more than 1e-14 of it
    for (size_t first = 0; first < count; first += kBlock) {
      const size_t past = std::min(count, first + kBlock);
      double block = 0, block_weight = 0;
      int64_t used = 0, bad = 0;
      for (size_t i = first; i < past; ++i) {
        const double w = weights ? static_cast<double>(weights[i]) : 1;
        if (!(w > 0)) continue;
        ++used;
        if (!std::isfinite(values[i])) {
          ++bad;
          continue;
        }
        block += w * values[i];
        block_weight += w;
      }
      sum.add(block);
      weight.add(block_weight);
      counted += used;
      nonfinite += bad;
    }
  }
  void merge(const WeightedMean& later) {
    sum.merge(later.sum);
    weight.merge(later.weight);
    counted += later.counted;
    nonfinite += later.nonfinite;
  }
  // Not a number when nothing was added.
  double mean() const { return sum.value() / weight.value(); }
};

}  // namespace triad
