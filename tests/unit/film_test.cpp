// SPDX-License-Identifier: Apache-2.0
// Films of few samples beside those of many, however a batch is told; and requests that are said by rows.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <triad/base/error.hpp>
#include <triad/base/random.hpp>
#include <triad/numeric/zero_pages.hpp>
#include <triad/sampling/film.hpp>
#include <triad/sampling/point_strategy.hpp>
#include <triad/sampling/sobol.hpp>

#include "sampling_sources.hpp"

using namespace triad;

namespace {

constexpr int kWidth = 23, kHeight = 5;

// Numbers of all sizes that cancel in part, and now and then one that cannot be kept.
Sample wild(int x, int y, uint32_t index, float lost) {
  const SampleRandom random(x, y, index, 5);
  const float large = index % 3 != 1 ? 1 : index % 6 > 1 ? -1e20f : 1e20f;
  Sample sample;
  sample.rgb = {random.uniform(20), random.uniform(21) * large, -random.uniform(22) * 0x1p31f};
  if (random.uniform(23) < .05f) sample.rgb = {-0.f, 0, 1e-40f};
  if (random.uniform(24) < lost) sample.valid = false;
  if (random.uniform(25) < lost) sample.rgb[random.u32(26) % 3] = random.uniform(27) < .5f ? NAN : -INFINITY;
  return sample;
}

struct Batch {
  std::vector<SampleRequest> requests;
  std::vector<Sample> samples;
  std::vector<FilmRow> rows;
};

// Samples first .. past - 1 of every pixel, a row of the film in two pieces.
Batch batch_of(const Film& film, uint32_t first, uint32_t past, float lost) {
  Batch batch;
  for (int y = 0; y < kHeight; ++y) {
    batch.rows.push_back({film.pixel(0, y), 7});
    batch.rows.push_back({film.pixel(7, y), kWidth - 7});
    for (int x = 0; x < kWidth; ++x)
      for (uint32_t index = first; index < past; ++index) {
        batch.requests.push_back({.pixel_x = x, .pixel_y = y, .index = index});
        batch.samples.push_back(wild(x, y, index, lost));
      }
  }
  return batch;
}

Film film_for_cpu(const char* cpu, Film::Holds holds) {
  setenv("TRIAD_CPU", cpu, 1);
  Film film(kWidth, kHeight, {}, holds);
  unsetenv("TRIAD_CPU");
  return film;
}

// Returns what was left out.
std::vector<size_t> add(Film& film, uint32_t first, uint32_t past, float lost, bool tell) {
  const Batch batch = batch_of(film, first, past, lost);
  return film.add(batch.requests, batch.samples, tell ? FilmRows{past - first, batch.rows} : FilmRows{});
}

void expect_same_picture(const Film& film, const Film& many) {
  const Image got = film.image(), expected = many.image();
  ASSERT_EQ(std::memcmp(got.pixels.data(), expected.pixels.data(), got.pixels.size() * sizeof(float)), 0);
  for (size_t p = 0; p < film.pixels(); ++p) {
    ASSERT_EQ(film.count(p), many.count(p));
    ASSERT_EQ(film.left_out(p), many.left_out(p));
  }
}

}  // namespace

TEST(FilmOfFew, IsTheFilmOfManyBitForBit) {
  for (const char* cpu : {"avx512", "avx2", "baseline"}) {
    if (!cpu_can_run(cpu[0] == 'b' ? CpuPath::kBaseline : cpu[3] == '2' ? CpuPath::kAvx2 : CpuPath::kAvx512))
      continue;
    for (uint32_t spp = 1; spp <= Film::kMostFew; ++spp)
      for (const float lost : {0.f, .03f, .6f})
        for (const bool tell : {false, true})
          for (const bool first_alone : {false, true}) {
            SCOPED_TRACE(testing::Message() << cpu << ", " << spp << ", " << lost << ", " << tell << first_alone);
            Film few = film_for_cpu(cpu, Film::Holds::kFew), many = film_for_cpu(cpu, Film::Holds::kMany);
            for (Film* film : {&few, &many}) film->expect(film->pixel(3, 2), kWidth);  // a hint, no more
            if (first_alone && spp > 1) {
              EXPECT_EQ(add(few, 0, 1, lost, tell), add(many, 0, 1, lost, false));
              EXPECT_EQ(add(few, 1, spp, lost, tell), add(many, 1, spp, lost, false));
            } else {
              EXPECT_EQ(add(few, 0, spp, lost, tell), add(many, 0, spp, lost, false));
            }
            expect_same_picture(few, many);
          }
  }
}

TEST(FilmOfFew, HasRoomForSixteen) {
  Film film(kWidth, kHeight, {}, Film::Holds::kFew);
  add(film, 0, 16, 0, true);
  EXPECT_THROW(add(film, 16, 17, 0, true), Error);
  EXPECT_THROW(film.add(0, 16, Sample{}), Error);
}

