// SPDX-License-Identifier: Apache-2.0
// POV-Ray's methods against their descriptions, sample by sample, and what their descriptions imply.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <mutex>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/strategy.hpp>

#include "pov_reference.hpp"
#include "sampling_sources.hpp"

using namespace triad;
using test::FunctionSource;
using test::grey;
using test::pov::Settings;
using testing::HasSubstr;

namespace {

constexpr Rgb kBlack{0, 0, 0}, kWhite{1, 1, 1};

RenderResult render(const std::string& strategy, const Source& source, const RenderOptions& options = {}) {
  return make_strategy(strategy, "--strategy")->render(source, options);
}

RenderOptions with_reasons() {
  RenderOptions options;
  options.planes.reasons = true;
  return options;
}

std::vector<std::array<double, 3>> colours(const RenderResult& result) {
  std::vector<std::array<double, 3>> all;
  for (size_t p = 0; p < result.film.pixels(); ++p) all.push_back(result.mean(p));
  return all;
}

std::vector<uint32_t> counts(const RenderResult& result) {
  std::vector<uint32_t> all;
  for (size_t p = 0; p < result.film.pixels(); ++p) all.push_back(result.film.count(p));
  return all;
}

// A number that depends on the place only, in [0, 1).
float hash(double x, double y, uint32_t what) {
  return SampleRandom(static_cast<int32_t>(x * 65536), static_cast<int32_t>(y * 65536), what, 7).uniform(20);
}

// Soft blobs, hard edges and specks; in places nothing, or no colour but an infinity.
FunctionSource difficult(int width, int height, double lost) {
  return FunctionSource(width, height, [=](const SampleRequest& r) {
    Sample sample;
    const double wave = .5 + .5 * std::sin(r.x * 1.3) * std::cos(r.y * .9 + r.x * .2);
    const bool edge = .3 * r.x + .8 * r.y < 6.3, line = std::abs(.9 * r.x - .35 * r.y - 3.1) < .14;
    sample.rgb = {static_cast<float>(line ? 1 : wave * wave), edge ? .8f : .1f,
                  hash(r.x, r.y, 0) < .03f ? 2.f : -.05f};
    if (hash(r.x, r.y, 1) < lost) sample.valid = false;
    if (hash(r.x, r.y, 2) < lost / 4) sample.rgb[1] = std::numeric_limits<float>::infinity();
    return sample;
  });
}
// The same with what is not finite said to be not valid, as references know no better.
FunctionSource said(const Source& source) {
  return FunctionSource(source.width(), source.height(), [&](const SampleRequest& r) {
    Sample sample;
    source.eval({&r, 1}, {&sample, 1});
    sample.valid &= std::isfinite(sample.rgb[1]);
    return sample;
  });
}

struct Case {
  std::string strategy;
  Settings settings;
};

std::vector<Case> lattice_cases() {
  std::vector<Case> cases;
  for (const int method : {2, 3, 4, 5})
    for (const int depth : {0, 1, 2, 4})
      for (const double threshold : {0., .15, .3, 1.})
        for (const bool scanline : {false, true}) {
          if ((method < 4 && scanline) || (threshold == 0 && depth == 4)) continue;
          Settings s;
          s.depth = depth;
          s.threshold = threshold;
          s.gamma = depth == 2 ? 1 : 2.5;
          s.by_area = method > 2;
          s.along_lines = method > 3;
          s.with_centre = method > 4;
          s.scanline = scanline;
          cases.push_back({fmt::format("pov{}:depth={},threshold={},gamma={}{}", method, depth, threshold, s.gamma,
                                       method < 4 ? ""
                                       : scanline ? ",order=scanline"
                                                  : ",order=fixpoint"),
                           s});
        }
  return cases;
}

void expect_picture(const RenderResult& result, const test::pov::Picture& expected, const std::string& what) {
  EXPECT_EQ(result.samples, expected.samples) << what;
  EXPECT_EQ(counts(result), expected.count) << what;
  for (size_t p = 0; p < expected.colour.size(); ++p)
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(result.mean(p)[c], expected.colour[p][c], 1e-13) << what << " pixel " << p;
}

}  // namespace

