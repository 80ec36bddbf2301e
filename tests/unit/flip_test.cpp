// SPDX-License-Identifier: Apache-2.0
// FLIP against its papers' formulas in double precision, published values and closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <triad/base/error.hpp>
#include <triad/evaluation/flip.hpp>
#include <triad/numeric/aligned.hpp>

#include "flip_reference.hpp"

using flip_reference::Picture;
using flip_reference::Rgb;
using flip_reference::ToneMapper;
using testing::HasSubstr;
using triad::Flip;
using triad::FlipToneMapper;
using triad::FloatRank;

namespace {

// A picture in floats with its border repeated `reach` times around it.
struct Padded {
  int reach, row;
  std::vector<float> rgb;
  Padded(const Picture& p, int r) : reach(r), row(3 * (p.width + 2 * r)) {
    for (int y = -r; y < p.height + r; ++y)
      for (int x = -r; x < p.width + r; ++x)
        for (const double v : p.at(x, y)) rgb.push_back(static_cast<float>(v));
  }
  triad::FlipPicture at(int x, int y) const {
    return {rgb.data() + static_cast<ptrdiff_t>(y + reach) * row + 3 * (x + reach), row};
  }
};

struct Maps {
  std::vector<float> errors, stops;
};
// In pieces of at most piece x piece pixels.
Maps flip(const Picture& reference, const Picture& test, double ppd, const triad::FlipViewing& viewing,
          int piece = 1 << 20) {
  const Flip metric(ppd);
  const Padded r(reference, metric.reach_px()), t(test, metric.reach_px());
  Maps maps;
  const auto pixels = static_cast<size_t>(reference.width) * static_cast<size_t>(reference.height);
  maps.errors.resize(pixels);
  maps.stops.resize(pixels);
  for (int y0 = 0; y0 < reference.height; y0 += piece)
    for (int x0 = 0; x0 < reference.width; x0 += piece) {
      const int width = std::min(piece, reference.width - x0), height = std::min(piece, reference.height - y0);
      const auto row = static_cast<size_t>(Flip::row_floats(width));
      triad::AlignedBuffer<float> errors(row * static_cast<size_t>(height)), stops(errors.size()),
          work(metric.work_floats(width, height));
      metric.evaluate(t.at(x0, y0), r.at(x0, y0), width, height, viewing, errors.data(), stops.data(), work.data());
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const size_t to = static_cast<size_t>(y0 + y) * static_cast<size_t>(reference.width) + x0 + x;
          maps.errors[to] = errors[static_cast<size_t>(y) * row + x];
          maps.stops[to] = stops[static_cast<size_t>(y) * row + x];
        }
    }
  return maps;
}

// Makes both pictures pixel by pixel from random numbers in [0, 1).
template <class Make>
std::pair<Picture, Picture> pair_of(int width, int height, const Make& make) {
  std::mt19937 random(17);
  const auto uniform = [&] { return static_cast<double>(random() >> 8) * 0x1p-24; };
  std::pair<Picture, Picture> made{{width, height, {}}, {width, height, {}}};
  for (int i = 0; i < width * height; ++i) {
    Rgb reference, test;
    for (size_t c = 0; c < 3; ++c) {
      make(uniform(), uniform(), c, reference[c], test[c]);
      reference[c] = static_cast<double>(static_cast<float>(reference[c]));  // what both computations see
      test[c] = static_cast<double>(static_cast<float>(test[c]));
    }
    made.first.pixels.push_back(reference);
    made.second.pixels.push_back(test);
  }
  return made;
}

Picture constant(const Rgb& value, int width = 25, int height = 13) {
  return {width, height, std::vector<Rgb>(static_cast<size_t>(width) * static_cast<size_t>(height), value)};
}

void expect_near(const std::vector<float>& got, const std::vector<double>& expected, double each, double mean,
                 const std::string& what) {
  ASSERT_EQ(got.size(), expected.size());
  double worst = 0, sum = 0;
  for (size_t i = 0; i < got.size(); ++i) {
    const double d = static_cast<double>(got[i]) - expected[i];
    worst = std::max(worst, std::isfinite(d) ? std::abs(d) : HUGE_VAL);
    sum += d;
  }
  EXPECT_LE(worst, each) << what;
  EXPECT_LE(std::abs(sum) / static_cast<double>(got.size()), mean) << what;
}

