// SPDX-License-Identifier: Apache-2.0
// Strategies and films against closed forms: counts, exact means, same bits, what is left out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <set>
#include <thread>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/point_strategy.hpp>
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

std::string refusal(const std::string& strategy) {
  try {
    make_strategy(strategy, "--strategy");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    return error.what();
  }
  return "";
}

FilmPlanes all_planes() {
  FilmPlanes planes = parse_planes("depth,position,normal,albedo,object-id,material-id,variance,samples", "--aov");
  planes.error = true;
  return planes;
}

}  // namespace

TEST(Strategy, SamplesAConstantAsOftenAsItSays) {
  const RampSource flat(37, 23, {.25f, .5f, .75f}, kBlack, kBlack);
  for (const auto& [text, each] : {std::pair{"control", 1},
                                   {"grid:n=1", 1},
                                   {"grid", 4},
                                   {"grid:n=5", 25},
                                   {"control:spp=3", 3},
                                   {"random", 16},
                                   {"random:spp=7", 7},
                                   {"jitter", 16},
                                   {"jitter:n=3", 9},
                                   {"importance:spp=5", 5},
                                   {"importance:filter=box2,points=jitter", 16},
                                   {"sobol-owen", 16},
                                   {"sobol-owen:spp=1", 1},
                                   {"sobol-owen:spp=13", 13}}) {
    const CountingSource counted(flat);
    const RenderResult result = render(text, counted);
    const uint64_t expected = uint64_t{37} * 23 * static_cast<uint64_t>(each);
    EXPECT_EQ(counted.samples(), expected) << text;
    EXPECT_EQ(result.samples, expected) << text;
    EXPECT_EQ(make_strategy(text, "")->most_samples(37, 23), expected) << text;
    EXPECT_TRUE(result.complete);
    uint64_t in_passes = 0;
    for (const PassRecord& pass : result.passes) in_passes += pass.samples;
    EXPECT_EQ(in_passes, expected) << text;
    for (size_t p = 0; p < result.film.pixels(); ++p) {
      ASSERT_EQ(result.film.count(p), static_cast<uint32_t>(each)) << text;
      ASSERT_EQ(result.film.mean(p), (std::array<double, 3>{.25, .5, .75})) << text;
    }
  }
}

TEST(Strategy, GridMeanOfARampIsItsIntegral) {
  // Binary fractions, so that float samples are exact too.
  const RampSource ramp(9, 7, {.5f, 0, 1}, {.25f, -.5f, .125f}, {.125f, 1, -.25f});
  for (const char* text : {"control", "grid:n=2", "grid:n=4", "grid:n=8"}) {
    const RenderResult result = render(text, ramp);
    for (int y = 0; y < 7; ++y)
      for (int x = 0; x < 9; ++x)
        ASSERT_EQ(result.film.mean(result.film.pixel(x, y)), *ramp.integral(x, y, x + 1, y + 1)) << text;
  }
}

TEST(Strategy, GridPutsOneSampleInEachCellsMiddle) {
  std::set<std::pair<double, double>> places;
  const FunctionSource source(1, 1, [&](const SampleRequest& r) {
    places.insert({r.x, r.y});
    EXPECT_EQ(r.footprint_px, 1.f / 3);
    return grey(0);
  });
  render("grid:n=3", source);
  std::set<std::pair<double, double>> expected;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) expected.insert({(i + .5) / 3, (j + .5) / 3});
  EXPECT_EQ(places, expected);
}

TEST(Strategy, SamplesStayInTheirPixelAndCarryItsKey) {
  const FunctionSource source(5, 4, [](const SampleRequest& r) {
    EXPECT_GE(r.x, r.pixel_x);
    EXPECT_LT(r.x, r.pixel_x + 1);
    EXPECT_GE(r.y, r.pixel_y);
    EXPECT_LT(r.y, r.pixel_y + 1);
    EXPECT_EQ(r.seed, 99u);
    return grey(r.pixel_x + 10 * r.pixel_y);
  });
  RenderOptions options;
  options.seed = 99;
  for (const char* text : {"control", "grid:n=3", "random:spp=9", "jitter:n=3", "sobol-owen:spp=11"}) {
    const RenderResult result = render(text, source, options);
    EXPECT_EQ(result.film.mean(result.film.pixel(4, 3))[0], 34) << text;
    EXPECT_EQ(result.film.mean(result.film.pixel(0, 2))[1], 20) << text;
  }
}