TEST(Pov, LatticesAreDividedAsDescribed) {
  const auto whole = difficult(9, 7, 0), holes = difficult(8, 5, .1), row = difficult(11, 1, .02),
             tall = difficult(2, 37, .02);
  const DiscSource disc(7, 9, 3.3, 4.1, 2.7, {1, .5f, 0}, {.1f, .2f, .4f});
  int number = 0;
  for (const Source* source :
       {static_cast<const Source*>(&whole), static_cast<const Source*>(&holes), static_cast<const Source*>(&row),
        static_cast<const Source*>(&tall), static_cast<const Source*>(&disc)}) {
    const auto finite = said(*source);
    for (const Case& each : lattice_cases())
      expect_picture(render(each.strategy, *source), test::pov::Tree(finite, each.settings).render(),
                     fmt::format("source {} {}", number, each.strategy));
    ++number;
  }
}

TEST(Pov, Method1IsReadingOrderBitForBit) {
  const auto whole = difficult(23, 17, 0), holes = difficult(16, 19, .1), row = difficult(31, 1, .02),
             column = difficult(1, 31, .02);
  for (const Source* source : {static_cast<const Source*>(&whole), static_cast<const Source*>(&holes),
                               static_cast<const Source*>(&row), static_cast<const Source*>(&column)})
    for (const int n : {1, 2, 3, 5})
      for (const double threshold : {0., .1, .3, .6, 1.2}) {
        Settings settings;
        settings.n = n;
        settings.threshold = threshold;
        const auto expected = test::pov::pov1(said(*source), settings);
        const RenderResult result = render(fmt::format("pov1:n={},threshold={}", n, threshold), *source);
        EXPECT_EQ(result.samples, expected.samples);
        EXPECT_EQ(counts(result), expected.count);
        // The reference's plain sums of a few floats are exact.
        EXPECT_EQ(colours(result), expected.colour) << n << " " << threshold;
      }
}

