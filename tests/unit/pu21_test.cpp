// SPDX-License-Identifier: Apache-2.0
// PU21 against its table and its formula, and the powers it is made of against the C library's.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <triad/evaluation/pu21.hpp>
#include <triad/numeric/elementary.hpp>
#include <vector>

TEST(Pu21, MatchesItsTable) {
  for (const auto& [nits, expected] : {std::pair{.1, 5.717074},
                                       {1., 36.543911},
                                       {10., 123.647484},
                                       {100., 256.383897},
                                       {1000., 420.096921},
                                       {10000., 595.393920}})
    EXPECT_NEAR(triad::pu21(nits), expected, 1e-6) << nits;
}

TEST(Pu21, MatchesItsFormulaEverywhere) {
  std::vector<double> nits, values;
  for (int i = 0; i <= 3000; ++i) nits.push_back(.005 * std::pow(2e6, i / 3000.));
  values = nits;
  triad::pu21(values.data(), values.size());
  for (size_t i = 0; i < nits.size(); ++i) {
    using Wide = long double;
    const Wide p = std::pow(static_cast<Wide>(nits[i]), .9062562627L);
    const Wide v =
        596.3148142L *
        (std::pow((.353487901L + .3734658629L * p) / (1 + 8.277049286e-05L * p), .09150303166L) - .9099517204L);
    ASSERT_NEAR(values[i], static_cast<double>(std::max(v, Wide{0})), 1e-11) << nits[i];
    ASSERT_EQ(values[i], triad::pu21(nits[i]));
    if (i > 0) {
      ASSERT_GE(values[i], values[i - 1]);
    }
  }
}

TEST(Pu21, ClampsAndKeepsNotANumber) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double low : {-infinity, -1., 0., 1e-300, .005}) EXPECT_EQ(triad::pu21(low), triad::pu21(.005)) << low;
  for (const double high : {1e4, 1e300, infinity}) EXPECT_EQ(triad::pu21(high), triad::pu21(1e4)) << high;
  EXPECT_NEAR(triad::pu21(.005), 0, 1e-6);
  double values[] = {NAN, 1};
  triad::pu21(values, 2);
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_EQ(values[1], triad::pu21(1));
}

TEST(Elementary, LogarithmsAndPowersAreRight) {
  long double worst_log = 0, worst_exp = 0, worst_near_one = 0;
  for (int i = 0; i < 200000; ++i) {
    const double x = std::ldexp(1 + (i * 7919 % 200003) / 200003., i % 2000 - 1000);
    const long double exact = std::log2(static_cast<long double>(x));
    worst_log = std::max(worst_log, std::abs(triad::plain_log2(x) - exact) / std::max(1.L, std::abs(exact)));
    const double y = (i - 100000) * .00999;
    worst_exp = std::max(worst_exp, std::abs(triad::plain_exp2(y) / std::exp2(static_cast<long double>(y)) - 1));
    const double near = 1 + (i - 100000) * 1e-9;
    worst_near_one =
        std::max(worst_near_one, std::abs(triad::plain_log2(near) - std::log2(static_cast<long double>(near))));
  }
  EXPECT_LT(worst_log, 4e-16L);
  EXPECT_LT(worst_exp, 4e-16L);
  EXPECT_LT(worst_near_one, 1e-19L);
  EXPECT_EQ(triad::plain_log2(1), 0);
  EXPECT_EQ(triad::plain_exp2(0), 1);
  for (const double power : {.0448, .2856, .5, 2., -3.})
    EXPECT_NEAR(triad::plain_pow(.7, power), std::pow(.7, power), 1e-15);
}
