// SPDX-License-Identifier: Apache-2.0
// What is seen of any panel: the error in the plane, S-CIELAB, CIELAB.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/colour/cielab.hpp>
#include <triad/colour/colour.hpp>
#include <triad/display/display_error.hpp>
#include <triad/display/s_cielab.hpp>
#include <vector>

#include "layouts.hpp"
#include "panel_reference.hpp"

using triad::DisplayError;
using triad::Edge;
using triad::PanelTorus;
using triad::Range;
namespace reference = triad::reference;
using reference::layout;

namespace {

// Values from -.2 to 1.2.
std::vector<float> random_picture(int pixels, unsigned seed) {
  std::vector<float> out;
  for (const double v : reference::random_cells(pixels, seed)) out.push_back(static_cast<float>(v * 1.4 - .2));
  return out;
}

std::vector<double> energy_of(const DisplayError& measure, const std::vector<float>& test,
                              const std::vector<float>& target) {
  DisplayError::Workspace work(measure);
  std::vector<double> energy(test.size());
  measure.picture({test.data(), 3 * measure.width_px()},
                  {target.data(), 3 * static_cast<ptrdiff_t>(measure.torus().columns())}, energy.data(), work);
  return energy;
}

}  // namespace

TEST(PlaneErrorTest, MatchesTheSumsOfItsDefinitionOnEveryLayout) {
  for (const std::string& name : reference::kLayoutNames)
    for (const Edge edge : {Edge::kMirror, Edge::kWrap})
      for (const bool clip : {true, false}) {
        const triad::Layout panel = layout(name);
        // Mirrored pictures need not end with a tile.
        const int width = edge == Edge::kMirror ? 3 : 2 * panel.tile_x, height = edge == Edge::kMirror ? 1 : 2;
        const auto eye = reference::observer(
            12, clip ? triad::Csf::kScielab : triad::Csf::kKolpatzikBouman);  // low, so that much is seen
        const reference::Torus torus{&panel, width, height, edge == Edge::kMirror, 1, 3};
        const auto test = random_picture(width * height, 1);
        const auto target = random_picture(width * height * panel.pixel_cells(), 2);
        const auto expected = reference::plane_energy(torus, eye, test, target, clip);
        const DisplayError measure(panel, eye, PanelTorus::Shape{width, height, 1, 3, edge, false},
                                   clip ? Range::kClip : Range::kUnbounded);
        const auto got = energy_of(measure, test, target);
        const double total = std::accumulate(expected.begin(), expected.end(), 0.);
        EXPECT_GT(total, 1e-3);
        for (size_t i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], expected[i], 1e-13 * total) << name << " " << i;
      }
}

TEST(PlaneErrorTest, EqualsRowsForPicturesThatAreConstantInY) {
  const int width = 14, height = 5;
  for (const char* name : {"rgb", "bgr"})
    for (const Edge edge : {Edge::kMirror, Edge::kWrap}) {
      const auto eye = reference::observer(20);
      const auto row = random_picture(width, 3), wide = random_picture(3 * width, 4);
      std::vector<float> test, target;
      for (int y = 0; y < height; ++y) {
        test.insert(test.end(), row.begin(), row.end());
        target.insert(target.end(), wide.begin(), wide.end());
      }
      const DisplayError by_row(layout(name), eye, width, edge, Range::kClip);
      const DisplayError plane(layout(name), eye, PanelTorus::Shape{width, height, 0, 0, edge, false}, Range::kClip);
      const auto expected = energy_of(by_row, row, wide), got = energy_of(plane, test, target);
      const double total = std::accumulate(expected.begin(), expected.end(), 0.);
      for (size_t i = 0; i < got.size(); ++i)
        EXPECT_NEAR(got[i], expected[i % expected.size()], 1e-13 * total) << name;
    }
}

TEST(PlaneErrorTest, WhiteAndBlackAreSeenAsThePanelsStructureAlone) {
  for (const std::string& name : reference::kLayoutNames) {
    const triad::Layout panel = layout(name);
    const int width = 4, height = 4;
    for (const float level : {0.f, 1.f}) {
      const DisplayError measure(panel, reference::observer(1000), PanelTorus::Shape{width, height}, Range::kClip);
      const auto got =
          energy_of(measure, std::vector<float>(3 * width * height, level),
                    std::vector<float>(3 * static_cast<size_t>(width * height * panel.pixel_cells()), level));
      for (const double e : got) EXPECT_NEAR(e, 0, 1e-20) << name;  // all of it is finer than an eye at 1000 ppd sees
    }
  }
}

