// SPDX-License-Identifier: Apache-2.0
// CIELAB and its differences: the fast forms against one pixel at a time from the definition, the published test
// data, and the metrics made of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <triad/colour/cielab.hpp>
#include <triad/colour/colour.hpp>
#include <triad/colour/delta_e.hpp>
#include <triad/display/vision.hpp>
#include <triad/numeric/branch_free.hpp>

#include "metric_runner.hpp"

namespace {

using metric_runner::constant;
using metric_runner::error_of;
using metric_runner::noise;
using metric_runner::run;
using testing::HasSubstr;
using triad::Lab;
using triad::LabBlock;
using triad::SyntheticPicture;

namespace bf = triad::branch_free;

constexpr double kDegree = std::numbers::pi / 180;

// CIEDE2000 as its authors write it, in degrees.
double literal_ciede2000(const Lab& one, const Lab& two) {
  const auto seventh = [](double c) { return std::sqrt(std::pow(c, 7) / (std::pow(c, 7) + std::pow(25., 7))); };
  const double g = .5 * (1 - seventh((std::hypot(one.a, one.b) + std::hypot(two.a, two.b)) / 2));
  const double a1 = (1 + g) * one.a, a2 = (1 + g) * two.a, c1 = std::hypot(a1, one.b), c2 = std::hypot(a2, two.b);
  const auto hue = [](double a, double b) {
    const double h = a == 0 && b == 0 ? 0 : std::atan2(b, a) / kDegree;
    return h < 0 ? h + 360 : h;
  };
  const double h1 = hue(a1, one.b), h2 = hue(a2, two.b);
  double dh = 0, mean = h1 + h2;
  if (c1 * c2 != 0) {
    dh = h2 - h1 > 180 ? h2 - h1 - 360 : h2 - h1 < -180 ? h2 - h1 + 360 : h2 - h1;
    mean = std::abs(h1 - h2) <= 180 ? (h1 + h2) / 2 : h1 + h2 < 360 ? (h1 + h2 + 360) / 2 : (h1 + h2 - 360) / 2;
  }
  const double dL = two.L - one.L, dC = c2 - c1, dH = 2 * std::sqrt(c1 * c2) * std::sin(dh / 2 * kDegree);
  const double L = (one.L + two.L) / 2 - 50, c = (c1 + c2) / 2;
  const double t = 1 - .17 * std::cos((mean - 30) * kDegree) + .24 * std::cos(2 * mean * kDegree) +
                   .32 * std::cos((3 * mean + 6) * kDegree) - .20 * std::cos((4 * mean - 63) * kDegree);
  const double theta = 30 * std::exp(-std::pow((mean - 275) / 25, 2));
  const double l = dL / (1 + .015 * L * L / std::sqrt(20 + L * L)), k = dC / (1 + .045 * c),
               h = dH / (1 + .015 * c * t);
  return std::sqrt(l * l + k * k + h * h - std::sin(2 * theta * kDegree) * 2 * seventh(c) * k * h);
}

LabBlock block_of(const std::vector<Lab>& colours) {
  LabBlock block{};
  for (size_t i = 0; i < colours.size(); ++i) {
    block.L[i] = colours[i].L;
    block.a[i] = colours[i].a;
    block.b[i] = colours[i].b;
  }
  return block;
}

std::vector<double> ciede2000(const std::vector<Lab>& one, const std::vector<Lab>& two) {
  const LabBlock x = block_of(one), y = block_of(two);
  std::vector<double> out(one.size());
  triad::ciede2000(x, y, one.size(), out.data());
  return out;
}

// Table 1 of G. Sharma, W. Wu and E. N. Dalal, "The CIEDE2000 color-difference formula: implementation notes,
// supplementary test data, and mathematical observations", Color Research and Application 30(1), 2005: two colours
// and their difference, to four places.
// clang-format off
constexpr double kSharma[][7] = {
    {50, 2.6772, -79.7751, 50, 0, -82.7485, 2.0425}, {50, 3.1571, -77.2803, 50, 0, -82.7485, 2.8615},
    {50, 2.8361, -74.02, 50, 0, -82.7485, 3.4412}, {50, -1.3802, -84.2814, 50, 0, -82.7485, 1},
    {50, -1.1848, -84.8006, 50, 0, -82.7485, 1}, {50, -.9009, -85.5211, 50, 0, -82.7485, 1},
    {50, 0, 0, 50, -1, 2, 2.3669}, {50, -1, 2, 50, 0, 0, 2.3669},
    {50, 2.49, -.001, 50, -2.49, .0009, 7.1792}, {50, 2.49, -.001, 50, -2.49, .001, 7.1792},
    {50, 2.49, -.001, 50, -2.49, .0011, 7.2195}, {50, 2.49, -.001, 50, -2.49, .0012, 7.2195},
    {50, -.001, 2.49, 50, .0009, -2.49, 4.8045}, {50, -.001, 2.49, 50, .001, -2.49, 4.8045},
    {50, -.001, 2.49, 50, .0011, -2.49, 4.7461}, {50, 2.5, 0, 50, 0, -2.5, 4.3065},
    {50, 2.5, 0, 73, 25, -18, 27.1492}, {50, 2.5, 0, 61, -5, 29, 22.8977},
    {50, 2.5, 0, 56, -27, -3, 31.903}, {50, 2.5, 0, 58, 24, 15, 19.4535},
    {50, 2.5, 0, 50, 3.1736, .5854, 1}, {50, 2.5, 0, 50, 3.2972, 0, 1},
    {50, 2.5, 0, 50, 1.8634, .5757, 1}, {50, 2.5, 0, 50, 3.2592, .335, 1},
    {60.2574, -34.0099, 36.2677, 60.4626, -34.1751, 39.4387, 1.2644}, {63.0109, -31.0961, -5.8663, 62.8187, -29.7946, -4.0864, 1.263},
    {61.2901, 3.7196, -5.3901, 61.4292, 2.248, -4.962, 1.8731}, {35.0831, -44.1164, 3.7933, 35.0232, -40.0716, 1.5901, 1.8645},
    {22.7233, 20.0904, -46.694, 23.0331, 14.973, -42.5619, 2.0373}, {36.4612, 47.858, 18.3852, 36.2715, 50.5065, 21.2231, 1.4146},
    {90.8027, -2.0831, 1.441, 91.1528, -1.6435, .0447, 1.4441}, {90.9257, -.5406, -.9208, 88.6381, -.8985, -.7239, 1.5381},
    {6.7747, -.2908, -2.4247, 5.8714, -.0985, -2.2286, .6377}, {2.0776, .0795, -1.135, .9033, -.0636, -.5514, .9082},
};
// clang-format on

std::vector<Lab> firsts() {
  std::vector<Lab> out;
  for (const auto& row : kSharma) out.push_back({row[0], row[1], row[2]});
  return out;
}
std::vector<Lab> seconds() {
  std::vector<Lab> out;
  for (const auto& row : kSharma) out.push_back({row[3], row[4], row[5]});
  return out;
}

std::array<double, 3> white_of(const std::array<double, 9>& m) {
  return {m[0] + m[1] + m[2], m[3] + m[4] + m[5], m[6] + m[7] + m[8]};
}

Lab lab_of(const float* rgb) {
  const auto& m = triad::rec709_to_xyz();
  std::array<double, 3> xyz{};
  for (size_t i = 0; i < 3; ++i)
    for (size_t d = 0; d < 3; ++d) xyz[i] += m[3 * i + d] * static_cast<double>(rgb[d]);
  return triad::xyz_to_lab(xyz, white_of(m));
}

}  // namespace

