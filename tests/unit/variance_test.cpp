// SPDX-License-Identifier: Apache-2.0
// The adaptive strategy against an obvious one that looks at every pixel anew in every round.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/sobol.hpp>
#include <triad/sampling/strategy.hpp>

#include "sampling_sources.hpp"

using namespace triad;
using test::FunctionSource;
using test::grey;
using testing::HasSubstr;

namespace {

constexpr Rgb kBlack{0, 0, 0}, kWhite{1, 1, 1};

RenderResult render(const std::string& strategy, const Source& source, const RenderOptions& options = {}) {
  return make_strategy(strategy, "--strategy")->render(source, options);
}

std::vector<uint32_t> counts(const Film& film) {
  std::vector<uint32_t> all;
  for (size_t p = 0; p < film.pixels(); ++p) all.push_back(film.count(p));
  return all;
}

std::vector<std::array<double, 3>> means(const Film& film) {
  std::vector<std::array<double, 3>> all;
  for (size_t p = 0; p < film.pixels(); ++p) all.push_back(film.mean(p));
  return all;
}

std::string refusal(const std::string& strategy) {
  try {
    make_strategy(strategy, "--strategy");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    return error.what();
  }
  return "";
}

struct Settings {
  double threshold;
  uint32_t least, batch, spp;
  double power;
  std::string text() const {
    return fmt::format("variance:threshold={},least={},batch={},spp={},power={}", threshold, least, batch, spp,
                       power);
  }
};

// The samples that each pixel shall have taken, from the definition and from all its samples each time.
std::vector<uint32_t> expected_counts(const Source& source, const Settings& settings, uint64_t seed) {
  const int width = source.width(), height = source.height();
  const auto pixel = [&](int x, int y) { return static_cast<size_t>(y * width + x); };
  std::vector<uint32_t> taken(pixel(0, height), settings.least);
  const auto unsure = [&](int x, int y) {
    const uint32_t n = taken[pixel(x, y)];
    if (n >= settings.spp) return false;
    std::array<double, 3> all{}, part{};
    uint32_t in_part = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const auto point = sobol_owen_point(i, SampleRandom::pixel_key(x, y, seed));
      const SampleRequest request{x + point[0] * 0x1p-32, y + point[1] * 0x1p-32, 1, x, y, i, seed};
      Sample sample;
      source.eval({&request, 1}, {&sample, 1});
      in_part += sobol_half(i);
      for (int c = 0; c < 3; ++c) {
        all[c] += sample.rgb[c];
        if (sobol_half(i)) part[c] += sample.rgb[c];
      }
    }
    double apart = 0, light = 0;
    for (int c = 0; c < 3; ++c) {
      apart += std::abs(all[c] / n - part[c] / in_part);
      light += all[c] / n;
    }
    return apart / (1e-4 + std::pow(light, settings.power)) >= settings.threshold;
  };
  for (bool any = true; any;) {
    any = false;
    std::vector<char> is_unsure(taken.size());
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) is_unsure[pixel(x, y)] = unsure(x, y);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        bool near = false;
        for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
          for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u) near |= is_unsure[pixel(u, v)] != 0;
        uint32_t& n = taken[pixel(x, y)];
        if (!near || n == settings.spp) continue;
        n = std::min(settings.spp, n + (settings.batch > 0 ? settings.batch : n));
        any = true;
      }
  }
  return taken;
}

}  // namespace

