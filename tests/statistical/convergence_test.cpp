// SPDX-License-Identifier: Apache-2.0
// Intervals and tests of the evaluation do what they promise, as often as they promise it: fixed seeds, bounds that a
// right implementation passes with all but 1e-6 of all seeds.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <triad/evaluation/convergence.hpp>
#include <triad/evaluation/noise_spectrum.hpp>

#include "../unit/stage_runner.hpp"

using namespace triad;
using stage_runner::header;
using stage_runner::Picture;

namespace {

constexpr double kSigmas = 5;

// `count` of `trials` is what a probability p gives.
void expect_rate(int count, int trials, double p, const std::string& what) {
  EXPECT_NEAR(count, trials * p, kSigmas * std::sqrt(trials * p * (1 - p))) << what << ", of " << trials;
}

// Mean squared errors of pictures of `pixels` pixels, each the mean of N normal samples, and biased.
std::vector<CostedError> render_series(int count, int pixels, double bias, std::mt19937_64& random,
                                       double sigma = 1) {
  std::normal_distribution<double> normal;
  std::vector<CostedError> points;
  for (int i = 0; i < count; ++i) {
    const double n = std::pow(2., i);
    double squares = 0;
    for (int p = 0; p < pixels; ++p) squares += std::pow(bias + sigma * normal(random) / std::sqrt(n), 2);
    points.push_back({n, squares / pixels});
  }
  return points;
}

TEST(ConvergenceOfMeans, HasASlopeOfMinusOneInNineteenOfTwentyIntervals) {
  std::mt19937_64 random(11);
  constexpr int kTrials = 400;
  int inside = 0, root_inside = 0, efficient = 0;
  for (int t = 0; t < kTrials; ++t) {
    auto points = render_series(7, 300, 0, random);
    const PowerLaw law = fit_power_law(points);
    inside += law.slope.low <= -1 && -1 <= law.slope.high;
    // Efficiency 1 / (mse N) has the expectation 1 / sigma^2, to a part in a hundred.
    std::vector<double> efficiencies;
    for (const CostedError& p : points) efficiencies.push_back(1 / (p.error * p.cost));
    const Interval mean = geometric_mean(efficiencies);
    efficient += mean.low <= 1 && 1 <= mean.high;
    for (CostedError& p : points) p.error = std::sqrt(p.error);
    const PowerLaw root = fit_power_law(points);
    root_inside += root.slope.low <= -.5 && -.5 <= root.slope.high;
  }
  expect_rate(inside, kTrials, .95, "slopes of -1");
  expect_rate(root_inside, kTrials, .95, "slopes of -1/2");
  expect_rate(efficient, kTrials, .95, "efficiencies");
}

TEST(ConvergenceOfMeans, ShowsBiasWhereThereIsSomeAndSeldomWhereThereIsNone) {
  std::mt19937_64 random(12);
  constexpr int kTrials = 400;
  int false_alarm = 0, false_free = 0, found = 0, inside = 0;
  const double bias = .1;  // squared .01, the variance at 128 samples .008
  for (int t = 0; t < kTrials; ++t) {
    const auto fair = render_series(8, 200, 0, random), biased = render_series(8, 200, bias, random);
    false_alarm += fit_floor(fair, 1).found();
    false_free += fit_floor(fair, std::nullopt).found();
    const ErrorFloor fit = fit_floor(biased, 1);
    found += fit.found();
    inside += fit.floor.low <= bias * bias && bias * bias <= fit.floor.high;
  }
  // At the border of what a floor may be, one end of the interval errs: 2.5 %.
  expect_rate(false_alarm, kTrials, .025, "bias claimed of unbiased renders");
  expect_rate(false_free, kTrials, .025, "the same with a free rate");
  EXPECT_GT(found, .99 * kTrials);
  expect_rate(inside, kTrials, .95, "floors");
}

TEST(CostRatio, HasTheTruthInNineteenOfTwentyIntervals) {
  std::mt19937_64 random(13);
  constexpr int kTrials = 400;
  int inside = 0;
  for (int t = 0; t < kTrials; ++t) {
    const auto a = render_series(6, 200, 0, random), b = render_series(8, 200, 0, random, std::sqrt(2.5));
    const Interval ratio = cost_ratio(fit_power_law(a), fit_power_law(b), .1);
    inside += ratio.low <= 2.5 && 2.5 <= ratio.high;
  }
  expect_rate(inside, kTrials, .95, "ratios");
}

NoiseResult spectrum_of(const std::vector<double>& values, int size, int tile) {
  const NoiseSpectrum spectrum(size, size, tile, 1, .125);
  NoiseSums sums{};
  spectrum.add({0, size, {values.data()}, nullptr}, 0, size, sums);
  return spectrum.finish(sums);
}

// Mean over a bin's coefficients of what a function of the frequency says, and how many there are.
struct Bin {
  double mean = 0, count = 0;
};
std::map<long, Bin> bins_of(int tile, const std::function<double(double, double)>& power) {
  std::map<long, Bin> bins;
  for (int ky = 0; ky < tile; ++ky)
    for (int kx = 0; kx < tile; ++kx) {
      const double fx = double(std::min(kx, tile - kx)) / tile, fy = double(std::min(ky, tile - ky)) / tile;
      Bin& bin = bins[std::lround(std::hypot(fx, fy) * tile)];
      bin.mean += power(fx, fy);
      bin.count += 1;
    }
  for (auto& [i, bin] : bins) bin.mean /= bin.count;
  return bins;
}

// Coefficients that count: half of a real picture's are the conjugates of the others, a Hann window makes neighbours
// alike (an eighth of 4.4 are independent), and the tiles that overlap add little.
double deviation(const Bin& bin, double tiles) { return std::sqrt(2 * 4.4 / (bin.count * tiles)); }

TEST(NoiseSpectrum, OfWhiteNoiseIsFlat) {
  std::mt19937_64 random(21);
  std::normal_distribution<double> normal(.25, .1);
  constexpr int kSize = 384, kTile = 64;
  std::vector<double> values(kSize * kSize);
  for (double& v : values) v = normal(random);
  const NoiseResult got = spectrum_of(values, kSize, kTile);
  const double n = kSize * kSize;
  EXPECT_NEAR(got.lag_x, 0, kSigmas / std::sqrt(n));
  EXPECT_NEAR(got.lag_y, 0, kSigmas / std::sqrt(n));
  EXPECT_NEAR(got.variance, .01, .01 * kSigmas * std::sqrt(2 / n));
  EXPECT_NEAR(got.low_share, got.white_share, .1 * got.white_share);
  EXPECT_NEAR(got.white_share, std::numbers::pi * .125 * .125, .003);
  size_t i = 0;
  for (const auto& [bin, b] : bins_of(kTile, [](double, double) { return .01; })) {
    EXPECT_NEAR(got.power.at(i), .01, .01 * kSigmas * deviation(b, 36)) << bin;
    ++i;
  }
}

TEST(NoiseSpectrum, OfBoxFilteredNoiseFollowsItsSinc) {
  // The mean of 4 x 4: |sin(4 pi f) / (4 sin(pi f))|^2 in x and y, and neighbours that share three of four.
  std::mt19937_64 random(22);
  std::normal_distribution<double> normal;
  constexpr int kSize = 384, kTile = 64, kBox = 4;
  std::vector<double> white(kSize * kSize), values(kSize * kSize);
  for (double& v : white) v = normal(random);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      for (int j = 0; j < kBox; ++j)
        for (int i = 0; i < kBox; ++i)
          values[static_cast<size_t>(y * kSize + x)] +=
              white[static_cast<size_t>((y + j) % kSize * kSize + (x + i) % kSize)] / (kBox * kBox);
  const NoiseResult got = spectrum_of(values, kSize, kTile);
  EXPECT_NEAR(got.lag_x, .75, .02);
  EXPECT_NEAR(got.lag_y, .75, .02);
  EXPECT_GT(got.low_share, .5);  // white noise: .05
  const auto sinc = [](double f) {
    if (f == 0) return 1.;
    const double s = std::sin(kBox * std::numbers::pi * f) / (kBox * std::sin(std::numbers::pi * f));
    return s * s;
  };
  size_t i = 0;
  int judged = 0;
  for (const auto& [bin, b] : bins_of(kTile, [&](double fx, double fy) { return sinc(fx) * sinc(fy); })) {
    const double power = got.power.at(i++);
    if (bin < 2 || b.mean < .01) continue;  // the window smears over one cycle per tile: the mean's place, the zeros
    EXPECT_NEAR(power, b.mean, b.mean * (kSigmas * deviation(b, 36) + .03)) << bin;
    ++judged;
  }
  EXPECT_GT(judged, 12);
}

struct Render {
  Picture test, reference, variance;
};
Render noisy(int size, double bias_sigmas, std::mt19937_64& random) {
  constexpr double kN = 16;
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(.01, 1);
  Render r{{header(size, size, 1), {}, {}}, {header(size, size, 1), {}, {}}, {header(size, size, 1), {}, {}}};
  for (int i = 0; i < size * size * 3; ++i) {
    const double variance = uniform(random) / kN, value = uniform(random);
    r.reference.pixels.push_back(static_cast<float>(value));
    r.variance.pixels.push_back(static_cast<float>(variance));
    r.test.pixels.push_back(static_cast<float>(value + (normal(random) + bias_sigmas) * std::sqrt(variance)));
  }
  r.test.metadata.set("triad:samples", std::to_string(static_cast<int>(kN) * size * size));
  return r;
}
stage_runner::Outcome z_test(const Render& r, const std::string& significance = ".01") {
  return stage_runner::run("z-test", {{"significance", significance}}, {&r.test, &r.reference, &r.variance, nullptr},
                           64);
}

TEST(ZTest, OfGaussianNoiseHasUniformPValues) {
  std::mt19937_64 random(31);
  const auto got = z_test(noisy(160, 0, random));
  const double tests = 160 * 160 * 3;
  EXPECT_EQ(got.scores[1], 1);
  // The Kolmogorov distribution is beyond 2.7 with probability 1e-6; the histogram's steps add one.
  EXPECT_LT(got.scores[3], 2.7 / std::sqrt(tests) + 1 / 4096.);
  EXPECT_NEAR(got.reports.at("z-rms"), 1, kSigmas / std::sqrt(2 * tests));
}

TEST(ZTest, RejectsFairRendersAsOftenAsItsSignificanceSays) {
  std::mt19937_64 random(32);
  constexpr int kTrials = 400;
  int rejected = 0;
  for (int t = 0; t < kTrials; ++t) rejected += z_test(noisy(8, 0, random), ".1").scores[1] == 0;
  expect_rate(rejected, kTrials, .1, "rejected");
}

TEST(ZTest, FindsBiasInOnePixelAndInAll) {
  std::mt19937_64 random(33);
  Render one = noisy(64, 0, random);
  const size_t at = (20 * 64 + 33) * 3 + 2;
  one.test.pixels[at] = one.reference.pixels[at] + 8 * std::sqrt(one.variance.pixels[at]);
  const auto found = z_test(one);
  EXPECT_EQ(found.scores[1], 0);
  EXPECT_EQ(found.reports.at("max-x"), 33);
  EXPECT_EQ(found.reports.at("max-y"), 20);
  EXPECT_EQ(found.reports.at("max-channel"), 2);
  EXPECT_NEAR(found.scores[0], 1 - 1 / (64. * 64 * 3), 1e-9);
  // Half a standard error everywhere: no pixel shows it, all together do (|z| > 1.15: .307 of them in place of .25).
  const auto all = z_test(noisy(64, .5, random));
  EXPECT_EQ(all.scores[1], 1);
  EXPECT_GT(all.scores[3], 2.7 / std::sqrt(64. * 64 * 3) + .02);
}

}  // namespace
