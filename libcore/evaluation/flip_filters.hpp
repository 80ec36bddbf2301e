// SPDX-License-Identifier: Apache-2.0
// The filters of FLIP: contrast sensitivity, edges and points (Andersson et al. 2020, sections 4.1.1 and 4.2).
#pragma once

#include <vector>

namespace triad {

// All are separable.
struct FlipFilters {
  // Below the least, a Gaussian's weights beside the centre are 0 in single precision.
  static constexpr double kLeast_ppd = 2, kMost_ppd = 2000;

  // Contrast sensitivity, a sum of a sqrt(pi / b) exp(-pi^2 x^2 / b) over x in degrees, cut at three standard
  // deviations of the widest and normalised to 1 over the square that is left: their weights from the centre to the
  // right, the first at distance 0. The blue-yellow one is the sum of the
  // two products wide(x) wide(y) + narrow(x) narrow(y).
  std::vector<float> achromatic, red_green, blue_yellow_wide, blue_yellow_narrow;

  // Edges and points: the Gaussian with the standard deviation .041 degrees, half the width of an edge detector, and
  // its first and second derivative, cut at three of it. Whole, from left to right. The Gaussian sums to 1; the
  // negative weights of each derivative sum to -1, the positive ones to 1.
  std::vector<float> gaussian, first_derivative, second_derivative;

  // Throws a usage error for a ppd outside of the limits.
  explicit FlipFilters(double ppd);
  int reach_px() const;
};

}  // namespace triad
