// SPDX-License-Identifier: Apache-2.0
// Colours of error maps against published ones, and the scale that a map's values ask for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/image/colour_map.hpp>

namespace triad {
namespace {

struct Published {
  size_t index;
  int code[3];
};

// The codes of the entries 0, 32, 64 ... 224, 255 as the maps' authors and matplotlib publish them, full signal 255.
constexpr Published kMagma[] = {{0, {0, 0, 4}},        {32, {29, 17, 71}},     {64, {81, 18, 124}},
                                {96, {131, 38, 129}},  {128, {183, 55, 121}},  {160, {231, 82, 99}},
                                {192, {252, 137, 97}}, {224, {254, 196, 136}}, {255, {252, 253, 191}}};
constexpr Published kViridis[] = {{0, {68, 1, 84}},     {32, {71, 45, 123}},   {64, {59, 82, 139}},
                                  {96, {44, 114, 142}}, {128, {33, 145, 140}}, {160, {40, 174, 128}},
                                  {192, {94, 201, 98}}, {224, {173, 220, 48}}, {255, {253, 231, 37}}};

template <size_t N>
void expect_near(const std::array<ColourCode, 256>& table, const Published (&published)[N]) {
  for (const Published& p : published)
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(table[p.index][c], p.code[c], 1) << p.index << " channel " << c;
}

// CIE L*, from sRGB codes (IEC 61966-2-1 and CIE 15).
double lightness(const ColourCode& code) {
  double y = 0;
  constexpr double kWeights[] = {.2126, .7152, .0722};
  for (size_t c = 0; c < 3; ++c) {
    const double v = code[c] / 255.;
    y += kWeights[c] * (v <= .04045 ? v / 12.92 : std::pow((v + .055) / 1.055, 2.4));
  }
  return y > 216. / 24389 ? 116 * std::cbrt(y) - 16 : y * 24389 / 27;
}

TEST(ColourMap, IsThePublishedOne) {
  expect_near(colour_table(ColourMap::kMagma), kMagma);
  expect_near(colour_table(ColourMap::kViridis), kViridis);
}

// What makes them fit for measuring: lightness rises everywhere, and nearly evenly. The maps were made even in
// CAM02-UCS; of the published ones, L* differs from a straight line by up to 1.7 (viridis) and 5.6 (magma).
TEST(ColourMap, RisesEvenlyInLightness) {
  for (const auto& [map, tolerance] : {std::pair{ColourMap::kMagma, 5.9}, std::pair{ColourMap::kViridis, 2.}}) {
    const auto& table = colour_table(map);
    const double low = lightness(table.front()), high = lightness(table.back());
    EXPECT_GT(high - low, 70) << colour_map_name(map);
    for (size_t i = 0; i < table.size(); ++i) {
      EXPECT_NEAR(lightness(table[i]), low + (high - low) * static_cast<double>(i) / 255, tolerance)
          << colour_map_name(map) << " " << i;
      if (i >= 4) {
        EXPECT_GT(lightness(table[i]), lightness(table[i - 4])) << colour_map_name(map) << " " << i;
      }
    }
  }
}

TEST(ColourMap, TakesTheNearestStepAndEndsAtTheEnds) {
  const auto& table = colour_table(ColourMap::kMagma);
  const MapScale scale{-1, 3};
  EXPECT_EQ(map_colour(table, scale, -1), table[0]);
  EXPECT_EQ(map_colour(table, scale, -7), table[0]);
  EXPECT_EQ(map_colour(table, scale, 3), table[255]);
  EXPECT_EQ(map_colour(table, scale, std::numeric_limits<double>::infinity()), table[255]);
  EXPECT_EQ(map_colour(table, scale, -1 + 4 * 100.4 / 255), table[100]);
  EXPECT_EQ(map_colour(table, scale, -1 + 4 * 100.6 / 255), table[101]);
  EXPECT_EQ(map_colour(table, scale, std::nan("")), (ColourCode{128, 128, 128}));
}

TEST(ColourMap, NamesAreThoseOfTheOption) {
  EXPECT_EQ(parse_colour_map("viridis"), ColourMap::kViridis);
  EXPECT_STREQ(colour_map_name(parse_colour_map("magma")), "magma");
  try {
    parse_colour_map("virdis");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find("did you mean 'viridis'"), std::string::npos) << error.what();
  }
}

TEST(RoundUp, GivesTwoDigits) {
  EXPECT_EQ(round_up_two_digits(0), 0);
  EXPECT_EQ(round_up_two_digits(.137), .14);
  EXPECT_EQ(round_up_two_digits(.14), .14);
  EXPECT_EQ(round_up_two_digits(.1401), .15);
  EXPECT_EQ(round_up_two_digits(9.91), 10);
  EXPECT_EQ(round_up_two_digits(1), 1);
  EXPECT_EQ(round_up_two_digits(123456), 130000);
  EXPECT_EQ(round_up_two_digits(3.21e-7), 3.3e-7);
  EXPECT_EQ(round_up_two_digits(-.137), -.13);
  EXPECT_EQ(round_up_two_digits(-.14), -.14);
  EXPECT_EQ(round_up_two_digits(-123456), -120000);
}

TEST(ScaleFinder, CoversNinetyNinePercent) {
  // 1000 values k / 1000: 99 % of them are at most .99, which is two digits already.
  ScaleFinder finder;
  for (int k = 1000; k > 0; --k) finder.add(static_cast<float>(k) / 1000);
  EXPECT_GE(finder.high(), .99);
  EXPECT_LE(finder.high(), 1.);
  // Ten of a thousand that are far off do not count, eleven do.
  for (const int far : {10, 11}) {
    ScaleFinder other;
    for (int k = 0; k < 1000; ++k) other.add(k < far ? 5.f : .0625f);
    EXPECT_EQ(other.high(), far == 10 ? .063 : 5) << far;
  }
}

TEST(ScaleFinder, TakesTheLargestWhereMostIsZero) {
  ScaleFinder finder;
  for (int k = 0; k < 1000; ++k) finder.add(k == 7 ? .5f : 0);
  EXPECT_EQ(finder.high(), .5);
}

TEST(ScaleFinder, GoesFromTheLeastToTheGreatestWhereSignsMatter) {
  const auto expect = [](const std::vector<float>& values, double low, double high) {
    ScaleFinder finder;
    for (const float value : values) finder.add(value);
    EXPECT_EQ(finder.low(), low) << values[0];
    EXPECT_EQ(finder.high(), high) << values[0];
  };
  expect({-3.33f, 1, 0, 5.01f}, -3.4, 5.1);
  expect({-12, -3.08f, -7}, -12, -3);  // not up to 0, which no value is near
  expect({-3, -3}, -3, 0);             // but a scale has two ends
  expect({-2, 0, 0}, -2, 0);
  expect({-std::numeric_limits<float>::infinity(), -1, 2}, -1, 2);
  expect({-std::numeric_limits<float>::infinity(), 1, 2}, 0, 2);
  // Among many zeros, a few of both signs count; among many values above 0, a few below do not.
  std::vector<float> sparse(1000, 0.f), most(1000, .5f);
  sparse[3] = -.5f;
  sparse[5] = 2;
  most[0] = -4;
  expect(sparse, -.5, 2);
  expect(most, 0, .5);
}

TEST(ScaleFinder, SurvivesWhatIsNoError) {
  ScaleFinder none;
  EXPECT_EQ(none.high(), 0);
  ScaleFinder finder;
  for (int k = 0; k < 10; ++k) {
    finder.add(-1);
    finder.add(std::numeric_limits<float>::quiet_NaN());
    finder.add(std::numeric_limits<float>::infinity());
    finder.add(2);
  }
  EXPECT_EQ(finder.high(), 2);
}

}  // namespace
}  // namespace triad
