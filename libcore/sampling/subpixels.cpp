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

std::vector<std::array<double, 3>> SubpixelSums::means(int y) const {
  const size_t end = static_cast<size_t>(width_) * kSubpixels;
  const std::span<const Sum> cells(&sums_[row(y)], end);
  std::vector<std::array<double, 3>> means(end);
  // `left` and `right` are the nearest subpixels with samples; end is none.
  for (size_t i = 0, left = end, right = 0; i < end; ++i) {
    if (cells[i].valid > 0) left = i;
    right = std::max(right, i);
    while (right < end && cells[right].valid == 0) ++right;
    const bool to_the_left = left < end && (right == end || i - left <= right - i);
    const size_t from = to_the_left ? left : right;
    if (from == end) break;
    const Sum& found = cells[from];
    means[i] = {found.rgb[0] / found.valid, found.rgb[1] / found.valid, found.rgb[2] / found.valid};
  }
  return means;
}

}  // namespace triad
