// SPDX-License-Identifier: Apache-2.0
// quad and tri, beside an obvious version of them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <numeric>
#include <triad/base/error.hpp>
#include <triad/base/log.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/strategy.hpp>

#include "levels_reference.hpp"
#include "sampling_sources.hpp"

using namespace triad;
using test::Expected;
using test::FunctionSource;
using test::grey;
using test::LevelSettings;
using testing::Each;
using testing::HasSubstr;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

RenderResult render(const std::string& strategy, const Source& source, const RenderOptions& options = {}) {
  return make_strategy(strategy, "--strategy")->render(source, options);
}

RenderResult render_with_reasons(const std::string& strategy, const Source& source) {
  RenderOptions options;
  options.planes.reasons = true;
  return render(strategy, source, options);
}

std::vector<uint64_t> samples_by_level(const RenderResult& result) {
  std::vector<uint64_t> samples;
  for (const PassRecord& pass : result.passes) samples.push_back(pass.samples);
  return samples;
}

double sum(const std::vector<float>& values) { return std::accumulate(values.begin(), values.end(), 0.); }

// A number in [0, 1) for each place.
double hash(double x, double y) {
  return SampleRandom(static_cast<int32_t>(x * 64), static_cast<int32_t>(y * 64), 0, 7).uniform(0);
}
FunctionSource speckles(int width, int height) {
  return FunctionSource(width, height, [](const SampleRequest& r) { return grey(hash(r.x, r.y)); });
}

// A wall, a ball before it, in some places nothing; colours of both vary a little; some samples are not valid.
FunctionSource still_life(int width, int height, double invalid) {
  return FunctionSource(width, height, [=](const SampleRequest& r) {
    const double dx = r.x - .45 * width, dy = r.y - .4 * height, radius = .3 * width;
    const bool ball = dx * dx + dy * dy < radius * radius;
    Sample sample;
    sample.rgb = {static_cast<float>(ball ? .6 : .6 + .02 * std::sin(r.x)), static_cast<float>(.3 + .0103 * r.y),
                  static_cast<float>(r.x + .5 * r.y < .9 * width ? .5 : .5437)};
    sample.valid = hash(r.x, r.y) >= invalid;
    if (r.y > .85 * height && !ball) return sample;
    const double z = ball ? 4 - std::sqrt(radius * radius - dx * dx - dy * dy) / radius : 5 + .0107 * r.x;
    sample.distance = static_cast<float>(z);
    sample.position = {static_cast<float>(.1 * dx), static_cast<float>(.1 * dy), static_cast<float>(z)};
    sample.object_id = ball ? 2 : 1;
    return sample;
  });
}

void expect_as_defined(const Source& source, const LevelSettings& settings) {
  SCOPED_TRACE(fmt::format("{} on {}x{}", settings.text(), source.width(), source.height()));
  const Expected right = expected(source, settings);
  const RenderResult result = render_with_reasons(settings.text(), source);
  size_t worst = 0;
  double difference = 0;
  for (size_t p = 0; p < result.film.pixels(); ++p) {
    ASSERT_EQ(result.film.count(p), right.counts[p]) << "pixel " << p;
    for (size_t c = 0; c < 3; ++c)
      if (std::abs(result.colour[p][c] - right.colour[p][c]) > difference) {
        difference = std::abs(result.colour[p][c] - right.colour[p][c]);
        worst = p;
      }
    if (settings.over > 0) continue;
    const char reason = right.reasons[p];
    ASSERT_EQ(result.reasons[0][p], reason == 'i') << "pixel " << p;
    ASSERT_EQ(result.reasons[1][p], reason == 'c') << "pixel " << p;
    ASSERT_EQ(result.reasons[2][p], reason == 'p') << "pixel " << p;
  }
  EXPECT_LT(difference, 1e-6) << "pixel " << worst;
}

}  // namespace

