// SPDX-License-Identifier: Apache-2.0
// Strategies with reconstruction filters against slow sums over every sample that they asked for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <mutex>
#include <set>
#include <triad/base/parallel.hpp>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/pixel_points.hpp>
#include <triad/sampling/reconstruction.hpp>
#include <triad/sampling/strategy.hpp>

#include "sampling_sources.hpp"

using namespace triad;
using test::FunctionSource;
using testing::HasSubstr;

namespace {

constexpr int kWidth = 9, kHeight = 7;

struct Asked {
  SampleRequest request;
  Sample sample;
};

// What a strategy asked for, and what it made of it.
struct Recorded {
  std::vector<Asked> asked;
  RenderResult result;
};

// Of noise with some samples not valid; the share of these that are.
Recorded record(const std::string& strategy, double valid_share, uint64_t seed) {
  std::vector<Asked> asked;
  std::mutex mutex;
  const FunctionSource source(kWidth, kHeight, [&](const SampleRequest& r) {
    const SampleRandom random(r.pixel_x, r.pixel_y, r.index, r.seed);
    Sample sample;
    for (uint32_t c = 0; c < 3; ++c) sample.rgb[c] = random.uniform(40 + c);
    sample.valid = random.uniform(50) < valid_share;
    if (sample.valid && random.uniform(51) < .02f) sample.rgb[1] = NAN;
    const std::lock_guard lock(mutex);
    asked.push_back({r, sample});
    return sample;
  });
  RenderOptions options;
  options.seed = seed;
  RenderResult result = make_strategy(strategy, "--strategy")->render(source, options);
  return {std::move(asked), std::move(result)};
}

bool counts(const Sample& s) { return s.valid && std::isfinite(s.rgb[1]); }

// A pixel as the weighted mean of the samples that `mine` chooses, or the nearest of them where the weights cancel.
struct SlowPixel {
  std::array<double, 3> colour{};
  bool cancelled = false, empty = false;
};
template <class Mine>
SlowPixel slow_pixel(const std::vector<Asked>& asked, const ReconstructionFilter& f, int x, int y, const Mine& mine) {
  SlowPixel pixel;
  double weight = 0, absolute = 0, nearest = HUGE_VAL;
  std::array<float, 3> nearest_rgb{};
  for (const auto& [r, sample] : asked) {
    const double dx = r.x - x - .5, dy = r.y - y - .5;
    if (!counts(sample) || !mine(r) || std::max(std::abs(dx), std::abs(dy)) > f.radius_px()) continue;
    const double w = f.value(dx) * f.value(dy);
    weight += w;
    absolute += std::abs(w);
    for (size_t c = 0; c < 3; ++c) pixel.colour[c] += w * sample.rgb[c];
    if (std::hypot(dx, dy) < nearest) nearest = std::hypot(dx, dy), nearest_rgb = sample.rgb;
  }
  pixel.empty = absolute == 0;
  pixel.cancelled = f.is_signed() && std::abs(weight) <= absolute / 16;
  for (size_t c = 0; c < 3; ++c)
    pixel.colour[c] = pixel.cancelled ? nearest_rgb[c] : weight != 0 ? pixel.colour[c] / weight : 0;
  return pixel;
}

std::string with(const std::string& strategy, size_t filter, const std::string& more) {
  return strategy + ":filter=" + reconstruction_names()[filter] + "," + more;
}
ReconstructionFilter filter_of(size_t i, double scale = 1) {
  return ReconstructionFilter(static_cast<ReconstructionKernel>(i), scale);
}

}  // namespace

