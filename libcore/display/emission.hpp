// SPDX-License-Identifier: Apache-2.0
// The light of a panel, cell by cell, from the values of a picture shown on it.
#pragma once

#include <array>
#include <cstddef>
#include <triad/display/layout.hpp>
#include <vector>

namespace triad {

// What the panel shows beyond the borders of a picture.
enum class Beyond {
  kDark,
  kMirror,  // the picture's mirror image, border pixel repeated, for ever: c b a | a b c | c b a
  kWrap     // the picture again
};

// The index within 0 .. size - 1 that continues a row of `size` samples at any index i; -1 where it is dark.
int continued(int i, int size, Beyond beyond);

// Rows of a picture, interleaved RGB. Rows y0 .. y1 - 1 are there, of height_px in all.
template <class Sample>
struct DriveRows {
  const Sample* pixels = nullptr;  // pixel (0, y0)
  ptrdiff_t stride = 0;            // samples from a row to the next; 3 width_px where rows touch
  int width_px = 0, height_px = 0;
  int y0 = 0, y1 = 0;
};

// Cells of the picture's fine grid, half open; cell (0, 0) is the picture's upper left one, and cells beyond its
// borders have numbers below 0 or above. Cells of pixel x: cells_x * x .. cells_x * x + cells_x - 1.
struct CellRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

// Immutable and thread-safe. Units: linear light, where a white picture has (1, 1, 1) on average over a tile. The
// same pixels give the same bits in whatever rectangles the cells are asked for.
class Emission {
 public:
  // origin: the pixel of the panel on which pixel (0, 0) of the picture lies; it counts modulo the tile.
  // matrix: what the light (linear RGB) is multiplied by, row-major, for example opponent_matrix().
  explicit Emission(const Layout& layout, int origin_x_px = 0, int origin_y_px = 0,
                    const std::array<double, 9>& matrix = {1, 0, 0, 0, 1, 0, 0, 0, 1});

  // A cell of pixel row y is lit by pixels of the rows y - reach_up_px() .. y + reach_down_px(), both >= 0, and
  // likewise for columns. 0 where all light stays within the pixel that drives it.
  int reach_left_px() const { return reach_[0]; }
  int reach_right_px() const { return reach_[1]; }
  int reach_up_px() const { return reach_[2]; }
  int reach_down_px() const { return reach_[3]; }

  // light[(y - cells.y0) * 3 * width + 3 * (x - cells.x0) + i] for all cells, which are written, not added to.
  // The rows that the cells need, after continuation beyond the picture, must be there; Error(kInternal) if not.
  template <class Sample, class Real>
  void light(const DriveRows<Sample>& picture, Beyond beyond, const CellRect& cells, Real* light) const;

 private:
  // What one emitter adds to one cell of the tile.
  struct Term {
    int dx, dy;  // from the cell's own pixel to the one that drives the emitter
    int channel;
    double light[3];
  };
  int cells_x_, cells_y_, tile_x_, tile_y_, origin_x_, origin_y_;
  bool derives_white_;
  std::array<int, 4> reach_{};
  std::vector<std::vector<Term>> terms_;  // [cell row of the tile * cells of its row + column]
};

}  // namespace triad
