// SPDX-License-Identifier: Apache-2.0
// The points of display pixels in batches: where they lie on a film of fine cells, and in which cell.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <triad/sampling/cell_strata.hpp>
#include <triad/sampling/source.hpp>
#include <vector>

namespace triad {

// How points lie in display pixels of so many cells. Immutable.
class CellPoints {
 public:
  CellPoints(const PixelPoints& points, const Cells& cells)
      : points_(points),
        cells_(cells),
        strata_(cell_strata(points, cells)),
        across_(strata_.columns, cells.x),
        down_(strata_.rows, cells.y) {}

  const Cells& cells() const { return cells_; }
  // Whether spp points give each cell some, whatever the random numbers.
  bool fill_all() const {
    return strata_.columns >= static_cast<uint32_t>(cells_.x) && strata_.rows >= static_cast<uint32_t>(cells_.y);
  }

 private:
  friend class CellBatch;
  const PixelPoints& points_;
  Cells cells_;
  CellStrata strata_;
  CellSide across_, down_;
};

// Points first .. past - 1 of some display pixels, one pixel's after the other's, by ascending index. Of one thread.
class CellBatch {
 public:
  // `points` must outlive it.
  CellBatch(const CellPoints& points, uint32_t first, uint32_t past, float footprint_px, uint64_t seed);

  uint32_t first() const { return first_; }
  uint32_t past() const { return first_ + static_cast<uint32_t>(per_pixel_); }
  size_t per_pixel() const { return per_pixel_; }
  size_t pixels() const { return pixels_; }
  size_t most() const { return requests_.size(); }           // samples that it has when full
  size_t room() const { return pixel_x_.size() - pixels_; }  // for pixels
  void clear() { pixels_ = 0; }
  // n pixels of a row, for which there is room.
  void add(int x, int y, size_t n = 1) {
    std::iota(pixel_x_.begin() + static_cast<ptrdiff_t>(pixels_),
              pixel_x_.begin() + static_cast<ptrdiff_t>(pixels_ + n), x);
    std::fill_n(pixel_y_.begin() + static_cast<ptrdiff_t>(pixels_), n, y);
    pixels_ += n;
  }

  // Sets the requests, which carry the keys of the display pixels, and their cells.
  void place();
  std::span<const SampleRequest> requests() const { return std::span(requests_).first(pixels_ * per_pixel_); }
  // Of each request, in its display pixel: row by row from 0.
  std::span<const uint32_t> cells() const { return std::span(cell_).first(pixels_ * per_pixel_); }
  int32_t pixel_x(size_t pixel) const { return pixel_x_[pixel]; }
  int32_t pixel_y(size_t pixel) const { return pixel_y_[pixel]; }

 private:
  TRIAD_INLINE_BODY void seed_pixels();
  TRIAD_INLINE_BODY void place_sobol_owen();
  TRIAD_INLINE_BODY void move_into_cells();

  const CellPoints& points_;
  const uint64_t seed_;
  const uint32_t first_;
  const size_t per_pixel_;
  size_t pixels_ = 0;
  std::vector<int32_t> pixel_x_, pixel_y_;
  std::vector<SampleRequest> requests_;
  // Of each request: places in the display pixel and the cell there.
  std::vector<double> x_, y_;
  std::vector<uint32_t> cell_;
  // Of Sobol points: where their scrambling starts, which never changes, and with which seed it goes on.
  std::vector<uint32_t> start_x_, start_y_, seed_x_, seed_y_;
  std::vector<uint32_t> pixel_seed_x_, pixel_seed_y_;  // of each pixel
};

}  // namespace triad
