// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "relative_error.hpp"

namespace {

struct Formula {
  static constexpr triad_plugin::Info info{
      "mape", "1.0", "Mean absolute percentage error |t - r| / (|r| + eps), eps = .01",
      "The error of a channel is |t - r| / (|r| + eps) with eps = .01, of test t and reference r, in linear light or "
      "in the space that compare --to names; .1 is ten percent. A pixel's value is the mean of its three channels'; "
      "it is what the map holds. mean is the mean over all pixels (with a mask: by its weights)."};
  static constexpr double kEps = .01;
  static double of(double t, double r, double eps) { return std::abs(t - r) / (std::abs(r) + eps); }
};
using Mape = relative_error::Mean<Formula>;

}  // namespace

TRIAD_PLUGIN("mape", Mape)
