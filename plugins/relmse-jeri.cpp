// SPDX-License-Identifier: Apache-2.0
#include "relative_error.hpp"

namespace {

struct Formula {
  static constexpr triad_plugin::Info info{
      "relmse-jeri", "1.0", "Relative squared error (t - r)^2 / (r^2 + eps), eps = .0001, as the viewer JERI has it",
      "relMSE is the name of several formulas, and their values do not compare; triad has those of tev, pbrt and "
      "JERI. "
      "This one is e = (t - r)^2 / (r^2 + eps) with eps = .0001, of test t and reference r, in linear light or in "
      "the "
      "space that compare --to names: JERI's MRSE, without the clamping to its range of exposures that its later "
      "versions do first. Dark pixels weigh up to 100 times what they do in relmse-tev. A pixel's value is the mean "
      "of "
      "its three channels'; it is what the map holds. A negative reference counts like a positive one.\n"
      "mean is the mean over all pixels (with a mask: by its weights). trimmed leaves out the trim percent of the "
      "pixels with the largest values, which tells apart an error that is everywhere from a few fireflies; of the "
      "pixel on the limit it counts the part that is left."};
  static constexpr double kEps = 1e-4;
  static double of(double t, double r, double eps) { return (t - r) * (t - r) / (r * r + eps); }
};
using Relmse = relative_error::TrimmedMean<Formula>;

}  // namespace

TRIAD_PLUGIN("relmse-jeri", Relmse)