TEST(Splat, IsTheWeightedMeanOfAllSamplesUnderTheFilter) {
  int cancelled = 0, empty = 0;
  for (size_t filter = 0; filter < reconstruction_names().size(); ++filter)
    for (const auto& [more, scale, valid] : {std::tuple{"spp=20", 1., .8},
                                             {"spp=1,points=random", 1., 1.},
                                             {"spp=2,points=random,scale=1.3", 1.3, .15},
                                             {"spp=3,points=jitter,scale=.5", .5, 1.}})
      for (uint64_t seed = 0; seed < 4; ++seed) {
        const ReconstructionFilter f = filter_of(filter, scale);
        const Recorded got = record(with("splat", filter, more), valid, seed);
        for (int y = 0; y < kHeight; ++y)
          for (int x = 0; x < kWidth; ++x) {
            SlowPixel slow = slow_pixel(got.asked, f, x, y, [](const SampleRequest&) { return true; });
            if (slow.empty) slow.colour = got.result.film.mean(got.result.film.pixel(x, y)), ++empty;
            cancelled += slow.cancelled;
            // Weights are exact to 4e-7; where they nearly cancel, that counts up to 16 times.
            const auto colour = got.result.mean(got.result.film.pixel(x, y));
            for (size_t c = 0; c < 3; ++c)
              ASSERT_NEAR(colour[c], slow.colour[c], f.is_signed() ? 1e-4 : 2e-6)
                  << f.name() << more << x << "," << y;
          }
      }
  EXPECT_GT(empty, 5) << "a narrow filter met samples everywhere";
  EXPECT_GT(cancelled, 20) << "the nearest sample was not needed, and not tested";
}

TEST(Splat, AsksForThePixelsBeyondTheBorderThatItsFilterReaches) {
  constexpr int kBorder[] = {0, 2, 1, 1, 2, 2, 3, 2};
  for (size_t filter = 0; filter < reconstruction_names().size(); ++filter) {
    const std::string text = with("splat", filter, "spp=5");
    const RampSource flat(kWidth, kHeight, {.3f, 0, 7}, {0, 0, 0}, {0, 0, 0});
    const CountingSource counted(flat);
    const RenderResult result = make_strategy(text, "")->render(counted, {});
    const auto expected = static_cast<uint64_t>(5 * (kWidth + 2 * kBorder[filter]) * (kHeight + 2 * kBorder[filter]));
    EXPECT_EQ(counted.samples(), expected) << text;
    EXPECT_EQ(result.samples, expected);
    EXPECT_EQ(make_strategy(text, "")->most_samples(kWidth, kHeight), expected);
    for (size_t p = 0; p < result.film.pixels(); ++p) {
      EXPECT_EQ(result.film.count(p), 5u);
      EXPECT_NEAR(result.mean(p)[0], static_cast<double>(.3f), 1e-14);
      EXPECT_NEAR(result.mean(p)[2], 7, 1e-13);
    }
  }
}

TEST(Uniform, IsTheWeightedMeanOfAPixelsOwnSamples) {
  int cancelled = 0;
  for (size_t filter = 0; filter < reconstruction_names().size(); ++filter)
    for (const auto& [more, scale, valid] :
         {std::tuple{"spp=20", 1., .8}, {"spp=4,points=random,scale=1.3", 1.3, 1.}, {"spp=6,points=jitter", 1., .2}})
      for (uint64_t seed = 0; seed < 3; ++seed) {
        const ReconstructionFilter f = filter_of(filter, scale);
        const Recorded got = record(with("uniform", filter, more), valid, seed);
        for (int y = 0; y < kHeight; ++y)
          for (int x = 0; x < kWidth; ++x) {
            const SlowPixel slow = slow_pixel(
                got.asked, f, x, y, [&](const SampleRequest& r) { return r.pixel_x == x && r.pixel_y == y; });
            cancelled += slow.cancelled;
            const auto colour = got.result.mean(got.result.film.pixel(x, y));
            for (size_t c = 0; c < 3; ++c)
              ASSERT_NEAR(colour[c], slow.colour[c], f.is_signed() ? 1e-5 : 1e-6) << f.name() << more;
          }
      }
  EXPECT_GT(cancelled, 5);
}