TEST(Strategy, SameBitsForAnyThreadsAndTiles) {
  const FunctionSource source(45, 31, [](const SampleRequest& r) {
    Sample sample;
    const SampleRandom random(r.pixel_x, r.pixel_y, r.index, r.seed);
    for (uint32_t c = 0; c < 3; ++c) {
      sample.rgb[c] = std::exp(20 * random.uniform(20 + c)) * static_cast<float>(r.x);
      sample.position[c] = random.uniform(30 + c);
      sample.normal[c] = random.uniform(40 + c);
      sample.albedo[c] = random.uniform(50 + c);
    }
    if (random.uniform(60) < .5f) sample.distance = random.uniform(61);
    sample.object_id = random.u32(62) % 5;
    sample.valid = random.uniform(63) < .9f;
    return sample;
  });
  RenderOptions options;
  options.planes = all_planes();
  for (const char* text :
       {"control", "grid:n=3", "random:spp=24", "jitter:n=5", "sobol-owen:spp=24", "uniform:filter=lanczos2,spp=24",
        "uniform:divide=integral,points=random", "splat:spp=24", "splat:filter=lanczos3,points=jitter,spp=3",
        "splat:filter=box2,scale=2.5,points=random,spp=18", "importance:filter=mitchell,spp=24"}) {
    std::vector<float> first;
    uint64_t dropped = 0;
    for (const int threads : {1, 2, 7})
      for (const int tile : {1, 5, 32, 1000}) {
        set_thread_limit(threads);
        options.tile_px = tile;
        options.soon_s = tile == 5 ? 0 : 1e9;
        const RenderResult result = render(text, source, options);
        const Image image = result.image();
        if (first.empty()) first = image.pixels, dropped = result.dropped;
        ASSERT_EQ(std::memcmp(first.data(), image.pixels.data(), first.size() * sizeof(float)), 0)
            << text << ", " << threads << " threads, tile " << tile;
        EXPECT_EQ(result.dropped, dropped);
      }
  }
  set_thread_limit(0);
}

TEST(Strategy, AQuickSourceIsSpared) {
  constexpr int kWidth = 40, kHeight = 30, kSlowRow = 10;  // the clock is looked at above row 16
  constexpr uint64_t kPixels = kWidth * kHeight;
  std::atomic<bool> slept = false;
  const FunctionSource source(kWidth, kHeight, [&](const SampleRequest& r) {
    if (r.pixel_y == kSlowRow && !slept.exchange(true)) std::this_thread::sleep_for(std::chrono::milliseconds(60));
    const SampleRandom random(r.pixel_x, r.pixel_y, r.index, r.seed);
    // Large numbers that cancel: what is left has been through the compensations, and its last bit shows their order.
    const float small = random.uniform(20) * (random.uniform(22) < .5f ? 1 : 0x1p31f);
    Sample sample = grey(r.index % 3 != 1 ? small : r.index % 6 > 1 ? -1e30 : 1e30);
    sample.valid = random.uniform(21) < .97f;
    return sample;
  });
  const auto passes = [](const RenderResult& result) {
    std::vector<uint64_t> samples;
    for (const PassRecord& pass : result.passes) samples.push_back(pass.samples);
    return samples;
  };
  RenderOptions options;
  options.tile_px = 1000;
  for (const bool halves : {false, true}) {
    options.planes.error = halves;
    options.soon_s = 0;
    const RenderResult one_first = render("sobol-owen:spp=42", source, options);
    EXPECT_THAT(passes(one_first), testing::ElementsAre(kPixels, 15 * kPixels, 16 * kPixels, 10 * kPixels));
    options.soon_s = 1e9;
    const RenderResult at_once = render("sobol-owen:spp=42", source, options);
    EXPECT_THAT(passes(at_once), testing::ElementsAre(16 * kPixels, 16 * kPixels, 10 * kPixels));
    options.soon_s = .05;
    slept = false;
    const RenderResult changed = render("sobol-owen:spp=42", source, options);
    EXPECT_EQ(changed.passes.size(), 4u);
    EXPECT_LT(changed.passes[0].samples, 16 * kPixels);
    EXPECT_EQ(changed.passes[0].samples + changed.passes[1].samples, 16 * kPixels);
    for (const RenderResult* other : {&at_once, &changed}) {
      EXPECT_EQ(other->dropped, one_first.dropped);
      for (size_t p = 0; p < kPixels; ++p) {
        const Film &got = other->film, &expected = one_first.film;
        ASSERT_EQ(got.count(p), expected.count(p)) << p;
        ASSERT_EQ(got.mean(p), expected.mean(p)) << p;
        if (!halves) continue;
        ASSERT_EQ(got.half_count(p), expected.half_count(p)) << p;
        ASSERT_EQ(got.half_mean(p), expected.half_mean(p)) << p;
      }
    }
  }
}

