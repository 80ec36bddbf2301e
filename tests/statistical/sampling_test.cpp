// SPDX-License-Identifier: Apache-2.0
// Renders of functions with known integrals: unbiased, with errors that fall and are estimated as they are.
#include <gtest/gtest.h>

#include <cmath>
#include <triad/base/parallel.hpp>
#include <triad/numeric/sum.hpp>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/strategy.hpp>

#include "../unit/sampling_sources.hpp"

using namespace triad;

namespace {

constexpr Rgb kBlack{0, 0, 0}, kWhite{1, 1, 1};

RenderResult render(const std::string& strategy, const Source& source, uint64_t seed = 0, double until_rmse = 0) {
  RenderOptions options;
  options.seed = seed;
  options.until_rmse = until_rmse;
  options.planes.error = options.planes.variance = true;
  return make_strategy(strategy, "--strategy")->render(source, options);
}

// Root mean square over pixels and channels, against the exact integral or `level`.
double true_rmse(const Film& film, const Source& source, double level = 0) {
  NeumaierSum sum;
  for (int y = 0; y < film.height(); ++y)
    for (int x = 0; x < film.width(); ++x) {
      const auto exact = source.integral(x, y, x + 1, y + 1).value_or(std::array<double, 3>{level, level, level});
      const auto mean = film.mean(film.pixel(x, y));
      for (int c = 0; c < 3; ++c) sum.add((mean[c] - exact[c]) * (mean[c] - exact[c]));
    }
  return std::sqrt(sum.value() / (3. * static_cast<double>(film.pixels())));
}

// Each pixel sees the same slanted edge at another offset.
HalfPlaneSource edge() { return HalfPlaneSource(48, 48, .6, .8, 33.3, kWhite, kBlack); }

}  // namespace

TEST(Sampling, MeanOverSeedsIsTheIntegral) {
  // z-test for each pixel that the edge of a disc crosses, its variance taken from the seeds themselves.
  const DiscSource disc(16, 12, 7.3, 6.1, 4.4, {1, 0, 3}, {0, 1, .5f});
  constexpr int kSeeds = 400;
  FilmPlanes planes;
  planes.variance = true;
  Film over_seeds(16, 12, planes);
  std::vector<std::array<double, 3>> sum(over_seeds.pixels()), squares(over_seeds.pixels());
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const RenderResult result = render("sobol-owen:spp=5", disc, seed);
    for (size_t p = 0; p < sum.size(); ++p)
      for (int c = 0; c < 3; ++c) {
        const double value = result.film.mean(p)[c];
        sum[p][c] += value;
        squares[p][c] += value * value;
      }
  }
  int crossed = 0;
  double chi2 = 0;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 16; ++x) {
      const size_t p = over_seeds.pixel(x, y);
      const auto exact = *disc.integral(x, y, x + 1, y + 1);
      const double mean = sum[p][0] / kSeeds;
      const double variance = (squares[p][0] - sum[p][0] * mean) / (kSeeds - 1) / kSeeds;
      if (exact[0] < .02 || exact[0] > .98) {  // hardly crossed: seeds may have missed it, and the variance is none
        EXPECT_NEAR(mean, exact[0], .02);
        continue;
      }
      ++crossed;
      const double z = (mean - exact[0]) / std::sqrt(variance);
      EXPECT_LT(std::abs(z), 4.5) << x << "," << y;
      chi2 += z * z;
    }
  EXPECT_GT(crossed, 20);
  EXPECT_NEAR(chi2, crossed, 4 * std::sqrt(2. * crossed));
}

TEST(Sampling, VarianceOfIndependentSamplesIsEstimatedAsItIs) {
  const double amplitude = 2, variance = amplitude * amplitude / 12;
  const auto source = test::noise(64, 64, 10, amplitude);
  for (const int spp : {2, 4, 16, 64}) {
    const RenderResult result = render("sobol-owen:spp=" + std::to_string(spp), source);
    NeumaierSum sum;
    for (size_t p = 0; p < result.film.pixels(); ++p)
      for (const double v : result.film.variance_of_mean(p)) {
        EXPECT_GE(v, 0);
        sum.add(v);
      }
    // The variance of s^2 for uniform numbers: sigma^4 (kurtosis 9/5 - (n-3)/(n-1)) / n.
    const double n = spp, count = 3. * static_cast<double>(result.film.pixels());
    const double sd = variance / n * std::sqrt((1.8 - (n - 3) / (n - 1)) / n / count);
    EXPECT_NEAR(sum.value() / count, variance / n, 5 * sd) << spp;
    // And the error that the halves give is the true one.
    if (spp >= 4) {
      EXPECT_NEAR(result.film.estimated_rmse() / true_rmse(result.film, source, 10), 1, .05) << spp;
    }
  }
}

