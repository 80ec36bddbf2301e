// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <triad/colour/cielab.hpp>

namespace triad {
namespace {

// ISO/CIE 11664-4: a cube root, continued below (6/29)^3 by its tangent there.
double lightness_response(double t) {
  constexpr double kJoin = 6. / 29;
  return t > kJoin * kJoin * kJoin ? std::cbrt(t) : t / (3 * kJoin * kJoin) + 4. / 29;
}

}  // namespace

Lab xyz_to_lab(const std::array<double, 3>& xyz, const std::array<double, 3>& white) {
  const double x = lightness_response(xyz[0] / white[0]), y = lightness_response(xyz[1] / white[1]),
               z = lightness_response(xyz[2] / white[2]);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

double cie76(const Lab& one, const Lab& other) {
  return std::hypot(one.L - other.L, one.a - other.a, one.b - other.b);
}

}  // namespace triad