TEST(BranchFree, IsAsExactAsItSays) {
  for (int i = -9000; i <= 9000; ++i) {
    const double x = std::pow(10, i / 30.) * (1 + 1e-3 * (i % 7));
    const double root = std::cbrt(x);
    ASSERT_NEAR(bf::cube_root(x) / root, 1, 1e-14) << x;
  }
  for (int i = 0; i <= 70000; ++i) {
    const double y = i / 100. * .99999;
    ASSERT_NEAR(bf::exp_minus(y) / std::exp(-y), 1, 1e-11) << y;
  }
  for (int i = -10472; i <= 10471; ++i) ASSERT_NEAR(bf::sine(i * 1e-4), std::sin(i * 1e-4), 2e-12) << i;
  for (const double length : {1e-150, 3., 1e150})
    for (int i = -3600; i <= 3600; ++i) {
      const double x = length * std::cos(i * kDegree / 10), y = length * std::sin(i * kDegree / 10);
      ASSERT_NEAR(bf::angle(y, x), std::atan2(y, x), 2e-10) << i;
    }
  for (const double y : {0., 1., -1.})
    for (const double x : {0., 1., -1.}) EXPECT_NEAR(bf::angle(y, x), std::atan2(y, x), 2e-10) << y << " " << x;
}

TEST(CielabTest, ManyPixelsAreTheSameAsOne) {
  const triad::RgbToLab to_lab(triad::rec709_to_xyz());
  const SyntheticPicture colours = noise(triad::kLabBlock, 1, 3, -.2f, 3);
  std::vector<float> rgb = colours.pixels;
  const float special[] = {0,           0,   0,  1, 1, 1, 1, 0, 0, 1e-4f, -1e-4f, 0, .0088564516f, .0088564517f,
                           .008856452f, 900, 20, 4};
  std::copy(std::begin(special), std::end(special), rgb.begin() + 30);
  for (const size_t count : {size_t{1}, size_t{2}, size_t{13}, triad::kLabBlock - 1, triad::kLabBlock}) {
    LabBlock got;
    to_lab.convert(rgb.data(), count, got);
    for (size_t i = 0; i < count; ++i) {
      const Lab expected = lab_of(&rgb[3 * i]);
      const double size = 1e-11 * std::max(1., std::abs(expected.L) / 100);
      EXPECT_NEAR(got.L[i], expected.L, size) << i;
      EXPECT_NEAR(got.a[i], expected.a, size) << i;
      EXPECT_NEAR(got.b[i], expected.b, size) << i;
    }
  }
}

