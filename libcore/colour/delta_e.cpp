// SPDX-License-Identifier: Apache-2.0
// CIEDE2000 is written with angles, but asks only for sines and cosines of them, and these are ratios of a, b and
// chroma. With unit vectors u1, u2 along the two hues: dot = C1 C2 cos(dh), cross = C1 C2 sin(dh), the mean hue is
// that of u1 + u2, and the cosines of its multiples are polynomials. What is left is one angle, in the Gaussian
// around blue, at 275 degrees.
#include <cmath>
#include <limits>
#include <numbers>
#include <triad/colour/delta_e.hpp>
#include <triad/numeric/branch_free.hpp>
#include <triad/numeric/widest.hpp>

namespace triad {
namespace {

using branch_free::angle;
using branch_free::cube_root;
using branch_free::exp_minus;
using branch_free::select;
using branch_free::sine;
using branch_free::with_sign;

constexpr double kTiny = std::numeric_limits<double>::min();

TRIAD_INLINE_BODY inline double lightness_response(double t) {
  constexpr double kJoin = 6. / 29, kJoinCubed = kJoin * kJoin * kJoin;
  const bool curved = t > kJoinCubed;
  return select(curved, cube_root(select(curved, t, kJoinCubed)), t * (1 / (3 * kJoin * kJoin)) + 4. / 29);
}

// sqrt(c^7 / (c^7 + 25^7)).
TRIAD_INLINE_BODY inline double chroma_share(double c) {
  const double c2 = c * c, c7 = c2 * c2 * c2 * c;
  return std::sqrt(c7 / (c7 + 6103515625));
}

// 1 - .17 cos(h - 30) + .24 cos(2h) + .32 cos(3h + 6) - .20 cos(4h - 63), in degrees, of cos h and sin h.
TRIAD_INLINE_BODY inline double hue_weight(double c, double s) {
  constexpr double kCos30 = .8660254037844386, kSin30 = .5, kCos6 = .9945218953682733, kSin6 = .10452846326765347,
                   kCos63 = .4539904997395468, kSin63 = .8910065241883679;
  const double c2 = 2 * c * c - 1, s2 = 2 * s * c, c3 = c * (4 * c * c - 3), s3 = s * (3 - 4 * s * s),
               c4 = 2 * c2 * c2 - 1, s4 = 2 * s2 * c2;
  return 1 - .17 * (c * kCos30 + s * kSin30) + .24 * c2 + .32 * (c3 * kCos6 - s3 * kSin6) -
         .20 * (c4 * kCos63 + s4 * kSin63);
}

// sin(60 degrees * exp(-((h - 275) / 25)^2)), h in [0, 360) degrees, of cos h and sin h.
TRIAD_INLINE_BODY inline double blue_turn(double c, double s) {
  constexpr double kCos275 = .08715574274765817, kSin275 = -.9961946980917455,
                   kPerRadian = 180 / (25 * std::numbers::pi);
  const double along = c * kCos275 + s * kSin275, across = s * kCos275 - c * kSin275;
  const double distance = angle(across, along) * kPerRadian, gauss = exp_minus(distance * distance);
  // Hues of 0 to 95 degrees are less than 180 above 275, but as h does not wrap here they lie far below it.
  const bool wrapped = (across > 0) & (s >= 0);
  return sine(std::numbers::pi / 3 * select(wrapped, 0, gauss));
}

TRIAD_INLINE_BODY inline double ciede2000_of(double L1, double a1, double b1, double L2, double a2, double b2) {
  const double mean_c = (std::sqrt(a1 * a1 + b1 * b1) + std::sqrt(a2 * a2 + b2 * b2)) / 2;
  const double stretch = 1.5 - .5 * chroma_share(mean_c);
  const double x1 = stretch * a1, x2 = stretch * a2;
  const double c1 = std::sqrt(x1 * x1 + b1 * b1), c2 = std::sqrt(x2 * x2 + b2 * b2), mean_c_prime = (c1 + c2) / 2;

  const double both = c1 * c2, dot = x1 * x2 + b1 * b2, cross = x1 * b2 - b1 * x2;
  // Without cancellation: sin(dh / 2) = sin(dh) / (2 cos(dh / 2)) up to a right angle, sqrt((1 - cos(dh)) / 2)
  // beyond.
  const double near = std::numbers::sqrt2 * cross / std::sqrt(both + std::abs(dot) + kTiny);
  const double far = std::sqrt(2 * (both + std::abs(dot)));
  double x = x1 * c2 + x2 * c1, y = b1 * c2 + b2 * c1;
  // Opposite hues: the difference is + 180 degrees if the first is below 180, else - 180, and the mean lies between
  // the lower and the higher.
  const bool first_is_lower = (b1 > 0) | ((b1 == 0) & (x1 > 0));
  const bool opposite = (dot < 0) & ((cross == 0) | ((x == 0) & (y == 0)));
  const double turn = select(opposite, select(first_is_lower, 1, -1), cross);
  const double dH = select(dot < 0, with_sign(far, turn), near);
  x = select(opposite, select(first_is_lower, -b1, -b2), x);
  y = select(opposite, select(first_is_lower, x1, x2), y);
  // Of a grey and a colour the mean hue, the colour's, does not matter: their hues do not differ, dH = 0.
  const double length = std::sqrt(x * x + y * y), per_length = 1 / (length + kTiny);
  const double cos_h = select(length > 0, x * per_length, 1), sin_h = y * per_length;

  const double from_middle = (L1 + L2) / 2 - 50, square = from_middle * from_middle;
  const double dL = (L2 - L1) / (1 + .015 * square / std::sqrt(20 + square));
  const double dC = (c2 - c1) / (1 + .045 * mean_c_prime);
  const double h = dH / (1 + .015 * mean_c_prime * hue_weight(cos_h, sin_h));
  const double rotation = -2 * chroma_share(mean_c_prime) * blue_turn(cos_h, sin_h);
  return std::sqrt(dL * dL + dC * dC + h * h + rotation * dC * h);
}

}  // namespace

RgbToLab::RgbToLab(const std::array<double, 9>& rgb_to_xyz) : relative_xyz_(rgb_to_xyz) {
  for (size_t i = 0; i < 3; ++i) {
    const double white = rgb_to_xyz[3 * i] + rgb_to_xyz[3 * i + 1] + rgb_to_xyz[3 * i + 2];
    for (size_t d = 0; d < 3; ++d) relative_xyz_[3 * i + d] /= white;
  }
}

void RgbToLab::convert(const float* rgb, size_t count, LabBlock& out) const {
  run_widest([&]() TRIAD_INLINE_BODY {
    const std::array<double, 9> m = relative_xyz_;
    // On the way, L, a and b hold the relative X, Y and Z.
    for (size_t i = 0; i < count; ++i) {
      const double r = static_cast<double>(rgb[3 * i]), g = static_cast<double>(rgb[3 * i + 1]),
                   b = static_cast<double>(rgb[3 * i + 2]);
      out.L[i] = m[0] * r + m[1] * g + m[2] * b;
      out.a[i] = m[3] * r + m[4] * g + m[5] * b;
      out.b[i] = m[6] * r + m[7] * g + m[8] * b;
    }
    for (size_t i = 0; i < count; ++i) {
      const double x = lightness_response(out.L[i]), y = lightness_response(out.a[i]),
                   z = lightness_response(out.b[i]);
      out.L[i] = 116 * y - 16;
      out.a[i] = 500 * (x - y);
      out.b[i] = 200 * (y - z);
    }
  });
}

void cie76(const LabBlock& one, const LabBlock& other, size_t count, double* delta_e) {
  run_widest([&]() TRIAD_INLINE_BODY {
    for (size_t i = 0; i < count; ++i) {
      const double L = one.L[i] - other.L[i], a = one.a[i] - other.a[i], b = one.b[i] - other.b[i];
      delta_e[i] = std::sqrt(L * L + a * a + b * b);
    }
  });
}

void ciede2000(const LabBlock& one, const LabBlock& other, size_t count, double* delta_e) {
  run_widest([&]() TRIAD_INLINE_BODY {
    for (size_t i = 0; i < count; ++i)
      delta_e[i] = ciede2000_of(one.L[i], one.a[i], one.b[i], other.L[i], other.a[i], other.b[i]);
  });
}

}  // namespace triad