TEST(Strategy, SeedsDifferAndRepeat) {
  const HalfPlaneSource edge(16, 16, .6, .8, 12, kWhite, kBlack);
  RenderOptions one, two;
  one.seed = 1;
  two.seed = 2;
  const auto pixels = [&](const RenderOptions& options) {
    return render("sobol-owen", edge, options).film.image().pixels;
  };
  EXPECT_EQ(pixels(one), pixels(one));
  EXPECT_NE(pixels(one), pixels(two));
}

TEST(Strategy, LeavesOutWhatIsNotANumber) {
  const FunctionSource source(8, 4, [](const SampleRequest& r) {
    Sample sample = grey(2);
    const bool here = r.pixel_x == 5 && r.pixel_y == 2;
    if (here && r.index == 1) sample.rgb[2] = NAN;
    if (here && r.index == 2) sample.rgb[0] = -INFINITY;
    if (here && r.index == 3) sample.valid = false;
    if (r.pixel_x == 6 && r.pixel_y == 3) sample.valid = false;
    return sample;
  });
  RenderOptions options;
  options.planes = all_planes();
  const RenderResult result = render("sobol-owen:spp=8", source, options);
  EXPECT_EQ(result.samples, 8u * 8 * 4);
  EXPECT_EQ(result.dropped, 3u + 8);
  EXPECT_EQ(result.dropped_x, 5);
  EXPECT_EQ(result.dropped_y, 2);
  EXPECT_EQ(result.film.count(result.film.pixel(5, 2)), 5u);
  EXPECT_EQ(result.film.mean(result.film.pixel(5, 2)), (std::array<double, 3>{2, 2, 2}));
  EXPECT_EQ(result.film.mean(result.film.pixel(6, 3)), (std::array<double, 3>{0, 0, 0}));
  EXPECT_EQ(result.film.variance_of_mean(result.film.pixel(6, 3)), (std::array<double, 3>{0, 0, 0}));
}

TEST(Strategy, EndsEarlyWithTheWholePictureCovered) {
  int asked = 0;
  RenderOptions options;
  options.tile_px = 8;
  set_thread_limit(1);
  options.stop = [&] { return ++asked > 200; };  // a pass asks 16 times for its tiles, and for full batches
  const RampSource flat(32, 32, {1, 2, 3}, kBlack, kBlack);
  const RenderResult result = render("sobol-owen:spp=65536", flat, options);
  set_thread_limit(0);
  EXPECT_FALSE(result.complete);
  EXPECT_LT(result.samples, 65536u * 32 * 32);
  for (size_t p = 0; p < result.film.pixels(); ++p) {
    ASSERT_GE(result.film.count(p), 1u);
    ASSERT_EQ(result.film.mean(p), (std::array<double, 3>{1, 2, 3}));
  }
}

TEST(Strategy, ProgressRisesToOne) {
  double last = 0;
  bool falls = false;
  RenderOptions options;
  options.progress = [&](double done) {
    falls = falls || done < last;
    last = done;
  };
  set_thread_limit(1);
  render("grid:n=4", RampSource(50, 40, kWhite, kBlack, kBlack), options);
  set_thread_limit(0);
  EXPECT_FALSE(falls);
  EXPECT_EQ(last, 1);
}

// A thread that goes on after another's batch has failed takes over its queue.
TEST(Strategy, ErrorsOfTheSourceComeThroughFromAnyBatch) {
  for (const char* text : {"sobol-owen:spp=1", "sobol-owen:spp=16", "grid:n=2", "cells:spp=16"})
    for (const int tile : {4, 32})
      for (int round = 0; round < 40; ++round) {
        std::atomic<int> asked = 0;
        const FunctionSource source(160, 120, [&](const SampleRequest&) -> Sample {
          if (++asked == 500 + 997 * round) throw_input("this one fails");
          return grey(1);
        });
        RenderOptions options;
        options.tile_px = tile;
        try {
          render(text, source, options);
        } catch (const Error& error) {
          EXPECT_STREQ(error.what(), "this one fails");
        }
      }
}

