// SPDX-License-Identifier: Apache-2.0
// The closed forms of the functions against brute force, and against other closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <triad/base/error.hpp>
#include <triad/numeric/fresnel.hpp>
#include <triad/sampling/functions.hpp>
#include <triad/sampling/reconstruction.hpp>

#include "brute_force.hpp"

using namespace triad;
using test::Box;
using test::value_at;

namespace {

std::unique_ptr<Source> make(const std::string& text, int width = 160, int height = 90, const Cells& cells = {}) {
  return make_function(text, width, height, cells, "test");
}

double exact(const Source& source, const Box& box) {
  const auto rgb = source.integral(box.x0, box.y0, box.x1, box.y1).value();
  EXPECT_EQ(rgb[0], rgb[1]);
  EXPECT_EQ(rgb[0], rgb[2]);
  return rgb[0];
}

double gaussian(const Source& source, double x, double y, double sigma_px) {
  return source.filtered(x, y, {.gaussian_sigma_px = sigma_px}).value()[0];
}

// Of side `side_px`, with its middle at odd places of a picture of 160 x 90.
std::vector<Box> odd_boxes(double side_px) {
  std::vector<Box> boxes;
  for (const auto& [x, y] : {std::pair{80., 45.}, {81.37, 44.21}, {40.618, 61.73}, {131.9, 20.04}}) {
    const double half = .5 * side_px;
    boxes.push_back({x - half, y - .8 * half, x + half, y + .8 * half});
  }
  return boxes;
}

}  // namespace

// ---- edges

// The page of formulas that every text on antialiasing has: the share of a unit box inside a half-plane with unit
// normal (a, b) sorted to a >= b >= 0, at signed distance d of its middle.
double half_plane_formula(double a, double b, double d) {
  a = std::abs(a), b = std::abs(b);
  if (a < b) std::swap(a, b);
  const double h = .5 * (a + b), k = .5 * (a - b);
  if (d <= -h) return 0;
  if (d >= h) return 1;
  if (d < -k) return (d + h) * (d + h) / (2 * a * b);
  if (d > k) return 1 - (h - d) * (h - d) / (2 * a * b);
  return .5 + d / a;
}

TEST(Edges, HalfPlaneIsTheTextbookFormula) {
  for (const double angle : {0., 20., 45., 90., 133.7, 180., 271., -60.}) {
    const auto source = make("half-plane:shift=.31,angle=" + std::to_string(angle));
    const double radians = angle * std::numbers::pi / 180, nx = std::cos(radians), ny = std::sin(radians);
    for (double t = -1; t <= 1; t += .0625) {
      // Middles along the normal, and off along the edge.
      const double x = 80 + (.31 + t) * nx - 3.3 * ny, y = 45 + (.31 + t) * ny + 3.3 * nx;
      EXPECT_NEAR(exact(*source, {x - .5, y - .5, x + .5, y + .5}), half_plane_formula(nx, ny, -t), 1e-13)
          << angle << " " << t;
      // A box of 50 pixels at 50 times the distance is the same picture.
      const double far_x = 80 + (.31 + 50 * t) * nx, far_y = 45 + (.31 + 50 * t) * ny;
      EXPECT_NEAR(exact(*source, {far_x - 25, far_y - 25, far_x + 25, far_y + 25}), half_plane_formula(nx, ny, -t),
                  1e-13);
      EXPECT_NEAR(gaussian(*source, x, y, .5), .5 * std::erfc(t / .5 / std::numbers::sqrt2), 1e-13);
    }
  }
}

TEST(Edges, ThinLineIsTwoHalfPlanes) {
  for (const double width : {.001, .3, 1., 7.}) {
    const auto source = make("thin-line:angle=20,shift=-1.2,width=" + std::to_string(width));
    const double nx = std::cos(std::numbers::pi / 9), ny = std::sin(std::numbers::pi / 9);
    double light = 0;
    for (int x = 70; x < 90; ++x) {
      const double d = (x + .5 - 80) * nx + .5 * ny + 1.2;  // of the middle of pixel (x, 45) from the line's middle
      const double expected =
          half_plane_formula(nx, ny, .5 * width - d) - half_plane_formula(nx, ny, -.5 * width - d);
      EXPECT_NEAR(exact(*source, {x * 1., 45, x + 1., 46}), expected, 1e-13);
      light += expected;
    }
    EXPECT_NEAR(light, width / nx, 1e-12);  // along a row a line of width w is w / cos(angle) long
    EXPECT_EQ(value_at(*source, 80 - 1.2 * nx, 45 - 1.2 * ny), 1);
    EXPECT_EQ(value_at(*source, 80 - (1.2 + .51 * width) * nx, 45 - (1.2 + .51 * width) * ny), 0);
    const double s = .5 * std::numbers::sqrt2;
    EXPECT_NEAR(gaussian(*source, 80 - .9 * nx, 45 - .9 * ny, .5),
                .5 * std::erfc((.3 - .5 * width) / s) - .5 * std::erfc((.3 + .5 * width) / s), 1e-13);
  }
}

