// SPDX-License-Identifier: Apache-2.0
// Looking things up in textures.
#pragma once

#include <array>
#include <cmath>

#include "vec.hpp"

namespace triad::raytracer {

using Texel = std::array<float, 4>;  // red, green, blue, straight alpha (1 where the texture has none)

// The texel's number on one axis of `size` texels, for any integer that fits an int64.
inline int wrapped(int64_t i, int size, Wrap wrap) {
  switch (wrap) {
    case Wrap::kClamp: return static_cast<int>(std::clamp<int64_t>(i, 0, size - 1));
    case Wrap::kRepeat: return static_cast<int>(((i % size) + size) % size);
    case Wrap::kMirror: break;
  }
  const int64_t period = 2 * int64_t{size}, j = ((i % period) + period) % period;
  return static_cast<int>(j < size ? j : period - 1 - j);
}

inline Texel texel_at(const Texture& texture, int x, int y) {
  const float* at = &texture.texels[(static_cast<size_t>(y) * texture.width + x) * texture.channels];
  return {at[0], at[1], at[2], texture.channels == 4 ? at[3] : 1.f};
}

// Value at (u, v), which are 0 at the left and upper edge and 1 at the opposite ones; bilinear between the centres of
// texels unless nearest. Coordinates too large to tell texels apart (2^40 texels), or not finite, read as 0.
inline Texel lookup(const Texture& texture, float u, float v, Wrap wrap_u, Wrap wrap_v, bool nearest) {
  constexpr double kLargest = 0x1p40;
  const double shift = nearest ? 0 : .5;
  double x = static_cast<double>(u) * texture.width - shift, y = static_cast<double>(v) * texture.height - shift;
  if (!(std::abs(x) < kLargest)) x = 0;
  if (!(std::abs(y) < kLargest)) y = 0;
  const double left = std::floor(x), top = std::floor(y);
  const int x0 = wrapped(static_cast<int64_t>(left), texture.width, wrap_u);
  const int y0 = wrapped(static_cast<int64_t>(top), texture.height, wrap_v);
  if (nearest) return texel_at(texture, x0, y0);
  const int x1 = wrapped(static_cast<int64_t>(left) + 1, texture.width, wrap_u);
  const int y1 = wrapped(static_cast<int64_t>(top) + 1, texture.height, wrap_v);
  const float fx = static_cast<float>(x - left), fy = static_cast<float>(y - top);
  const Texel a = texel_at(texture, x0, y0), b = texel_at(texture, x1, y0);
  const Texel c = texel_at(texture, x0, y1), d = texel_at(texture, x1, y1);
  Texel value;
  for (int i = 0; i < 4; ++i)
    value[i] = (a[i] * (1 - fx) + b[i] * fx) * (1 - fy) + (c[i] * (1 - fx) + d[i] * fx) * fy;
  return value;
}

// One use of a texture at a point of a mesh; uv: the mesh's two sets of coordinates there.
inline Texel lookup(const Scene& scene, const TextureUse& use, const std::array<Float2, 2>& uv) {
  const Float2 at = uv[use.texcoord];
  const auto& m = use.transform;
  return lookup(scene.textures[use.texture], m[0] * at.x + m[1] * at.y + m[2], m[3] * at.x + m[4] * at.y + m[5],
                use.wrap_u, use.wrap_v, use.nearest);
}

// Radiance from the direction `towards` (unit length, away from the scene).
inline Float3 environment_radiance(const Scene& scene, Float3 towards) {
  const Environment& environment = scene.environment;
  if (environment.texture < 0) return environment.radiance;
  const float u = .5f + std::atan2(towards.x, -towards.z) / (2 * kPi);
  const float v = std::acos(std::clamp(towards.y, -1.f, 1.f)) / kPi;
  const Texel texel = lookup(scene.textures[environment.texture], u, v, Wrap::kRepeat, Wrap::kClamp, false);
  return environment.radiance * Float3{texel[0], texel[1], texel[2]};
}

}  // namespace triad::raytracer
