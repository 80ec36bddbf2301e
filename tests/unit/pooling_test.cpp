// SPDX-License-Identifier: Apache-2.0
// Pooling against sorting all values and adding them up in a wider type.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <random>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/numeric/pooling.hpp>

using namespace triad;

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr uint64_t kKeepAll = 1u << 30;

struct Map {
  int width = 0, height = 0, channels = 1;
  std::vector<float> values, weights;  // weights: of each pixel, or none
};

std::optional<Pooling::Result> pool(const Map& map, int rows_per_block, uint64_t keep_bytes = kKeepAll) {
  const bool weighted = !map.weights.empty();
  Pooling pooling(weighted, keep_bytes, map.values.size());
  const int blocks = (map.height + rows_per_block - 1) / rows_per_block;
  parallel_for(blocks, [&](int64_t b) {
    const int y0 = static_cast<int>(b) * rows_per_block, y1 = std::min(map.height, y0 + rows_per_block);
    auto block = pooling.take(static_cast<size_t>(y1 - y0) * map.width * map.channels);
    for (int y = y0; y < y1; ++y)
      block->add_row(&map.values[static_cast<size_t>(y) * map.width * map.channels],
                     weighted ? &map.weights[static_cast<size_t>(y) * map.width] : nullptr, map.width, map.channels,
                     0, y);
    pooling.add(std::move(block));
  });
  return pooling.finish();
}

// Everything by definition: sort, and add in long double with weights that are whole numbers of 1/65535.
Pooling::Result reference(const Map& map) {
  struct Item {
    float value;
    long double weight;
  };
  std::vector<Item> items;
  Pooling::Result result;
  for (size_t i = 0; i < map.values.size(); ++i) {
    const double share = map.weights.empty() ? 1.0 : map.weights[i / map.channels];
    const double weight = map.weights.empty() ? 1.0 : std::round(std::clamp(share, 0.0, 1.0) * 65535);
    if (weight == 0) continue;
    const int pixel = static_cast<int>(i) / map.channels;
    const Pooling::Place place{pixel % map.width, pixel / map.width, static_cast<int>(i) % map.channels};
    const double value = static_cast<double>(map.values[i]);
    if (items.empty() || value < result.min) {
      result.min = value;
      result.min_at = place;
    }
    if (items.empty() || value > result.max) {
      result.max = value;
      result.max_at = place;
    }
    items.push_back({map.values[i], static_cast<long double>(weight)});
  }
  std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.value < b.value; });
  long double total = 0, sum = 0;
  for (const Item& item : items) {
    total += item.weight;
    sum += item.weight * static_cast<long double>(item.value);
  }
  result.values = items.size();
  result.weight = static_cast<double>(total / (map.weights.empty() ? 1 : 65535));
  result.mean = static_cast<double>(sum / total);
  if (result.min >= 0) result.weighted.emplace();
  for (size_t p = 0; p < kPooledPercents.size(); ++p) {
    long double running = 0, running_sum = 0;
    bool by_weight = false, by_sum = false;
    for (const Item& item : items) {
      running += item.weight;
      running_sum += item.weight * static_cast<long double>(item.value);
      if (!by_weight && running * 100 >= total * kPooledPercents[p]) {
        result.percentiles[p] = static_cast<double>(item.value);
        by_weight = true;
      }
      if (result.weighted && !by_sum && running_sum * 100 >= sum * kPooledPercents[p]) {
        (*result.weighted)[p] = static_cast<double>(item.value);
        by_sum = true;
      }
    }
  }
  return result;
}

void expect_same(const Pooling::Result& a, const Pooling::Result& b) {
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(a.weight, b.weight);
  EXPECT_EQ(a.mean, b.mean);
  EXPECT_EQ(a.percentiles, b.percentiles);
  EXPECT_EQ(a.weighted, b.weighted);
  EXPECT_EQ(a.histogram, b.histogram);
  EXPECT_TRUE(a.min_at == b.min_at && a.max_at == b.max_at);
}

