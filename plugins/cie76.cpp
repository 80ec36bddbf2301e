// SPDX-License-Identifier: Apache-2.0
#include "colour_difference.hpp"

namespace {

struct Formula {
  static constexpr triad_plugin::Info info{
      "cie76", "1.0", "CIE 1976 colour difference of each pixel: the distance in CIELAB",
      "sqrt(dL^2 + da^2 + db^2) of CIELAB (ISO/CIE 11664-4), of linear light under the white of the pictures' colour "
      "space, which is D65 for sRGB, Display P3 and Rec.2020. About 2.3 can just be told apart. Light above white "
      "keeps its value, and light below 0 goes on along CIELAB's straight piece near black: nothing is clamped. The "
      "pixels are compared one by one; s-cielab and display blur them first as an eye does. mean is the mean over "
      "all "
      "pixels (with a mask: by its weights); the map is each pixel's difference."};
  static constexpr auto of = triad::cie76;
};
using Cie76 = colour_difference::ColourDifference<Formula>;

}  // namespace

TRIAD_PLUGIN("cie76", Cie76)
