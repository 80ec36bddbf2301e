// SPDX-License-Identifier: Apache-2.0
// Samples of display pixels, binned into fine cells.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>

#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/cell_points.hpp>
#include <triad/sampling/sobol.hpp>
#include <triad/sampling/strategy.hpp>

#include "layouts.hpp"
#include "sampling_sources.hpp"

using namespace triad;
using test::FunctionSource;
using test::grey;
using testing::HasSubstr;

namespace {

using Colour = std::array<double, 3>;

constexpr Rgb kBlack{0, 0, 0}, kWhite{1, 1, 1};

RenderResult render(const std::string& strategy, const Source& source, const Cells& cells, uint64_t seed = 0) {
  RenderOptions options;
  options.cells = cells;
  options.seed = seed;
  return make_strategy(strategy, "--strategy")->render(source, options);
}

std::string refusal(const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    return error.what();
  }
  return "";
}

// A slanted edge through many pixels, each crossed at another offset; of the film's pixels.
HalfPlaneSource edge(int width_px, int height_px, const Cells& cells) {
  return HalfPlaneSource(width_px * cells.x, height_px * cells.y, .6 / cells.x, .8 / cells.y, .55 * width_px, kWhite,
                         kBlack);
}

// Root mean square over cells, against the exact means.
double rmse(const RenderResult& result, const Source& source) {
  double squares = 0;
  for (int y = 0; y < source.height(); ++y)
    for (int x = 0; x < source.width(); ++x) {
      const double error = result.mean(result.film.pixel(x, y))[0] - (*source.integral(x, y, x + 1, y + 1))[0];
      squares += error * error;
    }
  return std::sqrt(squares / static_cast<double>(result.film.pixels()));
}

}  // namespace

TEST(Cells, CountsAndConstantsOnTheCellsOfEveryLayout) {
  constexpr int kWidth = 13, kHeight = 7;
  for (const Layout& layout : reference::all_layouts()) {
    const Cells cells{layout.cells_x, layout.cells_y};
    const RampSource flat(kWidth * cells.x, kHeight * cells.y, {.3f, .5f, .7f}, kBlack, kBlack);
    for (const auto& [text, spp] : {std::pair{"cells", 16u},
                                    {"cells:spp=1", 1u},
                                    {"cells:spp=5", 5u},
                                    {"cells:spp=64", 64u},
                                    {"cells:spp=9,points=jitter", 9u},
                                    {"cells:spp=15,points=jitter", 15u},
                                    {"cells:spp=16,points=random", 16u}}) {
      const CountingSource counted(flat);
      const RenderResult result = render(text, counted, cells);
      EXPECT_EQ(counted.samples(), uint64_t{spp} * kWidth * kHeight) << layout.name << " " << text;
      EXPECT_EQ(result.samples, counted.samples());
      for (size_t p = 0; p < result.film.pixels(); ++p)
        for (size_t c = 0; c < 3; ++c)
          ASSERT_NEAR(result.mean(p)[c], flat.integral(0, 0, 1, 1)->at(c), 1e-14) << layout.name << " " << text;
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          uint32_t in_pixel = 0;
          for (int v = 0; v < cells.y; ++v)
            for (int u = 0; u < cells.x; ++u)
              in_pixel += result.film.count(result.film.pixel(x * cells.x + u, y * cells.y + v));
          ASSERT_EQ(in_pixel, spp) << layout.name << " " << text;
        }
    }
  }
}

TEST(Cells, WithOneCellItIsPlainAntialiasing) {
  const HalfPlaneSource source = edge(21, 17, {1, 1});
  for (const char* spp : {"1", "7", "16", "100"}) {
    const RenderResult plain = render(std::string("sobol-owen:spp=") + spp, source, {}, 3);
    const RenderResult result = render(std::string("cells:spp=") + spp, source, {}, 3);
    for (size_t p = 0; p < plain.film.pixels(); ++p) {
      EXPECT_EQ(result.film.count(p), plain.film.count(p));
      ASSERT_EQ(result.mean(p), plain.mean(p)) << spp;
    }
  }
}