TEST(Sampling, EdgeErrorFallsAsItShould) {
  // Over the picture, log2 of the error against log2 of N: about -3/4 for stratified points at a straight edge,
  // where random ones have -1/2.
  const HalfPlaneSource source = edge();
  const auto rmse = [&](int spp) {
    double sum = 0;
    for (uint64_t seed = 0; seed < 8; ++seed) {
      const double each = true_rmse(render("sobol-owen:spp=" + std::to_string(spp), source, seed).film, source);
      sum += each * each;
    }
    return std::sqrt(sum / 8);
  };
  const double slope = std::log2(rmse(1024) / rmse(4)) / 8;
  EXPECT_NEAR(slope, -.75, .05);
  // A grid: more points, less error, all the way.
  double last = true_rmse(render("control", source).film, source);
  for (const int n : {2, 4, 8, 16}) {
    const double now = true_rmse(render("grid:n=" + std::to_string(n), source).film, source);
    EXPECT_LT(now, last * .7) << n;
    last = now;
  }
}

TEST(Sampling, EstimatedErrorOfStratifiedPointsIsOnTheSafeSideAndNear) {
  const HalfPlaneSource source = edge();
  const DiscSource disc(48, 48, 24.2, 23.7, 17.3, kWhite, kBlack);
  for (const Source* each : {static_cast<const Source*>(&source), static_cast<const Source*>(&disc)})
    for (const int spp : {16, 32, 64, 256, 1024}) {
      double estimated = 0, exact = 0, welford = 0;
      for (uint64_t seed = 0; seed < 4; ++seed) {
        const RenderResult result = render("sobol-owen:spp=" + std::to_string(spp), *each, seed);
        estimated += std::pow(result.film.estimated_rmse(), 2);
        exact += std::pow(true_rmse(result.film, *each), 2);
        for (size_t p = 0; p < result.film.pixels(); ++p)
          welford += result.film.variance_of_mean(p)[0] / static_cast<double>(result.film.pixels());
      }
      const double ratio = std::sqrt(estimated / exact);
      RecordProperty("ratio_" + std::to_string(spp), std::to_string(ratio));
      EXPECT_GT(ratio, .9) << spp;
      EXPECT_LT(ratio, 2.) << spp;
      EXPECT_GT(std::sqrt(welford / exact), ratio) << "what the halves are for";
    }
}

TEST(Sampling, StopsWhenTheErrorIsReached) {
  const HalfPlaneSource source = edge();
  for (const double target : {1e-2, 1e-3}) {
    const RenderResult result = render("sobol-owen:spp=65536", source, 3, target);
    EXPECT_TRUE(result.reached);
    EXPECT_TRUE(result.complete);
    EXPECT_LE(result.passes.back().rmse, target);
    EXPECT_LT(true_rmse(result.film, source), target);
    EXPECT_GT(result.passes.at(result.passes.size() - 2).rmse, target) << "it went on longer than it had to";
    EXPECT_LT(result.samples, 65536u * 48 * 48);
  }
  // Noise: the error of n samples is known.
  const auto noisy = test::noise(64, 64, 1, 1);
  const RenderResult result = render("sobol-owen:spp=65536", noisy, 0, .01);
  const double needed = 1. / 12 / 1e-4;  // 833 samples, so the pass that ends with 1024
  EXPECT_EQ(result.film.count(0), 1024u);
  EXPECT_GT(1024, needed);
  EXPECT_LT(true_rmse(result.film, noisy, 1), .01);
  // Not reachable with what it may take.
  const RenderResult short_one = render("sobol-owen:spp=64", noisy, 0, .01);
  EXPECT_FALSE(short_one.reached);
  EXPECT_TRUE(short_one.complete);
  EXPECT_EQ(short_one.film.count(0), 64u);
}

TEST(Sampling, APictureOfOnePixelDoesNotStopByChance) {
  // With one pixel, the two halves agree by chance now and then; the variance does not.
  int wrong = 0;
  for (uint64_t seed = 0; seed < 200; ++seed) {
    const auto noisy = test::noise(1, 1, 1, 1);
    const RenderResult result = render("sobol-owen:spp=4096", noisy, seed, .01);
    wrong += result.film.count(0) < 512;
  }
  EXPECT_EQ(wrong, 0);
}