// Published values (B. Lindbloom, and many others) of the sRGB primaries under D65, to the digits that they all
// share.
TEST(CielabTest, HasThePublishedPrimaries) {
  const triad::RgbToLab to_lab(triad::rec709_to_xyz());
  const float rgb[] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  const double lab[][3] = {{53.24, 80.09, 67.20}, {87.73, -86.18, 83.18}, {32.30, 79.19, -107.86}, {100, 0, 0}};
  LabBlock got;
  to_lab.convert(rgb, 4, got);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(got.L[i], lab[i][0], .015) << i;
    EXPECT_NEAR(got.a[i], lab[i][1], .015) << i;
    EXPECT_NEAR(got.b[i], lab[i][2], .015) << i;
  }
}

TEST(Ciede2000Test, HasThePublishedDifferences) {
  const auto one = firsts(), two = seconds();
  ASSERT_EQ(one.size(), 34u);
  const auto there = ciede2000(one, two), back = ciede2000(two, one);
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_NEAR(there[i], kSharma[i][6], 5.01e-5) << "pair " << i + 1;
    EXPECT_NEAR(back[i], kSharma[i][6], 5.01e-5) << "pair " << i + 1 << " in reverse";
    EXPECT_NEAR(literal_ciede2000(one[i], two[i]), kSharma[i][6], 5.01e-5) << "pair " << i + 1 << ", the test's own";
  }
}

