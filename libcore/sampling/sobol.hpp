// SPDX-License-Identifier: Apache-2.0
// The first two dimensions of the Sobol sequence, scrambled after Owen.
//
// Owen scrambling (Randomly permuted (t,m,s)-nets and (t,s)-sequences, 1995) flips bit k of a coordinate by a
// random bit that depends on the k bits above it: points stay uniform, and each elementary interval still
// holds exactly one of every aligned 2^k consecutive points. Here the random bits are a hash.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <triad/base/random.hpp>

namespace triad {

constexpr uint32_t reverse_bits(uint32_t x) {
  x = x << 16 | x >> 16;
  x = (x & 0x00ff00ffu) << 8 | (x & 0xff00ff00u) >> 8;
  x = (x & 0x0f0f0f0fu) << 4 | (x & 0xf0f0f0f0u) >> 4;
  x = (x & 0x33333333u) << 2 | (x & 0xccccccccu) >> 2;
  return (x & 0x55555555u) << 1 | (x & 0xaaaaaaaau) >> 1;
}

// A nested uniform scramble of x's bits from the highest down, handed in and back in reverse order. There, each step
// is a bijection in which a bit depends on itself and lower ones only (odd products, sums, and x ^= x * even), which
// is what nesting asks for: the construction of Laine and Karras (Stratified Sampling for Stochastic Transparency,
// EGSR 2011), with the multipliers that Vegdahl found by search and published (2021) for a good avalanche.
constexpr uint32_t owen_scramble_start(uint32_t x) { return x ^ x * 0x3d20adeau; }  // what needs no seed
constexpr uint32_t owen_scramble_rest(uint32_t x, uint32_t seed) {
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}
constexpr uint32_t owen_scramble_reversed(uint32_t x, uint32_t seed) {
  return owen_scramble_rest(owen_scramble_start(x), seed);
}
constexpr uint32_t owen_scramble(uint32_t x, uint32_t seed) {
  return reverse_bits(owen_scramble_reversed(reverse_bits(x), seed));
}

// Point `index` of the plain Sobol sequence, dimensions 0 (van der Corput's) and 1, as 32-bit binary fractions with
// their bits in reverse order.
constexpr std::array<uint32_t, 2> sobol_point_reversed(uint32_t index) {
  // Dimension 1's generator matrix is Pascal's triangle modulo 2, the fifth Kronecker power of (1 1; 0 1): one
  // exchange for each power.
  uint32_t y = index;
  y ^= y >> 16;
  y ^= (y & 0xff00ff00u) >> 8;
  y ^= (y & 0xf0f0f0f0u) >> 4;
  y ^= (y & 0xccccccccu) >> 2;
  y ^= (y & 0xaaaaaaaau) >> 1;
  return {index, y};
}

// Parts the points into two halves, each well distributed itself. With an index's bits as the coefficients of a
// polynomial over GF(2), the digits of dimensions 0 and 1 are its expansions at 0 and at 1, and this is the first
// one at a root of z^2 + z + 1, whose powers repeat after three: the first digit of a third dimension. By
// Niederreiter (J. Number Theory 30, 1988) the three are a (1, 3)-sequence, so of the aligned 2^k points, each
// interval of area 2^-(k-2) holds two of either half. (A digit of dimension 0 or 1 instead would part them by
// where they lie, and differences between the halves would say nothing of the error.)
constexpr bool sobol_half(uint32_t index) { return std::popcount(index & 0xdb6db6dbu) & 1; }

constexpr std::array<uint32_t, 2> sobol_point(uint32_t index) {
  const std::array<uint32_t, 2> reversed = sobol_point_reversed(index);
  return {reverse_bits(reversed[0]), reverse_bits(reversed[1])};
}

// For the first points, both coordinates with owen_scramble_start() behind them: the half of the work that is the
// same for every key.
struct SobolStarts {
  static constexpr uint32_t kCount = 1024;
  std::array<uint32_t, kCount> x{}, y{};
  constexpr SobolStarts() {
    for (uint32_t i = 0; i < kCount; ++i) {
      const std::array<uint32_t, 2> plain = sobol_point_reversed(i);
      x[i] = owen_scramble_start(plain[0]);
      y[i] = owen_scramble_start(plain[1]);
    }
  }
};
inline constexpr SobolStarts kSobolStarts;

// What a key means for the two dimensions.
struct SobolOwenSeeds {
  uint32_t x, y;
  constexpr SobolOwenSeeds(uint32_t seed_x, uint32_t seed_y) : x(seed_x), y(seed_y) {}
  constexpr explicit SobolOwenSeeds(uint64_t key)
      : x(static_cast<uint32_t>(mix_bits(key + kGoldenIncrement))),
        y(static_cast<uint32_t>(mix_bits(key + kGoldenIncrement) >> 32)) {}
};
// The same point, scrambled by a key; 32-bit binary fractions.
constexpr std::array<uint32_t, 2> sobol_owen_point(uint32_t index, SobolOwenSeeds seeds) {
  const std::array<uint32_t, 2> plain = sobol_point_reversed(index);
  return {reverse_bits(owen_scramble_reversed(plain[0], seeds.x)),
          reverse_bits(owen_scramble_reversed(plain[1], seeds.y))};
}
constexpr std::array<uint32_t, 2> sobol_owen_point(uint32_t index, uint64_t key) {
  return sobol_owen_point(index, SobolOwenSeeds(key));
}

// Pair number `pair` of a point in many dimensions: each pair is the sequence above, its points in an order of
// its own (the index scrambled as well, after Burley: Practical Hash-based Owen Scrambling, JCGT 9(4), 2020).
// Every aligned block of 2^k indices stays such a block, so each pair is stratified at every power of two,
// and no pair is correlated with another. `key` identifies pixel and seed; both numbers are in [0, 1).
constexpr std::array<float, 2> sobol_owen_pair(uint32_t index, uint32_t pair, uint64_t key) {
  const uint64_t pair_key = mix_bits(key + kGoldenIncrement * (uint64_t{pair} + 1));
  const uint32_t shuffled =
      reverse_bits(owen_scramble_reversed(reverse_bits(index), static_cast<uint32_t>(pair_key)));
  const std::array<uint32_t, 2> point = sobol_owen_point(shuffled, mix_bits(pair_key));
  return {unit_float(point[0]), unit_float(point[1])};
}

}  // namespace triad
