// SPDX-License-Identifier: Apache-2.0
// The relative errors, the exact trimmed mean below them, the sums below that, and what `error` says of tolerances.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <triad/numeric/trimmed_mean.hpp>
#include <triad/numeric/weighted_mean.hpp>

#include "metric_runner.hpp"

namespace {

using metric_runner::constant;
using metric_runner::error_of;
using metric_runner::noise;
using metric_runner::run;
using testing::HasSubstr;
using triad::SyntheticPicture;
using triad::TrimLimit;
using triad::TrimmedSums;
using triad::WeightedMean;

struct Metric {
  const char* id;
  double eps;
  long double (*of)(long double t, long double r, long double eps);
};
// Written out anew, in extended precision.
const Metric kMetrics[] = {
    {"relmse-tev", .01, [](long double t, long double r, long double e) { return (r - t) * (r - t) / (e + r * r); }},
    {"relmse-jeri", 1e-4,
     [](long double t, long double r, long double e) { return (r - t) * (r - t) / (e + r * r); }},
    {"relmse-pbrt", .01,
     [](long double t, long double r, long double e) { return (r - t) * (r - t) / (r * r + 2 * r * e + e * e); }},
    {"mape", .01, [](long double t, long double r, long double e) { return std::fabs(r - t) / (e + std::fabs(r)); }},
    {"smape", .01, [](long double t, long double r, long double e) {
       return 2 * std::fabs(r - t) / (2 * e + std::fabs(r) + std::fabs(t));
     }}};

// By sorting: the mean of the smaller part of the weight. Pixel i has weight weights[i], or 1.
long double sorted_mean(std::vector<double> values, std::vector<double> weights, long double trim) {
  std::vector<size_t> order(values.size());
  long double total = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    order[i] = i;
    total += weights[i];
  }
  std::sort(order.begin(), order.end(), [&](size_t i, size_t j) { return values[i] < values[j]; });
  const long double kept = total * (1 - trim);
  long double left = kept, sum = 0;
  for (const size_t i : order) {
    const long double w = std::min<long double>(weights[i], left);
    sum += w * values[i];
    left -= w;
  }
  return sum / kept;
}

double trimmed(const std::vector<double>& values, const std::vector<float>& weights, double trim) {
  const float* w = weights.empty() ? nullptr : weights.data();
  const auto first = std::make_unique<TrimmedSums>(), second = std::make_unique<TrimmedSums>();
  first->add_first(values.data(), w, values.size());
  const TrimLimit limit = first->limit(trim);
  second->add_second(values.data(), w, values.size(), limit);
  return second->mean(limit);
}

}  // namespace

TEST(RelativeError, AgreesWithItsFormula) {
  for (const Metric& m : kMetrics)
    for (const auto& [width, height] : {std::pair{1, 1}, {7, 5}, {257, 3}, {600, 9}}) {
      // With dark, bright and negative references.
      const SyntheticPicture test = noise(width, height, 1, -.2f, 6), reference = noise(width, height, 2, -.05f, 5);
      const auto got = run(m.id, {}, test, reference, nullptr, {.borders = {0, 1, 4}});
      long double mean = 0;
      std::vector<double> values;
      for (size_t i = 0; i < got.map.size(); ++i) {
        long double pixel = 0;
        for (size_t c = 3 * i; c < 3 * i + 3; ++c)
          pixel +=
              m.of(static_cast<long double>(test.pixels[c]), static_cast<long double>(reference.pixels[c]), m.eps);
        pixel /= 3;
        values.push_back(static_cast<double>(pixel));
        EXPECT_NEAR(static_cast<double>(got.map[i]), values[i], 1e-7 * values[i]) << m.id << " " << i;
        mean += pixel;
      }
      mean /= static_cast<long double>(values.size());
      EXPECT_EQ(got.map.size(), static_cast<size_t>(width * height));
      EXPECT_NEAR(got.scores[0] / static_cast<double>(mean), 1, 2e-14) << m.id;
      if (got.scores.size() < 2) continue;
      const auto expected = sorted_mean(values, std::vector<double>(values.size(), 1), .001L);
      EXPECT_NEAR(got.scores[1] / static_cast<double>(expected), 1, 1e-12)
          << m.id;  // pbrt's has references near -eps
    }
}