TEST(Edges, FlatAndRampAreTheirMiddles) {
  const auto flat = make("flat:level=.7"), ramp = make("ramp");
  EXPECT_NEAR(exact(*flat, {3, 4, 3.1, 60}), .7, 1e-7);
  const auto mean = ramp->integral(40, 9, 80, 81).value();
  EXPECT_NEAR(mean[0], 60. / 160, 1e-6);
  EXPECT_NEAR(mean[2], .5, 1e-6);
  EXPECT_NEAR(ramp->filtered(60, 45, {.gaussian_sigma_px = 3}).value()[0], 60. / 160, 1e-6);
}

// ---- patterns

// Polygons cut by straight lines, one after the other: slow, and nothing like sums along a box's sides.
struct Corner {
  double x, y;
};
std::vector<Corner> cut(const std::vector<Corner>& polygon, double nx, double ny, double most) {
  std::vector<Corner> kept;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Corner a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    const double da = nx * a.x + ny * a.y - most, db = nx * b.x + ny * b.y - most;
    if (da <= 0) kept.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0))
      kept.push_back({(a.x * db - b.x * da) / (db - da), (a.y * db - b.y * da) / (db - da)});
  }
  return kept;
}
double area(const std::vector<Corner>& polygon) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Corner a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    twice += a.x * b.y - b.x * a.y;
  }
  return .5 * std::abs(twice);
}

// The bright share of a box: stripes of width cell_px, the first to the right of the middle bright, or squares.
double bright_share(const Box& box, double cell_px, double angle_deg, bool squares) {
  const double radians = angle_deg * std::numbers::pi / 180, nx = std::cos(radians), ny = std::sin(radians);
  const std::vector<Corner> corners{
      {box.x0 - 80, box.y0 - 45}, {box.x1 - 80, box.y0 - 45}, {box.x1 - 80, box.y1 - 45}, {box.x0 - 80, box.y1 - 45}};
  double bright = 0;
  const int reach = static_cast<int>(120 / cell_px);
  for (int i = -reach; i < reach; ++i) {
    const auto stripe = cut(cut(corners, nx, ny, (i + 1) * cell_px), -nx, -ny, -i * cell_px);
    if (stripe.empty()) continue;
    if (!squares && i % 2 == 0) bright += area(stripe);
    for (int j = -reach; squares && j < reach; ++j)
      if ((i + j) % 2 != 0) bright += area(cut(cut(stripe, -ny, nx, (j + 1) * cell_px), ny, -nx, -j * cell_px));
  }
  return bright / ((box.x1 - box.x0) * (box.y1 - box.y0));
}

TEST(Patterns, TurnedStripesAndSquaresAgainstPolygons) {
  for (const double angle : {0., 12., 45., -57.3, 90., 211.})
    for (const double cell_px : {.23, 3.7, 11.3})
      for (const double side_px : {.1, 1., 7.3, 50.}) {
        if (side_px / cell_px > 50) continue;
        const auto turned = ",angle=" + std::to_string(angle);
        const auto checker = make("checker:cell=" + std::to_string(cell_px) + turned);
        const auto stripes = make("stripes:period=" + std::to_string(2 * cell_px) + turned);
        for (const Box& box : odd_boxes(side_px)) {
          EXPECT_NEAR(exact(*checker, box), bright_share(box, cell_px, angle, true), 1e-10)
              << angle << " " << side_px;
          EXPECT_NEAR(exact(*stripes, box), bright_share(box, cell_px, angle, false), 1e-10);
          // And the picture itself has these squares.
          const double x = box.x0 + .0137, y = box.y0 + .0073;
          const Box point{x, y, x + 1e-6, y + 1e-6};
          EXPECT_EQ(value_at(*checker, x, y), std::round(bright_share(point, cell_px, angle, true)));
          EXPECT_EQ(value_at(*stripes, x, y), std::round(bright_share(point, cell_px, angle, false)));
        }
      }
}

