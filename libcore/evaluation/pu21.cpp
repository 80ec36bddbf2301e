// SPDX-License-Identifier: Apache-2.0
#include <triad/evaluation/pu21.hpp>
#include <triad/numeric/elementary.hpp>

namespace triad {
namespace {

// Both let a not-a-number pass.
TRIAD_INLINE_BODY inline double clamped(double nits) {
  const double above = nits < kPu21Lowest_nits ? kPu21Lowest_nits : nits;
  return above > kPu21Highest_nits ? kPu21Highest_nits : above;
}
TRIAD_INLINE_BODY inline double encode(double y) {
  constexpr double p1 = .353487901, p2 = .3734658629, p3 = 8.277049286e-05, p4 = .9062562627, p5 = .09150303166,
                   p6 = .9099517204, p7 = 596.3148142;
  const double power = plain_pow(y, p4);
  const double value = p7 * (plain_pow((p1 + p2 * power) / (1 + p3 * power), p5) - p6);
  return (value > 0 ? value : 0) + (y - y);
}

}  // namespace

double pu21(double nits) { return encode(clamped(nits)); }

void pu21(double* values, size_t count) {
  run_widest([&]() TRIAD_INLINE_BODY {
    // Two loops: in one, compilers branch to what they know of a clamped value, and then it is no vector code.
    for (size_t i = 0; i < count; ++i) values[i] = clamped(values[i]);
    for (size_t i = 0; i < count; ++i) values[i] = encode(values[i]);
  });
}

}  // namespace triad