TEST(FilmOfOneEach, IsTheFilmOfManyBitForBit) {
  for (const float lost : {0.f, .1f, 1.f})
    for (const bool tell : {false, true}) {
      Film one(kWidth, kHeight, {}, Film::Holds::kOneEach), alone(kWidth, kHeight, {}, Film::Holds::kOneEach);
      Film many(kWidth, kHeight, {});
      EXPECT_EQ(add(one, 0, 1, lost, tell), add(many, 0, 1, lost, false));
      expect_same_picture(one, many);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const size_t p = alone.pixel(x, y);
          EXPECT_EQ(alone.count(p) + alone.left_out(p), 0u);
          EXPECT_EQ(alone.mean(p)[0], 0);
          EXPECT_EQ(alone.add(p, 0, wild(x, y, 0, lost)), many.count(p) == 1);
        }
      expect_same_picture(alone, many);
      EXPECT_THROW(add(one, 1, 2, 0, tell), Error);
      EXPECT_THROW(one.add(0, 1, Sample{}), Error);
    }
}

TEST(FilmOfSome, IsTheFilmOfManyToItsBound) {
  Film some(kWidth, kHeight, {}, Film::Holds::kSome), many(kWidth, kHeight, {});
  EXPECT_EQ(add(some, 0, 200, .01f, false), add(many, 0, 200, .01f, false));
  for (size_t p = 0; p < some.pixels(); ++p) {
    ASSERT_EQ(some.count(p), many.count(p));
    ASSERT_EQ(some.left_out(p), many.left_out(p));
    double magnitudes[3] = {};
    for (uint32_t i = 0; i < 200; ++i) {
      const Sample sample = wild(static_cast<int>(p) % kWidth, static_cast<int>(p) / kWidth, i, .01f);
      if (sample.valid && std::isfinite(sample.rgb[0] + sample.rgb[1] + sample.rgb[2]))
        for (size_t c = 0; c < 3; ++c) magnitudes[c] += std::abs(sample.rgb[c]);
    }
    for (size_t c = 0; c < 3; ++c)
      ASSERT_NEAR(some.mean(p)[c], many.mean(p)[c], magnitudes[c] / some.count(p) * 0x1p-45);
  }
  EXPECT_THROW(add(some, 200, 257, 0, false), Error);
}

TEST(Requests, AreSaidByTheFirstOfEachPixel) {
  for (const size_t each : {1, 2, 7, 16, 33}) {
    std::vector<SampleRequest> requests(5 * each), sobol;
    for (size_t p = 0; p < 5; ++p)
      for (size_t i = 0; i < each; ++i) {
        SampleRequest& request = requests[p * each + i];
        request.seed = 31;
        if (i > 0) continue;
        request.footprint_px = .25f;
        request.pixel_x = 3 - static_cast<int32_t>(p);
        request.pixel_y = static_cast<int32_t>(p * p);
        request.index = static_cast<uint32_t>(9 * p);
      }
    sobol = requests;
    say_all(requests, each);
    place_sobol_owen(sobol, each);
    for (size_t i = 0; i < requests.size(); ++i) {
      const auto p = static_cast<int32_t>(i / each);
      const auto index = static_cast<uint32_t>(9 * static_cast<size_t>(p) + i % each);
      const auto point = sobol_owen_point(index, SampleRandom::pixel_key(3 - p, p * p, 31));
      ASSERT_EQ(sobol[i].x, 3 - p + point[0] * 0x1p-32) << each << ", " << i;
      ASSERT_EQ(sobol[i].y, p * p + point[1] * 0x1p-32) << each << ", " << i;
      for (const SampleRequest& request : {requests[i], sobol[i]}) {
        ASSERT_EQ(request.footprint_px, .25f);
        ASSERT_EQ(request.pixel_x, 3 - p);
        ASSERT_EQ(request.pixel_y, p * p);
        ASSERT_EQ(request.index, index);
        ASSERT_EQ(request.seed, 31u);
      }
    }
  }
}

TEST(ZeroPages, AreZeroWheneverTheyAreTaken) {
  for (const size_t bytes : {size_t{1}, size_t{4096}, (size_t{2} << 20) - 1, size_t{2} << 20, (size_t{2} << 20) + 9,
                             (size_t{4} << 20) + 126'000, (size_t{7} << 20) + 1, size_t{30} << 20})
    for (int round = 0; round < 3; ++round) {
      std::vector<unsigned char*> pieces;
      for (int i = 0; i < 3; ++i) pieces.push_back(static_cast<unsigned char*>(take_zero_pages(bytes)));
      for (unsigned char* piece : pieces) {
        ASSERT_EQ(piece[0], 0) << bytes;
        ASSERT_EQ(std::memcmp(piece, piece + 1, bytes - 1), 0) << bytes;  // each is as the one before
        std::memset(piece, 0xa5, bytes);
      }
      for (unsigned char* piece : pieces) give_back_zero_pages(piece, bytes);
    }
}