TEST(Patterns, UprightCheckerIsAProductOfWaves) {
  const auto source = make("checker:cell=3.7");
  // 1-D means of the sign along x and y, found from the picture itself; at (80, 45) four squares meet.
  const auto sign = [&](double a, double b, bool across) {
    return test::mean_of_steps(
        [&](double t) { return across ? 1 - 2 * value_at(*source, t, 46) : 1 - 2 * value_at(*source, 81, t); }, a, b,
        400);
  };
  for (const double side_px : {.1, 1., 7.3, 50.})
    for (const Box& box : odd_boxes(side_px))
      EXPECT_NEAR(exact(*source, box), .5 - .5 * sign(box.x0, box.x1, true) * sign(box.y0, box.y1, false), 1e-12);
  // A whole number of squares is half bright.
  EXPECT_NEAR(exact(*source, {80 - 3 * 3.7, 30.3, 80 + 5 * 3.7, 71.9}), .5, 1e-13);
}

TEST(Patterns, UprightWavesUnderSeparableFilters) {
  // A tent of radius 1.3 pixels, and its integral.
  const double r = 1.3;
  const SeparableFilter tent{.radius_px = r, .cumulative = [=](double t) {
                               const double half = .5 * (1 - std::abs(t) / r) * (1 - std::abs(t) / r);
                               return t < 0 ? half : 1 - half;
                             }};
  const SeparableFilter box{.radius_px = .5, .cumulative = [](double t) { return .5 + t; }};
  const Cells cells{3, 2};
  for (const std::string text : {"checker:cell=3.7", "checker:cell=.37", "stripes:period=2.3,shift=.2"}) {
    const auto source = make(text), wide = make(text, 160, 90, cells);
    for (const auto& [x, y] : {std::pair{80., 45.}, {81.37, 44.21}, {40.618, 61.73}}) {
      EXPECT_NEAR(source->filtered(x, y, box).value()[0], exact(*source, {x - .5, y - .5, x + .5, y + .5}), 1e-12);
      // Sums over a fine grid; each of up to 8 edges is misplaced by half a step of .65e-4 at most, where the filter
      // is below 1 / 1.3 px: 8 * .65e-4 / 1.3 / 2 at most.
      const auto wave = [&](const Source& of, bool across, double at, double weight_radius, const auto& weight) {
        const int steps = 40000;
        double sum = 0, total = 0;
        for (int i = 0; i < steps; ++i) {
          const double t = weight_radius * ((2. * i + 1) / steps - 1);
          const double s = across ? 1 - 2 * value_at(of, at + t, y * (&of == wide.get() ? 2 : 1) + 1e-3)
                                  : 1 - 2 * value_at(of, x * (&of == wide.get() ? 3 : 1) + 1e-3, at + t);
          sum += s * weight(t);
          total += weight(t);
        }
        return sum / total;
      };
      const auto tone = [&](const Source& of, double at_x, double at_y, double radius, const auto& weight) {
        const double across = wave(of, true, at_x, radius, weight);
        if (text[0] == 's') return .5 - .5 * across;
        // Each of the waves has the sign of the other at the fixed line: s(x) s(y0) and s(x0) s(y).
        const double fixed =
            1 - 2 * value_at(of, x * (&of == wide.get() ? 3 : 1) + 1e-3, y * (&of == wide.get() ? 2 : 1) + 1e-3);
        return .5 - .5 * across * wave(of, false, at_y, radius, weight) / fixed;
      };
      const auto tent_weight = [&](double t) { return r - std::abs(t); };
      const auto normal_weight = [](double t) { return std::exp(-2 * t * t); };
      EXPECT_NEAR(source->filtered(x, y, tent).value()[0], tone(*source, x, y, r, tent_weight), 2e-4);
      EXPECT_NEAR(gaussian(*source, x, y, .5), tone(*source, x, y, 4, normal_weight), 2e-4);
      for (const auto kernel :
           {ReconstructionKernel::kGaussian, ReconstructionKernel::kMitchell, ReconstructionKernel::kLanczos3}) {
        const ReconstructionFilter f(kernel);
        const SeparableFilter separable{.radius_px = f.radius_px(),
                                        .cumulative = [&](double t) { return f.cumulative(t); }};
        EXPECT_NEAR(source->filtered(x, y, separable).value()[0],
                    tone(*source, x, y, f.radius_px(), [&](double t) { return f.value(t); }), 5e-4)
            << f.name();
      }
      EXPECT_NEAR(wide->filtered(3 * x, 2 * y, tent).value()[0], tone(*wide, 3 * x, 2 * y, r, tent_weight), 2e-4);
      EXPECT_NEAR(gaussian(*wide, 3 * x, 2 * y, .5), tone(*wide, 3 * x, 2 * y, 4, normal_weight), 2e-4);
    }
  }
  EXPECT_FALSE(make("checker:angle=12")->filtered(9, 9, tent));
  EXPECT_FALSE(make("half-plane:angle=12")->filtered(9, 9, tent));
  EXPECT_NEAR(make("half-plane:angle=0")->filtered(80.4, 9, tent).value()[0], .5 * .9 / 1.3 * .9 / 1.3, 1e-13);
}