TEST(Ciede2000Test, AgreesWithTheFormulaWrittenOut) {
  std::mt19937 bits(5);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(bits()) / 4294967296.0;
  };
  std::vector<Lab> one, two;
  const auto test = [&](double tolerance, const char* what) {
    const auto got = ciede2000(one, two);
    for (size_t i = 0; i < got.size(); ++i)
      EXPECT_NEAR(got[i], literal_ciede2000(one[i], two[i]), tolerance)
          << what << " (" << one[i].L << " " << one[i].a << " " << one[i].b << ") (" << two[i].L << " " << two[i].a
          << " " << two[i].b << ")";
    one.clear();
    two.clear();
  };
  const auto add = [&](double L1, double c1, double h1, double L2, double c2, double h2) {
    one.push_back({L1, c1 * std::cos(h1 * kDegree), c1 * std::sin(h1 * kDegree)});
    two.push_back({L2, c2 * std::cos(h2 * kDegree), c2 * std::sin(h2 * kDegree)});
  };
  for (int round = 0; round < 40; ++round) {
    for (int i = 0; i < 250; ++i)
      add(uniform(0, 100), uniform(0, 130), uniform(0, 360), uniform(0, 100), uniform(0, 130), uniform(0, 360));
    test(1e-9, "any");
  }
  for (int i = 0; i < 251; ++i) {
    const double h = uniform(0, 360), c = uniform(0, 100);
    add(60, c, h, 60 + uniform(-1, 1), c + uniform(-1, 1) * 1e-3, h + uniform(-1, 1) * 1e-3);
  }
  test(1e-9, "hardly different");
  for (int i = 0; i < 251; ++i) add(50, uniform(0, 2), uniform(-9, 9), 50, uniform(40, 90), uniform(-9, 9));
  test(1e-9, "around hue 0");
  for (int i = 0; i < 251; ++i) add(30, uniform(20, 130), uniform(230, 320), 32, uniform(20, 130), uniform(230, 320));
  test(1e-9, "blue");
  for (int i = 0; i < 251; ++i) {
    const double h = uniform(0, 360);
    add(50, uniform(1, 99), h, 50, uniform(1, 99), h + 180 + (i % 2 ? 1 : -1) * std::pow(10, uniform(-5, 0)));
  }
  test(1e-7, "almost opposite");  // by hundred thousandths of a degree, of which doubles know the direction so well
  for (int i = 0; i < 251; ++i) {
    one.push_back({uniform(0, 100), i % 3 == 0 ? 0 : uniform(-50, 50), i % 3 == 0 ? 0 : uniform(-50, 50)});
    two.push_back({uniform(0, 100), i % 3 == 1 ? 0 : uniform(-50, 50), i % 3 == 1 ? 0 : uniform(-50, 50)});
    if (i % 6 == 0) two.back() = {uniform(0, 100), 0, 0};
  }
  test(1e-9, "greys");
  for (int i = 0; i < 251; ++i) {  // below black and far above white, as light out of range gives
    one.push_back({uniform(-80, 900), uniform(-900, 900), uniform(-900, 900)});
    two.push_back({uniform(-80, 900), uniform(-900, 900), uniform(-900, 900)});
  }
  test(1e-8, "out of range");
}

// Exactly opposite hues: the mean hue lies 90 degrees above the lower of the two.
TEST(Ciede2000Test, OfOppositeHuesFollowsTheRule) {
  const std::vector<Lab> one{{50, 0, 20}, {50, 8, 0}, {50, -8, 0}, {40, 0, -20}, {50, -30, 0}},
      two{{60, 0, -10}, {50, -32, 0}, {50, 8, 0}, {40, 0, 40}, {50, 15, 0}};
  const auto got = ciede2000(one, two);
  for (size_t i = 0; i < one.size(); ++i) {
    // The hues of these are exact in degrees, so that the literal formula sees 180 exactly.
    EXPECT_NEAR(got[i], literal_ciede2000(one[i], two[i]), 1e-9) << i;
  }
}

