// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "relative_error.hpp"

namespace {

struct Formula {
  static constexpr triad_plugin::Info info{
      "smape", "1.0", "Symmetric mean absolute percentage error |t - r| / ((|t| + |r|) / 2 + eps), eps = .01",
      "The error of a channel is |t - r| / ((|t| + |r|) / 2 + eps) with eps = .01, of test t and reference r, in "
      "linear "
      "light or in the space that compare --to names; .1 is ten percent, 2 the most there is. It stays the same when "
      "test and reference change places, and a firefly counts no more than a missing light. Tools that leave out the "
      "factor 2, |t - r| / (|t| + |r| + eps'), print half of it (with eps' = 2 eps). A pixel's value is the mean of "
      "its three channels'; it is what the map holds. mean is the mean over all pixels (with a mask: by its "
      "weights)."};
  static constexpr double kEps = .01;
  static double of(double t, double r, double eps) {
    return std::abs(t - r) / ((std::abs(t) + std::abs(r)) / 2 + eps);
  }
};
using Smape = relative_error::Mean<Formula>;

}  // namespace

TRIAD_PLUGIN("smape", Smape)
