// SPDX-License-Identifier: Apache-2.0
// Reconstruction filters against their published formulas, closed forms and a plain sum over many places.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <triad/base/error.hpp>
#include <triad/sampling/reconstruction.hpp>

using namespace triad;
using std::numbers::pi;

namespace {

struct Published {
  const char* name;
  double radius_px;
  std::function<double(double)> f;                                                  // for 0 <= x < radius
  double splat, importance, uniform, splat_digit, importance_digit, uniform_digit;  // gains, and their last digits
};

double lanczos(double x, double tau) {
  return x == 0 ? 1 : tau * std::sin(pi * x) * std::sin(pi * x / tau) / (pi * pi * x * x);
}
// As Mitchell and Netravali print it, with B = C = 1/3.
double mitchell(double x) {
  const double b = 1. / 3, c = 1. / 3;
  if (x < 1) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6;
  return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6;
}
// A window over [0, 1], as Harris prints it, for x pixels from its middle.
double blackman_harris(double x) {
  const double n = x / 4 + .5;
  return .35875 - .48829 * std::cos(2 * pi * n) + .14128 * std::cos(4 * pi * n) - .01168 * std::cos(6 * pi * n);
}

const std::vector<Published>& published() {
  const auto one = [](double) { return 1.; };
  const auto gaussian = [](double x) {
    return std::exp(-x * x / (2 * .5 * .5)) - std::exp(-1.5 * 1.5 / (2 * .5 * .5));
  };
  static const std::vector<Published> list{
      {"box", .5, one, 1, 1, 1, 1e-9, 1e-9, 1e-9},
      {"box2", 2, one, .0625, 1, 1, 1e-9, 1e-9, 1e-9},
      {"tent", 1, [](double x) { return 1 - x; }, .444, 1, 1.78, .001, 1e-9, .01},
      {"gaussian", 1.5, gaussian, .337, 1, 3.03, .001, 1e-9, .01},
      {"mitchell", 2, mitchell, .464, 1.31, 7.43, .001, .01, .01},
      {"lanczos2", 2, [](double x) { return lanczos(x, 2); }, .667, 1.92, 10.7, .001, .01, .1},
      {"lanczos3", 3, [](double x) { return lanczos(x, 3); }, .799, 3.41, 28.8, .001, .01, .1},
      {"blackman-harris", 2, blackman_harris, .251, 1, 4.02, .001, 1e-9, .01}};
  return list;
}

ReconstructionFilter filter(size_t i, double scale = 1) {
  return ReconstructionFilter(static_cast<ReconstructionKernel>(i), scale);
}

// Midpoints of n equal parts: slow, and exact to 1/n^2 of the second derivative where g has no jumps inside.
double plain_integral(const std::function<double(double)>& g, double a, double b, int n = 300'000) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += g(a + (i + .5) * (b - a) / n);
  return sum * (b - a) / n;
}

}  // namespace

TEST(Reconstruction, ValuesAreThePublishedOnes) {
  ASSERT_EQ(reconstruction_names().size(), published().size());
  for (size_t i = 0; i < published().size(); ++i) {
    const Published& expected = published()[i];
    for (const double scale : {1., 1.75}) {
      const ReconstructionFilter f = filter(i, scale);
      EXPECT_EQ(f.name(), expected.name);
      EXPECT_EQ(f.radius_px(), expected.radius_px * scale);
      for (int k = -400; k <= 400; ++k) {
        const double x = k / 100. * 1.0000001, value = std::abs(x) < expected.radius_px ? expected.f(std::abs(x)) : 0;
        ASSERT_NEAR(f.value(x * scale), value, 2e-15) << expected.name << " at " << x;
      }
      const ReconstructionTable table(f);
      for (int k = -400; k <= 400; ++k) {
        const double x = k / 400.00001 * f.radius_px();
        ASSERT_NEAR(table(x), f.value(x), 6e-7) << expected.name << " at " << x;
        ASSERT_EQ(table(x) < 0, f.value(x) < 0) << expected.name << " at " << x;
      }
      EXPECT_EQ(f.value(f.radius_px()), 0);
      EXPECT_EQ(f.value(-std::nextafter(f.radius_px(), 10)), 0);
      EXPECT_EQ(f.value(NAN), 0);
      // What lies on the border of two pixels belongs to one of them.
      EXPECT_TRUE(i >= 2 || f.value(-f.radius_px()) == 1) << expected.name;
    }
  }
  EXPECT_THROW(filter(0, 0), Error);
  EXPECT_THROW(filter(0, NAN), Error);
  EXPECT_THROW(filter(0, HUGE_VAL), Error);
}

TEST(Reconstruction, IntegralsAreThoseOfAPlainSum) {
  for (size_t i = 0; i < published().size(); ++i) {
    const Published& expected = published()[i];
    const auto& f = expected.f;
    const double r = expected.radius_px;
    const ReconstructionFilter one = filter(i), wide = filter(i, 2.5);
    EXPECT_NEAR(one.integral(), 2 * plain_integral(f, 0, r), 1e-9) << expected.name;
    EXPECT_NEAR(one.absolute_integral(), 2 * plain_integral([&](double x) { return std::abs(f(x)); }, 0, r), 1e-9);
    EXPECT_NEAR(one.square_integral(), 2 * plain_integral([&](double x) { return f(x) * f(x); }, 0, r), 1e-9);
    EXPECT_DOUBLE_EQ(wide.integral(), 2.5 * one.integral());
    EXPECT_DOUBLE_EQ(wide.absolute_integral(), 2.5 * one.absolute_integral());
    EXPECT_DOUBLE_EQ(wide.square_integral(), 2.5 * one.square_integral());
    EXPECT_EQ(one.is_signed(), i >= 4 && i <= 6);
  }
}

