// SPDX-License-Identifier: Apache-2.0
// What every strategy tries to find: the light of each pixel, filtered without error.
#pragma once

#include <functional>
#include <triad/sampling/source.hpp>
#include <vector>

namespace triad {

struct ExactOptions {
  // About each pixel's middle: the mean over a square of that side, Source::integral(); or Source::filtered().
  double box_px = 1;
  std::optional<SeparableFilter> filter{};
  std::function<bool()> stop{};                  // asked for each pixel, by any thread; true ends it early
  std::function<void(double share)> progress{};  // one call at a time, by any thread
};

// Each pixel's exact value, row by row, on all threads; where it was ended early, pixels that were not reached are 0.
// Throws Error(kUsage) if the source has no closed form for it.
std::vector<std::array<double, 3>> exact_picture(const Source& source, const ExactOptions& options = {});

}  // namespace triad
