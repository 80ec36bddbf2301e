// SPDX-License-Identifier: Apache-2.0
// Colour spaces and the transforms between them, by OpenColorIO.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace triad {

// rgb_to_xyz of linear Rec.709 / sRGB primaries with the D65 white point (x, y) = (.3127, .3290), row-major.
// IEC 61966-2-1; derived from the chromaticities to double precision, not the rounded published matrix.
const std::array<double, 9>& rec709_to_xyz();

class ColourConfig;

// A compiled transform; without one, the identity. Thread-safe.
class ColourTransform {
 public:
  // True when values would not change; then apply() need not be called (and does nothing).
  bool identity() const;
  // In place, `channels` floats a pixel, of which the first three are colour. alpha is the index of an
  // associated alpha channel or -1: colour is divided by it, transformed, and multiplied again, unless the
  // transform is linear. Pixels with alpha 0 are transformed as they are (light without coverage).
  void apply(float* pixels, size_t count, int channels, int alpha) const;
  const std::string& from() const;
  const std::string& to() const;

 private:
  friend class ColourConfig;
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

// An OpenColorIO configuration. Thread-safe once loaded.
class ColourConfig {
 public:
  // path "": $OCIO if set, else the bundled data/colour/config.ocio. Throws Error(kInput).
  static ColourConfig load(const std::string& path = "");

  // The bundled config's spaces: lin_rec709, srgb, lin_p3d65, display_p3, lin_rec2020, rec2020_bt1886, acescg,
  // aces2065_1 and "raw". Aliases ("sRGB", "Linear", "scene_linear" ...) and roles resolve to their space's name.
  std::vector<std::string> names() const;
  // The space's own name for a name, alias or role; "" if there is none.
  std::string resolve(const std::string& name) const;
  // The same, but throws Error(kUsage) that names `option` and the nearest name.
  std::string require(const std::string& name, const std::string& option) const;

  // Whether the space's values are proportional to light.
  bool is_linear(const std::string& name) const;
  // Whether its values are codes for a display or a file: a colour space that is not linear.
  bool has_display_codes(const std::string& name) const;
  // "raw" and other data spaces, which no transform touches.
  bool is_data(const std::string& name) const;
  // Its linear sibling: the linear space with the same primaries (srgb -> lin_rec709, display_p3 ->
  // lin_p3d65); a linear space itself. Spaces whose sibling the config does not have: lin_rec709.
  std::string linear_sibling(const std::string& name) const;
  // rgb_to_xyz (D65-adapted) of a linear space, row-major, from the transform itself.
  std::array<double, 9> rgb_to_xyz(const std::string& linear_space) const;
  // rx ry gx gy bx by wx wy of a linear space, for a file's header: the published ones where the space has
  // them (with the ACES white for ACES), else those of rgb_to_xyz().
  std::array<float, 8> chromaticities(const std::string& linear_space) const;
  // The linear space whose primaries and white match these chromaticities (rx ry gx gy bx by wx wy, as EXR
  // stores them) within 2e-4 once the white is adapted to D65 (Bradford or CAT02), or "".
  std::string match_chromaticities(const std::array<float, 8>& xy) const;

  // The names of two spaces that every part of Triad relies on; a user's config without them is an error
  // on load that says which roles or aliases it should have.
  const std::string& lin_rec709() const;
  const std::string& srgb() const;

  // Cached. Throws Error(kUsage) for unknown names.
  ColourTransform transform(const std::string& from, const std::string& to) const;
  // Where the config came from, for --explain.
  const std::string& origin() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace triad