TEST(Patterns, StripesOfOnePixelAreEvenForOneSampleAPixel) {
  const auto source = make("stripes");
  for (int x = 0; x < 160; ++x) EXPECT_EQ(value_at(*source, x + .25, 7.5), value_at(*source, .25, 3));
  EXPECT_NEAR(exact(*source, {17, 5, 18, 6}), .5, 1e-13);
  EXPECT_NEAR(exact(*source, {17, 5, 17.5, 6}), 1, 1e-13);
}

TEST(Patterns, DiscsHaveTheirArea) {
  for (const double radius : {.02, .3, 2.1}) {
    const auto source = make("discs:spacing=4.3,radius=" + std::to_string(radius));
    // Whole periods, wherever they begin.
    for (const double x : {3., 4.1, 77.7})
      EXPECT_NEAR(exact(*source, {x, x / 3, x + 3 * 4.3, x / 3 + 2 * 4.3}),
                  std::numbers::pi * radius * radius / 4.3 / 4.3, 1e-13);
  }
  const auto source = make("discs:spacing=4.3,radius=1.7");
  for (const double side_px : {.1, 1., 3.1})
    for (const Box& box : odd_boxes(side_px))
      EXPECT_NEAR(exact(*source, box), test::mean_by_lines(*source, box, 2000, 60), 1e-5) << side_px;
  // A large box is made of small ones.
  for (const Box& box : odd_boxes(50)) {
    double sum = 0;
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 50; ++i) sum += exact(*source, {box.x0 + i, box.y0 + j, box.x0 + i + 1, box.y0 + j + 1});
    EXPECT_NEAR(exact(*source, box), sum / 2000, 1e-12);
  }
}

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

// ---- all of them

TEST(Functions, ShowTheSamePictureWhateverTheCellsAndTheSize) {
  for (const FunctionInfo* info : function_list()) {
    const bool has_rows =
        std::any_of(info->params.begin(), info->params.end(), [](auto& p) { return p.name == "rows"; });
    const bool pixels = info->name == "strokes" || info->name == "colours" || info->name == "stems";
    const std::string text = info->name + (has_rows ? ":rows=90" : "");
    const auto plain = make(text), wide = make(text, 160, 90, {3, 2}), large = make(text, 480, 270);
    ASSERT_EQ(wide->width(), 480);
    ASSERT_EQ(wide->height(), 180);
    for (int i = 0; i < 300; ++i) {
      const double x = std::round(160 * 64 * std::fmod(i * .618, 1)) / 64 + 1 / 97.;
      const double y = std::round(90 * 64 * std::fmod(i * .755, 1)) / 64 + 1 / 89.;
      const double value = value_at(*plain, x, y);
      EXPECT_NEAR(value_at(*wide, 3 * x, 2 * y), value, 1e-4) << text;
      if (!pixels) {
        EXPECT_NEAR(value_at(*large, 3 * x, 3 * y), value, 1e-4) << text << " " << x << " " << y;
      }
    }
    if (!plain->abilities().exact_integral) continue;
    const auto mean = plain->integral(31.3, 40.1, 32.9, 41.4).value();
    for (const auto& again : {wide->integral(3 * 31.3, 2 * 40.1, 3 * 32.9, 2 * 41.4).value(),
                              large->integral(3 * 31.3, 3 * 40.1, 3 * 32.9, 3 * 41.4).value()})
      for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(again[c], mean[c], 1e-6) << text;
  }
}