TEST(Levels, AreAsDefined) {
  for (const auto& [width, height] : {std::pair{37, 29}, {16, 16}, {5, 11}, {2, 3}, {1, 1}, {1, 9}})
    for (const double invalid : {0., .1})
      for (const bool tri : {false, true}) {
        const FunctionSource source = still_life(width, height, invalid);
        expect_as_defined(source, {tri});
        expect_as_defined(source, {tri, false, 3, 0, .01, kInfinity});
        expect_as_defined(source, {tri, false, 2, 0, .05, .2, true});
        expect_as_defined(source, {tri, false, 1, 2, .02, .01, true});
        expect_as_defined(source, {tri, false, 0, 0});
      }
  expect_as_defined(still_life(37, 29, .1), {true, true});
  expect_as_defined(still_life(37, 29, .1), {true, true, 1, 1});
}

TEST(Levels, StillLifeHasEveryReason) {
  // Or the test above would not see them.
  const RenderResult result = render_with_reasons("quad:ids=on,colour=.01,position=.2", still_life(128, 96, 0));
  for (const std::vector<float>& reason : result.reasons) EXPECT_GT(sum(reason), 20);
  for (size_t p = 0; p < result.film.pixels(); ++p)
    ASSERT_LE(result.reasons[0][p] + result.reasons[1][p] + result.reasons[2][p], 1);
}

TEST(Levels, TakeAsManySamplesAsTheyMust) {
  const FunctionSource constant(64, 32, [](const SampleRequest&) { return grey(.4); });
  for (const std::string name : {"quad", "tri"}) {
    EXPECT_EQ(render(name, constant).samples, 64 * 32 / 16);
    EXPECT_EQ(render(name + ":over=1,under=0", constant).samples, 64 * 32);
    EXPECT_EQ(render(name + ":under=3", constant).samples, 64 * 32 / 64);
    EXPECT_EQ(render(name + ":under=0", constant).samples, 64 * 32);
    EXPECT_EQ(render(name + ":spp=4", constant).samples, 64 * 32 / 4);

    const FunctionSource busy = speckles(64, 32);
    const RenderResult all = render(name + ":colour=0", busy);
    EXPECT_EQ(all.samples, 1.3125 * 64 * 32);
    EXPECT_THAT(samples_by_level(all), testing::ElementsAre(128, 512, 2048));
    EXPECT_EQ(make_strategy(name + ":spp=3", "")->most_samples(64, 32), all.samples * 3);
    EXPECT_EQ(render(name + ":colour=0,over=1", busy).samples, 1.3125 * 64 * 32 + 4 * 64 * 32);
    // 4 x 3 cells, 7 x 5, 13 x 9.
    EXPECT_THAT(samples_by_level(render(name + ":colour=0", speckles(13, 9))), testing::ElementsAre(12, 35, 117));
  }
}

TEST(Levels, FullySampledAreControlAndGrid) {
  const FunctionSource busy = speckles(23, 18);
  const struct {
    std::string levels, points;
  } cases[] = {{"quad:under=0", "control"},
               {"quad:colour=0", "control"},
               {"tri:colour=0,finest=square", "control"},
               {"quad:colour=0,under=1,over=2", "grid:n=4"},
               {"tri:colour=0,under=0,over=1,finest=square", "grid:n=2"}};
  for (const auto& [levels, points] : cases) {
    SCOPED_TRACE(levels);
    const RenderResult a = render(levels, busy), b = render(points, busy);
    for (size_t p = 0; p < a.film.pixels(); ++p)
      for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(a.mean(p)[c], b.mean(p)[c], 1e-7);
  }
}

