// SPDX-License-Identifier: Apache-2.0
// Rounding to stored codes, judged by the visible energy of dense sums.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/display/dither.hpp>
#include <triad/display/panel_torus.hpp>
#include <triad/numeric/plane_blur.hpp>
#include <vector>

#include "layouts.hpp"
#include "panel_reference.hpp"

using triad::Dither;
using triad::DitherOptions;
using triad::PanelDither;
namespace reference = triad::reference;
using reference::layout;

namespace {

std::vector<float> round_picture(const triad::Layout& panel, const std::vector<float>& drives, int width, double ppd,
                                 const DitherOptions& options, int bits = 8) {
  const PanelDither dither(panel, reference::observer(ppd), 0, 0, triad::srgb_levels(bits), options);
  const int height = static_cast<int>(drives.size()) / 3 / width;
  std::vector<float> out(drives.size());
  dither.apply({drives.data(), 3 * width}, width, height, out.data(), 3 * width);
  return out;
}

// The energy that an eye sees of the difference of two pictures on the panel, both repeated for ever. By the classes
// that panel_test.cpp judges.
double visible_energy(const triad::Layout& panel, const std::vector<float>& one, const std::vector<float>& other,
                      int width, double ppd) {
  const int height = static_cast<int>(one.size()) / 3 / width;
  const triad::PanelTorus torus(panel, {width, height, 0, 0, triad::Edge::kWrap, false});
  const triad::PlaneBlur blur(torus.width(), torus.height());
  triad::PlaneBlur::Workspace work(blur);
  const auto eye = reference::observer(ppd);
  const auto C = triad::opponent_matrix(eye);
  const triad::Light first = torus.panel({one.data(), 3 * width}), second = torus.panel({other.data(), 3 * width});
  std::vector<double> rows(3 * torus.height());
  for (size_t c = 0; c < 3; ++c)
    blur.apply(
        [&](size_t y, double* row) {
          std::vector<double> a(3 * torus.width()), b(a.size());
          first(y, a.data());
          second(y, b.data());
          for (size_t k = 0; k < torus.width(); ++k) {
            row[k] = 0;
            for (size_t d = 0; d < 3; ++d) row[k] += C[3 * c + d] * (a[3 * k + d] - b[3 * k + d]);
          }
        },
        [&](size_t nx, double* values) { torus.transfer(eye, static_cast<int>(c), nx, values); }, torus.height(),
        [&](size_t y, const double* row) {
          rows[c * torus.height() + y] = std::inner_product(row, row + torus.width(), row, 0.);
        },
        work);
  return std::accumulate(rows.begin(), rows.end(), 0.);
}

// Slow gradients, different in each channel: where rounding is seen first.
std::vector<float> gradients(int width, int height) {
  std::vector<float> out;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int d = 0; d < 3; ++d)
        out.push_back(static_cast<float>(.2 + .004 * (d + 1) * std::sin(2 * std::numbers::pi * x / width + d) +
                                         .003 * std::cos(2 * std::numbers::pi * y / height - d)));
  return out;
}

}  // namespace

TEST(StoredLevelsTest, AreTheCurvesOfTheirStandard) {
  const auto srgb = triad::srgb_levels(8);
  ASSERT_EQ(srgb.levels.size(), 256u);
  ASSERT_EQ(srgb.limits.size(), 255u);
  EXPECT_EQ(srgb.levels[0], 0);
  EXPECT_EQ(srgb.levels[255], 1);
  EXPECT_NEAR(srgb.levels[1], 1 / (255 * 12.92), 1e-9);
  EXPECT_NEAR(srgb.levels[128], .21586050, 1e-7);
  EXPECT_NEAR(srgb.levels[188], .50288639, 1e-7);
  for (size_t k = 0; k < 255; ++k) {
    EXPECT_GT(srgb.limits[k], srgb.levels[k]);
    EXPECT_LT(srgb.limits[k], srgb.levels[k + 1]);
  }
  const auto linear = triad::linear_levels(2);
  for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(linear.levels[k], static_cast<double>(k) / 3, 1e-7);
  EXPECT_NEAR(linear.limits[1], .5, 1e-15);
  EXPECT_THROW(triad::srgb_levels(17), triad::Error);
}

TEST(PanelDitherTest, GivesNeighbouringCodesAndKeepsCodes) {
  const int width = 9;
  std::vector<float> drives;
  for (const double v : reference::random_cells(width * 7, 3)) drives.push_back(static_cast<float>(v * 1.2 - .1));
  drives[0] = 0;
  drives[1] = 1;
  for (const char* name : {"rgb", "qd-oled", "rwbg", "pentile-rgbg", "rgb-delta"})
    for (const Dither mode : {Dither::kNone, Dither::kOrdered, Dither::kPerceptual})
      for (const int bits : {1, 4, 8, 16}) {
        const auto levels = triad::srgb_levels(bits).levels;
        const auto got = round_picture(layout(name), drives, width, 40, {.mode = mode}, bits);
        for (size_t i = 0; i < drives.size(); ++i) {
          const double v = std::clamp(static_cast<double>(drives[i]), 0., 1.);
          const auto above = std::lower_bound(levels.begin(), levels.end(), v);
          const double low = above == levels.begin() ? levels.front() : *(above - 1);
          EXPECT_TRUE(static_cast<double>(got[i]) == *above || static_cast<double>(got[i]) == low)
              << name << bits << " " << v << " " << got[i];
        }
        EXPECT_EQ(round_picture(layout(name), got, width, 40, {.mode = mode}, bits), got) << name << bits;
      }
}