TEST(PlaneErrorTest, TheSameBitsOnAnyNumberOfThreads) {
  const triad::Layout panel = layout("qd-oled");
  const auto test = random_picture(23 * 19, 5), target = random_picture(23 * 19 * 4, 6);
  const DisplayError measure(panel, reference::observer(40), PanelTorus::Shape{23, 19}, Range::kClip);
  triad::set_thread_limit(1);
  const auto alone = energy_of(measure, test, target);
  triad::set_thread_limit(0);
  EXPECT_EQ(energy_of(measure, test, target), alone);
}

TEST(PlaneErrorTest, ThePixelAverageIsTheMeanOfItsCells) {
  const triad::Layout panel = layout("qd-oled");
  const DisplayError measure(panel, reference::observer(40), PanelTorus::Shape{2, 1}, Range::kClip);
  std::vector<float> cells(3 * 8), drives(6);
  cells[0] = 2;      // cell (0, 0), red, clamped to 1
  cells[3 * 4] = 1;  // cell (0, 1), the next row, red
  cells[3 * 2 + 1] = .5f;
  measure.pixel_average({cells.data(), 12}, drives.data());
  EXPECT_EQ(drives, (std::vector<float>{.5f, 0, 0, 0, .125f, 0}));
}

TEST(PlaneErrorTest, RefusesWithAClearLine) {
  const auto eye = reference::observer(40);
  const auto message = [&](const std::string& name, const PanelTorus::Shape& shape) -> std::string {
    try {
      DisplayError(layout(name), eye, shape, Range::kClip);
    } catch (const triad::Error& error) {
      return error.what();
    }
    return "nothing was thrown";
  };
  EXPECT_NE(message("pentile-rgbg", {3, 2, 0, 0, Edge::kWrap}).find("edge=wrap needs a width of whole tiles"),
            std::string::npos);
  EXPECT_NE(message("qd-oled", {3, 1, 0, 0, Edge::kMirror, true}).find("qd-oled"), std::string::npos);
  EXPECT_NE(message("rgb", {0, 2}).find("at least 1 pixel"), std::string::npos);
  EXPECT_NE(message("rgb", {1 << 27, 2}).find("too long"), std::string::npos);
}

TEST(DeltaTotalsTest, PercentilesAndMeansAreWeighted) {
  // Uniform on (0, 10], each value once and then half of the upper half again.
  triad::DeltaTotals totals{}, second{};
  for (int i = 1; i <= 10000; ++i) totals.add(i * 1e-3, 1);
  EXPECT_NEAR(totals.mean(), 5.0005, 1e-12);
  EXPECT_NEAR(totals.percentile(.95), 9.5, .01 * 9.5);
  EXPECT_NEAR(totals.percentile(.5), 5, .01 * 5);
  EXPECT_NEAR(totals.percentile(.01), .1, .01 * .1);
  for (int i = 5001; i <= 10000; ++i) second.add(i * 1e-3, .5);
  totals.merge(second);
  // 12500 in all; below 8 lie 8000 + 1500.
  EXPECT_NEAR(totals.percentile(9500. / 12500), 8, .01 * 8);
  triad::DeltaTotals none{};
  none.add(0, 3);
  EXPECT_EQ(none.percentile(.95), 0);
}

TEST(CielabTest, MatchesPublishedColours) {
  // sRGB's primaries and secondaries (D65): the values that colour pickers show.
  const auto& m = triad::rec709_to_xyz();
  const auto lab = [&](double r, double g, double b) {
    std::array<double, 3> xyz{}, white{};
    for (size_t i = 0; i < 3; ++i) {
      xyz[i] = m[3 * i] * r + m[3 * i + 1] * g + m[3 * i + 2] * b;
      white[i] = m[3 * i] + m[3 * i + 1] + m[3 * i + 2];
    }
    return triad::xyz_to_lab(xyz, white);
  };
  const struct {
    double rgb[3], L, a, b;
  } published[] = {{{1, 0, 0}, 53.24, 80.09, 67.20},
                   {{0, 1, 0}, 87.73, -86.18, 83.18},
                   {{0, 0, 1}, 32.30, 79.19, -107.86},
                   {{1, 1, 0}, 97.14, -21.55, 94.48},
                   {{0, 1, 1}, 91.11, -48.09, -14.13},
                   {{1, 1, 1}, 100, 0, 0},
                   {{0, 0, 0}, 0, 0, 0}};
  for (const auto& p : published) {
    const triad::Lab got = lab(p.rgb[0], p.rgb[1], p.rgb[2]);
    EXPECT_NEAR(got.L, p.L, .011);
    EXPECT_NEAR(got.a, p.a, .025);
    EXPECT_NEAR(got.b, p.b, .025);
  }
  // Both pieces meet at (6/29)^3, in value and slope: 116^3 / 27 = 903.3 L per unit of Y below it.
  const double join = std::pow(6. / 29, 3);
  EXPECT_NEAR(triad::xyz_to_lab({join, join, join}, {1, 1, 1}).L, 8, 1e-12);
  EXPECT_NEAR(triad::xyz_to_lab({0, .001, 0}, {1, 1, 1}).L, .9032962963, 1e-9);
  EXPECT_NEAR(triad::cie76({50, 3, 4}, {48, 0, -2}), 7, 1e-14);
}

