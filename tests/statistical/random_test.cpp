// SPDX-License-Identifier: Apache-2.0
// The hashed random numbers: uniform, and unrelated along every part of their key. Thresholds are those that an
// ideal generator would pass with all but 1e-6 of all seeds.
#include <gtest/gtest.h>

#include <cmath>
#include <triad/base/random.hpp>
#include <triad/sampling/sobol.hpp>
#include <vector>

using triad::SampleRandom;

namespace {

constexpr double kSigmas = 5;  // two-sided 5.7e-7

struct Key {
  int32_t x = 0, y = 0;
  uint32_t index = 0, dimension = 0;
  uint64_t seed = 0;
  uint32_t bits() const { return SampleRandom(x, y, index, seed).u32(dimension); }
};

// The i-th key when one part counts and the others stand.
Key along(int part, uint32_t i) {
  Key key{120, 45, 3, 17, 1};
  switch (part) {
    case 0: key.x = static_cast<int32_t>(i) - 1000; break;
    case 1: key.y = static_cast<int32_t>(i) - 1000; break;
    case 2: key.index = i; break;
    case 3: key.dimension = i; break;
    default: key.seed = i;
  }
  return key;
}
constexpr const char* kParts[] = {"x", "y", "index", "dimension", "seed"};

// For k degrees of freedom, chi-square is nearly normal with mean k and variance 2 k.
void expect_chi_square(double chi2, double freedom, const std::string& what) {
  EXPECT_NEAR(chi2, freedom, kSigmas * std::sqrt(2 * freedom)) << what;
}

}  // namespace

TEST(Random, IsUniformAlongEachPartOfItsKey) {
  constexpr uint32_t kNumbers = 1 << 18, kBins = 1024;
  for (int part = 0; part < 5; ++part) {
    std::vector<double> high(kBins), low(kBins);
    for (uint32_t i = 0; i < kNumbers; ++i) {
      const uint32_t bits = along(part, i).bits();
      ++high[bits >> 22];
      ++low[bits & 1023];
    }
    for (const auto* bins : {&high, &low}) {
      double chi2 = 0;
      for (const double n : *bins) chi2 += (n - kNumbers / kBins) * (n - kNumbers / kBins) / (kNumbers / kBins);
      expect_chi_square(chi2, kBins - 1, kParts[part]);
    }
  }
}

TEST(Random, NeighboursAreUnrelated) {
  // Pairs of consecutive numbers fill the square evenly, along each part and between each two parts.
  constexpr uint32_t kNumbers = 1 << 18, kSide = 32;
  for (int a = 0; a < 5; ++a)
    for (int b = 0; b < 5; ++b) {
      std::vector<double> bins(kSide * kSide);
      for (uint32_t i = 0; i < kNumbers; ++i) {
        const uint32_t first = along(a, i).bits();
        const uint32_t second = (a == b ? along(a, i + 1) : along(b, i)).bits();
        if (along(a, i).x == along(b, i).x && first == second) continue;  // the one key that both lines share
        ++bins[(first >> 27) * kSide + (second >> 27)];
      }
      double chi2 = 0;
      const double expected = static_cast<double>(kNumbers) / (kSide * kSide);
      for (const double n : bins) chi2 += (n - expected) * (n - expected) / expected;
      expect_chi_square(chi2, kSide * kSide - 1, std::string(kParts[a]) + " and " + kParts[b]);
    }
}

TEST(Random, EachBitOfTheKeyFlipsHalfOfTheNumber) {
  constexpr int kTrials = 4096;
  const auto flipped = [](Key key, int part, int bit) {
    switch (part) {
      case 0: key.x = static_cast<int32_t>(static_cast<uint32_t>(key.x) ^ (1u << bit)); break;
      case 1: key.y = static_cast<int32_t>(static_cast<uint32_t>(key.y) ^ (1u << bit)); break;
      case 2: key.index ^= 1u << bit; break;
      case 3: key.dimension ^= 1u << bit; break;
      default: key.seed ^= uint64_t{1} << bit;
    }
    return key.bits();
  };
  for (int part = 0; part < 5; ++part)
    for (int bit = 0; bit < (part == 4 ? 64 : 32); ++bit) {
      std::vector<int> flips(32);
      for (int t = 0; t < kTrials; ++t) {
        Key key{t % 64, t / 64, static_cast<uint32_t>(t) * 7, static_cast<uint32_t>(t % 13),
                static_cast<uint64_t>(t)};
        const uint32_t difference = key.bits() ^ flipped(key, part, bit);
        for (int o = 0; o < 32; ++o) flips[o] += difference >> o & 1;
      }
      for (int o = 0; o < 32; ++o)
        ASSERT_NEAR(flips[o], kTrials / 2, 5.5 * std::sqrt(kTrials) / 2)
            << kParts[part] << " bit " << bit << " to " << o;
    }
}

TEST(Random, FloatsAreBelowOne) {
  EXPECT_EQ(triad::unit_float(0), 0.f);
  EXPECT_LT(triad::unit_float(0xffffffffu), 1.f);
  EXPECT_EQ(triad::unit_float(0x80000000u), .5f);
}

TEST(Random, ScrambledBitsAreFairAndDependOnTheBitsAbove) {
  // Over many keys, each bit of a scrambled coordinate is 1 half of the time ...
  constexpr int kKeys = 20000;
  std::vector<int> ones(32), same(31);
  for (int k = 0; k < kKeys; ++k) {
    const uint32_t seed = SampleRandom(0, 0, 0, static_cast<uint64_t>(k)).u32(0);
    const uint32_t a = triad::owen_scramble(0, seed);
    // ... and a bit's flip is independent of that under the sibling half of an interval.
    for (int o = 0; o < 32; ++o) ones[o] += a >> o & 1;
    const uint32_t b = triad::owen_scramble(0x80000000u, seed);
    for (int o = 0; o < 31; ++o) same[o] += ((a ^ b) >> o & 1) == 0;
  }
  const double spread = kSigmas * std::sqrt(kKeys) / 2;
  for (int o = 0; o < 32; ++o) EXPECT_NEAR(ones[o], kKeys / 2, spread) << "bit " << o;
  for (int o = 0; o < 31; ++o) EXPECT_NEAR(same[o], kKeys / 2, spread) << "bit " << o;
}