TEST(Reconstruction, IntegralsInClosedForm) {
  const auto near = [](double value, double expected) { EXPECT_NEAR(value, expected, 2e-15 * expected); };
  near(filter(1).integral(), 4);
  near(filter(1).square_integral(), 4);
  near(filter(2).integral(), 1);
  near(filter(2).square_integral(), 2. / 3);
  near(filter(4).integral(), 1);
  near(filter(7).integral(), 4 * .35875);
  near(filter(7).square_integral(),
       4 * (.35875 * .35875 + (.48829 * .48829 + .14128 * .14128 + .01168 * .01168) / 2));
  const double whole = .5 * std::sqrt(2 * pi) * std::erf(3 / std::sqrt(2.)), edge = std::exp(-4.5);
  near(filter(3).integral(), whole - 3 * edge);
  near(filter(3).square_integral(), .5 * std::sqrt(pi) * std::erf(3.) - 2 * edge * whole + 3 * edge * edge);
}

TEST(Reconstruction, GainsAreThoseOfTheTable) {
  for (size_t i = 0; i < published().size(); ++i) {
    const Published& expected = published()[i];
    const ReconstructionFilter f = filter(i);
    EXPECT_NEAR(f.splat_gain(), expected.splat, expected.splat_digit / 2 * 1.0001) << expected.name;
    EXPECT_NEAR(f.importance_gain(), expected.importance, expected.importance_digit / 2 * 1.0001) << expected.name;
    EXPECT_NEAR(f.uniform_gain(), expected.uniform, expected.uniform_digit / 2 * 1.0001) << expected.name;
    // Twice as wide: four times the samples under it.
    EXPECT_NEAR(filter(i, 2).splat_gain(), f.splat_gain() / 4, 1e-14);
    EXPECT_NEAR(filter(i, 2).importance_gain(), f.importance_gain(), 1e-13);
    EXPECT_NEAR(filter(i, 2).uniform_gain(), f.uniform_gain(), 1e-13);
  }
}

TEST(Reconstruction, AutocorrelationIsThatOfAPlainSum) {
  EXPECT_NEAR(filter(1).autocorrelation(1), .75, 1e-14);  // boxes of 4 pixels overlap by 3
  EXPECT_NEAR(filter(2).autocorrelation(1), .25, 1e-14);  // 1/6 of 2/3
  EXPECT_NEAR(filter(0).autocorrelation(.25), .75, 1e-14);
  for (size_t i = 0; i < published().size(); ++i) {
    const Published& expected = published()[i];
    const auto f = [&](double x) { return std::abs(x) < expected.radius_px ? expected.f(std::abs(x)) : 0; };
    EXPECT_NEAR(filter(i).autocorrelation(0), 1, 1e-14);
    for (const double lag : {.5, 1., 2.}) {
      const double r = expected.radius_px;
      const double sum = plain_integral([&](double x) { return f(x) * f(x + lag); }, -r - lag, r);
      EXPECT_NEAR(filter(i).autocorrelation(lag), sum / filter(i).square_integral(), 1e-5) << expected.name << lag;
    }
    EXPECT_EQ(filter(i).autocorrelation(6.5), 0);
  }
}

TEST(Reconstruction, PlacesAreDrawnFromTheAbsoluteFilter) {
  for (size_t i = 0; i < published().size(); ++i) {
    const Published& expected = published()[i];
    const double scale = i % 2 ? 1 : 1.5, r = expected.radius_px * scale;
    const ReconstructionFilter f = filter(i, scale);
    // The share of the integral below a place, by the plain sum, is the number that it was made from.
    double running = 0, from = -r;
    for (int k = 1; k < 64; ++k) {
      const double u = k / 64., x = f.place(u);
      ASSERT_GT(x, from) << expected.name << u;
      running += plain_integral([&](double t) { return std::abs(expected.f(std::abs(t / scale))); }, from, x, 20'000);
      from = x;
      ASSERT_NEAR(running / f.absolute_integral(), u, 1e-8) << expected.name;
      ASSERT_NEAR(f.share_below(x), u, 1e-14) << expected.name;
    }
    // Ends, and numbers near the places where |f| is 0: in range, in order, and the way back.
    double last = -r;
    for (double u = 0; u < 1; u += 1. / 4099) {
      const double x = f.place(u);
      ASSERT_GE(x, last);
      ASSERT_LT(x, r);
      ASSERT_NEAR(f.share_below(x), u, 1e-14) << expected.name;
      last = x;
    }
    EXPECT_NEAR(f.place(0), -r, 1e-3);
    EXPECT_GE(f.place(0), -r);
    EXPECT_LT(f.place(std::nextafter(1., 0.)), r);
    EXPECT_EQ(f.place(.5), 0);
    EXPECT_EQ(f.share_below(-2 * r), 0);
    EXPECT_EQ(f.share_below(2 * r), 1);
    for (const double knot : f.knots_px()) {
      const double u = f.share_below(knot);
      EXPECT_TRUE(u >= 1 || std::abs(f.share_below(f.place(u)) - u) < 1e-14) << expected.name << knot;
    }
  }
}