// Whatever the random numbers, a cell has the samples of its strata: as many as its neighbours, or one row of them
// more.
TEST(Cells, EachHasItsShareOfTheSamples) {
  struct Case {
    const char* strategy;
    Cells cells;
    std::vector<uint32_t> across, down;  // strata of each of a pixel's cells
  };
  for (const Case& c :
       {Case{"cells:spp=16", {3, 1}, {5, 6, 5}, {1}}, Case{"cells:spp=64", {3, 1}, {21, 22, 21}, {1}},
        Case{"cells:spp=16", {1, 3}, {1}, {5, 6, 5}}, Case{"cells:spp=16", {4, 1}, {4, 4, 4, 4}, {1}},
        Case{"cells:spp=16", {2, 2}, {2, 2}, {2, 2}}, Case{"cells:spp=32", {4, 2}, {2, 2, 2, 2}, {2, 2}},
        Case{"cells:spp=64", {6, 6}, {1, 2, 1, 1, 2, 1}, {1, 2, 1, 1, 2, 1}},
        Case{"cells:spp=9,points=jitter", {2, 2}, {2, 1}, {2, 1}},
        Case{"cells:spp=16,points=jitter", {3, 1}, {1, 2, 1}, {4}}}) {
    const RampSource flat(5 * c.cells.x, 4 * c.cells.y, kWhite, kBlack, kBlack);
    for (const uint64_t seed : {0, 1, 2}) {
      const RenderResult result = render(c.strategy, flat, c.cells, seed);
      EXPECT_TRUE(result.colour.empty());
      for (int y = 0; y < 4 * c.cells.y; ++y)
        for (int x = 0; x < 5 * c.cells.x; ++x)
          ASSERT_EQ(result.film.count(result.film.pixel(x, y)),
                    c.across[static_cast<size_t>(x % c.cells.x)] * c.down[static_cast<size_t>(y % c.cells.y)])
              << c.strategy << " " << c.cells.x << "x" << c.cells.y << " at " << x << "," << y;
    }
  }
}

TEST(Cells, SamplesCountInTheCellThatTheyLieInAndCarryTheKeyOfTheirPixel) {
  constexpr int kWidth = 7, kHeight = 5;
  for (const Cells cells : {Cells{3, 1}, Cells{2, 2}, Cells{6, 6}, Cells{16, 16}})
    for (const char* text : {"cells:spp=37", "cells:spp=36,points=jitter", "cells:spp=16,points=random"}) {
      std::mutex mutex;
      std::set<std::tuple<int, int, uint32_t>> keys;
      const FunctionSource source(kWidth * cells.x, kHeight * cells.y, [&](const SampleRequest& r) {
        const std::lock_guard lock(mutex);
        EXPECT_TRUE(keys.insert({r.pixel_x, r.pixel_y, r.index}).second);
        EXPECT_EQ(std::floor(r.x / cells.x), r.pixel_x);
        EXPECT_EQ(std::floor(r.y / cells.y), r.pixel_y);
        return grey(std::floor(r.x) + 1000 * std::floor(r.y));
      });
      const RenderResult result = render(text, source, cells);
      for (int y = 0; y < kHeight * cells.y; ++y)
        for (int x = 0; x < kWidth * cells.x; ++x) {
          const size_t p = result.film.pixel(x, y);
          if (result.film.count(p) == 0) continue;
          ASSERT_EQ(result.mean(p)[0], x + 1000 * y) << text;
        }
    }
}