TEST(Strategy, ErrorsOfTheSourceComeThrough) {
  const FunctionSource source(40, 40, [](const SampleRequest& r) -> Sample {
    if (r.pixel_x == 17) throw_input("the lamp is broken");
    return grey(1);
  });
  EXPECT_THROW(render("sobol-owen", source), Error);
}

TEST(Strategy, NamesWhatIsWrongWithItsText) {
  EXPECT_THAT(refusal("gird:n=2"), HasSubstr("--strategy: there is no strategy 'gird' (did you mean 'grid'?)"));
  EXPECT_THAT(refusal(""), HasSubstr("there are control, grid, random, jitter, sobol-owen"));
  EXPECT_THAT(refusal("grid:m=2"), HasSubstr("no parameter 'm'"));
  EXPECT_THAT(refusal("control:n=2"), HasSubstr("it has spp"));
  EXPECT_THAT(refusal("grid:n"), HasSubstr("'n' is not key=value"));
  EXPECT_THAT(refusal("grid:"), HasSubstr("is not key=value"));
  EXPECT_THAT(refusal("grid:n=2,n=3"), HasSubstr("given twice"));
  for (const char* value : {"0", "-1", "1025", "2.5", "x", "", "99999999999999999999"})
    EXPECT_THAT(refusal(std::string("grid:n=") + value), HasSubstr("a whole number, 1 to 1024")) << value;
  EXPECT_EQ(make_strategy("grid:n=1024", "")->text(), "grid:n=1024");
  EXPECT_EQ(make_strategy("sobol-owen", "")->text(), "sobol-owen:spp=16");
  EXPECT_EQ(make_strategy("control", "")->text(), "control:spp=1");
  for (const StrategyInfo* info : strategy_list()) {
    EXPECT_EQ(make_strategy(info->name, "")->info().name, info->name);
    for (const StrategyParam& param : info->params)
      EXPECT_THAT(strategy_help(*info), HasSubstr(param.name + "=" + strategy_value(param, param.usual)));
  }
}

TEST(Strategy, AFixedPatternHasNoErrorToStopAt) {
  RenderOptions options;
  options.until_rmse = 1e-3;
  EXPECT_THROW(render("grid", RampSource(4, 4, kWhite, kBlack, kBlack), options), Error);
  EXPECT_THROW(render("control", RampSource(4, 4, kWhite, kBlack, kBlack), options), Error);
}

TEST(Film, HolesAreNoErrorThatSamplesWouldTakeAway) {
  // A hole of 3 x 2 pixels in noise: the error is that of the others, and it is reached.
  const auto lost = [](const SampleRequest& r) {
    return r.pixel_x >= 5 && r.pixel_x < 8 && (r.pixel_y == 4 || r.pixel_y == 5);
  };
  const auto noisy = test::noise(40, 30, .5, 1);
  const FunctionSource holes(40, 30, [&](const SampleRequest& r) {
    Sample sample;
    noisy.eval({&r, 1}, {&sample, 1});
    if (lost(r)) sample.rgb[1] = NAN;
    return sample;
  });
  RenderOptions options;
  options.planes.error = true;
  const double expected = std::sqrt(1. / 12 / 64);  // known to 1.2% of 3 x 1194 values
  EXPECT_NEAR(render("sobol-owen:spp=64", holes, options).passes.back().rmse, expected, .05 * expected);
  options.planes.variance = true;  // the other way in which films add samples
  EXPECT_NEAR(render("sobol-owen:spp=64", holes, options).passes.back().rmse, expected, .05 * expected);
  options.planes.variance = false;
  options.until_rmse = 1.05 * expected;
  for (const char* text : {"sobol-owen:spp=4096", "cells:spp=4096", "variance:threshold=0,spp=4096"}) {
    const RenderResult until = render(text, holes, options);
    EXPECT_TRUE(until.reached) << text;
    EXPECT_LE(until.samples, 128u * 40 * 30) << text;
    EXPECT_TRUE(until.film.has_nothing(until.film.pixel(6, 5))) << text;
  }
  // Three that were lost say little, and of nothing at all there is no error to know.
  EXPECT_TRUE(std::isinf(render("sobol-owen:spp=3", holes, options).film.estimated_rmse()));
  const FunctionSource nothing(40, 30, [](const SampleRequest&) { return grey(NAN); });
  EXPECT_TRUE(std::isinf(render("sobol-owen:spp=64", nothing, options).film.estimated_rmse()));
}

