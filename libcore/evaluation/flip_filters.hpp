// SPDX-License-Identifier: Apache-2.0
// The filters of FLIP: contrast sensitivity, edges and points (Andersson et al. 2020, sections 4.1.1 and 4.2).
#pragma once

#include <vector>

namespace triad {

// All are separable and even or odd: these are their weights from the centre to the right, the first at distance 0.
struct FlipFilters {
  static constexpr double kLeast_ppd = 1, kMost_ppd = 2000;

  // Contrast sensitivity, a sum of a sqrt(pi / b) exp(-pi^2 x^2 / b) over x in degrees, cut at three standard
  // deviations of the widest and normalised to 1 over the square that is left. The blue-yellow one is the sum of the
  // two products wide(x) wide(y) + narrow(x) narrow(y).
  std::vector<float> achromatic, red_green, blue_yellow_wide, blue_yellow_narrow;

  // Of the Gaussian with the standard deviation .041 degrees, half the width of an edge detector: itself with sum 1;
  // its first derivative, odd, whose weights to the right sum to 1; its second, whose negative weights sum to -1 and
  // whose positive ones to 1. All three have one length.
  std::vector<float> gaussian, first_derivative, second_derivative;

  // Throws a usage error for a ppd outside of the limits.
  explicit FlipFilters(double ppd);
  int reach_px() const;
};

}  // namespace triad