TEST(Cells, MeanOverSeedsIsTheIntegral) {
  // z-test for each cell that the edge crosses, its variance taken from the seeds themselves.
  const Cells cells{3, 2};
  const HalfPlaneSource source = edge(7, 6, cells);
  constexpr int kSeeds = 400;
  for (const char* text : {"cells:spp=16", "cells:spp=25,points=jitter"}) {
    std::vector<double> sum(size_t{7 * 6 * 6}), squares(sum.size());
    for (uint64_t seed = 0; seed < kSeeds; ++seed) {
      const RenderResult result = render(text, source, cells, seed);
      for (size_t p = 0; p < sum.size(); ++p) {
        const double value = result.mean(p)[0];
        sum[p] += value;
        squares[p] += value * value;
      }
    }
    int crossed = 0;
    double chi2 = 0;
    for (int y = 0; y < source.height(); ++y)
      for (int x = 0; x < source.width(); ++x) {
        const auto p = static_cast<size_t>(y * source.width() + x);
        const double exact = source.integral(x, y, x + 1, y + 1)->at(0), mean = sum[p] / kSeeds;
        if (exact < .05 || exact > .95) {
          EXPECT_NEAR(mean, exact, .04) << x << "," << y;
          continue;
        }
        ++crossed;
        const double z = (mean - exact) / std::sqrt((squares[p] - sum[p] * mean) / (kSeeds - 1) / kSeeds);
        EXPECT_LT(std::abs(z), 4.5) << text << " at " << x << "," << y;
        chi2 += z * z;
      }
    EXPECT_GT(crossed, 15);
    EXPECT_NEAR(chi2, crossed, 4 * std::sqrt(2. * crossed)) << text;
  }
}

TEST(Cells, EmptyCellsTakeTheNearestOnes) {
  // Four samples in 36 cells: 89% have none. Light that grows by 1 from cell to cell stays near the truth, and is not
  // shifted: on the torus of a pixel no direction is preferred.
  const FunctionSource source(60 * 6, 40 * 6, [](const SampleRequest& r) { return grey(std::floor(r.x)); });
  const RenderResult result = render("cells:spp=4,points=random", source, {6, 6});
  double shift = 0, squares = 0;
  int cells = 0;
  for (int y = 12; y < 38 * 6; ++y)
    for (int x = 12; x < 58 * 6; ++x, ++cells) {
      const double error = result.mean(result.film.pixel(x, y))[0] - x;
      ASSERT_LE(std::abs(error), 12);
      shift += error;
      squares += error * error;
    }
  EXPECT_NEAR(shift / cells, 0, .02);
  EXPECT_LT(std::sqrt(squares / cells), 2);
}

TEST(Cells, ErrorsOnAnEdgeFallWithTheSamples) {
  const Cells cells{3, 1};
  const HalfPlaneSource source = edge(60, 60, cells);
  const auto error = [&](const std::string& points, int spp) {
    return rmse(render("cells:points=" + points + ",spp=" + std::to_string(spp), source, cells), source);
  };
  // Independent points: N^-1/2. Boxes: N^-3/4 along edges that lie at random in them.
  const double random = error("random", 64) / error("random", 1024);
  EXPECT_NEAR(random, 4, .5);
  for (const char* points : {"sobol", "jitter"}) {
    EXPECT_GT(error(points, 64) / error(points, 1024), 6) << points;
    EXPECT_LT(error(points, 64), .6 * error("random", 64)) << points;
  }
}

TEST(Cells, InvalidSamplesPoisonNobody) {
  const Cells cells{3, 1};
  const auto value = [](const SampleRequest& r) { return grey(r.y < 3 ? .25 : .5); };
  const FunctionSource whole(45, 9, value), holes(45, 9, [&](const SampleRequest&r) {
    Sample sample = value(r);
    sample.valid = !(r.x >= 12 && r.x < 15 && r.y >= 4 && r.y < 5) && !(r.x >= 30 && r.x < 31);
    if (r.y < 1) sample.rgb[2] = NAN;
    return sample;
  });
  for (const char* text : {"cells", "cells:spp=25,points=jitter", "cells:points=random"}) {
    const RenderResult expected = render(text, whole, cells), result = render(text, holes, cells);
    EXPECT_GT(result.dropped, expected.samples / 9);
    EXPECT_EQ(result.dropped_x, 0);
    EXPECT_EQ(result.dropped_y, 0);
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 45; ++x) {
        const size_t p = result.film.pixel(x, y);
        // A lost cell takes what is about it, which has the same light.
        for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(result.mean(p)[c], expected.mean(p)[c], 1e-14);
      }
  }
  const FunctionSource nothing(12, 4, [](const SampleRequest&) {
    Sample sample;
    sample.valid = false;
    return sample;
  });
  for (const Colour& colour : render("cells", nothing, cells).colour) EXPECT_EQ(colour, Colour{});
}