TEST(Pov, StochasticIsRoundsAsDescribed) {
  const auto source = difficult(12, 9, .1);
  const auto finite = said(source);
  const struct {
    double threshold, confidence, z;  // the normal distribution's published quantiles
    uint32_t spp;
  } cases[] = {{.3, .9, 1.6448536269514722, 64},
               {.1, .5, .6744897501960817, 20},
               {.5, .99, 2.5758293035489004, 64},
               {.3, 0, 0, 16},
               {0, .9, 1.6448536269514722, 7}};
  for (const auto& [threshold, confidence, z, spp] : cases) {
    std::vector<std::vector<test::pov::Colour>> taken(12 * 9);
    for (std::vector<bool> more(taken.size(), true); std::count(more.begin(), more.end(), true) > 0;) {
      for (size_t p = 0; p < taken.size(); ++p) {
        if (!more[p]) continue;
        const int x = static_cast<int>(p % 12), y = static_cast<int>(p / 12);
        const SampleRandom random(x, y, static_cast<uint32_t>(taken[p].size()), 5);
        taken[p].push_back(test::pov::ask(finite, x + double{random.uniform(0)}, y + double{random.uniform(1)}));
      }
      for (size_t p = 0; p < taken.size(); ++p) {
        const int x = static_cast<int>(p % 12), y = static_cast<int>(p / 12);
        double sum[3] = {}, squares[3] = {}, n = 0;
        for (const auto& [u, v] : {std::pair{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
          if (x + u < 0 || x + u >= 12 || y + v < 0 || y + v >= 9) continue;
          for (const auto& colour : taken[static_cast<size_t>((y + v) * 12 + x + u)]) {
            if (!colour.known) continue;
            ++n;
            const auto value = test::pov::encoded(colour, 2.5);
            for (int c = 0; c < 3; ++c) sum[c] += value[c], squares[c] += double{value[c]} * value[c];
          }
        }
        double error = 0;
        for (int c = 0; c < 3; ++c) {
          const double variance = std::max(0., (squares[c] - sum[c] * sum[c] / n) / (n - 1));
          // So near, rounding may decide.
          error += variance < 1e-12 ? 0 : z * std::sqrt(variance / n);
        }
        more[p] = taken[p].size() < spp && (n < 2 || error > threshold);
      }
    }
    RenderOptions options;
    options.seed = 5;
    const RenderResult result = render(
        fmt::format("pov-stochastic:threshold={},confidence={},spp={}", threshold, confidence, spp), source, options);
    uint64_t all = 0;
    for (size_t p = 0; p < taken.size(); ++p) {
      uint32_t known = 0;
      for (const auto& colour : taken[p]) known += colour.known;
      all += taken[p].size();
      ASSERT_EQ(result.film.count(p), known) << threshold << " " << confidence << " pixel " << p;
    }
    EXPECT_EQ(result.samples, all);
    if (confidence > 0) {
      EXPECT_GT(all, taken.size()) << "a case in which nothing goes on tests nothing";
    }
  }
}

TEST(Pov, ConstantsTakeTheLeastAndStayWhatTheyAre) {
  const int w = 37, h = 23;
  const RampSource flat(w, h, {.2f, .5f, .75f}, kBlack, kBlack);
  const uint64_t pixels = uint64_t{w} * h, corners = uint64_t{w + 1} * (h + 1);
  for (const auto& [text, samples] : {std::pair{"pov1", pixels},
                                      {"pov2", corners},
                                      {"pov2:depth=0", corners},
                                      {"pov3", corners},
                                      {"pov4", corners},
                                      {"pov4:order=scanline", corners},
                                      {"pov5", corners + pixels},
                                      {"pov5:depth=0", corners + pixels},
                                      {"pov5:order=scanline", corners + pixels},
                                      {"pov-stochastic", pixels}}) {
    const CountingSource counted(flat);
    const RenderResult result = render(text, counted, with_reasons());
    EXPECT_EQ(result.samples, samples) << text;
    EXPECT_EQ(counted.samples(), samples) << text;
    EXPECT_THAT(colours(result), testing::Each(std::array<double, 3>{.2f, .5, .75})) << text;
    if (!result.reasons.empty()) {
      EXPECT_THAT(result.reasons[0], testing::Each(0.f)) << text;
    }
  }
}

TEST(Pov, ThresholdZeroTakesAllThereIs) {
  const RampSource flat(5, 4, kWhite, kBlack, kBlack);
  for (const char* method : {"pov2", "pov3", "pov4", "pov5", "pov4:order=scanline,"})
    for (const int depth : {1, 2, 3}) {
      const std::string text =
          fmt::format("{}{}depth={},threshold=0", method, std::strchr(method, ':') ? "" : ":", depth);
      const uint64_t side = uint64_t{1} << depth;
      EXPECT_EQ(render(text, flat).samples, (5 * side + 1) * (4 * side + 1)) << text;
      EXPECT_EQ(make_strategy(text, "")->most_samples(5, 4), (5 * side + 1) * (4 * side + 1)) << text;
    }
  EXPECT_EQ(render("pov1:n=4,threshold=0", flat).samples, 20u * 17);
  EXPECT_EQ(make_strategy("pov1:n=4", "")->most_samples(5, 4), 20u * 17);
  EXPECT_EQ(make_strategy("pov5:depth=0", "")->most_samples(5, 4), 30u + 20);
  const auto noisy = test::noise(5, 4, .5, .5);
  EXPECT_EQ(render("pov-stochastic:threshold=0,spp=9", noisy).samples, 20u * 9);
  EXPECT_EQ(make_strategy("pov-stochastic:spp=9", "")->most_samples(5, 4), 20u * 9);
}

TEST(Pov, CountsAtAnEdgeAcrossOnePixel) {
  const HalfPlaneSource edge(1, 1, 0, 1, .3, kWhite, kBlack);
  const uint64_t expected[] = {4, 9, 18, 35, 68, 133};
  for (int depth = 0; depth < 6; ++depth) {
    const RenderResult result = render(fmt::format("pov2:depth={}", depth), edge, with_reasons());
    EXPECT_EQ(result.samples, expected[depth]) << depth;
    EXPECT_EQ(result.reasons[0][0], static_cast<float>(depth));
    EXPECT_EQ(result.reasons[1][0], static_cast<float>(expected[depth]));
  }
  // The contrast in thresholds.
  for (const auto& [contrast, samples] :
       {std::pair{.99, 4u}, {1.01, 9u}, {1.99, 9u}, {2.01, 18u}, {3.99, 18u}, {4.01, 35u}, {100., 35u}}) {
    const auto grey_level = static_cast<float>(contrast * .3 / 3);
    const HalfPlaneSource faint(1, 1, 0, 1, .3, {grey_level, grey_level, grey_level}, kBlack);
    EXPECT_EQ(render("pov3:gamma=1", faint).samples, samples) << contrast;
    EXPECT_EQ(render("pov2:gamma=1", faint).samples, contrast < 1 ? 4u : 35u) << contrast;
  }
}

TEST(Pov, Method3NeverTakesMoreThanMethod2) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    const FunctionSource source(13, 11, [=](const SampleRequest& r) {
      const double size = 1 + seed % 5;
      return grey(std::pow(hash(std::floor(r.x * size) / size, std::floor(r.y * size * 1.3), seed), 1 + seed % 3));
    });
    for (const char* settings : {"depth=3", "depth=4,threshold=.6", "depth=2,threshold=.1,gamma=1"}) {
      const uint64_t two = render(std::string("pov2:") + settings, source).samples;
      EXPECT_LE(render(std::string("pov3:") + settings, source).samples, two) << seed << " " << settings;
    }
  }
}