constexpr double kDefault_ppd = 67.020645;
// Where both pictures are flat the authors' program, and ours with it, finds edges of up to 3e-4 in what single
// precision leaves of derivatives; of an error e that is e |ln e| times as much.
constexpr double kFlat = 1.1e-4;

}  // namespace

TEST(FlipTest, AgreesWithThePapersFormulas) {
  struct Kind {
    const char* name;
    double each, mean;
    void (*make)(double u, double v, size_t c, double& reference, double& test);
  };
  const Kind kinds[] = {{"noise", 1e-6, 2e-7, [](double u, double v, size_t, double& r, double& t) { r = u, t = v; }},
                        {"black and white", 3e-6, 1e-6,
                         [](double u, double v, size_t, double& r, double& t) { r = u > .5, t = v > .5; }},
                        {"out of range", 1e-6, 2e-7,
                         [](double u, double v, size_t, double& r, double& t) { r = 3 * u - 1, t = 3 * v - 1; }},
                        // Errors of some 1e-4, with the root of a small difference in them.
                        {"nearly alike", 5e-5, 2e-6, [](double u, double v, size_t, double& r, double& t) {
                           r = u, t = u * (1 + 1e-4 * (v - .5));
                         }}};
  for (const Kind& kind : kinds)
    for (const double ppd : {10., 25., kDefault_ppd})
      for (const auto& [width, height] : {std::pair{1, 1}, {1, 7}, {13, 5}, {40, 33}}) {
        auto [reference, test] = pair_of(width, height, kind.make);
        const Maps got = flip(reference, test, ppd, {});
        for (Picture* p : {&reference, &test})
          for (Rgb& c : p->pixels)
            for (double& v : c) v = std::clamp(v, 0., 1.);
        const bool flat = width == 1 && height == 1;
        expect_near(got.errors, flip_reference::ldr(reference, test, ppd), flat ? kFlat : kind.each,
                    flat ? kFlat : kind.mean,
                    std::string(kind.name) + " " + std::to_string(width) + "x" + std::to_string(height) + " at " +
                        std::to_string(ppd));
      }
}

TEST(FlipTest, AgreesInAnyRangeOfLightAndWithAnyToneMapper) {
  const std::vector<float> exposures{-9, -3.25f, 0, 2.5f};
  for (const auto& [mapper, slow] : {std::pair{FlipToneMapper::kAces, ToneMapper::kAces},
                                     {FlipToneMapper::kReinhard, ToneMapper::kReinhard},
                                     {FlipToneMapper::kHable, ToneMapper::kHable}})
    for (const auto& [width, height] : {std::pair{1, 1}, {13, 5}, {33, 20}}) {
      const auto [reference, test] = pair_of(width, height, [](double u, double v, size_t, double& r, double& t) {
        r = std::pow(10, 11 * u - 6);  // 1e-6 to 1e5
        t = v < .5 ? r * (1 + v) : std::pow(10, 22 * (v - .5) - 6);
      });
      const Maps got = flip(reference, test, kDefault_ppd, {false, exposures, mapper});
      const auto expected = flip_reference::hdr(reference, test, kDefault_ppd, slow, exposures);
      const std::string what = std::to_string(width) + "x" + std::to_string(height);
      const bool flat = width == 1 && height == 1;
      expect_near(got.errors, expected.errors, flat ? kFlat : 3e-6, flat ? kFlat : 5e-7, what);
      if (!flat) expect_near(got.stops, expected.stops, 0, 0, what);  // else several are alike
    }
}

TEST(FlipTest, DecodesCodes) {
  const auto [reference, test] =
      pair_of(24, 9, [](double u, double v, size_t, double& r, double& t) { r = u * u, t = v * v; });
  Picture light[] = {reference, test};
  for (Picture& p : light)
    for (Rgb& c : p.pixels)
      for (double& v : c) v = flip_reference::decoded(v);
  expect_near(flip(reference, test, 30, {.srgb_codes = true}).errors, flip_reference::ldr(light[0], light[1], 30),
              1e-6, 2e-7, "codes");
}