TEST(PanelDitherTest, NoneIsTheNearestCodeOfTheFile) {
  // In codes, not in light: .5 of a code up or down on the sRGB curve.
  const auto encoded = [](double v) { return v <= .0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - .055; };
  std::vector<float> drives;
  for (int i = 0; i < 3000; ++i) drives.push_back(static_cast<float>(i) / 2999.f);
  const auto got = round_picture(layout("rgb"), drives, 100, 40, {.mode = Dither::kNone});
  for (size_t i = 0; i < drives.size(); ++i) {
    const double code = encoded(static_cast<double>(drives[i])) * 255;
    if (std::abs(code - std::floor(code) - .5) < 1e-3) continue;
    EXPECT_NEAR(encoded(static_cast<double>(got[i])) * 255, std::round(code), 1e-3);
  }
}

TEST(PanelDitherTest, OrderedFollowsItsThresholds) {
  // A value p of the way between two codes goes up at p of the 64 places of the matrix.
  const auto levels = triad::srgb_levels(8).levels;
  for (const double part : {.1, .25, .5, .9}) {
    const std::vector<float> drives(3 * 64, static_cast<float>(levels[100] + part * (levels[101] - levels[100])));
    const auto got = round_picture(layout("rgb"), drives, 8, 40, {.mode = Dither::kOrdered});
    const auto up = std::count(got.begin(), got.end(), static_cast<float>(levels[101]));
    EXPECT_NEAR(static_cast<double>(up), 3 * 64 * part, 3.) << part;
  }
}

TEST(PanelDitherTest, NoSingleCodeCouldBeBetter) {
  // Seen from so near that the whole of an eye's blur lies within the radius; black all round, which is a code.
  const int width = 48, inner = 6;
  const double ppd = 12;
  for (const char* name : {"rgb", "qd-oled", "pentile-rgbg", "rgb-delta"}) {
    const triad::Layout panel = layout(name);
    std::vector<float> drives(3 * width * width);
    const auto values = reference::random_cells(inner * inner, 7);
    const auto index = [&](int k) {
      const int x = k / 3 % inner, y = k / 3 / inner, first = (width - inner) / 2;
      return static_cast<size_t>(3 * ((first + y) * width + first + x) + k % 3);
    };
    for (int k = 0; k < 3 * inner * inner; ++k) drives[index(k)] = static_cast<float>(values[static_cast<size_t>(k)]);
    const auto got = round_picture(panel, drives, width, ppd, {.passes = 16, .radius_px = 16}, 4);
    const double best = visible_energy(panel, got, drives, width, ppd);
    const auto nearest = round_picture(panel, drives, width, ppd, {.mode = Dither::kNone}, 4);
    EXPECT_LT(best, visible_energy(panel, nearest, drives, width, ppd)) << name;
    const auto levels = triad::srgb_levels(4).levels;
    for (int k = 0; k < 3 * inner * inner; k += 5) {
      const auto drive = static_cast<double>(drives[index(k)]);
      const auto above = std::lower_bound(levels.begin(), levels.end(), drive);
      auto other = got;
      other[index(k)] = static_cast<float>(static_cast<double>(got[index(k)]) == *above ? *(above - 1) : *above);
      EXPECT_GT(visible_energy(panel, other, drives, width, ppd), best * (1 - 1e-3)) << name << k;
    }
  }
}

TEST(PanelDitherTest, IsSeenLessThanOrdinaryRounding) {
  const int width = 48;
  const auto drives = gradients(width, width);
  for (const char* name : {"rgb", "qd-oled", "rwbg", "pentile-rgbg"})
    for (const double ppd : {40., 67.}) {
      const triad::Layout panel = layout(name);
      const auto energy = [&](Dither mode) {
        return visible_energy(panel, round_picture(panel, drives, width, ppd, {.mode = mode}), drives, width, ppd);
      };
      const double none = energy(Dither::kNone), ordered = energy(Dither::kOrdered),
                   perceptual = energy(Dither::kPerceptual);
      EXPECT_LT(perceptual, (ppd > 60 ? .06 : .2) * none) << name << ppd;
      EXPECT_LT(perceptual, .5 * ordered) << name << ppd;
    }
}

TEST(PanelDitherTest, LaterPassesOnlyImprove) {
  const int width = 48;
  const auto drives = gradients(width, width);
  const triad::Layout panel = layout("qd-oled");
  double before = 0;
  for (int passes = 1; passes <= 4; ++passes) {
    const double now = visible_energy(
        panel, round_picture(panel, drives, width, 40, {.passes = passes, .radius_px = 16}), drives, width, 40);
    if (passes > 1) {
      EXPECT_LT(now, before * 1.02) << passes;
    }
    before = now;
  }
}

TEST(PanelDitherTest, TheSameBitsOnAnyNumberOfThreads) {
  const auto drives = gradients(150, 110);
  triad::set_thread_limit(1);
  const auto alone = round_picture(layout("qd-oled"), drives, 150, 40, {});
  triad::set_thread_limit(0);
  EXPECT_EQ(round_picture(layout("qd-oled"), drives, 150, 40, {}), alone);
}
