// SPDX-License-Identifier: Apache-2.0
// Several floats side by side, as wide as the processor's registers, and the functions of single precision that loops
// over pictures need. Everything is plain IEEE arithmetic without fused products, lane by lane: a value gives the
// same bits in any lane and on every instruction set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <triad/numeric/widest.hpp>

// All functions here are inlined into the one that was compiled for the wide registers; no vector is ever passed.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace triad {

// The vectors of run_lanes().
typedef float Lanes4 __attribute__((vector_size(16)));
typedef float Lanes8 __attribute__((vector_size(32)));
typedef float Lanes16 __attribute__((vector_size(64)));
inline constexpr int kMostLanes = 16;

// Integers as wide, and what comparisons give: all bits of a lane set where they hold.
template <class V>
using LaneInts = decltype(V{} < V{});

template <class V>
inline constexpr int kLanes = static_cast<int>(sizeof(V) / sizeof(float));

// Calls body.operator()<V>(), an object whose call is marked TRIAD_INLINE_BODY, compiled for default_cpu_path() with
// the vector V that fills its registers. Worth it for a few hundred operations and up.
template <class Body>
void run_lanes(const Body& body) {
#if defined(__x86_64__) && defined(__GNUC__)
  static const CpuPath path = default_cpu_path();
  switch (path) {
    case CpuPath::kAvx512: return run_avx512([&]() TRIAD_INLINE_BODY { body.template operator()<Lanes16>(); });
    case CpuPath::kAvx2: return run_avx2([&]() TRIAD_INLINE_BODY { body.template operator()<Lanes8>(); });
    case CpuPath::kBaseline: return body.template operator()<Lanes4>();
  }
#else
  body.template operator()<Lanes4>();
#endif
}

template <class V>
TRIAD_INLINE_BODY inline V load(const float* from) {
  V v;
  __builtin_memcpy(&v, from, sizeof(V));
  return v;
}
template <class V>
TRIAD_INLINE_BODY inline void store(float* to, const V& v) {
  __builtin_memcpy(to, &v, sizeof(V));
}

template <class V>
TRIAD_INLINE_BODY inline V lanes_of(float x) {
  return x - V{};
}
template <class To, class V>
TRIAD_INLINE_BODY inline To same_bits(const V& v) {
  static_assert(sizeof(To) == sizeof(V));
  To to;
  __builtin_memcpy(&to, &v, sizeof(V));
  return to;
}

template <class V>
TRIAD_INLINE_BODY inline V abs_of(const V& x) {
  return same_bits<V>(same_bits<LaneInts<V>>(x) & 0x7fffffff);
}
// Where a is not a number: b.
template <class V>
TRIAD_INLINE_BODY inline V larger(const V& a, const V& b) {
  return a > b ? a : b;
}
// x in [0, 1]; what is not a number becomes 0.
template <class V>
TRIAD_INLINE_BODY inline V to_unit(const V& x) {
  const V low = larger(x, V{}), one = lanes_of<V>(1);
  return low > one ? one : low;
}

// The logarithm to base 2 of a normal number above 0, with an absolute error below 1e-7 + 6e-8 |log2 x|; near 1 it is
// as exact as the distance from 1. Through log2(m) = 2 / ln 2 artanh((m - 1) / (m + 1)), m in [2^-.5, 2^.5].
template <class V>
TRIAD_INLINE_BODY inline V log2_of(const V& x) {
  using I = LaneInts<V>;
  const I bits = same_bits<I>(x);
  const I exponent = (bits - 0x3f3504f3) >> 23;
  const V m = same_bits<V>(bits - (exponent << 23));
  const V t = (m - 1.f) / (m + 1.f), t2 = t * t;
  const V series =
      t * (2.88539008f + t2 * (.961796694f + t2 * (.577078016f + t2 * (.412198583f + t2 * .320598898f))));
  return __builtin_convertvector(exponent, V) + series;
}

// 2^x with a relative error below 2e-7; x above 127 is out of range, x below -126 gives 2^-126. The polynomial
// interpolates (2^x - 1) / x at Chebyshev's points of [-1/2, 1/2].
template <class V>
TRIAD_INLINE_BODY inline V exp2_of(const V& x) {
  using I = LaneInts<V>;
  constexpr float kRound = 12582912.f;  // 1.5 * 2^23: adding it leaves no bits behind the point
  const V y = larger(x, lanes_of<V>(-126.f));
  const V whole = (y + kRound) - kRound, f = y - whole;
  const V series =
      1.f +
      f * (.693147182f +
           f * (.240226507f + f * (.0555035696f + f * (.00961805694f + f * (.00133908668f + f * .000154614477f)))));
  return same_bits<V>(same_bits<I>(series) + (__builtin_convertvector(whole, I) << 23));
}

// The square root of 0 or a normal number above it, with a relative error below 3e-7. From half of its exponent, by
// two steps of the binomial series of (1 - h)^(-1/2), h = 1 - x r^2, towards r = x^(-1/2). (The library's function
// sets errno, which no vector can.)
template <class V>
TRIAD_INLINE_BODY inline V sqrt_of(const V& x) {
  V r = same_bits<V>(0x5f375a86 - (same_bits<LaneInts<V>>(x) >> 1));
  V h = 1.f - x * r * r;
  r = r * (1.f + h * (1 / 2.f + h * (3 / 8.f + h * (5 / 16.f))));
  h = 1.f - x * r * r;
  return x * (r * (1.f + h * (1 / 2.f)));
}

// The cube root of a normal number above 0, with a relative error below 2e-7. From a third of its exponent, by a step
// of the binomial series of (1 - h)^(-1/3), h = 1 - x r^3, to r = x^(-1/3), and one of Newton's for the root itself.
template <class V>
TRIAD_INLINE_BODY inline V cbrt_of(const V& x) {
  using I = LaneInts<V>;
  const V third = __builtin_convertvector(same_bits<I>(x), V) * (1 / 3.f);
  V r = same_bits<V>(0x54a2fa8c - __builtin_convertvector(third, I));
  const V h = 1.f - x * r * r * r;
  r = r * (1.f + h * (1 / 3.f + h * (2 / 9.f + h * (14 / 81.f))));
  const V r2 = r * r, root = x * r2;
  return root - (root * root * root - x) * (r2 * (1 / 3.f));
}

}  // namespace triad