void expect_as_reference(const Map& map) {
  const auto found = pool(map, 3);
  ASSERT_TRUE(found);
  const Pooling::Result wanted = reference(map);
  EXPECT_EQ(found->values, wanted.values);
  EXPECT_DOUBLE_EQ(found->weight, wanted.weight);
  EXPECT_NEAR(found->mean, wanted.mean, 1e-12 * std::abs(wanted.mean));
  EXPECT_EQ(found->min, wanted.min);
  EXPECT_EQ(found->max, wanted.max);
  EXPECT_TRUE(found->min_at == wanted.min_at);
  EXPECT_TRUE(found->max_at == wanted.max_at);
  EXPECT_EQ(found->percentiles, wanted.percentiles);
  EXPECT_EQ(found->weighted, wanted.weighted);
  // The histogram: each value within rounding of its bin.
  EXPECT_EQ(found->low, std::min(0.0, wanted.min));
  EXPECT_EQ(found->high, std::max(0.0, wanted.max));
  const double width = (found->high - found->low) / kPooledHistogramBins;
  double running = 0;
  for (int bin = 0; bin + 1 < kPooledHistogramBins && width > 0; ++bin) {
    running += found->histogram[static_cast<size_t>(bin)];
    const double border = found->low + (bin + 1) * width;
    double least = 0, most = 0;
    for (size_t i = 0; i < map.values.size(); ++i) {
      const double weight =
          map.weights.empty() ? 1 : std::round(static_cast<double>(map.weights[i / map.channels]) * 65535) / 65535;
      const double value = static_cast<double>(map.values[i]), slack = 1e-12 * (found->high - found->low);
      if (value < border - slack) least += weight;
      if (value < border + slack) most += weight;
    }
    EXPECT_GE(running, least - 1e-9);
    EXPECT_LE(running, most + 1e-9);
  }
  double all = 0;
  for (const double count : found->histogram) all += count;
  EXPECT_NEAR(all, wanted.weight, 1e-9 * wanted.weight);
  // In other strips, on one thread, and from a file: the same bits.
  expect_same(*pool(map, 1), *found);
  expect_same(*pool(map, map.height, 0), *found);
  expect_same(*pool(map, 2, 1000), *found);
}

Map random_map(int width, int height, int channels, unsigned seed, float (*shape)(float)) {
  Map map{width, height, channels, {}, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int i = 0; i < width * height * channels; ++i) map.values.push_back(shape(uniform(random)));
  return map;
}

}  // namespace

TEST(Pooling, FloatsKeepTheirOrderAsKeys) {
  const float ordered[] = {-kInfinity, -3e38f, -1.5f, -1,         -1e-40f, 0,
                           1e-45f,     1e-38f, 1,     1.0000001f, 3e38f,   kInfinity};
  for (size_t i = 0; i < std::size(ordered); ++i) {
    EXPECT_EQ(key_float(float_key(ordered[i])), ordered[i]);
    if (i > 0) {
      EXPECT_LT(float_key(ordered[i - 1]), float_key(ordered[i]));
    }
  }
  EXPECT_EQ(float_key(-0.0f), float_key(0.0f));
  EXPECT_EQ(float_key(-kInfinity), kLeastKey);
  EXPECT_EQ(float_key(kInfinity), kLargestKey);
  EXPECT_GT(float_key(std::nanf("")), kLargestKey);
  EXPECT_LT(float_key(-std::nanf("")), kLeastKey);
}

TEST(Pooling, AgreesWithSorting) {
  expect_as_reference(random_map(101, 37, 1, 1, [](float u) { return u; }));
  expect_as_reference(random_map(33, 21, 3, 2, [](float u) { return u * u * u * u; }));
  // As SSIM has it: near 1, now and then negative.
  expect_as_reference(random_map(64, 65, 1, 3, [](float u) { return 1 - 1.3f * u * u * u; }));
  expect_as_reference(random_map(53, 20, 1, 4, [](float u) { return -u; }));
  // Few different values, so that percentiles fall among equals.
  expect_as_reference(random_map(50, 40, 1, 5, [](float u) { return std::floor(u * 4) / 4; }));
  // From the smallest float to the largest.
  expect_as_reference(random_map(77, 51, 1, 6, [](float u) { return std::exp2(u * 277 - 149); }));
  // All within one bin of the first look, which then says nothing.
  expect_as_reference(random_map(91, 43, 1, 7, [](float u) { return 1 + u / 256; }));
}