TEST(RelativeError, OfFlatPicturesIsAClosedForm) {
  const SyntheticPicture test = constant(5, 4, {.5f, .5f, .5f}), reference = constant(5, 4, {.25f, .25f, .25f});
  const auto mean = [&](const char* id, const triad::ParamTexts& params = {}) {
    const auto scores = run(id, params, test, reference).scores;
    EXPECT_DOUBLE_EQ(scores.front(), scores.back()) << "all pixels are alike";
    return scores[0];
  };
  // One pair, and no two metrics agree.
  EXPECT_NEAR(mean("relmse-tev"), .0625 / .0725, 1e-15);
  EXPECT_NEAR(mean("relmse-pbrt"), .0625 / (.26 * .26), 1e-15);
  EXPECT_NEAR(mean("relmse-jeri"), .0625 / .0626, 1e-15);
  EXPECT_NEAR(mean("mape"), .25 / .26, 1e-15);
  EXPECT_NEAR(mean("smape"), .25 / .385, 1e-15);
  EXPECT_NEAR(mean("relmse-tev", {{"eps", ".9375"}}), .0625, 1e-15);
  EXPECT_NEAR(mean("smape", {{"eps", ".125"}}), .5, 1e-15);
}

TEST(RelativeError, IsZeroForEqualPictures) {
  const SyntheticPicture picture = noise(19, 7, 3);
  for (const Metric& m : kMetrics) EXPECT_THAT(run(m.id, {}, picture, picture).scores, testing::Each(0.0)) << m.id;
}

// Where imgtool would divide by 0 it leaves the channel out of the sum, but not of the count.
TEST(RelativeError, OfPbrtCountsAnInfiniteChannelAsNothing) {
  const SyntheticPicture test = constant(3, 2, {0, 1, 1}), reference = constant(3, 2, {-.25f, .75f, .75f});
  EXPECT_DOUBLE_EQ(run("relmse-pbrt", {{"eps", ".25"}}, test, reference).scores[0], .0625 * 2 / 3);
}

TEST(RelativeError, TrimmingTakesTheFirefliesAway) {
  SyntheticPicture test = constant(100, 20, {.5f, .5f, .5f});
  const SyntheticPicture reference = constant(100, 20, {.25f, .25f, .25f});
  std::fill_n(test.pixels.begin() + 3 * 1234, 3, 1e4f);
  const auto got = run("relmse-tev", {}, test, reference).scores;
  EXPECT_GT(got[0], 1e5);
  EXPECT_NEAR(got[1], .0625 / .0725, 1e-13);  // .1% of 2000 pixels are two
  // At .025% half of the firefly stays.
  const double firefly = std::pow(1e4 - .25, 2) / .0725;
  EXPECT_NEAR(run("relmse-tev", {{"trim", ".025"}}, test, reference).scores[1],
              (.5 * firefly + 1999 * .0625 / .0725) / 1999.5, 1e-9);
  EXPECT_EQ(run("relmse-tev", {{"trim", "0"}}, test, reference).scores[1], got[0]);
}