TEST(Ciede2000Test, IsZeroForEqualColoursAndTheSameBothWays) {
  const auto one = firsts(), two = seconds();
  EXPECT_THAT(ciede2000(one, one), testing::Each(0.));
  std::mt19937 bits(9);
  std::vector<Lab> x, y;
  for (int i = 0; i < 256; ++i)
    for (auto* colours : {&x, &y})
      colours->push_back({static_cast<double>(bits() % 100), static_cast<double>(bits() % 201) - 100.3,
                          static_cast<double>(bits() % 201) - 100.7});
  const auto there = ciede2000(x, y), back = ciede2000(y, x);
  for (size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(there[i], back[i], 1e-12);
}

// What is left over of a vector is done one by one: the bits must not tell where.
TEST(Ciede2000Test, BitsDoNotDependOnTheNeighbours) {
  const triad::RgbToLab to_lab(triad::rec709_to_xyz());
  const SyntheticPicture a = noise(triad::kLabBlock, 1, 1, -.1f, 1.5f), b = noise(triad::kLabBlock, 1, 2);
  LabBlock x, y, x1, y1;
  std::vector<double> all(triad::kLabBlock), all76(triad::kLabBlock);
  to_lab.convert(a.pixels.data(), triad::kLabBlock, x);
  to_lab.convert(b.pixels.data(), triad::kLabBlock, y);
  triad::ciede2000(x, y, triad::kLabBlock, all.data());
  triad::cie76(x, y, triad::kLabBlock, all76.data());
  for (size_t i = 0; i < triad::kLabBlock; ++i) {
    double one, one76;
    to_lab.convert(&a.pixels[3 * i], 1, x1);
    to_lab.convert(&b.pixels[3 * i], 1, y1);
    triad::ciede2000(x1, y1, 1, &one);
    triad::cie76(x1, y1, 1, &one76);
    EXPECT_EQ(std::bit_cast<uint64_t>(one), std::bit_cast<uint64_t>(all[i]));
    EXPECT_EQ(std::bit_cast<uint64_t>(one76), std::bit_cast<uint64_t>(all76[i]));
  }
}

TEST(ColourDifference, IsTheMeanOverThePixels) {
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 5}, {300, 9}}) {
    const SyntheticPicture test = noise(width, height, 1, -.05f, 1.5f), reference = noise(width, height, 2);
    long double mean76 = 0, mean2000 = 0;
    std::vector<double> map76, map2000;
    for (size_t i = 0; i < test.pixels.size(); i += 3) {
      const Lab one = lab_of(&test.pixels[i]), two = lab_of(&reference.pixels[i]);
      map76.push_back(triad::cie76(one, two));
      map2000.push_back(literal_ciede2000(one, two));
      mean76 += static_cast<long double>(map76.back()) / (width * height);
      mean2000 += static_cast<long double>(map2000.back()) / (width * height);
    }
    const auto got76 = run("cie76", {}, test, reference, nullptr, {.borders = {0, 2}}),
               got2000 = run("ciede2000", {}, test, reference, nullptr, {.borders = {0, 2}});
    EXPECT_NEAR(got76.scores[0] / static_cast<double>(mean76), 1, 1e-12);
    EXPECT_NEAR(got2000.scores[0] / static_cast<double>(mean2000), 1, 1e-9);
    for (size_t i = 0; i < map76.size(); ++i) {
      EXPECT_FLOAT_EQ(got76.map[i], static_cast<float>(map76[i]));
      EXPECT_NEAR(static_cast<double>(got2000.map[i]), map2000[i], 1e-7 * map2000[i] + 1e-9);
    }
  }
}

TEST(ColourDifference, TakesPicturesOfOtherPrimariesUnderTheSameWhite) {
  // The same colours, once in Rec.709 and once with the first two primaries exchanged.
  const SyntheticPicture test = noise(8, 8, 1);
  SyntheticPicture exchanged = test;
  for (size_t i = 0; i < test.pixels.size(); i += 3) std::swap(exchanged.pixels[i], exchanged.pixels[i + 1]);
  for (size_t i = 0; i < 3; ++i) std::swap(exchanged.image.rgb_to_xyz[3 * i], exchanged.image.rgb_to_xyz[3 * i + 1]);
  for (const char* id : {"cie76", "ciede2000"}) EXPECT_NEAR(run(id, {}, test, exchanged).scores[0], 0, 1e-11) << id;
  SyntheticPicture warmer = test;
  for (size_t i = 0; i < 3; ++i) warmer.image.rgb_to_xyz[6 + i] *= .9;
  for (const char* id : {"cie76", "ciede2000"})
    EXPECT_THAT(error_of(id, {}, test, warmer), HasSubstr("white points")) << id;
  EXPECT_THAT(error_of("s-cielab", {}, test, exchanged), HasSubstr("primaries"));
}

TEST(ColourDifference, PoolsByTheWeightsOfTheMask) {
  const SyntheticPicture reference = constant(4, 2, {.2f, .4f, .6f});
  SyntheticPicture test = reference, mask = constant(4, 2, {0});
  std::fill_n(test.pixels.begin() + 3, 3, .5f);
  test.pixels[0] = NAN;
  mask.pixels[1] = 1;
  mask.pixels[6] = .25f;
  const double difference = triad::cie76(lab_of(&test.pixels[3]), lab_of(&reference.pixels[3]));
  EXPECT_NEAR(run("cie76", {}, test, reference, &mask).scores[0], difference / 1.25, 1e-9);
  EXPECT_THAT(error_of("cie76", {}, test, reference), HasSubstr("1 pixel"));
  std::fill(mask.pixels.begin(), mask.pixels.end(), 0.f);
  for (const char* id : {"cie76", "ciede2000", "s-cielab"}) {
    EXPECT_THAT(error_of(id, {}, reference, reference, &mask), HasSubstr("every pixel is left out")) << id;
    EXPECT_THAT(error_of(id, {}, reference, constant(4, 3, {0, 0, 0})), HasSubstr("4x3")) << id;
  }
}

