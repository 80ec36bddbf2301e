// SPDX-License-Identifier: Apache-2.0
// What theory says of the noise of splatting, of importance sampling and of weighted samples, and of edges.
#include <gtest/gtest.h>

#include <cmath>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/reconstruction.hpp>
#include <triad/sampling/strategy.hpp>

#include "../unit/sampling_sources.hpp"

using namespace triad;

namespace {

constexpr int kSide = 96;
constexpr double kVariance = 1. / 12;  // of white noise in [-1/2, 1/2)

RenderResult render(const std::string& strategy, const Source& source, uint64_t seed = 0) {
  RenderOptions options;
  options.seed = seed;
  return make_strategy(strategy, "--strategy")->render(source, options);
}
std::string with(const std::string& strategy, size_t filter, const std::string& more) {
  return strategy + ":filter=" + reconstruction_names()[filter] + "," + more;
}
ReconstructionFilter filter_of(size_t i) { return ReconstructionFilter(static_cast<ReconstructionKernel>(i)); }

struct Noise {
  double variance = 0, across = 0,
         down = 0;  // of a pixel about 0; its correlation with its right and lower neighbour
};
Noise noise_of(const std::string& strategy, int seeds = 3, int side = kSide) {
  Noise noise;
  double products_across = 0, products_down = 0;
  for (uint64_t seed = 0; seed < static_cast<uint64_t>(seeds); ++seed) {
    const RenderResult result = render(strategy, test::noise(side, side, 0, 1), seed);
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const auto here = result.mean(result.film.pixel(x, y));
        const auto right = result.mean(result.film.pixel(std::min(x + 1, side - 1), y));
        const auto below = result.mean(result.film.pixel(x, std::min(y + 1, side - 1)));
        for (size_t c = 0; c < 3; ++c) {
          noise.variance += here[c] * here[c];
          if (x < side - 1) products_across += here[c] * right[c];
          if (y < side - 1) products_down += here[c] * below[c];
        }
      }
  }
  const double pairs = 3. * seeds * side * (side - 1), values = 3. * seeds * side * side;
  noise.variance /= values;
  noise.across = products_across / pairs / noise.variance;
  noise.down = products_down / pairs / noise.variance;
  return noise;
}

// Of the filter's mean over the side of an edge where nx x + ny y < d, with (x, y) from the pixel's centre; by sums
// over midpoints, in x of the filter and in y of its running integral.
class SlowEdge {
 public:
  explicit SlowEdge(const ReconstructionFilter& f) : f_(f), r_(f.radius_px()), running_(kParts + 1) {
    for (int i = 0; i < kParts; ++i) running_[i + 1] = running_[i] + f.value(middle(i)) * 2 * r_ / kParts;
  }
  double operator()(double nx, double ny, double d) const {
    double sum = 0;
    for (int i = 0; i < kParts; ++i) {
      const double y = std::clamp((d - nx * middle(i)) / ny, -r_, r_);
      const double place = (y + r_) / (2 * r_) * kParts;
      const int k = std::min(static_cast<int>(place), kParts - 1);
      sum += f_.value(middle(i)) * (running_[k] + (place - k) * (running_[k + 1] - running_[k]));
    }
    return sum * 2 * r_ / kParts / (f_.integral() * f_.integral());
  }

 private:
  static constexpr int kParts = 2000;
  double middle(int i) const { return -r_ + (i + .5) * 2 * r_ / kParts; }
  const ReconstructionFilter& f_;
  double r_;
  std::vector<double> running_;
};

}  // namespace

TEST(FilteredNoise, SplattingHasTheGainsAndTheCorrelationOfTheFormula) {
  for (size_t i = 0; i < reconstruction_names().size(); ++i) {
    const ReconstructionFilter f = filter_of(i);
    const Noise noise = noise_of(with("splat", i, "spp=64,points=random"));
    // The widest, box2, has about 3 * 3 * 96^2 / 16 pixels that are independent: 2% of one standard deviation.
    EXPECT_NEAR(noise.variance * 64 / kVariance / f.splat_gain(), 1, i == 1 ? .08 : .05) << f.name();
    EXPECT_NEAR(noise.across, f.autocorrelation(1), .05) << f.name();
    EXPECT_NEAR(noise.down, f.autocorrelation(1), .05) << f.name();
  }
}

TEST(FilteredNoise, ImportanceSamplingHasTheGainsAndIsWhite) {
  for (size_t i = 0; i < reconstruction_names().size(); ++i) {
    const ReconstructionFilter f = filter_of(i);
    const Noise noise = noise_of(with("importance", i, "spp=16,points=random"));
    EXPECT_NEAR(noise.variance * 16 / kVariance / f.importance_gain(), 1, .03) << f.name();  // one deviation is .5%
    EXPECT_NEAR(noise.across, 0, .02) << f.name();
    EXPECT_NEAR(noise.down, 0, .02) << f.name();
  }
}

TEST(FilteredNoise, WeightedUniformPointsHaveTheGains) {
  for (size_t i = 0; i < reconstruction_names().size(); ++i) {
    const ReconstructionFilter f = filter_of(i);
    const Noise noise = noise_of(with("uniform", i, "spp=16,points=random,divide=integral"));
    EXPECT_NEAR(noise.variance * 16 / kVariance / f.uniform_gain(), 1, .05) << f.name();
    EXPECT_NEAR(noise.across, 0, .02) << f.name();
  }
}