TEST(Levels, HigherThresholdsTakeFewerSamplesOnEveryLevel) {
  const FunctionSource source = still_life(160, 120, 0);
  for (const std::string name : {"quad", "tri"})
    for (const std::string threshold : {"colour=.1,position", "position=.5,colour"}) {
      std::vector<uint64_t> before, most;
      for (const std::string value : {"0", ".003", ".01", ".03", ".1", "inf"}) {
        const auto now = samples_by_level(render(name + ":over=1," + threshold + "=" + value, source));
        ASSERT_EQ(now.size(), 4u);
        for (size_t i = 0; i < before.size(); ++i) EXPECT_LE(now[i], before[i]) << name << " " << value << " " << i;
        if (most.empty()) most = now;
        before = now;
      }
      for (size_t i = 1; i < most.size(); ++i) EXPECT_LT(before[i], most[i]);
    }
}

TEST(Levels, RampsAreInterpolatedExactlyInTheInterior) {
  const RampSource ramp(40, 24, {.1f, .2f, .9f}, {.04f, .01f, -.02f}, {.03f, -.005f, .01f});
  for (const std::string strategy : {"quad:colour=1e-5,position=inf", "tri:colour=1e-5,position=inf"}) {
    SCOPED_TRACE(strategy);
    const RenderResult result = render_with_reasons(strategy, ramp);
    for (int y = 4; y < 20; ++y)
      for (int x = 8; x < 32; ++x) {
        const size_t p = result.film.pixel(x, y);
        ASSERT_EQ(result.reasons[1][p], 0);
        for (size_t c = 0; c < 3; ++c)
          ASSERT_NEAR(result.mean(p)[c], (*ramp.integral(x, y, x + 1, y + 1))[c], 1e-6) << x << " " << y;
      }
    // The border repeats: there it is no ramp.
    EXPECT_GT(sum(result.reasons[1]), 40);
    // 6 x 4 coarse cells, and of the finer levels nothing.
    uint32_t inside = 0;
    for (int y = 4; y < 20; ++y)
      for (int x = 8; x < 32; ++x) inside += result.film.count(result.film.pixel(x, y));
    EXPECT_EQ(inside, 24u);
  }
}

TEST(Levels, SeeWhiteBeforeWhiteByPositionsAndIds) {
  const FunctionSource white(48, 32, [](const SampleRequest& r) {
    Sample sample = grey(1);
    const bool near = r.x < 21.3;
    sample.distance = near ? 2 : 3;
    sample.position = {static_cast<float>(.01 * r.x), static_cast<float>(.01 * r.y), sample.distance};
    sample.object_id = near ? 1 : 2;
    return sample;
  });
  for (const std::string name : {"quad", "tri"}) {
    EXPECT_EQ(render(name + ":position=inf", white).samples, 48 * 32 / 16);
    const RenderResult positions = render_with_reasons(name, white);
    const RenderResult ids = render_with_reasons(name + ":position=inf,ids=on", white);
    for (const RenderResult* result : {&positions, &ids}) {
      const std::vector<float>& reason = result->reasons[result == &ids ? 0 : 2];
      for (int y = 0; y < 32; ++y) {
        EXPECT_EQ(reason[result->film.pixel(21, y)], 1) << y;
        EXPECT_EQ(reason[result->film.pixel(4, y)] + reason[result->film.pixel(40, y)], 0) << y;
      }
      for (const size_t other : {size_t{1}, result == &ids ? size_t{2} : size_t{0}})
        EXPECT_THAT(result->reasons[other], Each(0));
    }
  }
}

TEST(Levels, MissesAreAnEdgeToHits) {
  // Half of the picture hits a plane that nothing else tells apart from what lies behind it.
  const FunctionSource source(32, 32, [](const SampleRequest& r) {
    Sample sample = grey(.5);
    if (r.y > 17) return sample;
    sample.distance = 1;
    sample.position = {static_cast<float>(r.x), static_cast<float>(r.y), 0};
    return sample;
  });
  const RenderResult result = render_with_reasons("quad:position=1e9", source);
  for (int x = 0; x < 32; ++x) {
    EXPECT_EQ(result.reasons[2][result.film.pixel(x, 16)] + result.reasons[2][result.film.pixel(x, 17)], 2);
    EXPECT_EQ(result.reasons[2][result.film.pixel(x, 4)] + result.reasons[2][result.film.pixel(x, 28)], 0);
  }
}

