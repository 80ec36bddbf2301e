// SPDX-License-Identifier: Apache-2.0
// Sums that keep what rounding would lose.
#pragma once

#include <cmath>

namespace triad {

// Compensated summation after Neumaier (Zeitschrift fuer Angewandte Mathematik und Mechanik 54, 1974,
// pp. 39-51): the error of n additions is about 2^-53 |sum| + n 2^-106 sum|x|, whatever their order.
//
// A plain record: all bytes zero is an empty sum, and it may be copied as bytes. Partial sums merge; the
// result depends on how the terms were split and in which order parts were merged, in its last bit, so keep
// both fixed where bits matter. A sum with an infinity or a not-a-number in it is what plain addition gives.
struct NeumaierSum {
  double sum = 0, compensation = 0;

  void add(double x) {
    const double t = sum + x;
    compensation += std::abs(sum) >= std::abs(x) ? (sum - t) + x : (x - t) + sum;
    sum = t;
  }
  void merge(const NeumaierSum& later) {
    add(later.sum);
    compensation += later.compensation;
  }
  double value() const { return std::isfinite(sum) ? sum + compensation : sum; }
};

}  // namespace triad
