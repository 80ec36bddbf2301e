// SPDX-License-Identifier: Apache-2.0
// The hard cases of strategies and films: large numbers with small noise, one and two samples, pictures of one pixel,
// patterns that repeat with the samples.
#include <gtest/gtest.h>

#include <cmath>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/strategy.hpp>

#include "../unit/sampling_sources.hpp"

using namespace triad;
using test::FunctionSource;
using test::grey;

namespace {

RenderResult render(const std::string& strategy, const Source& source) {
  RenderOptions options;
  options.planes.variance = options.planes.error = true;
  return make_strategy(strategy, "--strategy")->render(source, options);
}

}  // namespace

TEST(StatisticsStability, SumsKeepWhatRoundingWouldLose) {
  // 1e8 and -1e8 alternate on top of a bias that float holds exactly: the mean is the bias.
  Film film(1, 1, {});
  const int n = 1'000'000;
  for (int i = 0; i < n; ++i) film.add(0, static_cast<uint32_t>(i), grey((i & 1 ? -1e8 : 1e8) + (i % 4 < 2 ? 8 : 0)));
  EXPECT_EQ(film.mean(0)[0], 4);
}

TEST(StatisticsStability, VarianceOfLargeNumbersWithSmallNoise) {
  // Float's step at 1e8 is 8: values 1e8 + {0, 8, 16, 24} in turn have variance 80 n / (n - 1).
  FilmPlanes planes;
  planes.variance = true;
  Film film(2, 1, planes);
  const uint32_t n = 400'000;
  for (uint32_t i = 0; i < n; ++i) {
    film.add(0, i, grey(1e8 + 8 * (i % 4)));
    film.add(1, i, grey(1e8));
  }
  EXPECT_NEAR(film.variance_of_mean(0)[1] * n, 80. * n / (n - 1), 80 * 1e-9);
  EXPECT_EQ(film.variance_of_mean(1)[1], 0);
  Film small(1, 1, planes);
  EXPECT_EQ(small.variance_of_mean(0)[0], 0);
  small.add(0, 0, grey(1e8));
  EXPECT_EQ(small.variance_of_mean(0)[0], 0);  // one sample
  small.add(0, 1, grey(1e8 + 16));
  EXPECT_DOUBLE_EQ(small.variance_of_mean(0)[0], 128. / 2);  // two: 2 * 8^2 / 1
}

TEST(StatisticsStability, NaiveVarianceWouldBeLost) {
  // Why Welford: the textbook's mean of squares less the square of the mean, in double, over the same numbers.
  double sum = 0, squares = 0;
  const int n = 400'000;
  for (int i = 0; i < n; ++i) {
    const double x = 1e8 + 8 * (i % 4);
    sum += x;
    squares += x * x;
  }
  EXPECT_GT(std::abs(squares / n - sum / n * (sum / n) - 80), 1);
}

TEST(StrategyStability, OnePixelAndOneSample) {
  const RampSource pixel(1, 1, {1, 2, 3}, {0, 0, 0}, {0, 0, 0});
  for (const auto& [text, samples] : {std::pair{"control", 1u},
                                      {"grid:n=1", 1u},
                                      {"grid:n=7", 49u},
                                      {"sobol-owen:spp=1", 1u},
                                      {"sobol-owen:spp=2", 2u}}) {
    const RenderResult result = render(text, pixel);
    EXPECT_EQ(result.samples, samples) << text;
    EXPECT_EQ(result.film.mean(0), (std::array<double, 3>{1, 2, 3})) << text;
    EXPECT_EQ(result.film.variance_of_mean(0), (std::array<double, 3>{0, 0, 0})) << text;
  }
  // One sample says nothing of the error; what is not known is not called 0.
  EXPECT_TRUE(std::isinf(render("sobol-owen:spp=1", pixel).film.estimated_rmse()));
}

TEST(StrategyStability, MoireWhereThePeriodIsTheSampleSpacing) {
  // Stripes a quarter of a pixel wide, black and white, so that each pixel is half white. A grid of 2 or 4 meets
  // them always at the same phase: that is what a grid does, and here it says 0 or 1. Scrambled points do not.
  const FunctionSource stripes(32, 32,
                               [](const SampleRequest& r) { return grey(std::fmod(r.x * 4, 2.) < 1 ? 1 : 0); });
  for (const auto& [text, expected] : {std::pair{"control", 1.}, {"grid:n=2", 0.}, {"grid:n=4", .5}}) {
    const RenderResult result = render(text, stripes);
    for (size_t p = 0; p < result.film.pixels(); ++p) ASSERT_EQ(result.film.mean(p)[0], expected) << text;
  }
  const RenderResult result = render("sobol-owen:spp=16", stripes);
  for (size_t p = 0; p < result.film.pixels(); ++p) ASSERT_EQ(result.film.mean(p)[0], .5);  // 4 points in each stripe
}

TEST(StrategyStability, AbsurdlyBrightAndDarkLight) {
  const FunctionSource source(4, 1, [](const SampleRequest& r) {
    return grey(r.pixel_x == 0 ? 3e38 : r.pixel_x == 1 ? 1e-45 : r.pixel_x == 2 ? -1e-38 : 0);
  });
  const RenderResult result = render("sobol-owen:spp=64", source);
  EXPECT_EQ(result.dropped, 0u);
  EXPECT_EQ(result.film.mean(0)[0], static_cast<double>(3e38f));
  EXPECT_EQ(result.film.mean(1)[0], static_cast<double>(1e-45f));
  EXPECT_EQ(result.film.mean(2)[0], static_cast<double>(-1e-38f));
  for (size_t p = 0; p < 4; ++p) EXPECT_EQ(result.film.variance_of_mean(p)[1], 0);
}
