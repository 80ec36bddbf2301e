// SPDX-License-Identifier: Apache-2.0
// Elementary functions without branches, tables or calls, so that a loop over them becomes vector code (run_widest).
// In double precision; each says how exact it is, and branch_free_test.cpp holds it to that. The same bits on every
// machine and for every vector width. Arguments outside of what is said give some number or a not-a-number.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <numbers>
#include <triad/numeric/widest.hpp>

namespace triad::branch_free {

inline constexpr double kTwo52 = 4503599627370496;  // from here on, doubles are whole numbers

// condition ? a : b, both of which have been computed.
TRIAD_INLINE_BODY inline double select(bool condition, double a, double b) {
  const uint64_t mask = -static_cast<uint64_t>(condition);
  return std::bit_cast<double>((std::bit_cast<uint64_t>(a) & mask) | (std::bit_cast<uint64_t>(b) & ~mask));
}

TRIAD_INLINE_BODY inline double magnitude(double x) {
  return std::bit_cast<double>(std::bit_cast<uint64_t>(x) & (UINT64_MAX >> 1));
}

// The magnitude of a with the sign of b.
TRIAD_INLINE_BODY inline double with_sign(double a, double b) {
  constexpr uint64_t kSign = uint64_t{1} << 63;
  return std::bit_cast<double>((std::bit_cast<uint64_t>(a) & ~kSign) | (std::bit_cast<uint64_t>(b) & kSign));
}

// Cube root of a normal number above 0; relative error below 1e-14.
//
// A third of the exponent and of what follows it, as if both were one number, is the root to 3.5% (Kahan's start, as
// in FreeBSD's cbrt); two of Halley's steps cube the error each.
TRIAD_INLINE_BODY inline double cube_root(double x) {
  constexpr uint64_t kAsDouble = std::bit_cast<uint64_t>(kTwo52);
  // Whole numbers below 2^32 become doubles and back by the bits of 2^52: vectors of 64-bit integers know no
  // division.
  const double high = std::bit_cast<double>((std::bit_cast<uint64_t>(x) >> 32) | kAsDouble) - kTwo52;
  const double third = high * (1. / 3) + 715094163.;
  double root = std::bit_cast<double>(std::bit_cast<uint64_t>(third + kTwo52) << 32);
  for (int step = 0; step < 2; ++step) {
    const double cube = root * root * root;
    root *= (cube + 2 * x) / (2 * cube + x);
  }
  return root;
}

// e^-y for y in [0, 700]; relative error below 1e-11.
TRIAD_INLINE_BODY inline double exp_minus(double y) {
  constexpr double kRound = 1.5 * kTwo52;
  const double power = (y * -std::numbers::log2e + kRound) - kRound;
  const double r = y * -1. - power * std::numbers::ln2;  // within ln(2) / 2 of 0
  double sum = 1. / 362880;                              // Taylor's series; the first term left out is r^10 / 10!
  sum = sum * r + 1. / 40320;
  sum = sum * r + 1. / 5040;
  sum = sum * r + 1. / 720;
  sum = sum * r + 1. / 120;
  sum = sum * r + 1. / 24;
  sum = sum * r + 1. / 6;
  sum = sum * r + .5;
  sum = sum * r + 1;
  sum = sum * r + 1;
  return sum * std::bit_cast<double>(std::bit_cast<uint64_t>(power + (kTwo52 + 1023)) << 52);
}

// sin(x) for |x| <= pi / 3; absolute error below 2e-12.
TRIAD_INLINE_BODY inline double sine(double x) {
  const double s = x * x;  // Taylor's series to x^13
  double sum = 1. / 6227020800;
  sum = sum * s - 1. / 39916800;
  sum = sum * s + 1. / 362880;
  sum = sum * s - 1. / 5040;
  sum = sum * s + 1. / 120;
  sum = sum * s - 1. / 6;
  return x + x * s * sum;
}

// The angle of (x, y), in [-pi, pi]; absolute error below 2e-10. 0 for (0, 0).
TRIAD_INLINE_BODY inline double angle(double y, double x) {
  const double ax = magnitude(x), ay = magnitude(y);
  const bool steep = ay > ax;
  const double low = select(steep, ax, ay), high = select(steep, ay, ax);
  // Above 22.5 degrees, from 45 degrees on: atan(q) = pi / 4 + atan((q - 1) / (q + 1)).
  constexpr double kTangent = std::numbers::sqrt2 - 1;
  const bool far = low > kTangent * high;
  const double over = select(far, low - high, low), under = select(far, high + low, high);
  const double q = over / (under + std::numeric_limits<double>::min()), s = q * q;
  double sum = -1. / 23;  // Taylor's series; |q| <= sqrt(2) - 1
  sum = sum * s + 1. / 21;
  sum = sum * s - 1. / 19;
  sum = sum * s + 1. / 17;
  sum = sum * s - 1. / 15;
  sum = sum * s + 1. / 13;
  sum = sum * s - 1. / 11;
  sum = sum * s + 1. / 9;
  sum = sum * s - 1. / 7;
  sum = sum * s + 1. / 5;
  sum = sum * s - 1. / 3;
  double a = q + q * s * sum + select(far, std::numbers::pi / 4, 0);
  a = select(steep, std::numbers::pi / 2 - a, a);
  a = select(x < 0, std::numbers::pi - a, a);
  return with_sign(a, y);
}

}  // namespace triad::branch_free
