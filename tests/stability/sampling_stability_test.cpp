// SPDX-License-Identifier: Apache-2.0
// The hard cases of strategies and films: large numbers with small noise, one and two samples, pictures of one pixel,
// patterns that repeat with the samples.
#include <gtest/gtest.h>

#include <cmath>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/strategy.hpp>

#include "../unit/sampling_sources.hpp"
#include "stability_table.hpp"

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
  stability::equal("sums", "10^6 samples of +-1e8 over a bias of 4: mean", film.mean(0)[0], 4);
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
  const double expected = 80. * n / (n - 1);
  stability::at_most("statistics", "variance of 1e8 + noise of 9: relative error",
                     std::abs(film.variance_of_mean(0)[1] * n / expected - 1), 1e-9);
  stability::equal("statistics", "variance of 1e8 without noise", film.variance_of_mean(1)[1], 0);
  Film small(1, 1, planes);
  EXPECT_EQ(small.variance_of_mean(0)[0], 0);
  small.add(0, 0, grey(1e8));
  stability::equal("statistics", "variance of one sample", small.variance_of_mean(0)[0], 0);
  small.add(0, 1, grey(1e8 + 16));
  stability::equal("statistics", "variance of the mean of two, 1e8 and 1e8 + 16", small.variance_of_mean(0)[0],
                   2 * 8 * 8 / 1 / 2.);
  Film equal(1, 1, planes);
  equal.add(0, 0, grey(.1));
  equal.add(0, 1, grey(.1));
  stability::equal("statistics", "variance of two equal samples", equal.variance_of_mean(0)[0], 0);
}

TEST(StatisticsStability, VarianceIsNeverNegative) {
  FilmPlanes planes;
  planes.variance = true;
  uint64_t negative = 0;
  constexpr uint32_t kFilms = 2000;
  for (uint32_t k = 0; k < kFilms; ++k) {
    // The last bits of large and small numbers, two of them, in turn.
    Film film(1, 1, planes);
    const float base = std::ldexp(1.f + static_cast<float>(k) / kFilms, static_cast<int>(k % 120) - 60);
    for (uint32_t i = 0; i < 2 + k % 7; ++i)
      film.add(0, i, grey(static_cast<double>(i % 2 == 0 ? base : std::nextafter(base, 0.f))));
    negative += !(film.variance_of_mean(0)[0] >= 0);
  }
  stability::never("statistics", "variance of numbers one bit apart: negative or not a number", negative, kFilms);
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
  stability::naive_fails("statistics", "the same as mean of squares less square of mean: relative error",
                         std::abs((squares / n - sum / n * (sum / n)) / 80 - 1), 1. / 80);
}

TEST(StrategyStability, OnePixelAndOneSample) {
  const RampSource pixel(1, 1, {1, 2, 3}, {0, 0, 0}, {0, 0, 0});
  for (const auto& [text, samples] : {std::pair{"control", 1u},
                                      {"grid:n=1", 1u},
                                      {"grid:n=7", 49u},
                                      {"sobol-owen:spp=1", 1u},
                                      {"sobol-owen:spp=2", 2u},
                                      {"variance", 16u},
                                      {"variance:threshold=0", 256u}}) {
    const RenderResult result = render(text, pixel);
    stability::equal("strategies", std::string("one pixel, ") + text + ": samples",
                     static_cast<double>(result.samples), samples);
    EXPECT_EQ(result.film.mean(0), (std::array<double, 3>{1, 2, 3})) << text;
    EXPECT_EQ(result.film.variance_of_mean(0), (std::array<double, 3>{0, 0, 0})) << text;
  }
  // One sample says nothing of the error; what is not known is not called 0.
  EXPECT_TRUE(std::isinf(render("sobol-owen:spp=1", pixel).film.estimated_rmse()));
}

TEST(StrategyStability, ThresholdsWithoutMeasure) {
  const auto noisy = test::noise(16, 16, 1, 1);
  for (const auto& [text, samples] : {std::pair{"variance:threshold=0", 256.},
                                      {"variance:threshold=5e-324", 256.},
                                      {"variance:threshold=1e308", 16.},
                                      {"variance:threshold=inf", 16.},
                                      {"variance:threshold=0,least=256", 256.},
                                      {"variance:threshold=0,batch=16777216", 256.}}) {
    const RenderResult result = render(text, noisy);
    stability::equal("strategies", std::string("noise, ") + text + ": samples per pixel",
                     static_cast<double>(result.samples) / 256, samples);
  }
}

TEST(StrategyStability, MoireWhereThePeriodIsTheSampleSpacing) {
  // Stripes a quarter of a pixel wide, black and white, so that each pixel is half white. A grid of 2 or 4 meets
  // them always at the same phase: that is what a grid does, and here it says 0 or 1. Scrambled points do not.
  const FunctionSource stripes(32, 32,
                               [](const SampleRequest& r) { return grey(std::fmod(r.x * 4, 2.) < 1 ? 1 : 0); });
  for (const auto& [text, expected] : {std::pair{"control", 1.}, {"grid:n=2", 0.}, {"grid:n=4", .5}}) {
    const RenderResult result = render(text, stripes);
    uint64_t others = 0;
    for (size_t p = 0; p < result.film.pixels(); ++p) others += result.film.mean(p)[0] != expected;
    stability::never("strategies", fmt::format("stripes in step with {}: pixels other than {}", text, expected),
                     others, result.film.pixels());
  }
  const RenderResult result = render("sobol-owen:spp=16", stripes);
  uint64_t others = 0;
  for (size_t p = 0; p < result.film.pixels(); ++p)
    others += result.film.mean(p)[0] != .5;  // 4 points in each stripe
  stability::never("strategies", "stripes under sobol-owen:spp=16: pixels other than 0.5", others,
                   result.film.pixels());
}

TEST(StrategyStability, AbsurdlyBrightAndDarkLight) {
  const FunctionSource source(4, 1, [](const SampleRequest& r) {
    return grey(r.pixel_x == 0 ? 3e38 : r.pixel_x == 1 ? 1e-45 : r.pixel_x == 2 ? -1e-38 : 0);
  });
  const RenderResult result = render("sobol-owen:spp=64", source);
  stability::never("values", "samples of 3e38, 1e-45 and -1e-38: dropped", result.dropped, result.samples);
  EXPECT_EQ(result.film.mean(0)[0], static_cast<double>(3e38f));
  EXPECT_EQ(result.film.mean(1)[0], static_cast<double>(1e-45f));
  EXPECT_EQ(result.film.mean(2)[0], static_cast<double>(-1e-38f));
  for (size_t p = 0; p < 4; ++p) EXPECT_EQ(result.film.variance_of_mean(p)[1], 0);
}
