// SPDX-License-Identifier: Apache-2.0
// Functions whose detail gets finer without end, against quadrature and lines: zone plate, chirp, horizon.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <triad/numeric/fresnel.hpp>

#include "brute_force.hpp"

using namespace triad;
using test::Box;
using test::exact;
using test::gaussian;
using test::make;
using test::odd_boxes;
using test::value_at;

// ---- zone plate

TEST(Fresnel, PublishedValues) {
  // Abramowitz and Stegun, table 7.7.
  const double table[][3] = {{.5, .4923442, .0647324},
                             {1, .7798934, .4382591},
                             {2, .4882534, .3434157},
                             {3, .6057208, .4963130},
                             {5, .5636312, .4991914}};
  for (const auto& [z, c, s] : table) {
    EXPECT_NEAR(fresnel(z).real(), c, 6e-8) << z;
    EXPECT_NEAR(fresnel(z).imag(), s, 6e-8) << z;
    EXPECT_EQ(fresnel(-z), -fresnel(z));
  }
}

TEST(Fresnel, AgainstQuadrature) {
  using Complex = std::complex<double>;
  for (double z = .01; z < 14; z += .0837) {
    const Complex mean = test::mean_by_quadrature<Complex>(
        [](double t) { return std::exp(Complex(0, .5 * std::numbers::pi * t * t)); }, 0, z,
        100 + static_cast<int>(40 * z * z));
    EXPECT_NEAR(std::abs(fresnel(z) - z * mean), 0, 3e-14) << z;
  }
  EXPECT_NEAR(std::abs(fresnel(2 - 1e-13) - fresnel(2 + 1e-13)), 0, 1e-12);  // where the method changes
}

TEST(ZonePlate, AgainstQuadrature) {
  const auto source = make("zone-plate:rings=30");
  // At the middle, between, at the nearest edge, at the corner: 2 pi / 3 to 4.2 radians a pixel.
  for (const auto& [x, y] : {std::pair{80., 45.}, {81.3, 43.9}, {97.1, 61.2}, {80.4, 1.7}, {158.3, 88.8}})
    for (const double side_px : {.1, 1., 2.7, 20.}) {
      const Box box{x - .5 * side_px, y - .4 * side_px, x + .5 * side_px, y + .4 * side_px};
      const int panels = 3 + static_cast<int>(3 * side_px);
      const double mean = test::mean_by_quadrature<double>(
          [&](double v) {
            return test::mean_by_quadrature<double>([&](double u) { return value_at(*source, u, v); }, box.x0, box.x1,
                                                    panels);
          },
          box.y0, box.y1, panels);
      EXPECT_NEAR(exact(*source, box), mean, 2e-7) << x << " " << y << " " << side_px;
    }
  EXPECT_EQ(value_at(*source, 80, 45), 1);
  // Half a ring: the phase is pi where a r^2 is.
  EXPECT_NEAR(value_at(*source, 80 + 45 * std::sqrt(.5 / 30), 45), 0, 1e-6);
}

TEST(ZonePlate, UnderAGaussian) {
  for (const Cells cells : {Cells{1, 1}, Cells{3, 1}}) {
    const auto source = make("zone-plate:rings=30", 160, 90, cells);
    for (const auto& [x, y] : {std::pair{80., 45.}, {81.3, 43.9}, {80.4, 1.7}, {158.3, 88.8}}) {
      const double sigma = .7, end = 6 * sigma, at = x * cells.x;
      const auto weighted = test::mean_by_quadrature<double>(
          [&](double v) {
            return test::mean_by_quadrature<double>(
                [&](double u) {
                  const double weight = std::exp(-.5 * ((u - at) * (u - at) + (v - y) * (v - y)) / (sigma * sigma));
                  return weight * value_at(*source, u, v);
                },
                at - end, at + end, 20);
          },
          y - end, y + end, 20);
      const double whole = 2 * std::numbers::pi * sigma * sigma / (4 * end * end);
      EXPECT_NEAR(gaussian(*source, at, y, sigma), weighted / whole, 1e-6);
    }
  }
}

// ---- chirp and horizon

