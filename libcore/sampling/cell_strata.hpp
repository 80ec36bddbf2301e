// SPDX-License-Identifier: Apache-2.0
// How the points of a display pixel are parted among its fine cells.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <triad/image/image.hpp>
#include <triad/numeric/widest.hpp>
#include <triad/sampling/pixel_points.hpp>
#include <vector>

namespace triad {

// Equal boxes of the square that the points are made in, columns by rows, each of which holds as many points as any
// other.
struct CellStrata {
  uint32_t columns = 1, rows = 1;
};
// Those of `points` that fit display pixels of so many cells best.
CellStrata cell_strata(const PixelPoints& points, const Cells& cells);

// One side of a display pixel: takes the side of the square that the points are made in, cut into strata, to cells.
// Each cell is given as many whole strata as its neighbours, or one more, and so has its samples, however they are
// scrambled; within a cell points keep their density. With fewer strata than cells nothing is moved.
class CellSide {
 public:
  // Both at least 1.
  CellSide(uint32_t strata, int cells);
  // From places in [0, 1) to cells from the pixel's edge.
  typedef double Eight __attribute__((vector_size(64)));
  TRIAD_INLINE_BODY void move(Eight& places) const {
    if (stays()) return;
    Eight cell{}, start{}, scale = cells_[0].scale - Eight{};
    for (size_t c = 1; c < cells_.size(); ++c) {
      const auto past = places >= cells_[c].start;
      cell = past ? static_cast<double>(c) - Eight{} : cell;
      start = past ? cells_[c].start - Eight{} : start;
      scale = past ? cells_[c].scale - Eight{} : scale;
    }
    places = cell + (places - start) * scale;
  }
  // Whether it leaves all places as they are.
  bool stays() const { return cells_.size() == 1 && cells_[0].scale == 1; }

  struct Cell {
    double start, scale;  // its first place, and cells by which a place moves it
  };
  // One for all where nothing is moved.
  std::span<const Cell> cells() const { return cells_; }
  uint32_t count() const { return count_; }

 private:
  uint32_t count_;
  std::vector<Cell> cells_;
};

}  // namespace triad
