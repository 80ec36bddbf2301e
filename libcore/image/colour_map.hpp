// SPDX-License-Identifier: Apache-2.0
// Colours for error maps: numbers shown as colours whose lightness rises evenly, so that equal steps look equal.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace triad {

enum class ColourMap {
  kMagma,   // black, violet, orange, pale yellow
  kViridis  // dark violet, blue-green, yellow; told apart by those who do not see red or green
};

// "magma" or "viridis". Throws Error(kUsage) naming --colour-map.
ColourMap parse_colour_map(const std::string& text);
const char* colour_map_name(ColourMap map);

using ColourCode = std::array<uint8_t, 3>;  // sRGB

// 256 colours from the lowest to the highest value. Chebyshev polynomials of degree 12 fitted to the maps of that
// name by N. J. Smith and S. van der Walt (2015, CC0), within 1 code of each of them. Thread-safe.
const std::array<ColourCode, 256>& colour_table(ColourMap map);

// The range of values that the colours span. Throws nothing; high > low.
struct MapScale {
  double low = 0, high = 1;
};

// The colour of the nearest of 256 steps from scale.low to scale.high; beyond them, the first or last. NaN is grey
// (128, 128, 128), which is in neither table.
ColourCode map_colour(const std::array<ColourCode, 256>& table, const MapScale& scale, double value);

// Collects values of which a scale is to be made, in bounded memory. Not thread-safe.
class ScaleFinder {
 public:
  ScaleFinder();
  // NaN counts as 0.
  void add(float value);
  // Whether one in a hundred of the values other than 0, or more, is below 0: fewer come of rounding.
  bool has_signs() const;
  // 0, or with signs the largest number of two significant digits that is no more than the least finite value.
  double low() const;
  // The smallest number of two significant digits that is no less than 99 % of the values (to within 1/128 of it);
  // where that is 0, than the largest finite value; 0 if no value is above 0. With signs, no less than the largest
  // finite value, which may be below 0, or 0 where that would be low().
  double high() const;

 private:
  std::vector<uint64_t> counts_;                // by the upper bits of the float: its exponent and 7 bits of fraction
  uint64_t total_ = 0, below_ = 0, above_ = 0;  // 0
  float least_, largest_;                       // of the finite ones
};

// The smallest number of two significant decimal digits that is not below `value` (within 1e-9 of it); 0 for 0 and
// for NaN.
double round_up_two_digits(double value);

}  // namespace triad