TEST(FilteredNoise, OfThePublishedComparison) {
  // "Antialiasing: to splat or not" sees about the same noise under a box of 4 pixels; it differs by 4.
  const auto rms = [](const std::string& text, int side = kSide) {
    return std::sqrt(noise_of(text, 3, side).variance);
  };
  EXPECT_NEAR(rms("importance:filter=box2,points=random") / rms("splat:filter=box2,points=random"), 4, .4);
  // And more noise without splatting under Lanczos2, from uniform points.
  const double splat = rms("splat:filter=lanczos2,spp=16,points=random");
  EXPECT_NEAR(rms("uniform:filter=lanczos2,spp=16,points=random,divide=integral") / splat, 4, .4);
  // Divided by the weights, when there are enough samples for these to be near their mean.
  EXPECT_NEAR(rms("uniform:filter=lanczos2,spp=1024,points=random", 24) /
                  rms("splat:filter=lanczos2,spp=1024,points=random", 24),
              4, .4);
}

TEST(FilteredNoise, OfAConstantUnderSignedImportanceSampling) {
  const RampSource flat(kSide, kSide, {2, .5f, 0}, {0, 0, 0}, {0, 0, 0});
  for (const size_t i : {4u, 5u, 6u}) {
    const ReconstructionFilter f = filter_of(i);
    const RenderResult result = render(with("importance", i, "spp=16,points=random"), flat);
    double sum = 0, squares = 0;
    for (size_t p = 0; p < result.film.pixels(); ++p) {
      sum += result.mean(p)[0] - 2;
      squares += std::pow(result.mean(p)[0] - 2, 2);
      ASSERT_NEAR(result.mean(p)[1], result.mean(p)[0] / 4, 1e-6);
      ASSERT_EQ(result.mean(p)[2], 0);
    }
    const auto n = static_cast<double>(result.film.pixels());
    const double deviation = 2 * std::sqrt((f.importance_gain() - 1) / 16);
    EXPECT_NEAR(std::sqrt(squares / n) / deviation, 1, .04) << f.name();  // one deviation is .7%
    EXPECT_LT(std::abs(sum / n), 4 * deviation / std::sqrt(n)) << f.name();
  }
}

TEST(FilteredNoise, OfImportanceSamplingIsEstimatedAsItIs) {
  for (const char* filter : {"gaussian", "lanczos3"}) {
    const auto source = test::noise(kSide, kSide, 1, 1);
    RenderOptions options;
    options.planes.error = true;
    const auto strategy = make_strategy(std::string("importance:points=random,spp=64,filter=") + filter, "");
    const RenderResult result = strategy->render(source, options);
    double squares = 0;
    for (size_t p = 0; p < result.film.pixels(); ++p)
      for (const double v : result.mean(p))
        squares += (v - 1) * (v - 1) / 3 / static_cast<double>(result.film.pixels());
    EXPECT_NEAR(result.passes.back().rmse / std::sqrt(squares), 1, .03) << filter;
  }
}

TEST(FilteredEdge, AllThreeWaysConvergeToTheFilteredEdge) {
  constexpr int kEdgeSide = 24;
  constexpr double kAcross = .6, kDown = .8, kFrom = 16.3;
  const HalfPlaneSource edge(kEdgeSide, kEdgeSide, kAcross, kDown, kFrom, {1, 1, 1}, {0, 0, 0});
  const double inside = edge.integral(0, 0, 1e-9, 1e-9).value()[0];  // 1 if the first colour is at the origin
  for (const size_t i : {1u, 3u, 4u, 5u}) {
    const ReconstructionFilter f = filter_of(i);
    const SlowEdge slow(f);
    for (const auto& [strategy, more, tolerance] : {std::tuple{"splat", "spp=512", 1e-3},
                                                    {"importance", "spp=2048", 3e-3},
                                                    {"uniform", "spp=2048", 6e-3},
                                                    {"uniform", "spp=2048,divide=integral", 6e-3}}) {
      const RenderResult result = render(with(strategy, i, more), edge);
      double bias = 0, squares = 0;
      for (int y = 0; y < kEdgeSide; ++y)
        for (int x = 0; x < kEdgeSide; ++x) {
          const double share = slow(kAcross, kDown, kFrom - kAcross * (x + .5) - kDown * (y + .5));
          const double off = result.mean(result.film.pixel(x, y))[0] - (inside * share + (1 - inside) * (1 - share));
          bias += off / (kEdgeSide * kEdgeSide);
          squares += off * off / (kEdgeSide * kEdgeSide);
        }
      EXPECT_LT(std::sqrt(squares), tolerance) << f.name() << " " << strategy << more;
      EXPECT_LT(std::abs(bias), tolerance / 8) << f.name() << " " << strategy << more;
    }
  }
}

TEST(PlainSamplers, EdgeErrorFallsAsItShould) {
  const HalfPlaneSource edge(48, 48, .6, .8, 33.3, {1, 1, 1}, {0, 0, 0});
  const auto rmse = [&](const std::string& text) {
    double squares = 0;
    for (uint64_t seed = 0; seed < 8; ++seed) {
      const RenderResult result = render(text, edge, seed);
      for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 48; ++x)
          squares += std::pow(result.mean(result.film.pixel(x, y))[0] - (*edge.integral(x, y, x + 1, y + 1))[0], 2);
    }
    return std::sqrt(squares / (8 * 48 * 48));
  };
  // Over a factor of 64 in samples.
  EXPECT_NEAR(std::log2(rmse("random:spp=1024") / rmse("random:spp=16")) / 6, -.5, .03);
  EXPECT_NEAR(std::log2(rmse("jitter:n=32") / rmse("jitter:n=4")) / 6, -.75, .03);
}
