// SPDX-License-Identifier: Apache-2.0
// Transforms that are a curve, a matrix and a curve, computed by ourselves. Not installed.
#pragma once

#include <array>
#include <cstddef>
#include <memory>

namespace triad::colour {

// x^p for x > 0, to 2e-10 relative: a cubic on each of 64 intervals of the mantissa, times a tabulated power
// of two. About ten times as fast as std::pow; ColourCurve.MatchesStdPow guards the claim.
class PowerTable {
 public:
  explicit PowerTable(double p);
  double operator()(double x) const;

 private:
  static constexpr int kIntervals = 64, kLeastExponent = -126, kExponents = 254;  // all normal floats
  double p_;
  std::array<std::array<double, 4>, kIntervals> cubic_;
  std::array<double, kExponents> scale_;
};

// A display curve, mirrored at the origin: linear below a break, a power with an offset above it.
//   decode(v) = v / slope                            for v <= encoded_break
//               ((v + offset) / (1 + offset))^gamma  above
// encode() is the inverse.
class Curve {
 public:
  // gamma 2.4 and offset .055 are sRGB with the constants of IEC 61966-2-1 (12.92, .04045, .0031308). Any other
  // pair has the break at which value and slope are continuous. offset 0: a pure power.
  Curve(double gamma, double offset);
  double decode(double v) const;
  double encode(double v) const;
  bool same_as(const Curve& other) const { return gamma_ == other.gamma_ && offset_ == other.offset_; }

 private:
  double gamma_, offset_;
  double slope_ = 1, encoded_break_ = 0, linear_break_ = 0;
  PowerTable up_, down_;
};

using Matrix3 = std::array<double, 9>;  // row-major

Matrix3 multiply(const Matrix3& a, const Matrix3& b);
std::array<double, 3> multiply(const Matrix3& m, const std::array<double, 3>& v);
// The matrix must be regular.
Matrix3 inverse(const Matrix3& m);

// rgb_to_xyz from chromaticities rx ry gx gy bx by wx wy, white at Y = 1.
Matrix3 rgb_to_xyz(const std::array<double, 8>& xy);
// The inverse of rgb_to_xyz().
std::array<double, 8> chromaticities_of(const Matrix3& rgb_to_xyz);
// von Kries adaptation of XYZ between white points by Bradford's cone responses (Lam 1985) or by CIECAM02's.
enum class Cones { kBradford, kCat02 };
Matrix3 adaptation(double from_x, double from_y, double to_x, double to_y, Cones cones);

struct Evaluator {
  std::shared_ptr<const Curve> decode, encode;  // may be null
  Matrix3 matrix{1, 0, 0, 0, 1, 0, 0, 0, 1};
  bool has_matrix = false;

  bool linear() const { return !decode && !encode; }
  // Removes what cancels out; afterwards true if nothing is left.
  bool simplify();
  std::array<double, 3> operator()(std::array<double, 3> rgb) const;
  void apply(float* pixels, size_t count, int channels, int alpha) const;
};

}  // namespace triad::colour
