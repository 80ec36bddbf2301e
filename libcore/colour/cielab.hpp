// SPDX-License-Identifier: Apache-2.0
// CIE 1976 L*a*b* and its colour difference: ISO/CIE 11664-4:2019.
#pragma once

#include <array>

namespace triad {

struct Lab {
  double L = 0, a = 0, b = 0;  // L 0 black .. 100 white
};

// white: the XYZ of what counts as white, all above 0. Values of any sign: the straight piece near black goes on.
Lab xyz_to_lab(const std::array<double, 3>& xyz, const std::array<double, 3>& white);

// Euclidean distance: CIE76, Delta E*ab. About 2.3 can just be told apart.
double cie76(const Lab& one, const Lab& other);

}  // namespace triad