TEST(Pooling, OfFewValues) {
  expect_as_reference({1, 1, 1, {.25f}, {}});
  expect_as_reference({1, 1, 3, {3, -1, 2}, {}});
  expect_as_reference({3, 1, 1, {-2, -2, -2}, {}});
  expect_as_reference({5, 4, 1, {20, 19, 18, 17, 16, 15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1}, {}});
  const auto twenty = pool({5, 4, 1, {20, 19, 18, 17, 16, 15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1}, {}}, 1);
  // Of 20 values one is 5 %, five 25 % and so on; their sum is 210, of which 55 = 1 + ... + 10 is more than 25 %.
  EXPECT_THAT(twenty->percentiles, testing::ElementsAre(1, 5, 10, 15, 19, 20));
  EXPECT_THAT(*twenty->weighted, testing::ElementsAre(5, 10, 14, 18, 20, 20));
}

TEST(Pooling, OfNothingButZeros) {
  const auto found = pool({4, 2, 1, std::vector<float>{0, -0.0f, 0, 0, 0, 0, 0, 0}, {}}, 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->mean, 0);
  EXPECT_FALSE(std::signbit(found->min));
  EXPECT_THAT(found->percentiles, testing::Each(0));
  ASSERT_TRUE(found->weighted);
  EXPECT_THAT(*found->weighted, testing::Each(0));
  EXPECT_EQ(found->histogram[0], 8);
  EXPECT_TRUE((found->max_at == Pooling::Place{0, 0, 0}));
}

TEST(Pooling, WeightsCount) {
  Map map = random_map(45, 33, 3, 11, [](float u) { return u * u; });
  std::mt19937 random(12);
  std::uniform_real_distribution<float> uniform(-.5f, 1.5f);
  for (int i = 0; i < map.width * map.height; ++i) map.weights.push_back(std::clamp(uniform(random), 0.f, 1.f));
  expect_as_reference(map);
  // A pixel of weight 0 is not there, not even as the largest.
  EXPECT_EQ(pool({3, 1, 1, {9, 1, 2}, {0, .5f, 1}}, 1)->max, 2);
  EXPECT_EQ(pool({3, 1, 1, {9, 1, 2}, {0, .5f, 1}}, 1)->weight, 1 + 32768.0 / 65535);
  EXPECT_FALSE(pool({2, 1, 1, {1, 2}, {0, 0}}, 1));
  EXPECT_FALSE(pool({0, 0, 1, {}, {}}, 1));
}

TEST(Pooling, PlacesAreTheFirstInReadingOrder) {
  Map map{4, 40, 1, std::vector<float>(160, .5f), {}};
  map.values[3 * 4 + 2] = map.values[3 * 4 + 3] = map.values[20 * 4 + 0] = 1;
  map.values[5 * 4 + 1] = map.values[39 * 4 + 0] = 0;
  for (int rows : {1, 2, 7, 40}) {
    const auto found = pool(map, rows);
    EXPECT_TRUE((found->max_at == Pooling::Place{2, 3, 0}));
    EXPECT_TRUE((found->min_at == Pooling::Place{1, 5, 0}));
  }
}

TEST(Pooling, InfinitiesAreTheLargest) {
  Map map{10, 1, 1, {1, 2, 3, kInfinity, 5, 6, 7, 8, kInfinity, 10}, {}};
  const auto found = pool(map, 1);
  EXPECT_EQ(found->mean, static_cast<double>(kInfinity));
  EXPECT_EQ(found->max, static_cast<double>(kInfinity));
  EXPECT_EQ(found->max_at.x, 3);
  EXPECT_EQ(found->high, 10);
  EXPECT_EQ(found->histogram.back(), 3);
  EXPECT_THAT(found->percentiles,
              testing::ElementsAre(1, 3, 6, 10, static_cast<double>(kInfinity), static_cast<double>(kInfinity)));
  EXPECT_THAT(*found->weighted, testing::Each(static_cast<double>(kInfinity)));
  map.values[0] = -kInfinity;
  EXPECT_TRUE(std::isnan(pool(map, 1)->mean));
  EXPECT_EQ(pool(map, 1)->min, -static_cast<double>(kInfinity));
  EXPECT_EQ(pool({1, 1, 1, {kInfinity}, {}}, 1)->high, 0);
}