TEST(Variance, TakesTheSamplesThatTheDefinitionAsksFor) {
  const DiscSource disc(21, 17, 9.3, 8.1, 5.7, {3, .5f, 0}, {.1f, .2f, .4f});
  const FunctionSource speckled(19, 13, [](const SampleRequest& r) {
    const SampleRandom random(r.pixel_x, r.pixel_y, r.index, r.seed);
    return grey(random.uniform(70) < .02f ? 5 : random.uniform(71));
  });
  const struct {
    const Source& source;
    std::vector<Settings> settings;
  } cases[] = {{disc, {{.05, 16, 4, 64, .5}, {.05, 16, 0, 100, .5}, {.2, 4, 3, 50, 0}, {.1, 8, 0, 64, 1}}},
               {speckled, {{.5, 16, 4, 64, .5}, {.4, 16, 0, 100, .5}, {1, 8, 3, 50, 0}, {.4, 8, 0, 64, 1}}}};
  for (const auto& [source, all] : cases)
    for (const Settings& settings : all) {
      RenderOptions options;
      options.seed = 11;
      const RenderResult result = render(settings.text(), source, options);
      const std::vector<uint32_t> expected = expected_counts(source, settings, options.seed);
      EXPECT_EQ(counts(result.film), expected) << settings.text();
      uint64_t sum = 0;
      for (const uint32_t n : expected) sum += n;
      EXPECT_EQ(result.samples, sum) << settings.text();
      EXPECT_GT(sum, expected.size() * settings.least) << "a case in which nothing goes on tests nothing";
      EXPECT_LT(sum, expected.size() * settings.spp) << "nor does one in which all goes on";
    }
}

TEST(Variance, ThresholdZeroIsSobolOwen) {
  const HalfPlaneSource edge(23, 17, .6, .8, 14, {2, 1, .5f}, {0, 0, .25f});
  const RenderResult uniform = render("sobol-owen:spp=60", edge);
  for (const char* rest : {"batch=4", "batch=0", "batch=7", "least=60"}) {
    const RenderResult result = render(std::string("variance:threshold=0,spp=60,") + rest, edge);
    EXPECT_EQ(result.samples, 60u * 23 * 17) << rest;
    EXPECT_EQ(counts(result.film), counts(uniform.film)) << rest;
    EXPECT_EQ(means(result.film), means(uniform.film)) << rest;
  }
  EXPECT_EQ(make_strategy("variance:spp=60", "")->most_samples(23, 17), 60u * 23 * 17);
}

TEST(Variance, QuietPicturesTakeTheLeast) {
  const auto noisy = test::noise(20, 20, 10, 10);
  EXPECT_THAT(counts(render("variance:threshold=inf,least=24", noisy).film), testing::Each(24u));
  EXPECT_EQ(means(render("variance:threshold=inf,least=24", noisy).film),
            means(render("sobol-owen:spp=24", noisy).film));
  for (const float level : {0.f, .3f, 1e6f}) {
    const RenderResult result = render("variance", RampSource(20, 20, {level, level, level}, kBlack, kBlack));
    EXPECT_THAT(counts(result.film), testing::Each(16u)) << level;
    EXPECT_THAT(means(result.film), testing::Each(std::array<double, 3>{level, level, level}));
  }
}

TEST(Variance, SamplesGatherAtAnEdge) {
  // The edge lies in column 12; columns 11 and 13 go on with it, and no others.
  const HalfPlaneSource edge(32, 24, 1, 0, 12.3, kWhite, kBlack);
  const RenderResult result = render("variance:threshold=.001,batch=0", edge);
  double at_edge = 0;
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 32; ++x) {
      const uint32_t n = result.film.count(result.film.pixel(x, y));
      if (x >= 11 && x <= 13) {
        at_edge += n / (3. * 24);
      } else {
        ASSERT_EQ(n, 16u) << x << "," << y;
      }
    }
  EXPECT_GT(at_edge, 64);
  FilmPlanes planes;
  planes.samples = true;
  RenderOptions options;
  options.planes = planes;
  const Image image = render("variance:threshold=.001,batch=0", edge, options).film.image();
  EXPECT_EQ(image.spec.channels.back(), "samples");
  for (size_t p = 0; p < result.film.pixels(); ++p) EXPECT_EQ(image.pixels[4 * p + 3], result.film.count(p));
}