TEST(ScielabMetric, OfFlatFieldsIsPlainCielab) {
  const SyntheticPicture test = constant(23, 9, {.2f, .5f, 1.1f}), reference = constant(23, 9, {.25f, .48f, .9f});
  const double expected = run("cie76", {}, test, reference).scores[0];
  EXPECT_GT(expected, 5);
  for (const char* edge : {"mirror", "wrap"}) {
    const auto got = run("s-cielab", {{"edge", edge}}, test, reference);
    EXPECT_NEAR(got.scores[0], expected, 2e-5) << edge;
    for (const float v : got.map) EXPECT_NEAR(static_cast<double>(v), expected, 3e-5);
  }
  EXPECT_EQ(run("s-cielab", {}, test, test).scores[0], 0);
}

// A cosine that the mirror at the border continues is an eigenfunction of each kernel: it comes out times the
// kernel's transfer at its frequency.
TEST(ScielabMetric, SeesAGratingWithTheKernelsTransfer) {
  const int width = 40, height = 3, half_waves = 7;
  const auto& m = triad::rec709_to_xyz();
  const auto white = white_of(m);
  const auto inverse = triad::inverse_3x3(triad::xyz_to_opponent());
  for (const int cells : {1, 3})
    for (const double ppd : {20., 60.}) {
      SyntheticPicture test = constant(width, height, {0, 0, 0}),
                       reference = constant(width, height, {.4f, .4f, .4f});
      const auto wave = [&](int x) { return std::cos(std::numbers::pi * half_waves * (x + .5) / width); };
      for (int i = 0; i < width * height; ++i)
        std::fill_n(test.pixels.begin() + 3 * i, 3, static_cast<float>(.4 + .05 * wave(i % width)));
      for (SyntheticPicture* picture : {&test, &reference}) {
        picture->image.cells_x = cells;
        picture->image.pixel_aspect = 1. / cells;
      }
      const auto got = run("s-cielab", {{"ppd", ppd == 20 ? "20" : "60"}}, test, reference);
      const double frequency_cpd = half_waves / 2. / width * ppd * cells;
      double mean = 0;
      for (int x = 0; x < width; ++x) {
        std::array<double, 3> seen{}, xyz{}, grey{};
        for (size_t c = 0; c < 3; ++c) {
          double flat = 0;
          for (size_t i = 0; i < 3; ++i) flat += triad::xyz_to_opponent()[3 * c + i] * white[i];
          seen[c] = flat * (.4 + .05 * wave(x) * triad::scielab_metric_mtf(static_cast<int>(c), frequency_cpd));
        }
        for (size_t i = 0; i < 3; ++i) {
          grey[i] = .4 * white[i];
          for (size_t c = 0; c < 3; ++c) xyz[i] += inverse[3 * i + c] * seen[c];
        }
        const double expected = triad::cie76(triad::xyz_to_lab(xyz, white), triad::xyz_to_lab(grey, white));
        for (int y = 0; y < height; ++y)
          EXPECT_NEAR(static_cast<double>(got.map[static_cast<size_t>(y * width + x)]), expected, 3e-5) << x;
        mean += expected / width;
      }
      EXPECT_NEAR(got.scores[0], mean, 2e-5);
      EXPECT_GT(mean, .05);
    }
}

TEST(ScielabMetric, HardlySeesADitherThatIsFineEnough) {
  SyntheticPicture test = constant(32, 32, {.5f, .5f, .5f});
  const SyntheticPicture reference = test;
  for (int i = 0; i < 32 * 32; ++i) std::fill_n(test.pixels.begin() + 3 * i, 3, (i + i / 32) % 2 ? .75f : .25f);
  EXPECT_GT(run("cie76", {}, test, reference).scores[0], 10);
  EXPECT_LT(run("s-cielab", {{"ppd", "60"}}, test, reference).scores[0], .02);
  EXPECT_GT(run("s-cielab", {{"ppd", "5"}}, test, reference).scores[0], 2);
}
