// SPDX-License-Identifier: Apache-2.0
#include "relative_error.hpp"

namespace {

struct Formula {
  static constexpr triad_plugin::Info info{
      "relmse-pbrt", "1.0", "Relative squared error (t - r)^2 / (r + eps)^2, eps = .01, as pbrt's imgtool has it",
      "relMSE is the name of several formulas, and their values do not compare; triad has those of tev, pbrt and "
      "JERI. "
      "This one is e = ((t - r) / (r + eps))^2 with eps = .01, of test t and reference r, in linear light or in the "
      "space that compare --to names: what imgtool diff --metric MRSE prints. A pixel's value is the mean of its "
      "three "
      "channels'; it is what the map holds. References near -eps, which only filters with negative lobes make, blow "
      "it "
      "up; where r + eps is 0, the channel counts as 0, as it does there.\n"
      "mean is the mean over all pixels (with a mask: by its weights). trimmed leaves out the trim percent of the "
      "pixels with the largest values, which tells apart an error that is everywhere from a few fireflies; of the "
      "pixel on the limit it counts the part that is left."};
  static constexpr double kEps = .01;
  static double of(double t, double r, double eps) {
    const double under = r + eps, ratio = (t - r) / under;
    return under == 0 ? 0 : ratio * ratio;
  }
};
using Relmse = relative_error::TrimmedMean<Formula>;

}  // namespace

TRIAD_PLUGIN("relmse-pbrt", Relmse)
