// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <triad/base/error.hpp>
#include <triad/sampling/subpixels.hpp>

namespace triad {

void require_whole_pixels(const StrategyInfo& info, const RenderOptions& options) {
  if (options.cells.x != 1 || options.cells.y != 1)
    throw_usage("the strategy '" + info.name + "' makes the pixels of a display and no cells of " +
                std::to_string(options.cells.x) + "x" + std::to_string(options.cells.y) + " a pixel; leave them out");
}

SubpixelSums::SubpixelSums(int width, int height)
    : width_(width), sums_(static_cast<size_t>(width) * static_cast<size_t>(height) * kSubpixels) {}

void SubpixelSums::add(int x, int y, int subpixel, const Sample& sample) {
  Sum& sum = sums_[row(y) + static_cast<size_t>(x) * kSubpixels + static_cast<size_t>(subpixel)];
  ++sum.asked;
  if (!sample.valid) return;
  ++sum.valid;
  for (size_t c = 0; c < 3; ++c) sum.rgb[c] += sample.rgb[c];
}

std::array<double, 3> SubpixelSums::mean(int x, int y, int subpixel) const {
  const auto end = static_cast<int64_t>(width_) * kSubpixels, here = int64_t{x} * kSubpixels + subpixel;
  const Sum* const cells = &sums_[row(y)];
  const Sum* found = &cells[here];
  for (int64_t away = 1; found->valid == 0 && away < end; ++away) {
    if (here - away >= 0) found = &cells[here - away];
    if (found->valid == 0 && here + away < end) found = &cells[here + away];
  }
  if (found->valid == 0) return {};
  return {found->rgb[0] / found->valid, found->rgb[1] / found->valid, found->rgb[2] / found->valid};
}

}  // namespace triad