TEST(Chirp, AgainstLines) {
  const auto source = make("chirp:bottom=3,top=150");
  for (const double side_px : {.1, 1., 7.3})
    for (const Box& box : odd_boxes(side_px))
      EXPECT_NEAR(exact(*source, box), test::mean_by_lines(*source, box, 2000, 120), 4e-6) << side_px;
  // 50 pixels reach where a band is a quarter of a pixel wide.
  for (const Box& box : odd_boxes(50))
    EXPECT_NEAR(exact(*source, box), test::mean_by_lines(*source, box, 2000, 800), 1e-5);
  // The frequency: bright bands of 1 / 3 of the height at the bottom, of 1 / 150 at the top.
  EXPECT_EQ(value_at(*source, 80 + 14.9, 90), 1);
  EXPECT_EQ(value_at(*source, 80 + 15.1, 90), 0);
  EXPECT_EQ(value_at(*source, 80 + .29, 0), 1);
  EXPECT_EQ(value_at(*source, 80 + .31, 0), 0);
  // One frequency everywhere.
  EXPECT_NEAR(exact(*make("chirp:bottom=3,top=3"), {80, 0, 80 + 22.5, 90}), 15 / 22.5, 1e-12);
}

TEST(Horizon, AgainstColumns) {
  const auto source = make("horizon");  // at row 27, squares of 13.5 pixels at the bottom
  for (const Box& box : {Box{81.3, 60.2, 81.4, 60.3}, Box{95.1, 47.3, 96.1, 48.3}, Box{33.3, 40.1, 40.6, 47.4},
                         Box{100.2, 38, 150.2, 88}})
    EXPECT_NEAR(exact(*source, box), test::mean_by_lines(*source, box, 2000, 300, true), 1e-5) << box.x0;
  EXPECT_EQ(exact(*source, {3, 4, 9, 27}), .5);
  EXPECT_EQ(exact(*make("horizon:sky=.25"), {3, 4, 9, 27}), .25);
  // Rows of squares have edges where 1.2 (.7 / .15) / eta is whole, eta heights below the horizon: the eighth at 5.6
  // / 8.
  const double row = 27 + 90 * 5.6 / 8;
  EXPECT_NE(value_at(*source, 81, row + .01), value_at(*source, 81, row - .01));
  EXPECT_NE(value_at(*source, 80 + 13.4, 90), value_at(*source, 80 + 13.6, 90));
}

// Sums of the square waves' known integrals along x over depths a fortieth of a square apart, up to where the floor
// is grey.
double horizon_reference(double x0_px, double x1_px, double bottom_px) {
  constexpr double kAcross = .7 / .15, kAway = 1.2 * kAcross, kFarthest = 1e5;
  const double x0 = (x0_px - 80) / 90, x1 = (x1_px - 80) / 90, near = (bottom_px - 27) / 90;
  const auto triangle = [](double t) {
    const double rest = std::fmod(std::abs(t), 2.);
    return rest < 1 ? rest : 2 - rest;
  };
  double sum = 0;
  constexpr int kParts = 40;
  for (double row = std::floor(kAway / near); row < kFarthest; ++row)
    for (int part = 0; part < kParts; ++part) {
      const double begin = std::max(kAway / near, row + part / double{kParts});
      const double end = std::max(begin, row + (part + 1) / double{kParts});
      const double depth = kAway / (.5 * (begin + end));
      const double across = depth / kAcross * (triangle(kAcross * x1 / depth) - triangle(kAcross * x0 / depth));
      sum += (std::fmod(row, 2) == 0 ? 1 : -1) * across * (kAway / begin - kAway / end);
    }
  return .5 - .5 * sum / ((x1 - x0) * near);
}

TEST(Horizon, AtTheHorizon) {
  const auto source = make("horizon");
  // A pixel just below, in the middle, where rows and columns are in step (x = 1.2 heights), and elsewhere.
  for (const double x : {80., 80 + 1.2 * 90, 17.3})
    EXPECT_NEAR(exact(*source, {x, 27, x + 1, 28}), horizon_reference(x, x + 1, 28), 2e-7) << x;
  // Half of it sky.
  EXPECT_NEAR(exact(*make("horizon:sky=1"), {17.3, 26, 18.3, 28}), .5 + .5 * horizon_reference(17.3, 18.3, 28), 2e-7);
  // From squares far smaller than a pixel: half-way between bright and dark.
  EXPECT_NEAR(exact(*source, {60, 27, 61, 27.1}), .5, 2e-3);
}