TEST(Pov, OnlyOrderlessMethodsCommuteWithFlips) {
  constexpr int kWidth = 19, kHeight = 13;
  const auto flipped_case = [&](const std::string& strategy, bool across, bool down) {
    const auto picture = difficult(kWidth, kHeight, .02);
    const FunctionSource mirrored(kWidth, kHeight, [&](SampleRequest r) {
      if (across) r.x = kWidth - r.x;
      if (down) r.y = kHeight - r.y;
      Sample sample;
      picture.eval({&r, 1}, {&sample, 1});
      return sample;
    });
    const auto plain = colours(render(strategy, picture)), other = colours(render(strategy, mirrored));
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const int u = across ? kWidth - 1 - x : x, v = down ? kHeight - 1 - y : y;
        if (plain[static_cast<size_t>(y * kWidth + x)] != other[static_cast<size_t>(v * kWidth + u)]) return false;
      }
    return true;
  };
  for (const auto& [across, down] : {std::pair{true, false}, {false, true}, {true, true}}) {
    for (const char* strategy : {"pov2", "pov3", "pov4", "pov5"})
      EXPECT_TRUE(flipped_case(strategy, across, down)) << strategy << across << down;
    for (const char* strategy : {"pov1", "pov4:order=scanline"})
      EXPECT_FALSE(flipped_case(strategy, across, down)) << strategy << across << down;
  }
}

TEST(Pov, NoSampleIsTakenTwice) {
  for (const char* strategy : {"pov1:n=2", "pov2", "pov4", "pov4:order=scanline", "pov5", "pov-stochastic"}) {
    std::set<std::pair<double, double>> places;
    std::set<std::tuple<int, int, uint32_t>> keys;
    std::mutex mutex;
    const auto picture = difficult(14, 37, .02);
    const FunctionSource source(14, 37, [&](const SampleRequest& r) {
      const std::lock_guard lock(mutex);
      EXPECT_TRUE(places.insert({r.x, r.y}).second) << strategy << " " << r.x << " " << r.y;
      EXPECT_TRUE(keys.insert({r.pixel_x, r.pixel_y, r.index}).second) << strategy;
      EXPECT_TRUE(r.pixel_x >= 0 && r.pixel_x < 14 && r.pixel_y >= 0 && r.pixel_y < 37);
      EXPECT_TRUE(r.x >= r.pixel_x && r.x <= r.pixel_x + 1 && r.y >= r.pixel_y && r.y <= r.pixel_y + 1);
      EXPECT_TRUE(r.footprint_px <= 1 && r.footprint_px >= .125f);
      Sample sample;
      picture.eval({&r, 1}, {&sample, 1});
      return sample;
    });
    const uint64_t samples = render(strategy, source).samples;
    EXPECT_EQ(samples, places.size()) << strategy;
  }
}

TEST(Pov, SameBitsForAnyThreadsAndTiles) {
  const auto source = difficult(131, 67, .02);
  for (const char* strategy :
       {"pov1", "pov2:depth=2", "pov3", "pov4", "pov4:order=scanline", "pov5", "pov-stochastic:threshold=.1"}) {
    std::vector<std::array<double, 3>> first;
    std::vector<std::vector<float>> reasons;
    std::vector<uint32_t> taken;
    for (const int threads : {1, 2, 7}) {
      set_thread_limit(threads);
      RenderOptions options = with_reasons();
      options.tile_px = 8 << threads % 3;
      const RenderResult result = render(strategy, source, options);
      if (first.empty()) first = colours(result), reasons = result.reasons, taken = counts(result);
      EXPECT_EQ(std::memcmp(first.data(), colours(result).data(), first.size() * sizeof(first[0])), 0) << strategy;
      EXPECT_EQ(result.reasons, reasons) << strategy;
      EXPECT_EQ(counts(result), taken) << strategy;
    }
  }
  set_thread_limit(0);
}