// Colours that differ by many orders of magnitude, some of them not valid.
Sample wild(const SampleRequest& r) {
  const SampleRandom random(r.pixel_x, r.pixel_y, r.index, r.seed);
  Sample sample;
  for (uint32_t c = 0; c < 3; ++c) sample.rgb[c] = std::exp(20 * random.uniform(20 + c));
  sample.valid = random.uniform(63) < .9f;
  if (random.uniform(64) < .02f) sample.rgb[1] = INFINITY;
  sample.distance = random.uniform(65);
  sample.object_id = r.index + 1;
  return sample;
}

// Each cell beside the sums of what fell into it, over every way that samples go: alone and with others of their
// cell, in few cells and many, into films of means, of sums, of halves and of more planes.
TEST(Cells, MeansAndCountsAreThoseOfTheSamples) {
  constexpr int kWidth = 9, kHeight = 5;
  for (const Cells cells :
       {Cells{1, 1}, Cells{2, 1}, Cells{3, 1}, Cells{1, 3}, Cells{2, 2}, Cells{6, 6}, Cells{16, 8}})
    for (const char* text : {"cells:spp=1", "cells:spp=4", "cells:spp=16", "cells:spp=37", "cells:spp=200",
                             "cells:spp=12,points=jitter", "cells:spp=16,points=random"})
      for (const char* planes : {"", "error", "depth,object-id"}) {
        struct Sum {
          long double rgb[3] = {}, half[3] = {}, depth = 0;
          uint32_t count = 0, in_half = 0, left_out = 0, first = UINT32_MAX;
        };
        std::vector<Sum> sums(static_cast<size_t>(kWidth * cells.x * kHeight * cells.y));
        std::mutex mutex;
        const FunctionSource source(kWidth * cells.x, kHeight * cells.y, [&](const SampleRequest& r) {
          const Sample sample = wild(r);
          const std::lock_guard lock(mutex);
          Sum& sum = sums[static_cast<size_t>(static_cast<int>(r.y) * kWidth * cells.x + static_cast<int>(r.x))];
          if (!sample.valid || !std::isfinite(sample.rgb[1])) {
            ++sum.left_out;
            return sample;
          }
          ++sum.count;
          sum.in_half += sobol_half(r.index);
          for (size_t c = 0; c < 3; ++c) {
            sum.rgb[c] += sample.rgb[c];
            if (sobol_half(r.index)) sum.half[c] += sample.rgb[c];
          }
          sum.depth += sample.distance;
          sum.first = std::min(sum.first, r.index + 1);
          return sample;
        });
        RenderOptions options;
        options.cells = cells;
        options.planes.error = planes == std::string("error");
        if (!options.planes.error) options.planes = parse_planes(planes, "");
        const RenderResult result = make_strategy(text, "")->render(source, options);
        const Film& film = result.film;
        const Image image = film.image();
        const size_t channels = image.spec.channels.size();
        uint64_t left_out = 0;
        for (size_t p = 0; p < sums.size(); ++p) {
          const Sum& sum = sums[p];
          left_out += sum.left_out;
          ASSERT_EQ(film.count(p), sum.count) << text << " " << planes;
          ASSERT_EQ(film.left_out(p), sum.left_out) << text << " " << planes;
          for (size_t c = 0; c < 3; ++c) {
            const auto mean = static_cast<double>(sum.rgb[c] / std::max(1u, sum.count));
            // Few samples are rounded to float once, as the picture is.
            ASSERT_NEAR(film.mean(p)[c], mean, mean * (film.keeps_means() ? 0x1.001p-24 : 1e-14))
                << text << " " << planes;
            if (film.planes().error) {
              const auto half = static_cast<double>(sum.half[c] / std::max(1u, sum.in_half));
              ASSERT_EQ(film.half_count(p), sum.in_half);
              ASSERT_NEAR(film.half_mean(p)[c], half, half * 1e-14);
            }
          }
          if (options.planes.depth && sum.count > 0) {
            ASSERT_NEAR(image.pixels[channels * p + 3], static_cast<double>(sum.depth / sum.count), 1e-6);
            ASSERT_EQ(image.pixels[channels * p + 4], static_cast<float>(sum.first));
          }
        }
        EXPECT_EQ(result.dropped, left_out);
      }
}