TEST(SCielabTest, TheKernelsSumToOne) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(triad::scielab_metric_mtf(c, 0), 1, 1e-15);
  // The third Gaussian is gone at a few tenths of a cycle per degree, and the two others are the error's.
  EXPECT_NEAR(
      triad::scielab_metric_mtf(0, .1),
      triad::mtf(reference::observer(40), 0, .1) - .117686 * std::exp(-std::pow(std::numbers::pi * 4.336 * .1, 2)),
      1e-12);
}

TEST(SCielabTest, UniformFieldsGetPlainCielab) {
  const triad::SCielab metric(reference::kRec709ToXyz, {30, 20, 17, 11, 120, 40});
  triad::SCielab::Workspace work(metric);
  const double one[3] = {.2, .5, .05}, other[3] = {.25, .48, .1};
  const auto field = [](const double* rgb) {
    return [rgb](size_t, double* row) {
      for (int k = 0; k < 30; ++k) std::copy_n(rgb, 3, row + 3 * k);
    };
  };
  std::array<double, 3> xyz[2]{}, white{};
  for (size_t i = 0; i < 3; ++i)
    for (size_t d = 0; d < 3; ++d) {
      xyz[0][i] += reference::kRec709ToXyz[3 * i + d] * one[d];
      xyz[1][i] += reference::kRec709ToXyz[3 * i + d] * other[d];
      white[i] += reference::kRec709ToXyz[3 * i + d];
    }
  const double expected = triad::cie76(triad::xyz_to_lab(xyz[0], white), triad::xyz_to_lab(xyz[1], white));
  std::vector<double> got(17 * 11, -1);
  metric.delta_e(
      field(one), field(other), [&](size_t y, const double* values) { std::copy_n(values, 17, &got[y * 17]); }, work);
  for (const double v : got) EXPECT_NEAR(v, expected, 2e-5);
  EXPECT_GT(expected, 5);
}

TEST(SCielabTest, AGratingIsSeenWithTheKernelsTransfer) {
  // Grey with a small cosine of f cycles per degree on it, against plain grey. A grey of XYZ proportional to the
  // white stays grey in luminance only if all channels pass alike; so the opponent values are computed one by one
  // here.
  const int n = 64, cycles = 6;
  const double ppd = 60, f = cycles * ppd / n, mean = .4, swing = .05;
  const triad::SCielab metric(reference::kRec709ToXyz, {n, 8, n, 8, ppd, ppd});
  triad::SCielab::Workspace work(metric);
  std::vector<double> got(n * 8);
  const auto value = [&](int k) { return mean + swing * std::cos(2 * std::numbers::pi * cycles * k / n); };
  metric.delta_e(
      [&](size_t, double* row) {
        for (int k = 0; k < n; ++k) std::fill_n(row + 3 * k, 3, value(k));
      },
      [&](size_t, double* row) { std::fill_n(row, 3 * n, mean); },
      [&](size_t y, const double* values) { std::copy_n(values, n, &got[y * n]); }, work);
  Eigen::Matrix3d to_opponent, to_xyz;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      to_opponent(i, j) = triad::xyz_to_opponent()[static_cast<size_t>(3 * i + j)];
      to_xyz(i, j) = reference::kRec709ToXyz[static_cast<size_t>(3 * i + j)];
    }
  const Eigen::Vector3d white = to_xyz * Eigen::Vector3d::Ones(), grey = to_opponent * white;
  for (int k = 0; k < n; ++k) {
    Eigen::Vector3d seen;
    for (int c = 0; c < 3; ++c) seen[c] = grey[c] * (mean + (value(k) - mean) * triad::scielab_metric_mtf(c, f));
    const Eigen::Vector3d xyz = to_opponent.inverse() * seen;
    const std::array<double, 3> w{white[0], white[1], white[2]};
    const double expected = triad::cie76(triad::xyz_to_lab({xyz[0], xyz[1], xyz[2]}, w),
                                         triad::xyz_to_lab({w[0] * mean, w[1] * mean, w[2] * mean}, w));
    for (int y = 0; y < 8; ++y) EXPECT_NEAR(got[static_cast<size_t>(y * n + k)], expected, 2e-5);
  }
}
