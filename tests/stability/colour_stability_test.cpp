// SPDX-License-Identifier: Apache-2.0
// What 16-bit and half files hold must come back from linear light as it went.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <triad/colour/colour.hpp>
#include <vector>

#include "stability_table.hpp"

namespace {
const triad::ColourConfig& bundled() {
  static const auto config = triad::ColourConfig::load(TRIAD_SOURCE_DIR "/data/colour/config.ocio");
  return config;
}
}  // namespace

TEST(ColourStability, EverySixteenBitCodeComesBack) {
  for (const auto& [encoded, linear] :
       {std::pair{"srgb", "lin_rec709"}, std::pair{"srgb", "acescg"}, std::pair{"display_p3", "lin_rec709"},
        std::pair{"rec2020_bt1886", "lin_rec2020"}}) {
    std::vector<float> pixels(65536 * 3);
    for (int i = 0; i < 65536; ++i)
      for (int c = 0; c < 3; ++c) pixels[i * 3 + c] = static_cast<float>(i) / 65535.f;
    bundled().transform(encoded, linear).apply(pixels.data(), 65536, 3, -1);
    bundled().transform(linear, encoded).apply(pixels.data(), 65536, 3, -1);
    uint64_t changed = 0;
    for (int i = 0; i < 65536; ++i)
      for (int c = 0; c < 3; ++c) changed += std::floor(pixels[i * 3 + c] * 65535. + .5) != i;
    triad::stability::never("colour",
                            std::string("16-bit codes changed by ") + encoded + " to " + linear + " and back",
                            changed, pixels.size());
  }
}

TEST(ColourStability, CurvesRiseEverywhere) {
  for (const auto& [from, to] : {std::pair{"srgb", "lin_rec709"}, std::pair{"lin_rec709", "srgb"}}) {
    const auto transform = bundled().transform(from, to);
    float before = -1, worst = 0;
    for (int i = 0; i < 2000000; ++i) {
      float pixel[3] = {static_cast<float>(i) * 1e-6f, 0, 0};
      transform.apply(pixel, 1, 3, -1);
      // The standard's own constants make a step of 3e-8 at its break, from light to code.
      const float fall = std::isfinite(pixel[0]) ? before - pixel[0] : INFINITY;
      worst = std::max(worst, fall);
      before = pixel[0];
    }
    triad::stability::at_most("colour", std::string("falls of the curve from ") + from + " to " + to,
                              static_cast<double>(worst), 6e-8);
  }
}
