// SPDX-License-Identifier: Apache-2.0
// Student's t against published tables and closed forms, intervals against hand calculation, and what plans compare.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <triad/base/random.hpp>
#include <triad/evaluation/study_comparisons.hpp>
#include <triad/evaluation/study_statistics.hpp>

using namespace triad;

namespace {

TEST(StudentT, AgreesWithThePublishedTable) {
  // Upper critical values of Student's t to three decimals, as handbooks print them.
  struct Row {
    double freedom, p95, p975, p99, p999;
  };
  for (const Row& row :
       {Row{1, 6.314, 12.706, 31.821, 318.309}, Row{2, 2.920, 4.303, 6.965, 22.327},
        Row{3, 2.353, 3.182, 4.541, 10.215}, Row{4, 2.132, 2.776, 3.747, 7.173}, Row{5, 2.015, 2.571, 3.365, 5.893},
        Row{9, 1.833, 2.262, 2.821, 4.297}, Row{10, 1.812, 2.228, 2.764, 4.144}, Row{30, 1.697, 2.042, 2.457, 3.385},
        Row{100, 1.660, 1.984, 2.364, 3.174}}) {
    EXPECT_NEAR(student_quantile(.95, row.freedom), row.p95, .0006) << row.freedom;
    EXPECT_NEAR(student_quantile(.975, row.freedom), row.p975, .0006) << row.freedom;
    EXPECT_NEAR(student_quantile(.99, row.freedom), row.p99, .0006) << row.freedom;
    EXPECT_NEAR(student_quantile(.999, row.freedom), row.p999, .0006) << row.freedom;
  }
}

TEST(StudentT, AgreesWithClosedForms) {
  for (const double t : {-40., -3.2, -.7, -1e-3, 0., .2, 1., 5., 300.}) {
    EXPECT_NEAR(student_cumulative(t, 1), .5 + std::atan(t) / std::numbers::pi, 1e-13) << t;
    EXPECT_NEAR(student_cumulative(t, 2), .5 + t / (2 * std::sqrt(2 + t * t)), 1e-13) << t;
    // Four degrees, by integrating the density with u = t / sqrt(4 + t^2), the sine of an angle.
    const double u = t / std::sqrt(4 + t * t);
    EXPECT_NEAR(student_cumulative(t, 4), .5 + .75 * (u - u * u * u / 3), 1e-13) << t;
  }
  // Many degrees: the normal distribution, up to terms of 1 / freedom.
  EXPECT_NEAR(student_cumulative(1.3, 1e8), .5 * std::erfc(-1.3 / std::numbers::sqrt2), 1e-8);
}

TEST(StudentT, QuantileAndCumulativeAreInverse) {
  for (const double freedom : {.7, 1., 2.5, 7., 63.4, 1e4})
    for (const double p : {1e-6, .01, .3, .5, .62, .975, .999})
      EXPECT_NEAR(student_cumulative(student_quantile(p, freedom), freedom), p, 1e-12 * p + 1e-13)
          << p << " " << freedom;
}

TEST(Intervals, OfDataWithKnownMoments) {
  // 1 .. 5: mean 3, s^2 = 2.5, so t(.975, 4) sqrt(2.5 / 5) = 2.776445 * .7071068.
  EXPECT_EQ(mean_of({1, 2, 3, 4, 5}), 3);
  EXPECT_NEAR(half_width_95({1, 2, 3, 4, 5}), 2.776445105 * std::sqrt(.5), 1e-8);
  EXPECT_EQ(half_width_95({.1, .1, .1}), 0);
  EXPECT_TRUE(std::isnan(half_width_95({7})));
  EXPECT_TRUE(std::isnan(mean_of({})));
}

// Normal numbers by Box and Muller.
double normal(uint32_t index) {
  const SampleRandom random(0, 0, index, 17);
  return std::sqrt(-2 * std::log(1 - static_cast<double>(random.uniform(0)))) *
         std::cos(2 * std::numbers::pi * static_cast<double>(random.uniform(1)));
}

TEST(Intervals, HoldTheExpectationInNineteenOfTwentyCases) {
  constexpr int kTrials = 20000, kValues = 4;
  int held = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> values;
    for (int i = 0; i < kValues; ++i) values.push_back(5 + 2 * normal(static_cast<uint32_t>(trial * kValues + i)));
    held += std::abs(mean_of(values) - 5) <= half_width_95(values);
  }
  // Five standard deviations of the binomial; the normal distribution's 1.96 would hold .87.
  EXPECT_NEAR(static_cast<double>(held) / kTrials, .95, 5 * std::sqrt(.95 * .05 / kTrials));
}