TEST(Uniform, DividedByTheIntegralIsThePlainEstimate) {
  for (const size_t filter : {1u, 3u, 5u}) {
    const ReconstructionFilter f = filter_of(filter);
    const Recorded got = record(with("uniform", filter, "spp=12,divide=integral"), 1, 3);
    std::vector<std::array<double, 3>> sums(got.result.film.pixels());
    for (const auto& [r, sample] : got.asked)
      for (size_t c = 0; c < 3 && counts(sample); ++c)
        sums[got.result.film.pixel(r.pixel_x, r.pixel_y)][c] +=
            f.value(r.x - r.pixel_x - .5) * f.value(r.y - r.pixel_y - .5) * sample.rgb[c];
    const double area = std::pow(2 * f.radius_px() / f.integral(), 2);
    for (size_t p = 0; p < sums.size(); ++p)
      for (size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(got.result.mean(p)[c], area * sums[p][c] / got.result.film.count(p), 1e-5) << f.name();
  }
}

TEST(Importance, IsTheMeanWithTheFiltersSigns) {
  for (size_t filter = 0; filter < reconstruction_names().size(); ++filter) {
    const ReconstructionFilter f = filter_of(filter, .75);
    const Recorded got = record(with("importance", filter, "spp=12,scale=.75"), .9, 3);
    const double ratio = f.absolute_integral() / f.integral();
    std::vector<std::array<double, 3>> sums(got.result.film.pixels());
    for (const auto& [r, sample] : got.asked) {
      const double dx = r.x - r.pixel_x - .5, dy = r.y - r.pixel_y - .5;
      EXPECT_LE(std::max(std::abs(dx), std::abs(dy)), f.radius_px());
      const double sign = f.value(dx) * f.value(dy) < 0 ? -1 : 1;
      for (size_t c = 0; c < 3 && counts(sample); ++c)
        sums[got.result.film.pixel(r.pixel_x, r.pixel_y)][c] += sign * ratio * ratio * sample.rgb[c];
    }
    for (size_t p = 0; p < sums.size(); ++p)
      for (size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(got.result.mean(p)[c], sums[p][c] / got.result.film.count(p), 1e-6) << f.name();
  }
}

TEST(Importance, UnderABoxIsTheSamplersOwnPicture) {
  const RampSource ramp(kWidth, kHeight, {.5f, 0, 1}, {.25f, -.5f, .125f}, {.125f, 1, -.25f});
  for (const auto& [plain, filtered] : {std::pair{"sobol-owen:spp=6", "importance:filter=box,spp=6"},
                                        {"random:spp=6", "importance:filter=box,spp=6,points=random"},
                                        {"jitter:n=3", "importance:filter=box,spp=9,points=jitter"},
                                        {"random:spp=6", "uniform:filter=box,spp=6,points=random"},
                                        {"jitter:n=3", "splat:filter=box,spp=9,points=jitter"}}) {
    const RenderResult a = make_strategy(plain, "")->render(ramp, {}),
                       b = make_strategy(filtered, "")->render(ramp, {});
    for (size_t p = 0; p < a.film.pixels(); ++p)
      for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(a.mean(p)[c], b.mean(p)[c], 2e-6) << filtered;
  }
}

TEST(FilteredPoints, KeepAConstant) {
  const RampSource flat(kWidth, kHeight, {.3f, 0, 7}, {0, 0, 0}, {0, 0, 0});
  for (size_t filter = 0; filter < reconstruction_names().size(); ++filter)
    for (const char* strategy : {"uniform", "importance"}) {
      if (filter_of(filter).is_signed() && strategy[0] == 'i') continue;
      const std::string text = with(strategy, filter, "spp=16");
      const CountingSource counted(flat);
      const RenderResult result = make_strategy(text, "")->render(counted, {});
      EXPECT_EQ(counted.samples(), static_cast<uint64_t>(16 * kWidth * kHeight)) << text;
      EXPECT_EQ(make_strategy(text, "")->most_samples(kWidth, kHeight), counted.samples());
      for (size_t p = 0; p < result.film.pixels(); ++p) {
        ASSERT_EQ(result.film.count(p), 16u);
        ASSERT_NEAR(result.mean(p)[0], static_cast<double>(.3f), 2e-6) << text;
        ASSERT_EQ(result.mean(p)[1], 0);
        ASSERT_NEAR(result.mean(p)[2], 7, 5e-5) << text;
      }
    }
}

TEST(FilteredPoints, WorkInPicturesSmallerThanTheirFilter) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 70}, {70, 1}, {2, 3}})
    for (const char* text : {"splat:filter=lanczos3,scale=8,spp=2", "uniform:filter=lanczos3,scale=8,spp=2",
                             "importance:filter=box2,scale=8,spp=2", "splat:filter=box,scale=.125,spp=2"}) {
      const RampSource flat(width, height, {2, 0, 0}, {0, 0, 0}, {0, 0, 0});
      const RenderResult result = make_strategy(text, "")->render(flat, {});
      for (size_t p = 0; p < result.film.pixels(); ++p) {
        ASSERT_EQ(result.film.count(p), 2u);
        ASSERT_NEAR(result.mean(p)[0], 2, 1e-5) << text;
      }
    }
}

