// SPDX-License-Identifier: Apache-2.0
// The functions of vectors against the library's in double precision, and every width against every other.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <triad/numeric/aligned.hpp>
#include <triad/numeric/lanes.hpp>

namespace {

using triad::Lanes16;
using triad::Lanes4;
using triad::Lanes8;

constexpr int kCount = 4096;
using Values = triad::AlignedBuffer<float>;

// Function f of values spread evenly, or by ratio, from low to high.
Values spread(double low, double high, bool by_ratio) {
  Values x(kCount);
  for (int i = 0; i < kCount; ++i) {
    const double at = static_cast<double>(i) / (kCount - 1);
    x[i] = static_cast<float>(by_ratio ? low * std::pow(high / low, at) : low + (high - low) * at);
  }
  return x;
}

template <class F>
Values applied(const F& f, const Values& x) {
  Values y(kCount);
  triad::run_lanes([&]<class V>() TRIAD_INLINE_BODY {
    for (int i = 0; i < kCount; i += triad::kLanes<V>) triad::store<V>(&y[i], f(triad::load<V>(&x[i])));
  });
  // Every other width that this processor has gives the same bits.
  const auto same = [&](const Values& z) {
    for (int i = 0; i < kCount; ++i) ASSERT_EQ(std::bit_cast<uint32_t>(z[i]), std::bit_cast<uint32_t>(y[i])) << x[i];
  };
  Values z(kCount);
  for (int i = 0; i < kCount; i += 4) triad::store<Lanes4>(&z[i], f(triad::load<Lanes4>(&x[i])));
  same(z);
#if defined(__x86_64__) && defined(__GNUC__)
  if (triad::cpu_can_run(triad::CpuPath::kAvx2)) {
    triad::run_avx2([&]() TRIAD_INLINE_BODY {
      for (int i = 0; i < kCount; i += 8) triad::store<Lanes8>(&z[i], f(triad::load<Lanes8>(&x[i])));
    });
    same(z);
  }
  if (triad::cpu_can_run(triad::CpuPath::kAvx512)) {
    triad::run_avx512([&]() TRIAD_INLINE_BODY {
      for (int i = 0; i < kCount; i += 16) triad::store<Lanes16>(&z[i], f(triad::load<Lanes16>(&x[i])));
    });
    same(z);
  }
#endif
  return y;
}

template <class Exact>
double worst_relative(const Values& x, const Values& y, const Exact& exact) {
  double worst = 0;
  for (int i = 0; i < kCount; ++i)
    worst = std::max(worst, std::abs(static_cast<double>(y[i]) / exact(static_cast<double>(x[i])) - 1));
  return worst;
}

}  // namespace

TEST(LanesTest, RootsAreThoseOfTheLibrary) {
  for (const Values& x : {spread(1e-37, 1e37, true), spread(.5, 4, false)}) {
    const auto root = [](const auto& v) TRIAD_INLINE_BODY { return triad::sqrt_of(v); };
    const auto cube = [](const auto& v) TRIAD_INLINE_BODY { return triad::cbrt_of(v); };
    EXPECT_LT(worst_relative(x, applied(root, x), [](double v) { return std::sqrt(v); }), 3e-7);
    EXPECT_LT(worst_relative(x, applied(cube, x), [](double v) { return std::cbrt(v); }), 2e-7);
  }
  const Values zero(kCount);
  EXPECT_EQ(applied([](const auto& v) TRIAD_INLINE_BODY { return triad::sqrt_of(v); }, zero)[0], 0);
}

TEST(LanesTest, LogarithmsAndPowersAreThoseOfTheLibrary) {
  const auto log2 = [](const auto& v) TRIAD_INLINE_BODY { return triad::log2_of(v); };
  const auto exp2 = [](const auto& v) TRIAD_INLINE_BODY { return triad::exp2_of(v); };
  for (const Values& x : {spread(1e-37, 1e37, true), spread(.25, 4, false), spread(.9999, 1.0001, false)}) {
    const Values y = applied(log2, x);
    for (int i = 0; i < kCount; ++i) {
      const double exact = std::log2(static_cast<double>(x[i]));
      ASSERT_NEAR(static_cast<double>(y[i]), exact, std::min(2e-7, std::abs(exact) * 3e-7) + 6e-8 * std::abs(exact))
          << x[i];
    }
  }
  for (const Values& x : {spread(-126, 126.9, false), spread(-1, 1, false)})
    EXPECT_LT(worst_relative(x, applied(exp2, x), [](double v) { return std::exp2(v); }), 2e-7);
  EXPECT_EQ(applied(exp2, Values(kCount))[0], 1);
  EXPECT_EQ(applied(exp2, spread(-1e30, -127, false))[0], 0x1p-126f);
}

TEST(LanesTest, UnitIsCutAndWithoutNotANumber) {
  Values x = spread(-1, 2, false);
  x[0] = NAN;
  x[1] = HUGE_VALF;
  x[2] = -HUGE_VALF;
  const Values y = applied([](const auto& v) TRIAD_INLINE_BODY { return triad::to_unit(v); }, x);
  EXPECT_EQ(y[0], 0);
  EXPECT_EQ(y[1], 1);
  EXPECT_EQ(y[2], 0);
  for (int i = 3; i < kCount; ++i) EXPECT_EQ(y[i], std::clamp(x[i], 0.f, 1.f));
}
