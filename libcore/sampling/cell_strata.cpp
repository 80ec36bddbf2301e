// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <triad/sampling/cell_strata.hpp>

namespace triad {
namespace {

constexpr uint32_t kMost = 4096;  // along a side of a pixel; finer ones would change no cell by a thousandth

}  // namespace

CellStrata cell_strata(const PixelPoints& points, const Cells& cells) {
  if (points.kind() != PixelPoints::Kind::kSobol)
    return {std::min(kMost, points.columns()), std::min(kMost, points.rows())};
  // Any 2^a x 2^b boxes with a + b = log2 spp hold one point each. Where a side has one cell, boxes need not be
  // told apart along it; else they are to be of the cells' shape.
  const int bits = std::bit_width(points.samples_per_pixel()) - 1;
  int across = cells.y == 1 ? bits : 0;
  if (cells.x > 1 && cells.y > 1)
    across = static_cast<int>(std::lround((bits + std::log2(static_cast<double>(cells.x) / cells.y)) / 2));
  across = std::clamp(across, 0, bits);
  return {std::min(kMost, 1u << across), std::min(kMost, 1u << (bits - across))};
}

CellSide::CellSide(uint32_t strata, int cells) : count_(static_cast<uint32_t>(cells)) {
  const uint32_t n = count_;
  if (strata < n) {
    cells_ = {{0, static_cast<double>(n)}};
    return;
  }
  for (uint32_t cell = 0; cell < n; ++cell) {
    const uint32_t first = (cell * strata + n / 2) / n, past = ((cell + 1) * strata + n / 2) / n;
    cells_.push_back({static_cast<double>(first) / strata, static_cast<double>(strata) / (past - first)});
  }
}

}  // namespace triad