// Whole sixteens of samples may be placed by hand for the machine's widest vectors, fifteen are not.
TEST(Cells, PointsArePlacedTheSameInBatchesOfAnySize) {
  for (const uint32_t spp : {16u, 48u, 64u})
    for (const Cells cells : {Cells{1, 1}, Cells{3, 1}, Cells{1, 3}, Cells{2, 2}, Cells{6, 6}, Cells{16, 1}}) {
      const PixelPoints points(PixelPoints::Kind::kSobol, spp);
      const CellPoints in_cells(points, cells);
      CellBatch whole(in_cells, spp - 16, spp, .25f, 7), part(in_cells, spp - 16, spp - 1, .25f, 7);
      while (whole.room() > 0 && part.room() > 0)
        for (CellBatch* each : {&whole, &part}) each->add(3 + static_cast<int>(each->pixels()) * 1001, 70'000);
      whole.place();
      part.place();
      for (size_t k = 0; k < part.pixels(); ++k)
        for (size_t i = 0; i < 15; ++i) {
          const SampleRequest &a = whole.requests()[16 * k + i], &b = part.requests()[15 * k + i];
          ASSERT_EQ(a.x, b.x);
          ASSERT_EQ(a.y, b.y);
          ASSERT_EQ(std::tie(a.pixel_x, a.pixel_y, a.index), std::tie(b.pixel_x, b.pixel_y, b.index));
          ASSERT_EQ(whole.cells()[16 * k + i], part.cells()[15 * k + i]);
          const int column = static_cast<int>(std::floor(a.x)) - a.pixel_x * cells.x;
          ASSERT_EQ(static_cast<int>(part.cells()[15 * k + i]) % cells.x, column);
        }
    }
}

TEST(Cells, SameBitsForAnyThreadsAndTiles) {
  const FunctionSource source(45, 34, wild);
  for (const auto& [text, cells, error] :
       {std::tuple{"cells:spp=24", Cells{3, 2}, true}, std::tuple{"cells:spp=24", Cells{3, 1}, false},
        std::tuple{"cells:spp=16", Cells{3, 2}, false}, std::tuple{"cells:spp=16", Cells{3, 1}, false},
        std::tuple{"cells:spp=5", Cells{3, 2}, true}, std::tuple{"cells:spp=40", Cells{15, 2}, false},
        std::tuple{"cells:spp=36,points=jitter", Cells{3, 2}, true},
        std::tuple{"cells:spp=3,points=random", Cells{3, 2}, true},
        std::tuple{"cells:spp=64,threshold=1e7,least=4", Cells{3, 2}, true}}) {
    std::optional<RenderResult> first;
    // Whether the first 16 samples are taken together changes nothing, and whether only some of them are.
    for (const auto& [threads, soon_s] : {std::pair{1, 1e9}, std::pair{1, 0.}, std::pair{2, 1e9}, std::pair{7, 3e-4}})
      for (const int tile : {1, 5, 32, 1000}) {
        set_thread_limit(threads);
        RenderOptions options;
        options.tile_px = tile;
        options.cells = cells;
        options.soon_s = soon_s;
        options.planes.error = error;
        RenderResult result = make_strategy(text, "")->render(source, options);
        set_thread_limit(0);
        if (!first) {
          first = std::move(result);
          continue;
        }
        ASSERT_EQ(result.colour, first->colour) << text << ", " << threads << " threads, tiles of " << tile;
        for (size_t p = 0; p < result.film.pixels(); ++p)
          ASSERT_EQ(result.mean(p), first->mean(p)) << text << ", " << threads << " threads, tiles of " << tile;
        ASSERT_EQ(result.dropped, first->dropped);
        // Bits: with jitter nothing is estimated.
        ASSERT_EQ(std::bit_cast<uint64_t>(result.passes.back().rmse),
                  std::bit_cast<uint64_t>(first->passes.back().rmse));
      }
  }
}

// The mean of the samples in the smallest window with any, looked for cell by cell.
Colour around(const Film& film, const Cells& cells, int x, int y) {
  const int side = std::max(cells.x, cells.y);
  for (int reach = 0; reach <= 2 * side; ++reach) {
    double n = 0;
    Colour sum{};
    for (int v = y - reach * cells.y / side; v <= y + reach * cells.y / side; ++v)
      for (int u = x - reach * cells.x / side; u <= x + reach * cells.x / side; ++u) {
        if (u < 0 || v < 0 || u >= film.width() || v >= film.height()) continue;
        const size_t p = film.pixel(u, v);
        n += film.count(p);
        for (size_t c = 0; c < 3; ++c) sum[c] += film.count(p) * film.mean(p)[c];
      }
    if (n > 0) return {sum[0] / n, sum[1] / n, sum[2] / n};
  }
  return {};
}

TEST(Cells, EmptyOnesAreFilledFromTheSmallestWindow) {
  for (const Cells cells : {Cells{3, 1}, Cells{1, 3}, Cells{2, 2}, Cells{4, 2}, Cells{6, 6}}) {
    const int width = 11 * cells.x, height = 9 * cells.y;
    // One pixel in three, and nothing at all in a corner of more than two pixels.
    const FunctionSource source(width, height, [&](const SampleRequest& r) {
      const SampleRandom random(r.pixel_x, r.pixel_y, r.index, r.seed);
      Sample sample = grey(random.uniform(70));
      sample.valid = (r.x > 6 * cells.x || r.y > 5 * cells.y) && (r.pixel_x + r.pixel_y) % 3 == 0;
      return sample;
    });
    for (const char* text : {"cells:spp=1", "cells:spp=5,points=random"}) {
      const RenderResult result = render(text, source, cells);
      int filled = 0, left_black = 0;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const size_t p = result.film.pixel(x, y);
          const Colour expected = around(result.film, cells, x, y);
          for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(result.mean(p)[c], expected[c], 1e-14) << text;
          filled += result.film.count(p) == 0 && expected != Colour{};
          left_black += expected == Colour{};
        }
      EXPECT_GT(filled, 20);
      EXPECT_GT(left_black, 3);
    }
  }
}