TEST(Levels, SourcesWithoutGeometryAreJudgedByColour) {
  const DiscSource disc(40, 40, 20, 20, 9, {1, 1, 1}, {0, 0, 0});
  testing::internal::CaptureStderr();
  const RenderResult result = render_with_reasons("quad:ids=on", disc);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("quad: the source tells no positions"));
  EXPECT_GT(sum(result.reasons[1]), 50);
  EXPECT_EQ(sum(result.reasons[0]) + sum(result.reasons[2]), 0);
  EXPECT_TRUE(make_strategy("quad", "")->uses_geometry());
  EXPECT_TRUE(make_strategy("tri:position=inf,ids=on", "")->uses_geometry());
  EXPECT_FALSE(make_strategy("tri:position=inf", "")->uses_geometry());
}

TEST(Levels, MissWhatNoCoarseRayMeets) {
  // The nearest coarse centres are at 18 and 22 in both directions, 2.8 pixels away; those of under=1 are 1.4 away.
  const DiscSource disc(40, 40, 20, 20, 2, {1, 1, 1}, {0, 0, 0});
  EXPECT_EQ(render("quad:position=inf", disc).samples, 100u);
  const RenderResult found = render("quad:position=inf,under=1", disc), full = render("control", disc);
  for (size_t p = 0; p < full.film.pixels(); ++p) ASSERT_EQ(found.mean(p), full.mean(p)) << p;
}

TEST(Levels, ConstantInConstantOut) {
  Sample sample;
  sample.rgb = {.1f, .3f, .7f};
  for (const auto& [width, height] : {std::pair{1, 1}, {5, 3}, {33, 18}})
    for (const std::string strategy :
         {"quad", "tri", "tri:finest=square,under=3", "quad:colour=0,under=1,over=2", "tri:over=1,spp=4"}) {
      const RenderResult result =
          render(strategy, FunctionSource(width, height, [&](const auto&) { return sample; }));
      for (size_t p = 0; p < result.film.pixels(); ++p)
        for (size_t c = 0; c < 3; ++c) ASSERT_EQ(result.mean(p)[c], sample.rgb[c]) << strategy << " " << p;
    }
}

TEST(Levels, SamplesThatAreNotValidHarmNobody) {
  Sample sample;
  sample.rgb = {.1f, .3f, .7f};
  for (const double invalid : {.02, .1, 1.})
    for (const std::string strategy : {"quad", "tri"}) {
      const FunctionSource source(40, 30, [&](const SampleRequest& r) {
        Sample here = sample;
        here.distance = 3;
        if (hash(r.x, r.y) < invalid) here.rgb[1] = std::numeric_limits<float>::quiet_NaN();
        return here;
      });
      const RenderResult result = render(strategy, source);
      EXPECT_GT(result.dropped, 0u);
      for (size_t p = 0; p < result.film.pixels(); ++p)
        for (size_t c = 0; c < 3; ++c)
          ASSERT_NEAR(result.mean(p)[c], invalid == 1 ? 0 : sample.rgb[c], 1e-6) << strategy << " " << p;
    }
}

TEST(Levels, DrawTheSameNumbersEverywhereIfAsked) {
  const FunctionSource noise = test::noise(32, 32, .5, .8);
  const RenderResult own = render("quad:noise=own,spp=2", noise), shared = render("quad:noise=shared,spp=2", noise);
  EXPECT_GT(own.samples, 2 * 1.2 * 32 * 32);
  EXPECT_EQ(shared.samples, 2 * 32 * 32 / 16);
  for (size_t p = 0; p < shared.film.pixels(); ++p) {
    ASSERT_EQ(shared.mean(p), shared.mean(0));
    ASSERT_EQ(shared.film.count(p), p % 4 == 2 && p / 32 % 4 == 2 ? 2u : 0u);
  }
  // Another seed, other numbers, and each sample of a place its own.
  RenderOptions options;
  options.seed = 1;
  EXPECT_NE(render("quad:noise=shared,spp=2", noise, options).mean(0), shared.mean(0));
  EXPECT_NE(render("quad:noise=shared,spp=1", noise).mean(0), shared.mean(0));
}

