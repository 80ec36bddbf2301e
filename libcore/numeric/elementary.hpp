// SPDX-License-Identifier: Apache-2.0
// Logarithms and powers as plain arithmetic: loops over arrays of them vectorise under run_widest(), and give the
// same bits on every processor, which a C library does not promise.
#pragma once

#include <bit>
#include <cstdint>
#include <numbers>
#include <triad/numeric/widest.hpp>

namespace triad {

// Base-2 logarithm of a positive, finite, normal number; anything else gives a meaningless number. The error is below
// 4e-16 of max(1, |result|) (tested). x = 2^e m with m in [sqrt(1/2), sqrt(2)), ln m = 2 artanh((m - 1) / (m + 1)).
TRIAD_INLINE_BODY inline double plain_log2(double x) {
  constexpr uint64_t kOne = uint64_t{1023} << 52, kExponent = uint64_t{0xfff} << 52;
  constexpr uint64_t kRootHalf = std::bit_cast<uint64_t>(1 / std::numbers::sqrt2);
  const uint64_t bits = std::bit_cast<uint64_t>(x), shifted = bits - kRootHalf + kOne;
  const double m = std::bit_cast<double>(bits - (shifted & kExponent) + kOne);
  // An integer below 2^52 as the low bits of 2^52 and more: a conversion that every vector unit has.
  constexpr uint64_t kTwo52 = std::bit_cast<uint64_t>(0x1p52);
  const double e = std::bit_cast<double>((shifted >> 52) | kTwo52) - (0x1p52 + 1023);
  const double t = (m - 1) / (m + 1), z = t * t;  // z < .0295: the next term is below 2e-18
  // Written out: compilers leave divisions in a loop over n.
  const double series =
      1 + z * (1. / 3 +
               z * (1. / 5 +
                    z * (1. / 7 +
                         z * (1. / 9 +
                              z * (1. / 11 +
                                   z * (1. / 13 +
                                        z * (1. / 15 +
                                             z * (1. / 17 + z * (1. / 19 + z * (1. / 21 + z * (1. / 23)))))))))));
  return e + 2 / std::numbers::ln2 * (t * series);
}

// 2^x for |x| <= 1000; outside, a meaningless number. Relative error below 4e-16 (tested). x = n + r with n whole and
// |r| <= 1/2, 2^r by its Taylor series.
TRIAD_INLINE_BODY inline double plain_exp2(double x) {
  constexpr double kRound = 0x1.8p52;  // adding it rounds to a whole number, left in the low bits
  const double shifted = x + kRound, r = (x - (shifted - kRound)) * std::numbers::ln2;
  const double series =
      1 +
      r * (1 + r * (1. / 2 +
                    r * (1. / 6 +
                         r * (1. / 24 +
                              r * (1. / 120 +
                                   r * (1. / 720 +
                                        r * (1. / 5040 +
                                             r * (1. / 40320 +
                                                  r * (1. / 362880 + r * (1. / 3628800 +
                                                                          r * (1. / 39916800 +
                                                                               r * (1. / 479001600 +
                                                                                    r * (1. / 6227020800)))))))))))));
  return std::bit_cast<double>(std::bit_cast<uint64_t>(series) + (std::bit_cast<uint64_t>(shifted) << 52));
}

// x^exponent for a positive, finite, normal x and |exponent log2(x)| <= 1000.
TRIAD_INLINE_BODY inline double plain_pow(double x, double exponent) { return plain_exp2(exponent * plain_log2(x)); }

}  // namespace triad