TEST(Welch, AgreesWithHandCalculation) {
  // a: mean 2, s^2 = 1, n = 3; b: mean 5, s^2 = 5/3, n = 4. t = -3 / sqrt(1/3 + 5/12) = -2 sqrt 3,
  // freedom = (3/4)^2 / ((1/3)^2 / 2 + (5/12)^2 / 3) = .5625 / (1/18 + 25/432).
  const LessThanTest test = test_less({1, 2, 3}, {3.5, 4.5, 5.5, 6.5});
  EXPECT_NEAR(test.t, -2 * std::sqrt(3.), 1e-12);
  EXPECT_NEAR(test.freedom, .5625 / (1. / 18 + 25. / 432), 1e-12);
  EXPECT_LT(test.p, .02);
  EXPECT_GT(test.p, .005);  // t(.99, 5) = 3.365 and t(.995, 4.9) = 4.05 enclose 3.46
  const LessThanTest back = test_less({3.5, 4.5, 5.5, 6.5}, {1, 2, 3});
  EXPECT_NEAR(back.p, 1 - test.p, 1e-12);
  EXPECT_EQ(test_less({1, 1}, {1, 1}).p, .5);
  EXPECT_EQ(test_less({1, 1}, {2, 2}).p, 0);
  EXPECT_TRUE(std::isnan(test_less({1}, {2, 3}).p));
}

StudyRecord record(const std::string& method, const std::string& spp, std::vector<double> seconds, double rmse) {
  return {{{"method", method}, {"spp", spp}},
          {{"seconds", std::move(seconds)}, {"rmse", {rmse}}},
          {"seconds", "rmse"},
          1};
}

StudyPlan plan_of() {
  StudyPlan plan;
  plan.axes = {{"method", {"a", "b"}, {}}, {"spp", {"1", "4"}, {}}};
  return plan;
}

TEST(Comparisons, AtEqualSecondsAreInterpolatedInLogarithms) {
  StudyPlan plan = plan_of();
  plan.equal = {{"method", "a", "spp", "seconds", "rmse"}};
  // b: rmse = 8 / seconds between 1 and 16 s. a has 3 at 2 s, where b has 4; at 100 s b has no figure.
  const std::vector<StudyRecord> records{record("a", "1", {2}, 3), record("a", "4", {100}, 1),
                                         record("b", "1", {1}, 8), record("b", "4", {16}, .5)};
  const auto results = compare_at_equal(plan, records);
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].value, "b");
  EXPECT_EQ(results[0].along, "1");
  EXPECT_NEAR(results[0].ratio, 4. / 3, 1e-12);
  EXPECT_TRUE(std::isnan(results[1].ratio));
  EXPECT_THAT(
      comparisons_text(plan, records),
      testing::HasSubstr("rmse relative to a's at equal seconds, by spp of a\nmethod     1  4\nb       1.33  -"));
}

TEST(Comparisons, OfSecondsTestEachGroup) {
  StudyPlan plan = plan_of();
  plan.faster = {{"method", "a", "b"}};
  const std::vector<StudyRecord> records{record("a", "1", {1, 2, 3}, 1), record("a", "4", {9, 10, 11}, 1),
                                         record("b", "1", {3.5, 4.5, 5.5, 6.5}, 1), record("b", "4", {9, 10, 11}, 1)};
  const auto results = compare_seconds(plan, records);
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].where, (StudySettings{{"spp", "1"}}));
  EXPECT_EQ(results[0].ratio, 2. / 5);
  EXPECT_NEAR(results[0].test.t, -2 * std::sqrt(3.), 1e-12);
  EXPECT_NEAR(results[1].test.p, .5, 1e-12);
  EXPECT_THAT(comparisons_text(plan, records), testing::HasSubstr("a than b"));
}

TEST(Comparisons, WithPublishedFiguresAreRatios) {
  StudyPlan plan = plan_of();
  plan.published = {{"Table 1", "rmse", "method", "spp", "a", {{"a", {10, 20}}, {"b", {5, 30}}}}};
  const std::vector<StudyRecord> records{record("a", "1", {1}, 4), record("a", "4", {1}, 2), record("b", "1", {1}, 3),
                                         record("b", "4", {1}, 1)};
  const auto results = compare_published(plan, records);
  ASSERT_EQ(results.size(), 4u);
  EXPECT_EQ(results[2].row, "b");
  EXPECT_EQ(results[2].ours, .75);
  EXPECT_EQ(results[2].theirs, .5);
  EXPECT_EQ(results[3].ours, .5);
  EXPECT_EQ(results[3].theirs, 1.5);
  EXPECT_THAT(comparisons_text(plan, records),
              testing::HasSubstr("Table 1: rmse relative to a, ours (published)\nmethod           1          4\n"
                                 "a            1 (1)      1 (1)\nb       0.75 (0.5)  0.5 (1.5)\n"));
}

TEST(Records, WithSeedsShowMeansAndIntervalsOverSeeds) {
  // Two repeats of three seeds: rmse differs by seed only.
  StudyRecord one{
      {{"n", "a"}}, {{"rmse", {1, 2, 6, 1, 2, 6}}, {"seconds", {5, 1, 2, 9, 3, 4}}}, {"seconds", "rmse"}, 3};
  EXPECT_THAT(one.samples("rmse"), testing::ElementsAre(1, 2, 6));
  EXPECT_EQ(one.shown("rmse"), 3);
  EXPECT_EQ(one.shown("seconds"), 3.5);  // the median of all six
  EXPECT_THAT(one.samples("seconds"), testing::ElementsAre(7, 2, 3));
  StudyPlan plan;
  plan.axes = {{"n", {"a"}, {}}};
  plan.measure = {"rmse"};
  // s^2 = 7 of 1, 2, 6: t(.975, 2) = 4.302653 times sqrt(7 / 3).
  EXPECT_EQ(study_table(plan, {one}), "n      rmse\na  3 ±6.572\n");
}

}  // namespace