TEST(Variance, SameBitsForAnyThreadsAndTiles) {
  const FunctionSource source(75, 70, [](const SampleRequest& r) {
    const SampleRandom random(r.pixel_x, r.pixel_y, r.index, r.seed);
    Sample sample = grey(r.x < 31.4 ? 1 : random.uniform(72) * random.uniform(73));
    sample.valid = random.uniform(74) < .95f;
    return sample;
  });
  std::vector<float> first;
  uint64_t samples = 0;
  for (const int threads : {1, 2, 7})
    for (const int tile : {8, 32, 64}) {
      set_thread_limit(threads);
      RenderOptions options;
      options.tile_px = tile;
      options.planes.samples = options.planes.variance = tile == 32;
      const RenderResult result = render("variance:threshold=.02,spp=80", source, options);
      std::vector<float> pixels;
      for (size_t p = 0; p < result.film.pixels(); ++p) {
        for (const double v : result.film.mean(p)) pixels.push_back(static_cast<float>(v));
        pixels.push_back(static_cast<float>(result.film.count(p)));
      }
      if (first.empty()) first = pixels, samples = result.samples;
      ASSERT_EQ(std::memcmp(first.data(), pixels.data(), first.size() * sizeof(float)), 0)
          << threads << " threads, tile " << tile;
      EXPECT_EQ(result.samples, samples);
    }
  set_thread_limit(0);
}

TEST(Variance, APixelThatIsNeverKnownIsGivenUp) {
  const FunctionSource source(8, 6, [](const SampleRequest& r) {
    Sample sample = grey(2);
    sample.valid = !(r.pixel_x == 3 && r.pixel_y == 2);
    return sample;
  });
  for (const uint32_t least : {4u, 16u}) {
    const RenderResult result = render("variance:spp=40,threshold=inf,least=" + std::to_string(least), source);
    EXPECT_EQ(result.dropped, least);
    EXPECT_EQ(result.samples, 48 * least);
    EXPECT_EQ(result.film.count(result.film.pixel(3, 2)), 0u);
  }
}

TEST(Variance, ProgressRisesToOneAndIsToldOfWhatIsLeft) {
  double last = 0;
  bool falls = false;
  RenderOptions options;
  options.progress = [&](double done) {
    falls = falls || done < last;
    last = done;
  };
  set_thread_limit(1);
  render("variance:threshold=.02", HalfPlaneSource(40, 40, .6, .8, 25, kWhite, kBlack), options);
  EXPECT_FALSE(falls);
  EXPECT_EQ(last, 1);
  // Ended early, all of it is there.
  int asked = 0;
  options.stop = [&] { return ++asked > 40; };
  const RenderResult result =
      render("variance:least=1000,spp=1000", RampSource(32, 32, kWhite, kBlack, kBlack), options);
  set_thread_limit(0);
  EXPECT_FALSE(result.complete);
  EXPECT_THAT(means(result.film), testing::Each(std::array<double, 3>{1, 1, 1}));
}

TEST(Variance, NamesWhatIsWrongWithItsText) {
  for (const char* value : {"-1", "nan", "x", "", "1,5"})
    EXPECT_NE(refusal(std::string("variance:threshold=") + value), "") << value;
  EXPECT_THAT(refusal("variance:threshold=-1"),
              HasSubstr("--strategy: variance:threshold='-1' cannot be used; it must be a number, 0 to inf"));
  EXPECT_THAT(refusal("variance:least=2.5"), HasSubstr("it must be a whole number, 4 to 16777216"));
  EXPECT_THAT(refusal("variance:least=32,spp=31"), HasSubstr("--strategy: variance:least=32 is above spp=31"));
  EXPECT_THAT(refusal("variance:spp=8"), HasSubstr("variance:least=16 is above spp=8"));
  EXPECT_EQ(make_strategy("variance:threshold=2.5e-3", "")->text(),
            "variance:threshold=0.0025,least=16,batch=4,spp=256,power=0.5");
  EXPECT_EQ(make_strategy("variance:threshold=inf", "")->text(),
            "variance:threshold=inf,least=16,batch=4,spp=256,power=0.5");
}
