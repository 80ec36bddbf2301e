// SPDX-License-Identifier: Apache-2.0
// PU21: luminance in candelas per square metre as numbers of which equal steps are about equally visible, so that
// metrics for ordinary pictures can judge high dynamic range. R. K. Mantiuk and M. Azimi, "PU21: A novel perceptually
// uniform encoding for adapting existing quality metrics for HDR", Picture Coding Symposium 2021; the variant
// "banding + glare", which the authors recommend. Functions are pure and thread-safe.
#pragma once

#include <cstddef>

namespace triad {

// What the encoding was fitted to; values outside are taken for the nearer end.
inline constexpr double kPu21Lowest_nits = .005, kPu21Highest_nits = 10000;
// The peak and data range to use with it, as the authors' own tool does: white at 100 nits encodes to 256.4.
inline constexpr double kPu21Peak = 256;

// V = max(p7 (((p1 + p2 Y^p4) / (1 + p3 Y^p4))^p5 - p6), 0): 0 at .005 nits, 595.4 at 10000. Not a number stays so.
double pu21(double nits);

// Luminances in nits become their V, in place: the same bits as pu21(double), on every processor.
void pu21(double* values, size_t count);

}  // namespace triad