TEST(Functions, LowAndHighAreTheirTones) {
  const auto usual = make("checker:angle=12"), soft = make("checker:angle=12,low=.4,high=.6");
  for (const Box& box : odd_boxes(2.3)) EXPECT_NEAR(exact(*soft, box), .4 + .2 * exact(*usual, box), 1e-14);
  for (int x = 0; x < 90; ++x) EXPECT_NEAR(value_at(*soft, x + .3, x), .4 + .2 * value_at(*usual, x + .3, x), 1e-7);
}

TEST(Functions, WhiteOnWhiteIsSeenByIdsAndPositionsOnly) {
  const auto sample = [](const Source& source, double x, double y) {
    SampleRequest request;
    request.x = x;
    request.y = y;
    Sample s;
    source.eval({&request, 1}, {&s, 1});
    return s;
  };
  for (const std::string tell : {"both", "ids", "position"}) {
    const auto source = make("white-on-white:angle=0,tell=" + tell);
    EXPECT_TRUE(source->abilities().geometry);
    const Sample left = sample(*source, 79.9, 45), right = sample(*source, 80.1, 45);
    EXPECT_EQ(left.rgb, right.rgb);
    EXPECT_EQ(left.object_id != right.object_id, tell != "position");
    EXPECT_EQ(left.distance != right.distance, tell != "ids");
    EXPECT_FLOAT_EQ(right.position[2], -right.distance);
    EXPECT_EQ(exact(*source, {79, 4, 81, 5}), 1);
    // Positions are even on each sheet: half a picture height is half a unit.
    EXPECT_FLOAT_EQ(sample(*source, 120, 0).position[0] - right.position[0], (120 - 80.1f) / 90);
    EXPECT_FLOAT_EQ(sample(*source, 120, 0).position[1], .5f);
  }
}

TEST(Functions, SmallThingsHaveTheirLight) {
  const auto speck = make("speck");
  double light = 0;
  for (int y = 40; y < 50; ++y)
    for (int x = 75; x < 85; ++x) light += exact(*speck, {x * 1., y * 1., x + 1., y + 1.});
  EXPECT_NEAR(light, std::numbers::pi * .05 * .05 * 1000, 1e-9);
  EXPECT_EQ(value_at(*speck, .502 * 160, .503 * 90), 1000);
  // Samples of one in 4 x 4 pixels, in the middles of their squares, miss the small object.
  const auto object = make("small-object");
  for (int y = 2; y < 90; y += 4)
    for (int x = 2; x < 160; x += 4) EXPECT_EQ(value_at(*object, x, y), 0);
  EXPECT_NEAR(exact(*object, {70, 40, 90, 50}) * 200, std::numbers::pi * .9 * .9, 1e-12);
}

TEST(Functions, SayWhatIsWrong) {
  const auto message = [](const std::string& text) {
    try {
      make(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage);
      return std::string(error.what());
    }
    return std::string();
  };
  using testing::AllOf;
  using testing::HasSubstr;
  EXPECT_THAT(message("zone-plat"), AllOf(HasSubstr("test"), HasSubstr("zone-plat'"), HasSubstr("'zone-plate'")));
  EXPECT_THAT(message("checker:cel=3"), AllOf(HasSubstr("checker"), HasSubstr("did you mean 'cell'")));
  EXPECT_THAT(message("checker:cell=0"), AllOf(HasSubstr("cell='0'"), HasSubstr("1e-04 to 1e+05")));
  EXPECT_THAT(message("checker:cell"), HasSubstr("a function is written name:key=value"));
  EXPECT_THAT(message("white-on-white:tell=id"), HasSubstr("did you mean 'ids'"));
  EXPECT_THAT(message("discs:radius=3"), AllOf(HasSubstr("radius=3"), HasSubstr("spacing=4.3")));
  EXPECT_THAT(message("discs:radius=.01,spacing=.02,rows=100000"), HasSubstr("larger spacing"));
  EXPECT_THAT(message("chirp:top=3"), AllOf(HasSubstr("top=3"), HasSubstr("bottom=4")));
  EXPECT_EQ(function_text("checker:angle=12", "test"), "checker:cell=3.7,angle=12,rows=0,low=0,high=1");
}