TEST(FlipTest, GivesThePublishedValues) {
  const auto each_is = [](const Rgb& a, const Rgb& b, double value, double tolerance) {
    for (const bool swapped : {false, true})
      for (const float error : flip(constant(swapped ? b : a), constant(swapped ? a : b), kDefault_ppd, {}).errors)
        EXPECT_NEAR(static_cast<double>(error), value, tolerance);
  };
  each_is({0, 0, 0}, {1, 1, 1}, .96738833, 5e-8);
  each_is({0, 1, 0}, {0, 0, 1}, 1, 2e-7);
}

TEST(FlipTest, OfThePictureItselfIsExactlyZero) {
  const auto [reference, unused] =
      pair_of(70, 9, [](double u, double, size_t, double& r, double& t) { r = std::exp2(30 * u - 20), t = 0; });
  for (const triad::FlipViewing& viewing : {triad::FlipViewing{}, triad::FlipViewing{false, {-4, 0, 3}}})
    EXPECT_THAT(flip(reference, reference, kDefault_ppd, viewing).errors, testing::Each(0.f));
}

// Flat pictures have no edges: their error is that of their colours alone, whatever the ppd.
TEST(FlipTest, OfFlatColoursDoesNotDependOnTheDistance) {
  const Picture one = constant({.2, .5, .7}), other = constant({.25, .45, .7});
  const double expected = flip_reference::ldr(constant({.2, .5, .7}, 1, 1), constant({.25, .45, .7}, 1, 1), 5)[0];
  EXPECT_GT(expected, .1);
  for (const double ppd : {2., 7.3, 67.02, 200.})
    for (const float error : flip(one, other, ppd, {}).errors)
      EXPECT_NEAR(static_cast<double>(error), expected, kFlat) << ppd;
}

// Single precision squares to infinity above 1.8e19, and infinity over infinity is shown as black; a negative value
// has a positive square.
TEST(FlipTest, TreatsHugeAndNegativeLightAsTheAuthorsProgramDoes) {
  const triad::FlipViewing aces{false, {0}}, reinhard{false, {0}, FlipToneMapper::kReinhard};
  const auto error = [](double reference, double test, const triad::FlipViewing& viewing) {
    return static_cast<double>(flip(constant({reference, reference, reference}, 3, 2),
                                    constant({test, test, test}, 3, 2), kDefault_ppd, viewing)
                                   .errors[0]);
  };
  EXPECT_EQ(error(0, 1e25, aces), 0);
  EXPECT_NEAR(error(1e18, 1e25, aces), .96738833, 1e-7);
  EXPECT_EQ(error(1e18, -1, aces), 0);
  EXPECT_EQ(error(0, -.5, reinhard), 0);
  EXPECT_NEAR(error(0, -2, reinhard), .96738833, 1e-7);  // -2 / (1 - 2)
}

TEST(FlipTest, OfAPieceIsThatOfThePicture) {
  const auto [reference, test] =
      pair_of(150, 40, [](double u, double v, size_t, double& r, double& t) { r = 4 * u, t = 3 * u + v; });
  const triad::FlipViewing viewing{false, {-2, 0.5f}};
  const Maps whole = flip(reference, test, kDefault_ppd, viewing);
  for (const int piece : {1, 7, 32, 65}) {
    const Maps pieces = flip(reference, test, kDefault_ppd, viewing, piece);
    EXPECT_EQ(pieces.errors, whole.errors) << piece;
    EXPECT_EQ(pieces.stops, whole.stops) << piece;
  }
}