TEST(Cells, EstimatesTheErrorOfTheCellsThatItWrites) {
  // Noise of variance 1/12 in each sample: of 64 in a pixel, 21, 22 and 21 are in its cells. Over 3 x 3600 values,
  // the root of the estimate is known to .7%.
  const auto source = test::noise(120, 30, .5, 1);
  RenderOptions options;
  options.cells = {3, 1};
  options.planes.error = true;
  const double expected = std::sqrt((2. / 21 + 1. / 22) / 3 / 12);
  const RenderResult fixed = make_strategy("cells:spp=64", "")->render(source, options);
  EXPECT_NEAR(fixed.passes.back().rmse, expected, .04 * expected);
  double squares = 0;
  for (size_t p = 0; p < fixed.film.pixels(); ++p)
    for (const double value : fixed.mean(p)) squares += (value - .5) * (value - .5) / 3;
  EXPECT_NEAR(fixed.passes.back().rmse, std::sqrt(squares / static_cast<double>(fixed.film.pixels())),
              .05 * expected);
  // Of cells with a sample or none it knows nothing.
  EXPECT_TRUE(std::isinf(make_strategy("cells:spp=3", "")->render(source, options).passes.back().rmse));
  options.until_rmse = 1.04 * expected;
  const RenderResult until = make_strategy("cells:spp=4096", "")->render(source, options);
  EXPECT_TRUE(until.reached);
  EXPECT_LE(until.samples, 128u * 1200);
  EXPECT_GE(until.samples, 64u * 1200);
}