TEST(RelativeError, PoolsByTheWeightsOfTheMask) {
  SyntheticPicture test = noise(40, 10, 5), mask = noise(40, 10, 6, 0, 1, 1);
  const SyntheticPicture reference = noise(40, 10, 7, .1f, 1);
  for (size_t i = 0; i < mask.pixels.size(); i += 3) mask.pixels[i] = 0;
  std::vector<double> values, weights(mask.pixels.begin(), mask.pixels.end());
  for (const float v : run("relmse-jeri", {}, test, reference).map) values.push_back(static_cast<double>(v));
  test.pixels[0] = NAN;  // has weight 0
  test.pixels[9] = HUGE_VALF;
  const auto got = run("relmse-jeri", {{"trim", "7"}}, test, reference, &mask, {.borders = {0, 3, 4}}).scores;
  EXPECT_NEAR(got[0], static_cast<double>(sorted_mean(values, weights, 0)), 1e-7 * got[0]);
  EXPECT_NEAR(got[1], static_cast<double>(sorted_mean(values, weights, .07L)), 1e-7 * got[1]);
  EXPECT_LT(got[1], .9 * got[0]);
  EXPECT_THAT(error_of("relmse-jeri", {}, test, reference), HasSubstr("2 pixels"));
  std::fill(mask.pixels.begin(), mask.pixels.end(), 0.f);
  for (const Metric& m : kMetrics)
    EXPECT_THAT(error_of(m.id, {}, test, reference, &mask), HasSubstr("every pixel is left out")) << m.id;
}

TEST(RelativeError, RefusesPicturesOfOtherSizes) {
  const SyntheticPicture a = noise(4, 3, 1), b = noise(4, 4, 1);
  for (const Metric& m : kMetrics)
    EXPECT_THAT(error_of(m.id, {}, a, b), testing::AllOf(HasSubstr("4x3"), HasSubstr("4x4"))) << m.id;
}

TEST(TrimmedMean, IsThatOfTheSortedValues) {
  std::mt19937 bits(7);
  const auto uniform = [&] { return static_cast<double>(bits()) / 4294967296.0; };
  for (const size_t count : {size_t{1}, size_t{2}, size_t{63}, size_t{1000}, size_t{20011}})
    for (const double trim : {0., .001, .0421, .5, .999}) {
      // Over 30 decades; all in one bin of the upper bits; many alike; huge ones beyond float. Else floats, so that
      // those which are alike in single precision are.
      std::vector<double> wide, narrow, alike, huge, ones(count, 1), unequal;
      std::vector<float> weights;
      const auto rounded = [](double v) { return static_cast<double>(static_cast<float>(v)); };
      for (size_t i = 0; i < count; ++i) {
        wide.push_back(rounded(std::pow(10, 30 * uniform() - 15)));
        narrow.push_back(rounded(1 + 1e-3 * uniform()));
        alike.push_back(i % 3 == 0 ? 0 : .1);
        huge.push_back(i % 2 ? 1e39 : uniform());
        weights.push_back(static_cast<float>(uniform()));
        unequal.push_back(static_cast<double>(weights[i]));
      }
      for (const auto* values : {&wide, &narrow, &alike, &huge}) {
        const auto plain = static_cast<double>(sorted_mean(*values, ones, trim));
        const auto weighted = static_cast<double>(sorted_mean(*values, unequal, trim));
        EXPECT_NEAR(trimmed(*values, {}, trim), plain, 1e-12 * plain) << count << " " << trim;
        EXPECT_NEAR(trimmed(*values, weights, trim), weighted, 1e-12 * weighted) << count << " " << trim;
      }
    }
}

TEST(TrimmedMean, KeepsTwelveDigitsOverAThousandMillionPixels) {
  const std::vector<double> block(1000, .1);
  const auto first = std::make_unique<TrimmedSums>(), second = std::make_unique<TrimmedSums>(),
             all_first = std::make_unique<TrimmedSums>(), all_second = std::make_unique<TrimmedSums>();
  const double bright = 1. / 3;
  for (int i = 0; i < 1000; ++i) first->add_first(block.data(), nullptr, 1000);
  for (int i = 0; i < 1000; ++i) first->add_first(&bright, nullptr, 1);
  for (int i = 0; i < 1000; ++i) all_first->merge(*first);
  const TrimLimit limit = all_first->limit(.0005);
  for (int i = 0; i < 1000; ++i) second->add_second(block.data(), nullptr, 1000, limit);
  for (int i = 0; i < 1000; ++i) second->add_second(&bright, nullptr, 1, limit);
  for (int i = 0; i < 1000; ++i) all_second->merge(*second);
  const long double total = 1001e6L, kept = total * (1 - .0005L), dark = 1000e6L;
  const long double expected = (dark * .1L + (kept - dark) / 3) / kept;
  EXPECT_NEAR(all_second->mean(limit) / static_cast<double>(expected), 1, 1e-13);
}

