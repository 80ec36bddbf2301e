// SPDX-License-Identifier: Apache-2.0
// The small bias of stopping where samples agree, and the error that is estimated all the same.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <triad/base/parallel.hpp>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/sobol.hpp>
#include <triad/sampling/strategy.hpp>

#include "../unit/sampling_sources.hpp"

using namespace triad;
using test::FunctionSource;
using test::grey;

namespace {

RenderResult render(const std::string& strategy, const Source& source, uint64_t seed, double until_rmse = 0) {
  RenderOptions options;
  options.seed = seed;
  options.until_rmse = until_rmse;
  options.planes.error = true;
  return make_strategy(strategy, "--strategy")->render(source, options);
}

double true_rmse(const Film& film, const Source& source) {
  double sum = 0;
  for (int y = 0; y < film.height(); ++y)
    for (int x = 0; x < film.width(); ++x) {
      const auto exact = *source.integral(x, y, x + 1, y + 1);
      for (int c = 0; c < 3; ++c) sum += std::pow(film.mean(film.pixel(x, y))[c] - exact[c], 2);
    }
  return std::sqrt(sum / (3. * static_cast<double>(film.pixels())));
}

}  // namespace

TEST(Variance, BiasOfIndependentSamplesIsTheOneThatCountingGives) {
  // White with probability p, else black, one pixel: 4 samples, and 4 more if the two halves differ. All 2^8 outcomes
  // give the mean's expectation.
  constexpr double kWhite = .2, kThreshold = .6;
  double mean = 0, square = 0, number = 0, product = 0;
  for (uint32_t outcome = 0; outcome < 256; ++outcome) {
    const int whites = std::popcount(outcome);
    const double weight = std::pow(kWhite, whites) * std::pow(1 - kWhite, 8 - whites);
    double all = 0, part = 0;
    for (uint32_t i = 0; i < 4; ++i) {
      all += (outcome >> i & 1) / 4.;
      part += (outcome >> i & 1 & sobol_half(i)) / 2.;
    }
    const bool goes_on = 3 * std::abs(all - part) / (1e-4 + std::sqrt(3 * all)) >= kThreshold;
    const double n = goes_on ? 8 : 4, value = goes_on ? whites / 8. : all;
    mean += weight * value;
    square += weight * value * value;
    number += weight * n;
    product += weight * value * n;
  }
  // Wald: the expected sum is p E[n], so that the bias is -cov(mean, n) / E[n], and dark as cov is positive.
  EXPECT_NEAR(mean - kWhite, -(product - mean * number) / number, 1e-12);
  EXPECT_LT(mean, kWhite - .01);

  const FunctionSource coin(1, 1, [](const SampleRequest& r) {
    return grey(SampleRandom(r.pixel_x, r.pixel_y, r.index, r.seed).uniform(80) < kWhite ? 1 : 0);
  });
  constexpr int kSeeds = 40'000;
  double sum = 0, samples = 0;
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const RenderResult result = render("variance:threshold=.6,least=4,batch=4,spp=8", coin, seed);
    sum += result.film.mean(0)[0];
    samples += static_cast<double>(result.samples);
  }
  EXPECT_NEAR(sum / kSeeds, mean, 4 * std::sqrt((square - mean * mean) / kSeeds));
  EXPECT_NEAR(samples / kSeeds, number, 4 * 2 / std::sqrt(kSeeds));  // n is 4 or 8: its deviation is at most 2
}

TEST(Variance, BiasAtAnEdgeIsLost) {
  // At a sharp edge, which pixels go on says little of whether they are too bright: even coarse settings are as good
  // as unbiased. Summed over the picture, in pixels of white; about 60 pixels are crossed.
  const DiscSource disc(24, 24, 11.7, 12.2, 8.3, {1, 1, 1}, {0, 0, 0});
  constexpr int kSeeds = 200;
  for (const char* text : {"variance", "variance:threshold=.1,batch=0", "variance:threshold=.3,least=4,batch=0"}) {
    double sum = 0, squares = 0;
    for (uint64_t seed = 0; seed < kSeeds; ++seed) {
      const RenderResult result = render(text, disc, seed);
      double off = 0;
      for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 24; ++x)
          off += result.film.mean(result.film.pixel(x, y))[0] - (*disc.integral(x, y, x + 1, y + 1))[0];
      sum += off;
      squares += off * off;
    }
    const double standard_error = std::sqrt(squares) / kSeeds;
    EXPECT_LT(std::abs(sum / kSeeds), 4 * standard_error) << text;
    EXPECT_LT(standard_error, .03) << text;
  }
}

namespace {

double noise_rmse(const Film& film, double level) {
  double sum = 0;
  for (size_t p = 0; p < film.pixels(); ++p)
    for (const double v : film.mean(p)) sum += (v - level) * (v - level);
  return std::sqrt(sum / (3. * static_cast<double>(film.pixels())));
}

}  // namespace

TEST(Variance, ErrorIsEstimatedAsWellAsUniformly) {
  const HalfPlaneSource edge(64, 64, .6, .8, 41.3, {1, 1, 1}, {0, 0, 0});
  for (const char* text : {"variance:threshold=.05,spp=1024", "variance:threshold=.01,spp=1024,batch=0",
                           "variance:threshold=.02,power=0"}) {
    double estimated = 0, exact = 0;
    for (uint64_t seed = 0; seed < 4; ++seed) {
      const RenderResult result = render(text, edge, seed);
      estimated += std::pow(result.passes.back().rmse, 2);
      exact += std::pow(true_rmse(result.film, edge), 2);
    }
    EXPECT_GT(std::sqrt(estimated / exact), .9) << text;
    EXPECT_LT(std::sqrt(estimated / exact), 2) << text;
  }
  // Pixels end where their halves agree, and the halves are what the estimate is made of; in plain noise, where all
  // of it is chance, that makes it low, by less than a tenth.
  const auto noisy = test::noise(64, 64, 1, 1);
  for (const char* text : {"variance:threshold=.05,spp=1024", "variance:threshold=.05,batch=0,spp=1024",
                           "variance:threshold=.1,least=4,batch=0,spp=1024"}) {
    const RenderResult result = render(text, noisy, 0);
    const double ratio = result.passes.back().rmse / noise_rmse(result.film, 1);
    EXPECT_GT(ratio, .9) << text;
    EXPECT_LT(ratio, 1.02) << text;
  }
}

TEST(Variance, StopsWhenTheErrorIsReached) {
  const HalfPlaneSource edge(64, 64, .6, .8, 41.3, {1, 1, 1}, {0, 0, 0});
  const RenderResult result = render("variance:threshold=0,spp=65536,batch=0", edge, 3, 2e-3);
  EXPECT_TRUE(result.reached);
  EXPECT_LE(result.passes.back().rmse, 2e-3);
  EXPECT_GT(result.passes.at(result.passes.size() - 2).rmse, 2e-3);
  EXPECT_LT(true_rmse(result.film, edge), 2e-3);
  // The threshold ends it first.
  const RenderResult coarse = render("variance:threshold=.3", edge, 3, 1e-4);
  EXPECT_FALSE(coarse.reached);
  EXPECT_TRUE(coarse.complete);
  // And to the same error, samples go where the error is.
  const RenderResult adaptive = render("variance:threshold=.002,spp=65536,batch=0", edge, 3, 2e-3);
  EXPECT_TRUE(adaptive.reached);
  EXPECT_LT(adaptive.samples, result.samples / 4);
}