TEST(FilteredPoints, EndEarlyWithTheWholePictureCovered) {
  const RampSource flat(32, 32, {1, 2, 3}, {0, 0, 0}, {0, 0, 0});
  for (const char* text : {"splat:filter=lanczos2,spp=4096", "uniform:spp=4096", "importance:spp=4096"}) {
    int asked = 0;
    RenderOptions options;
    options.stop = [&] { return ++asked > 100; };
    set_thread_limit(1);
    const RenderResult result = make_strategy(text, "")->render(flat, options);
    set_thread_limit(0);
    EXPECT_FALSE(result.complete);
    EXPECT_LT(result.samples, 110'000u) << text;  // in batches of 1024
    for (size_t p = 0; p < result.film.pixels(); ++p) ASSERT_NEAR(result.mean(p)[2], 3, 2e-6) << text;
  }
}

TEST(Splat, TakesFewerSamplesAtOnceInWidePictures) {
  const auto passes = [](int width, const char* text) {
    const RampSource flat(width, 1, {1, 2, 3}, {0, 0, 0}, {0, 0, 0});
    std::vector<uint64_t> samples;
    for (const PassRecord& pass : make_strategy(text, "")->render(flat, {}).passes) samples.push_back(pass.samples);
    return samples;
  };
  using testing::ElementsAre;
  EXPECT_THAT(passes(100, "splat:spp=4,filter=gaussian"), ElementsAre(102 * 3, 102 * 3 * 3));
  // Three rows of a million pixels have room for one sample a pixel only, within 2^22.
  EXPECT_THAT(passes(1'000'000, "splat:spp=3,filter=gaussian"), ElementsAre(3'000'006, 3'000'006, 3'000'006));
}

TEST(FilteredPoints, EstimateErrorsWhereHalvesOfThemMeanSomething) {
  const auto estimates = [](const char* text) { return make_strategy(text, "")->estimates_error(); };
  EXPECT_TRUE(estimates("random"));
  EXPECT_TRUE(estimates("importance"));
  EXPECT_TRUE(estimates("importance:filter=lanczos2,points=random"));
  EXPECT_TRUE(estimates("uniform:divide=integral"));
  for (const char* text : {"jitter", "control:spp=16", "importance:points=jitter", "uniform", "splat"})
    EXPECT_FALSE(estimates(text)) << text;
  EXPECT_EQ(make_strategy("splat", "")->text(), "splat:filter=gaussian,spp=16,points=sobol,scale=1");
}

TEST(PixelPoints, JitterPutsOneIntoEachCell) {
  for (const auto& [spp, nx, ny] : {std::tuple{1, 1, 1}, {12, 3, 4}, {16, 4, 4}, {7, 1, 7}, {1024, 32, 32}}) {
    std::vector<SampleRequest> requests;
    for (int i = 0; i < spp; ++i) requests.push_back({0, 0, 1, -3, 11, static_cast<uint32_t>(i), 5});
    PixelPoints(PixelPoints::Kind::kJitter, static_cast<uint32_t>(spp)).place(requests);
    std::set<std::pair<int, int>> cells;
    for (const SampleRequest& r : requests)
      cells.insert({static_cast<int>((r.x + 3) * nx), static_cast<int>((r.y - 11) * ny)});
    EXPECT_EQ(cells.size(), static_cast<size_t>(spp));
    EXPECT_GE(cells.begin()->first, 0);
    EXPECT_EQ(cells.rbegin()->first, nx - 1);
  }
}

TEST(Control, TakesAllItsSamplesAtTheCentre) {
  const FunctionSource source(3, 2, [](const SampleRequest& r) {
    EXPECT_EQ(r.x, r.pixel_x + .5);
    EXPECT_EQ(r.y, r.pixel_y + .5);
    EXPECT_EQ(r.footprint_px, 1);
    return test::grey(r.index);
  });
  EXPECT_EQ(make_strategy("control:spp=5", "")->render(source, {}).mean(3)[0], 2);  // of 0 1 2 3 4
}