TEST(WeightedMean, KeepsTwelveDigitsWhereAPlainSumLosesThem) {
  // A large value first, beside which each of a million others is less than its last bit.
  WeightedMean all{};
  long double sum = 0, weight = 0;
  double plain = 0;
  std::mt19937 bits(11);
  for (int i = 0; i < 1'000'000; ++i) {
    const double value = i == 0 ? 1e16 : static_cast<double>(bits()) / 4294967296.0;
    const float w = i % 7 == 3 ? .3f : 1.f;
    WeightedMean strip{};
    strip.add(&value, &w, 1);
    all.merge(strip);
    sum += static_cast<long double>(w) * static_cast<long double>(value);
    weight += static_cast<long double>(w);
    plain += static_cast<double>(w) * value;
  }
  const auto expected = static_cast<double>(sum / weight);
  EXPECT_NEAR(all.mean() / expected, 1, 1e-15);
  EXPECT_GT(std::abs(plain / static_cast<double>(sum) - 1), 1e-11) << "not hard enough to tell";
  EXPECT_EQ(all.counted, 1'000'000);
}

// 10^9 pixels in strips of 10^6.
TEST(WeightedMean, KeepsTwelveDigitsOverAThousandMillionPixels) {
  const std::vector<double> block(1000, .1);
  WeightedMean strip{}, all{};
  for (int i = 0; i < 1000; ++i) strip.add(block.data(), nullptr, 1000);
  for (int i = 0; i < 1000; ++i) all.merge(strip);
  EXPECT_EQ(all.counted, 1'000'000'000);
  EXPECT_NEAR(all.mean() / .1, 1, 1e-14);
}

TEST(WeightedMean, CountsWhatIsNotFiniteAndLeavesItOut) {
  const double values[] = {1, NAN, HUGE_VAL, 3, -HUGE_VAL};
  const float weights[] = {.5f, 1, .5f, 1, 0};
  WeightedMean sums{};
  sums.add(values, weights, 5);
  EXPECT_EQ(sums.nonfinite, 2);
  EXPECT_EQ(sums.counted, 4);
  EXPECT_DOUBLE_EQ(sums.mean(), 3.5 / 1.5);
}

TEST(ErrorMetric, TellsTheShareOfThePixelsBeyondATolerance) {
  SyntheticPicture test = constant(10, 4, {.5f, .5f, .5f});
  const SyntheticPicture reference = test;
  test.pixels[3 * 7 + 1] += .125f;  // one channel of one pixel
  test.pixels[3 * 9] -= .25f;       // another pixel, darker, in two channels
  test.pixels[3 * 9 + 2] += .5f;
  constexpr size_t kAbove = 6;
  const auto share = [&](const char* tolerance, const SyntheticPicture* mask = nullptr) {
    const auto got =
        run("error", {{"tolerance", tolerance}, {"peak", "4"}}, test, reference, mask, {.borders = {0, 3}});
    EXPECT_EQ(got.reports.at("peak"), 4);
    return got.scores.at(kAbove);
  };
  EXPECT_DOUBLE_EQ(share("0"), 2. / 40);
  EXPECT_DOUBLE_EQ(share(".124"), 2. / 40);
  EXPECT_DOUBLE_EQ(share(".125"), 1. / 40);  // no more than the tolerance
  EXPECT_DOUBLE_EQ(share(".4"), 1. / 40);
  EXPECT_DOUBLE_EQ(share(".5"), 0);
  SyntheticPicture mask = constant(10, 4, {1});
  mask.pixels[7] = .25f;
  mask.pixels[8] = 0;
  EXPECT_DOUBLE_EQ(share(".1", &mask), 1.25 / 38.25);
  EXPECT_DOUBLE_EQ(run("error", {}, test, reference).scores.at(kAbove), 2. / 40);
}