TEST(Cells, WithAThresholdSamplesGoWhereNoiseIsSeen) {
  const Cells cells{3, 1};
  // Nothing to be unsure of: the first samples are all. Noise that never falls below the threshold: spp.
  const RampSource flat(40 * 3, 30, {.3f, .5f, .7f}, kBlack, kBlack);
  EXPECT_EQ(render("cells:spp=256,threshold=.001,least=4", flat, cells).samples, 4u * 40 * 30);
  EXPECT_EQ(render("cells:spp=64,threshold=1e-9,least=4", test::noise(40 * 3, 30, .5, 1), cells).samples,
            64u * 40 * 30);
  // An edge: pixels go on if it crosses them or a neighbour, which is to say within 2.1 of it.
  const HalfPlaneSource source = edge(60, 60, cells);
  const RenderResult result = render("cells:spp=256,threshold=.002,least=8", source, cells);
  int crossed = 0, all_the_way = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x) {
      const double distance = std::abs(.6 * (x + .5) + .8 * (y + .5) - .55 * 60);
      uint32_t n = 0;
      for (int u = 0; u < 3; ++u) n += result.film.count(result.film.pixel(3 * x + u, y));
      ASSERT_TRUE(n == 8 || n == 16 || n == 32 || n == 64 || n == 128 || n == 256) << n;
      if (distance > 2.5) {
        ASSERT_EQ(n, 8u) << x << "," << y;
      }
      if (distance < .3) {
        ++crossed;
        all_the_way += n == 256;
      }
    }
  EXPECT_GT(crossed, 30);
  EXPECT_GT(all_the_way, .8 * crossed);
  // And are worth more there than everywhere.
  EXPECT_LT(result.samples, 40u * 60 * 60);
  EXPECT_LT(rmse(result, source), .5 * rmse(render("cells:spp=40", source, cells), source));
  // Further out, an eye sees less of the same noise, and fewer go on.
  const RenderResult near = render("cells:spp=256,threshold=.02,least=8,ppd=20", source, cells);
  const RenderResult far = render("cells:spp=256,threshold=.02,least=8,ppd=150", source, cells);
  EXPECT_LT(10 * far.samples, 9 * near.samples);
}

TEST(Cells, AnEndedRenderIsWhole) {
  const RampSource flat(96, 64, {.5f, .5f, .5f}, kBlack, kBlack);
  RenderOptions options;
  options.cells = {3, 1};
  std::atomic<int> done = 0;
  options.progress = [&](double share) { done = static_cast<int>(share * 1000); };
  options.stop = [&] { return done > 100; };
  const RenderResult result = make_strategy("cells:spp=1024", "")->render(flat, options);
  EXPECT_FALSE(result.complete);
  EXPECT_LT(result.samples, 1024u * 32 * 64);
  for (size_t p = 0; p < result.film.pixels(); ++p) ASSERT_EQ(result.mean(p), (Colour{.5, .5, .5}));
}

TEST(Cells, RefusesWhatDoesNotFit) {
  const RampSource flat(100, 10, kWhite, kBlack, kBlack);
  EXPECT_THAT(refusal([&] { render("cells", flat, {3, 1}); }), HasSubstr("100x10 has none of 3x1 cells"));
  EXPECT_THAT(refusal([&] { render("cells", flat, {1, 3}); }), HasSubstr("100x10 has none of 1x3 cells"));
  EXPECT_THAT(refusal([] { make_strategy("cells:points=jitter,threshold=.1", "--strategy"); }),
              HasSubstr("take points=sobol or random"));
  EXPECT_THAT(refusal([] { make_strategy("cells:spp=4,threshold=1", "--strategy"); }),
              HasSubstr("least=8 is above spp=4"));
}