TEST(Levels, MoreSamplesOfAPlaceAreAveraged) {
  const FunctionSource source(16, 16, [](const SampleRequest& r) { return grey(r.index % 4 == 3 ? 1 : 0); });
  for (const std::string noise : {"own", "shared"}) {
    const RenderResult result = render("tri:over=1,spp=4,noise=" + noise, source);
    EXPECT_EQ(result.samples, 4u * 16);
    for (size_t p = 0; p < result.film.pixels(); ++p) ASSERT_EQ(result.mean(p)[0], .25);
  }
}

TEST(Levels, SameBitsForAnyThreads) {
  const FunctionSource source = still_life(150, 110, .03);
  for (const std::string strategy : {"quad:over=1,ids=on,noise=own", "tri:noise=own"}) {
    std::optional<RenderResult> one;
    for (const int threads : {1, 2, 7}) {
      set_thread_limit(threads);
      RenderResult now = render_with_reasons(strategy, source);
      if (one) {
        EXPECT_EQ(now.reasons, one->reasons);
        EXPECT_EQ(std::memcmp(now.colour.data(), one->colour.data(), now.colour.size() * sizeof(now.colour[0])), 0);
        EXPECT_EQ(now.dropped_x, one->dropped_x);
        for (size_t p = 0; p < now.film.pixels(); ++p) {
          ASSERT_EQ(now.film.count(p), one->film.count(p));
          ASSERT_EQ(now.film.mean(p), one->film.mean(p));
        }
      } else {
        one.emplace(std::move(now));
      }
    }
    set_thread_limit(0);
  }
}

TEST(Levels, EndedEarlyShowWhatTheyHave) {
  std::atomic<int> asked = 0;
  RenderOptions options;
  options.stop = [&] { return ++asked > 24; };
  const RenderResult result = render("quad:colour=0", speckles(64, 64), options);
  EXPECT_FALSE(result.complete);
  EXPECT_GT(result.samples, 256u);
  EXPECT_LT(result.samples, 1.3125 * 64 * 64);
  for (size_t p = 0; p < result.film.pixels(); ++p) ASSERT_GT(result.mean(p)[0], 0);
}

TEST(Levels, MakeNothingFinerThanPixelsOnceStopped) {
  for (const char* name : {"quad", "tri"}) {
    std::atomic<int> asked = 0;
    const FunctionSource flat(64, 48, [&](const SampleRequest&) {
      ++asked;
      return grey(.7);
    });
    RenderOptions options;
    options.planes.reasons = true;
    options.stop = [&] { return asked == 16 * 12; };  // the coarsest level
    const RenderResult result = render(std::string(name) + ":under=2,over=4", flat, options);
    EXPECT_FALSE(result.complete);
    EXPECT_EQ(result.passes.size(), 3u);  // of 4 x 4, 2 x 2 and single pixels
    for (size_t p = 0; p < result.film.pixels(); ++p) ASSERT_NEAR(result.mean(p)[1], .7, 1e-6);
  }
}

TEST(Levels, AskForTheirMemoryFirst) {
  // The film alone would fit.
  const int side = static_cast<int>(std::sqrt(static_cast<double>(machine_memory_bytes()) / 2000));
  std::atomic<int> asked = 0;
  const FunctionSource source(side, side, [&](const SampleRequest&) {
    ++asked;
    return grey(.5);
  });
  try {
    render("quad:over=4", source);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_THAT(error.what(), HasSubstr("less `over`"));
  }
  EXPECT_EQ(asked, 0);
}