TEST(Pov, WhatIsNeverKnownIsBlackAndItsNeighboursAreNot) {
  const FunctionSource source(6, 5, [](const SampleRequest& r) {
    Sample sample = grey(.5);
    sample.valid = !(r.x >= 2 && r.x <= 3 && r.y >= 1 && r.y <= 2);
    return sample;
  });
  for (const char* strategy : {"pov1", "pov2", "pov3", "pov4", "pov5", "pov4:order=scanline", "pov-stochastic"}) {
    const RenderResult result = render(strategy, source);
    EXPECT_GT(result.dropped, 0u) << strategy;
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x)
        EXPECT_EQ(result.mean(result.film.pixel(x, y))[0], x == 2 && y == 1 ? 0 : .5) << strategy << x << "," << y;
  }
}

TEST(Pov, ReasonsSayWhoFoundIt) {
  // The centre of column 2 is dark, and differs from column 1; with its samples it is grey, and column 3 differs.
  const HalfPlaneSource edge(4, 1, 1, 0, 2.4, kWhite, kBlack);
  const RenderResult result = render("pov1", edge, with_reasons());
  EXPECT_EQ(result.reasons.at(0), (std::vector<float>{0, 2, 1, 1}));
  EXPECT_EQ(make_strategy("pov1", "")->reason_channels(), (std::vector<std::string>{"reason.supersampled"}));
  EXPECT_EQ(result.image({"reason.supersampled"}).pixels[1 * 4 + 3], 2);
}

TEST(Pov, EndedEarlyThePictureIsWhatThereIs) {
  const auto source = difficult(64, 64, 0);
  // The first look at all of it takes 16 batches, 17 with corners, and 33 with centres and corners.
  for (const auto& [strategy, batches] : {std::pair{"pov1", 20},
                                          {"pov2", 20},
                                          {"pov4", 20},
                                          {"pov4:order=scanline", 20},
                                          {"pov5", 36},
                                          {"pov-stochastic", 20}}) {
    set_thread_limit(1);
    RenderOptions options;
    double last = 0;
    bool falls = false;
    options.progress = [&](double done) { falls = falls || done < last, last = done; };
    const RenderResult whole = render(strategy, source, options);
    EXPECT_FALSE(falls) << strategy;
    EXPECT_EQ(last, 1) << strategy;
    uint64_t in_passes = 0;
    for (const PassRecord& pass : whole.passes) in_passes += pass.samples;
    EXPECT_EQ(in_passes, whole.samples) << strategy;
    int asked = 0;
    options.stop = [&, most = batches] { return ++asked > most; };
    const RenderResult part = render(strategy, source, options);
    set_thread_limit(0);
    EXPECT_FALSE(part.complete) << strategy;
    EXPECT_LT(part.samples, whole.samples) << strategy;
    for (size_t p = 0; p < part.film.pixels(); ++p) EXPECT_GT(part.mean(p)[0] + part.mean(p)[1], 0) << strategy;
  }
}

TEST(Pov, NamesWhatIsWrongWithItsText) {
  const auto refusal = [](const std::string& strategy) -> std::string {
    try {
      make_strategy(strategy, "--strategy");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal("pov4:order=random"), HasSubstr("it must be one of fixpoint, scanline"));
  EXPECT_THAT(refusal("pov2:order=scanline"), HasSubstr("has no parameter 'order'"));
  EXPECT_THAT(refusal("pov2:depth=9"), HasSubstr("a whole number, 0 to 8"));
  EXPECT_THAT(refusal("pov1:gamma=0"), HasSubstr("a number, 0.1 to 10"));
  EXPECT_THAT(refusal("pov-stochastic:confidence=1"), HasSubstr("pov-stochastic:confidence='1' cannot be used"));
  EXPECT_EQ(make_strategy("pov4:order=scanline", "")->text(), "pov4:depth=3,threshold=0.3,gamma=2.5,order=scanline");
  EXPECT_EQ(make_strategy("pov1", "")->text(), "pov1:n=3,threshold=0.3,gamma=2.5");
}
