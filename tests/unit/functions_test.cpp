// SPDX-License-Identifier: Apache-2.0
// The closed forms of straight functions against brute force and other closed forms; what all functions share.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <triad/base/error.hpp>
#include <triad/sampling/exact.hpp>
#include <triad/sampling/functions.hpp>
#include <triad/sampling/reconstruction.hpp>

#include "brute_force.hpp"

using namespace triad;
using test::Box;
using test::exact;
using test::gaussian;
using test::make;
using test::odd_boxes;
using test::value_at;

// ---- edges

// The share of a unit box inside a half-plane with unit
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
  // As the help says of quad's first samples in other sizes.
  const auto missed = make("small-object", 400, 225);
  for (int y = 2; y < 225; y += 4)
    for (int x = 2; x < 400; x += 4) EXPECT_EQ(value_at(*missed, x, y), 0);
  EXPECT_EQ(value_at(*make("small-object", 404, 228), 202, 114), 1);
}

TEST(Functions, ExactPicturesCanBeEndedInsideARow) {
  int asked = 0;
  const auto picture = exact_picture(*make("flat", 1000, 1), {.stop = [&] { return ++asked > 10; }});
  EXPECT_EQ(std::count_if(picture.begin(), picture.end(), [](const auto& rgb) { return rgb[0] > 0; }), 10);
}

TEST(Functions, SayWhatIsWrong) {
  const auto message = [](const std::string& text, int width = 160, int height = 90) {
    try {
      make(text, width, height);
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
  EXPECT_THAT(message("checker:cell=1e-4"), AllOf(HasSubstr("cell=1e-04"), HasSubstr("larger cell")));
  EXPECT_THAT(message("checker:rows=100000,cell=3.7"), AllOf(HasSubstr("rows=1e+05"), HasSubstr("larger cell")));
  EXPECT_THAT(message("stripes:period=.009,angle=3"), HasSubstr("larger period"));
  EXPECT_NEAR(exact(*make("stripes:period=.01", 2, 1), {0, 0, 1, 1}), .5, 1e-12);
  EXPECT_THAT(message("chirp:top=3"), AllOf(HasSubstr("top=3"), HasSubstr("bottom=4")));
  EXPECT_THAT(message("chirp:top=1e6", 401, 100), AllOf(HasSubstr("401x100"), HasSubstr("smaller top")));
  EXPECT_THAT(message("chirp:top=1e6", 400, 100), "");
  EXPECT_THAT(message("horizon", 201, 2), AllOf(HasSubstr("201x2"), HasSubstr("less wide")));
  EXPECT_THAT(message("horizon", 200, 2), "");
  EXPECT_EQ(function_text("checker:angle=12", "test"), "checker:cell=3.7,angle=12,rows=0,low=0,high=1");
}
