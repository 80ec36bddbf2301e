// SPDX-License-Identifier: Apache-2.0
#include "colour_difference.hpp"

namespace {

struct Formula {
  static constexpr triad_plugin::Info info{
      "ciede2000", "1.0", "CIEDE2000 colour difference of each pixel",
      "ISO/CIE 11664-6 with kL = kC = kH = 1, of CIELAB of linear light under the white of the pictures' colour "
      "space, "
      "which is D65 for sRGB, Display P3 and Rec.2020. It mends what CIELAB has uneven, above all among blues and "
      "saturated colours, and is meant for differences up to about 5. Light above white keeps its value, and light "
      "below 0 goes on along CIELAB's straight piece near black: nothing is clamped. The pixels are compared one by "
      "one; s-cielab and display blur them first as an eye does. mean is the mean over all pixels (with a mask: by "
      "its "
      "weights); the map is each pixel's difference."};
  static constexpr auto of = triad::ciede2000;
};
using Ciede2000 = colour_difference::ColourDifference<Formula>;

}  // namespace

TRIAD_PLUGIN("ciede2000", Ciede2000)
