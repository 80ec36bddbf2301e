// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <triad/base/error.hpp>
#include <triad/display/emission.hpp>
#include <triad/display/torus.hpp>

namespace triad {

int TorusAxis::at(int r, int scale) const {
  int k = r - before_px * scale;
  const int gap = length_px() - size_px;
  if (k >= (size_px + gap - gap / 2) * scale) k -= length_px() * scale;
  return continued(k, size_px * scale, edge == Edge::kMirror ? Beyond::kMirror : Beyond::kWrap);
}

int mirror_margin_px(double ppd) { return std::max(32, static_cast<int>(std::ceil(.8 * ppd))); }

int good_length(int n) {
  const int step = n > 512 ? 32 : 4;
  for (int length = (n + step - 1) / step * step;; length += step) {
    int rest = length;
    for (const int prime : {2, 3, 5, 7})
      while (rest % prime == 0) rest /= prime;
    if (rest == 1) return length;
  }
}

TorusAxis torus_axis(int size_px, int cells, int tile_px, int origin_px, Edge edge, double ppd) {
  constexpr int kMaxSize = 1 << 26;
  if (size_px < 1 || size_px > kMaxSize)
    throw_usage("a picture of " + std::to_string(size_px) + " pixels in one direction: 1 to " +
                std::to_string(kMaxSize) + " can be filtered");
  TorusAxis axis;
  axis.size_px = size_px;
  axis.tile_px = tile_px;
  axis.cells = cells;
  axis.before_px = (origin_px % tile_px + tile_px) % tile_px;
  axis.edge = edge;
  const auto tiles = [&](int pixels) { return (pixels + tile_px - 1) / tile_px; };
  // Beyond a few mirror images of a small picture nothing new would come.
  const int64_t margin_px = std::min<int64_t>(mirror_margin_px(ppd), std::max<int64_t>(32, int64_t{4} * size_px));
  const int mirrored_px = static_cast<int>(size_px + 2 * margin_px);
  axis.tiles = edge == Edge::kWrap ? tiles(size_px) : good_length(tiles(mirrored_px));
  return axis;
}

}  // namespace triad
