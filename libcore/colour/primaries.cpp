// SPDX-License-Identifier: Apache-2.0
#include <triad/colour/colour.hpp>
#include <triad/colour/internal/evaluator.hpp>

namespace triad {
namespace colour {
namespace {

std::array<double, 3> xyz_of(double x, double y) { return {x / y, 1, (1 - x - y) / y}; }

}  // namespace

Matrix3 multiply(const Matrix3& a, const Matrix3& b) {
  Matrix3 result{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) result[i * 3 + j] += a[i * 3 + k] * b[k * 3 + j];
  return result;
}

std::array<double, 3> multiply(const Matrix3& m, const std::array<double, 3>& v) {
  return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
          m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}

Matrix3 inverse(const Matrix3& m) {
  const Matrix3 adjugate{m[4] * m[8] - m[5] * m[7], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
                         m[5] * m[6] - m[3] * m[8], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
                         m[3] * m[7] - m[4] * m[6], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
  const double determinant = m[0] * adjugate[0] + m[1] * adjugate[3] + m[2] * adjugate[6];
  Matrix3 result = adjugate;
  for (double& v : result) v /= determinant;
  return result;
}

Matrix3 rgb_to_xyz(const std::array<double, 8>& xy) {
  Matrix3 m;
  for (int c = 0; c < 3; ++c) {
    m[c] = xy[2 * c];
    m[3 + c] = xy[2 * c + 1];
    m[6 + c] = 1 - xy[2 * c] - xy[2 * c + 1];
  }
  // Red, green and blue in the amounts that add up to the white.
  const auto amount = multiply(inverse(m), xyz_of(xy[6], xy[7]));
  for (int i = 0; i < 9; ++i) m[i] *= amount[i % 3];
  return m;
}

std::array<double, 8> chromaticities_of(const Matrix3& m) {
  std::array<double, 8> xy;
  for (int c = 0; c < 4; ++c) {
    std::array<double, 3> xyz{};
    for (int i = 0; i < 3; ++i) xyz[i] = c < 3 ? m[i * 3 + c] : m[i * 3] + m[i * 3 + 1] + m[i * 3 + 2];
    const double sum = xyz[0] + xyz[1] + xyz[2];
    xy[2 * c] = xyz[0] / sum;
    xy[2 * c + 1] = xyz[1] / sum;
  }
  return xy;
}

Matrix3 adaptation(double from_x, double from_y, double to_x, double to_y, Cones cones) {
  static constexpr Matrix3 kBradford{.8951, .2664, -.1614, -.7502, 1.7135, .0367, .0389, -.0685, 1.0296};
  static constexpr Matrix3 kCat02{.7328, .4296, -.1624, -.7036, 1.6975, .0061, .0030, .0136, .9834};
  const Matrix3& to_cones = cones == Cones::kBradford ? kBradford : kCat02;
  const auto from = multiply(to_cones, xyz_of(from_x, from_y));
  const auto to = multiply(to_cones, xyz_of(to_x, to_y));
  Matrix3 scaled = to_cones;
  for (int i = 0; i < 9; ++i) scaled[i] *= to[i / 3] / from[i / 3];
  return multiply(inverse(to_cones), scaled);
}

}  // namespace colour

const std::array<double, 9>& rec709_to_xyz() {
  static const auto matrix = colour::rgb_to_xyz({.64, .33, .30, .60, .15, .06, .3127, .3290});
  return matrix;
}

}  // namespace triad
