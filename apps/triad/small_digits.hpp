// SPDX-License-Identifier: Apache-2.0
// Numbers drawn in a picture, without a font on the machine.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace triad::app {

inline constexpr int kDigitScale = 2;  // pixels for a dot
inline constexpr int kDigitDotsX = 3, kDigitDotsY = 5, kDigitAdvance = kDigitDotsX + 1;
inline constexpr int kDigitRows = kDigitDotsY * kDigitScale;

// Three significant digits: "0", ".14", "12", "1.5e-6".
inline std::string small_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", value);
  return buffer;
}

inline int small_text_width(std::string_view text) {
  return text.empty() ? 0 : (static_cast<int>(text.size()) * kDigitAdvance - 1) * kDigitScale;
}

// Calls dot(x, y) for each pixel of `text`, whose upper left corner is (0, 0); it takes small_text_width() times
// kDigitRows. Characters that numbers do not have are left blank.
template <class Dot>
void draw_small_text(std::string_view text, const Dot& dot) {
  constexpr std::string_view kCharacters = "0123456789.-+e";
  // Five rows of three dots each, the upper row first, as octal digits.
  constexpr std::array<uint16_t, kCharacters.size()> kGlyphs{075557, 026227, 071747, 071317, 055711, 074717, 074757,
                                                             071122, 075757, 075717, 000002, 000700, 002720, 074647};
  for (size_t i = 0; i < text.size(); ++i) {
    const size_t glyph = kCharacters.find(text[i]);
    if (glyph == std::string_view::npos) continue;
    for (int row = 0; row < kDigitDotsY; ++row)
      for (int column = 0; column < kDigitDotsX; ++column) {
        const int bit = 3 * (kDigitDotsY - 1 - row) + (kDigitDotsX - 1 - column);
        if (!(kGlyphs[glyph] >> bit & 1)) continue;
        for (int p = 0; p < kDigitScale * kDigitScale; ++p)
          dot((static_cast<int>(i) * kDigitAdvance + column) * kDigitScale + p % kDigitScale,
              row * kDigitScale + p / kDigitScale);
      }
  }
}

}  // namespace triad::app