TEST(FlipFiltersTest, AreNormalised) {
  for (const double ppd : {2., 4.7, kDefault_ppd, 500.}) {
    const triad::FlipFilters f(ppd);
    const auto sum = [](const std::vector<float>& half) {
      double s = half[0];
      for (size_t k = 1; k < half.size(); ++k) s += 2 * static_cast<double>(half[k]);
      return s;
    };
    EXPECT_NEAR(sum(f.achromatic), 1, 1e-6);
    EXPECT_NEAR(sum(f.red_green), 1, 1e-6);
    EXPECT_NEAR(std::pow(sum(f.blue_yellow_wide), 2) + std::pow(sum(f.blue_yellow_narrow), 2), 1, 1e-6);
    const auto whole = [](const std::vector<float>& weights, int sign) {
      double s = 0;
      for (const float w : weights) s += std::max(0., sign * static_cast<double>(w));
      return s;
    };
    EXPECT_NEAR(whole(f.gaussian, 1), 1, 1e-6);
    for (const auto* derivative : {&f.first_derivative, &f.second_derivative})
      for (const int sign : {-1, 1}) EXPECT_NEAR(whole(*derivative, sign), 1, 1e-6);
    EXPECT_EQ(f.gaussian.size(), f.first_derivative.size());
    EXPECT_EQ(f.gaussian.size(), f.second_derivative.size());
  }
  const triad::FlipFilters f(kDefault_ppd);
  EXPECT_EQ(f.blue_yellow_wide.size(), 11u);  // 3 sqrt(.04 / 2) / pi 67.02 = 9.05
  EXPECT_EQ(f.gaussian.size(), 19u);          // 3 .041 67.02 = 8.24
  EXPECT_EQ(f.reach_px(), 10);
  for (const double ppd : {0., 1.99, 2001., static_cast<double>(NAN)})
    EXPECT_THROW(triad::FlipFilters{ppd}, triad::Error) << ppd;
}

TEST(FlipExposuresTest, FollowMedianAndLargestLuminance) {
  // Reinhard shows x as .85 where x = .85 / .15.
  const auto reinhard = triad::flip_exposures(FlipToneMapper::kReinhard, {}, {}, 0, .25f, 100);
  EXPECT_NEAR(reinhard.start_stops, std::log2(.85 / .15 / 100), 1e-5);
  EXPECT_NEAR(reinhard.stop_stops, std::log2(.85 / .15 / .25), 1e-5);
  EXPECT_EQ(reinhard.count, 9);  // log2(400) = 8.64
  for (const auto& [mapper, slow] :
       {std::pair{FlipToneMapper::kAces, ToneMapper::kAces}, {FlipToneMapper::kHable, ToneMapper::kHable}}) {
    const auto found = triad::flip_exposures(mapper, {}, {}, 5, 2, 7);
    const double bright = 2 * std::exp2(static_cast<double>(found.stop_stops));
    EXPECT_NEAR(flip_reference::toned(slow, {bright, bright, bright})[0], .85, 1e-6);
    EXPECT_NEAR(found.stop_stops - found.start_stops, std::log2(3.5), 1e-6);
    EXPECT_EQ(found.count, 5);
    EXPECT_FLOAT_EQ(found.at(3), found.start_stops + 3 * std::log2(3.5f) / 4);
  }
  const auto given = triad::flip_exposures(FlipToneMapper::kAces, -2.f, 3.5f, 0, 1, 1);
  EXPECT_EQ(given.count, 6);
  EXPECT_EQ(given.at(0), -2);
  EXPECT_EQ(given.at(5), 3.5f);
  EXPECT_EQ(triad::flip_exposures(FlipToneMapper::kAces, 0.f, .5f, 0, 1, 1).count, 2);
  EXPECT_EQ(triad::flip_exposures(FlipToneMapper::kAces, 1.f, 2.f, 1, 1, 1).at(0), 1);
  EXPECT_THROW(triad::flip_exposures(FlipToneMapper::kAces, 1.f, 0.f, 0, 1, 1), triad::Error);
}

TEST(FloatRankTest, FindsEveryRank) {
  std::mt19937 random(5);
  std::vector<float> values{0, -0.f, 0, 1e-40f, -1e-40f, 3e38f, -3e38f, 1, 1, 1};
  for (int i = 0; i < 300; ++i)
    values.push_back(std::ldexp(static_cast<float>(random() % 64) - 20, static_cast<int>(random() % 40) - 20));
  std::vector<float> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  for (size_t rank = 0; rank < values.size(); rank += rank < 160 && rank > 140 ? 1 : 7) {
    std::vector<uint64_t> upper(FloatRank::kBins), lower(FloatRank::kBins);
    for (const float v : values) ++upper[FloatRank::upper_key(v)];
    const auto place = FloatRank::find(upper, rank);
    for (const float v : values)
      if (FloatRank::upper_key(v) == place.bin) ++lower[FloatRank::lower_key(v)];
    EXPECT_EQ(FloatRank::value(place.bin, FloatRank::find(lower, place.rank).bin), sorted[rank]) << rank;
  }
}
