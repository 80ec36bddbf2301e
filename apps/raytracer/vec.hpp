// SPDX-License-Identifier: Apache-2.0
// Arithmetic on Float3, as vectors and as colours.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene.hpp"

namespace triad::raytracer {

inline constexpr float kPi = std::numbers::pi_v<float>;

constexpr Float3 operator+(Float3 a, Float3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Float3 operator-(Float3 a, Float3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Float3 operator-(Float3 a) { return {-a.x, -a.y, -a.z}; }
constexpr Float3 operator*(Float3 a, Float3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
constexpr Float3 operator*(Float3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
constexpr Float3 operator*(float s, Float3 a) { return a * s; }
constexpr Float3 operator/(Float3 a, float s) { return a * (1 / s); }
constexpr Float3& operator+=(Float3& a, Float3 b) { return a = a + b; }
constexpr Float3& operator*=(Float3& a, Float3 b) { return a = a * b; }
constexpr Float3& operator*=(Float3& a, float s) { return a = a * s; }
constexpr float dot(Float3 a, Float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Float3 cross(Float3 a, Float3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(Float3 a) { return std::sqrt(dot(a, a)); }
// Of a vector of any size whose square is neither 0 nor infinite.
inline Float3 normalise(Float3 a) { return a * (1 / length(a)); }
// Likewise where squares of floats may vanish or overflow (edges of tiny or huge triangles); 0 stays 0.
inline Float3 normalise_safely(Float3 a) {
  const double x = a.x, y = a.y, z = a.z, size = std::sqrt(x * x + y * y + z * z);
  if (!(size > 0)) return {};
  const double inverse = 1 / size;
  return {static_cast<float>(x * inverse), static_cast<float>(y * inverse), static_cast<float>(z * inverse)};
}
constexpr Float3 lerp(Float3 a, Float3 b, float t) { return a * (1 - t) + b * t; }
constexpr float max_component(Float3 a) { return std::max(a.x, std::max(a.y, a.z)); }
// Luminance of linear BT.709 (ITU-R BT.709-6, item 3.2).
constexpr float luminance(Float3 a) { return .2126f * a.x + .7152f * a.y + .0722f * a.z; }
inline bool is_finite(Float3 a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

// An orthonormal basis around a unit vector: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017.
struct Frame {
  Float3 x, y, z;
  explicit Frame(Float3 normal) : z(normal) {
    const float sign = std::copysign(1.f, z.z);
    const float a = -1 / (sign + z.z), b = z.x * z.y * a;
    x = {1 + sign * z.x * z.x * a, sign * b, -sign * z.x};
    y = {b, sign + z.y * z.y * a, -z.y};
  }
  Float3 to_local(Float3 v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  Float3 to_world(Float3 v) const { return x * v.x + y * v.y + z * v.z; }
};

}  // namespace triad::raytracer