TEST(Film, PlanesAreMeansOverHitsAndFirstIds) {
  FilmPlanes planes = all_planes();
  Film film(2, 1, planes);
  Sample hit = grey(1), miss = grey(3);
  hit.distance = 4;
  hit.position = {1, 2, 3};
  hit.normal = {0, 0, 1};
  hit.albedo = {.5f, .25f, 1};
  hit.object_id = 7;
  hit.material_id = 70001;
  EXPECT_TRUE(film.add(0, 0, hit));
  hit.distance = 8;
  hit.position = {3, 2, 1};
  hit.normal = {0, 1, 0};
  hit.object_id = 8;
  EXPECT_TRUE(film.add(0, 1, hit));
  EXPECT_TRUE(film.add(0, 2, miss));
  EXPECT_TRUE(film.add(0, 3, miss));
  const Image image = film.image();
  EXPECT_EQ(image.spec.channels,
            (std::vector<std::string>{"R", "G", "B", "Z", "P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "albedo.R",
                                      "albedo.G", "albedo.B", "object_id", "material_id", "variance.R", "variance.G",
                                      "variance.B", "samples"}));
  const std::vector<float> first(image.pixels.begin(), image.pixels.begin() + 19);
  const float variance = 4.f / 3 / 4;  // of 1 1 3 3: sum of squares about 2 is 4
  EXPECT_EQ(first, (std::vector<float>{2, 2, 2, 6, 2, 2, 2, 0, .5f, .5f, .25f, .125f, .5f, 7, 70001, variance,
                                       variance, variance, 4}));
  const std::vector<float> second(image.pixels.begin() + 19, image.pixels.end());
  EXPECT_EQ(second, (std::vector<float>{0, 0, 0, INFINITY, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_THAT(([] { parse_planes("depth,albdo", "--aov"); }),
              testing::ThrowsMessage<Error>(HasSubstr("--aov: 'albdo' is not known (did you mean 'albedo'?)")));
  EXPECT_EQ(parse_planes("", "--aov"), FilmPlanes{});
}

TEST(Film, EveryInstructionSetGivesTheSameBits) {
  const auto film_of = [](const char* cpu, bool halves, size_t each) {
    if (cpu) setenv("TRIAD_CPU", cpu, 1);
    FilmPlanes planes;
    planes.error = halves;
    Film film(64, 1, planes);
    if (cpu) unsetenv("TRIAD_CPU");
    for (uint32_t first = 0; first < 3 * each; first += static_cast<uint32_t>(each)) {
      std::vector<SampleRequest> requests;
      std::vector<Sample> samples;
      for (int x = 0; x < 64; ++x)
        for (uint32_t index = first; index < first + each; ++index) {
          requests.push_back({.pixel_x = x, .index = index});
          const SampleRandom random(x, 0, index, each);
          const auto small = [&](uint32_t d) {
            return random.uniform(d) * (random.uniform(d + 1) < .5f ? 1 : 0x1p31f);
          };
          const float large = index % 3 != 1 ? 1 : index % 6 > 1 ? -1e20f : 1e20f;
          samples.push_back({.rgb = {small(20), small(30) * large, -small(40)}});
          if (random.uniform(50) < .01f) samples.back().valid = false;
          if (random.uniform(51) < .01f)
            samples.back().rgb[random.u32(52) % 3] = random.uniform(53) < .5f ? NAN : INFINITY;
          if (random.uniform(54) < .01f) samples.back().rgb = {-0.f, 0, 1e-40f};
        }
      film.add(requests, samples);
    }
    return film;
  };
  for (const bool halves : {false, true})
    for (size_t each = 1; each <= 35; ++each) {
      const Film widest = film_of(nullptr, halves, each), baseline = film_of("baseline", halves, each);
      for (size_t p = 0; p < widest.pixels(); ++p) {
        ASSERT_EQ(widest.count(p), baseline.count(p)) << each;
        ASSERT_EQ(widest.left_out(p), baseline.left_out(p)) << each;
        ASSERT_EQ(widest.mean(p), baseline.mean(p)) << each;
        if (!halves) continue;
        ASSERT_EQ(widest.half_count(p), baseline.half_count(p)) << each;
        ASSERT_EQ(widest.half_mean(p), baseline.half_mean(p)) << each;
      }
    }
}

TEST(Film, RefusesMoreThanTheMachineHas) {
  EXPECT_THROW(Film(2147483647, 2147483647, {}), Error);
  EXPECT_THROW(Film(3'000'000, 3'000'000, {}), Error);
}

TEST(Analytic, IntegralsAgainstSamplesOnAFineGrid) {
  // An independent way: 512^2 points per pixel; an edge of length s misplaces at most about s/512 of a pixel's area.
  const HalfPlaneSource plane(6, 5, -.3, .954, 1.2, {2, 0, 1}, {0, 1, 1});
  const DiscSource disc(6, 5, 2.9, 2.2, 1.83, {2, 0, 1}, {0, 1, 1});
  const DiscSource speck(6, 5, 2.51, 2.47, .11, {2, 0, 1}, {0, 1, 1});  // within one pixel
  for (const Source* source :
       {static_cast<const Source*>(&plane), static_cast<const Source*>(&disc), static_cast<const Source*>(&speck)}) {
    const RenderResult result = render("grid:n=512", *source);
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x) {
        const auto exact = *source->integral(x, y, x + 1, y + 1);
        const auto mean = result.film.mean(result.film.pixel(x, y));
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(mean[c], exact[c], 2e-4) << x << "," << y;
      }
  }
  // Over the whole film, the disc's area is pi r^2 of 30, and additive over its pixels.
  double sum = 0;
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 6; ++x) sum += (*disc.integral(x, y, x + 1, y + 1))[0];
  EXPECT_NEAR(sum, 2 * std::numbers::pi * 1.83 * 1.83, 1e-13);
  EXPECT_NEAR((*disc.integral(0, 0, 6, 5))[0] * 30, sum, 1e-13);
}

TEST(Sobol, FirstPointsAreThePublishedOnes) {
  // Joe and Kuo's table, dimensions 1 and 2, in natural (not Gray code) order.
  const double expected[8][2] = {{0, 0},       {.5, .5},     {.25, .75},   {.75, .25},
                                 {.125, .625}, {.625, .125}, {.375, .375}, {.875, .875}};
  for (uint32_t i = 0; i < 8; ++i) {
    const auto point = sobol_point(i);
    EXPECT_EQ(point[0] * 0x1p-32, expected[i][0]) << i;
    EXPECT_EQ(point[1] * 0x1p-32, expected[i][1]) << i;
  }
}

namespace {

// How many elementary intervals of 2^-a by 2^-(k-a), a = 0..k, do not hold exactly one of the 2^k points.
template <typename PointAt>
int unfair_intervals(uint32_t k, const PointAt& point_at) {
  int unfair = 0;
  for (uint32_t a = 0; a <= k; ++a) {
    std::vector<int> held(size_t{1} << k);
    for (uint32_t i = 0; i < (1u << k); ++i) {
      const std::array<double, 2> p = point_at(i);
      const auto column = static_cast<size_t>(std::ldexp(p[0], static_cast<int>(a)));
      const auto row = static_cast<size_t>(std::ldexp(p[1], static_cast<int>(k - a)));
      ++held[row << a | column];
    }
    for (const int n : held) unfair += n != 1;
  }
  return unfair;
}

}  // namespace

TEST(Sobol, EachElementaryIntervalHoldsExactlyOne) {
  for (uint32_t k = 0; k <= 12; ++k)
    for (const uint64_t key : {0ull, 1ull, 0x123456789abcdefull}) {
      for (const uint32_t block : {0u, 1u, 5u})  // any aligned block of 2^k
        EXPECT_EQ(unfair_intervals(k,
                                   [&](uint32_t i) {
                                     const auto p = sobol_owen_point((block << k) + i, key);
                                     return std::array{p[0] * 0x1p-32, p[1] * 0x1p-32};
                                   }),
                  0)
            << "2^" << k << " points, key " << key;
      EXPECT_EQ(unfair_intervals(k,
                                 [&](uint32_t i) {
                                   const auto p = sobol_owen_pair(i, 3, key);
                                   return std::array<double, 2>{p[0], p[1]};
                                 }),
                0)
          << "pair, 2^" << k << " points, key " << key;
    }
  // And the points that the strategy really asks for.
  std::vector<std::array<double, 2>> places(256);
  const FunctionSource source(1, 1, [&](const SampleRequest& r) {
    places[r.index] = {r.x, r.y};
    return grey(0);
  });
  render("sobol-owen:spp=256", source);
  EXPECT_EQ(unfair_intervals(8, [&](uint32_t i) { return places[i]; }), 0);
}

TEST(Sobol, RunsOfAnyLengthArePlacedAsPointByPoint) {
  // Neighbours change the pixel, the offset, or both; the last run is met again.
  struct Run {
    int32_t x, y;
    uint32_t first, count;
  };
  std::vector<Run> runs;
  for (uint32_t count = 1; count <= 37; ++count)
    for (const uint32_t first : {0u, 1u, 13u, (1u << 24) - 37}) {
      const auto n = static_cast<int32_t>(count);
      runs.push_back({n % 3 == 0 ? -n : n, static_cast<int32_t>(first % 7) - 2, first, count});
      runs.push_back({2147483647 - n, -2147483647 - 1, first, count});
    }
  runs.push_back(runs.front());
  std::vector<SampleRequest> requests;
  for (const Run& run : runs)
    for (uint32_t i = 0; i < run.count; ++i) requests.push_back({-1, -1, .25f, run.x, run.y, run.first + i, 31});
  const SampleRequest beyond{-1, -1, .5f, runs.back().x, runs.back().y, 5, 31};
  requests.push_back(beyond);
  place_sobol_owen(std::span(requests).first(requests.size() - 1));

  size_t at = 0;
  for (const Run& run : runs)
    for (uint32_t i = 0; i < run.count; ++i, ++at) {
      const SampleRequest& placed = requests[at];
      const auto point = sobol_owen_point(run.first + i, SampleRandom::pixel_key(run.x, run.y, 31));
      ASSERT_EQ(placed.x, run.x + point[0] * 0x1p-32) << run.count << " from " << run.first << ", " << i;
      ASSERT_EQ(placed.y, run.y + point[1] * 0x1p-32) << run.count << " from " << run.first << ", " << i;
      ASSERT_EQ(placed.index, run.first + i);
      ASSERT_EQ(placed.pixel_x, run.x);
      ASSERT_EQ(placed.pixel_y, run.y);
      ASSERT_EQ(placed.footprint_px, .25f);
      ASSERT_EQ(placed.seed, 31u);
    }
  EXPECT_EQ(requests.back().x, beyond.x);
  EXPECT_EQ(requests.back().y, beyond.y);
}

TEST(Sobol, HalvesShareEachIntervalOfFourPointsEvenly) {
  for (uint32_t k = 2; k <= 12; ++k)
    for (uint32_t a = 0; a <= k - 2; ++a) {
      std::vector<int> first_half(size_t{1} << (k - 2));
      for (uint32_t i = 0; i < (1u << k); ++i) {
        const auto p = sobol_owen_point(i, 7);
        const size_t column = size_t{p[0]} >> (32 - a), row = size_t{p[1]} >> (32 - (k - 2 - a));
        first_half[row << a | column] += !sobol_half(i);
      }
      EXPECT_THAT(first_half, testing::Each(2)) << k << " " << a;
    }
}

TEST(Sobol, ScramblingIsNested) {
  // Two numbers that share their k highest bits share them afterwards, and differ in the next one if they did.
  for (uint32_t t = 0; t < 2000; ++t) {
    const uint32_t x = SampleRandom(0, 0, t, 5).u32(0), seed = SampleRandom(0, 0, t, 5).u32(1);
    for (int k = 0; k < 32; ++k) {
      const uint32_t low = k == 31 ? 0 : SampleRandom(0, 0, t, 6).u32(0) >> (k + 1);
      const uint32_t y = x ^ (0x80000000u >> k) ^ low;  // differs first in bit k from the top
      const uint32_t difference = owen_scramble(x, seed) ^ owen_scramble(y, seed);
      ASSERT_EQ(std::countl_zero(difference), k);
    }
  }
}