TEST(Pooling, ANotANumberIsFound) {
  for (const bool weighted : {false, true})
    for (const float nan : {std::nanf(""), -std::nanf("")}) {
      Pooling pooling(weighted, 0, 12);
      const auto block = pooling.take(12);
      const float values[] = {0, 1, 2, 3, 4, 5}, bad[] = {0, 1, 2, 3, nan, nan}, weights[] = {1, 1};
      block->add_row(values, weighted ? weights : nullptr, 2, 3, 7, 0);
      EXPECT_FALSE(block->nan_at());
      block->add_row(bad, weighted ? weights : nullptr, 2, 3, 7, 1);
      ASSERT_TRUE(block->nan_at());
      EXPECT_TRUE((*block->nan_at() == Pooling::Place{8, 1, 1}));
    }
}

TEST(Pooling, SumsAreExact) {
  // Terms that cancel over the whole range of floats, and what is left is a few of the smallest ones.
  std::vector<float> terms;
  std::mt19937 random(3);
  for (int i = 0; i < 5000; ++i) {
    const auto bits = static_cast<uint32_t>(random());
    const float value = key_float(float_key(std::bit_cast<float>(bits)));
    if (!std::isfinite(value)) continue;
    terms.push_back(value);
    terms.push_back(-value);
  }
  terms.insert(terms.end(), 12, 1e-45f);
  std::shuffle(terms.begin(), terms.end(), random);
  const Map map{static_cast<int>(terms.size()), 1, 1, terms, {}};
  EXPECT_EQ(pool(map, 1)->mean, 12 * static_cast<double>(1e-45f) / static_cast<double>(terms.size()));

  ExactSum sum;
  sum.add_float(std::bit_cast<uint32_t>(-1.0f), 3);
  EXPECT_EQ(sum.value(), -3);
  EXPECT_TRUE(sum.negative());
  sum.add_float(std::bit_cast<uint32_t>(1.0f), 3);
  EXPECT_TRUE(sum.zero());
  // Half way between two doubles: to the even one; a trace more: up.
  sum.add_float(std::bit_cast<uint32_t>(0x1p60f), 1);
  sum.add_float(std::bit_cast<uint32_t>(0x1p7f), 1);
  EXPECT_EQ(sum.value(), 0x1p60);
  sum.add_float(std::bit_cast<uint32_t>(0x1p-149f), 1);
  EXPECT_EQ(sum.value(), 0x1p60 + 0x1p8);
}

TEST(Pooling, ManyValuesOfOneBinAreCounted) {
  const std::vector<uint32_t> keys((size_t{1} << 24) + 5, float_key(.75f) + 3);
  FloatBins bins;
  bins.add(keys.data(), keys.size(), keys[0], keys[0]);
  FloatHistogram histogram;
  histogram.merge(bins);
  EXPECT_EQ(histogram.total(), keys.size());
}

TEST(Pooling, AMeanOfABillionValuesKeepsTwelveDigits) {
  // 1000 values, a million times over, the largest weight on each: as many as no test has the time to write down.
  FloatBins bins;
  long double mean = 0;
  std::mt19937 random(8);
  std::uniform_real_distribution<float> exponent(-30, 30);
  constexpr int kValues = 1000, kTimes = 1000;
  for (int i = 0; i < kValues; ++i) {
    const float value = std::exp2(exponent(random)) * (i % 3 ? 1.f : -1.f);
    for (int n = 0; n < 1000; ++n) bins.add(float_key(value), FloatBins::kMostWeight);
    mean += static_cast<long double>(value) / kValues;
  }
  FloatHistogram histogram;
  for (int n = 0; n < kTimes; ++n) histogram.merge(bins);
  EXPECT_EQ(histogram.total(), uint64_t{65535} * kValues * 1000 * kTimes);
  EXPECT_NEAR(histogram.mean(), static_cast<double>(mean), 1e-14 * std::abs(static_cast<double>(mean)));
}

TEST(Pooling, SaysWhereItsTemporarySpaceIsMissing) {
  const Map map = random_map(64, 64, 1, 9, [](float u) { return u; });
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before ? before : "";
  setenv("TMPDIR", "/no/such/folder", 1);
  try {
    pool(map, 1, 100);
    ADD_FAILURE() << "no folder, no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    EXPECT_THAT(error.what(), testing::HasSubstr("/no/such/folder"));
    EXPECT_THAT(error.what(), testing::HasSubstr("TMPDIR"));
  }
  before ? setenv("TMPDIR", kept.c_str(), 1) : unsetenv("TMPDIR");
  // A file that may not grow stands in for a full disk.
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small{1000, limit.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  EXPECT_THROW(pool(map, 1, 100), Error);
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, handler);
}
