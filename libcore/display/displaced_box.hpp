// SPDX-License-Identifier: Apache-2.0
// The displaced box: each emitter shows the mean of its own colour over a pixel's size around it. Cheap, within
// [0, 1], exact on flat fields; what the filters are regularised towards, and where the solver starts.
#pragma once

#include <cstddef>
#include <triad/display/layout.hpp>
#include <vector>

namespace triad {

// Weights of the fine cells first_cell .. first_cell + weights.size() - 1 in one direction, counted from the tile's
// first cell; they sum to 1.
struct BoxWindow {
  int first_cell = 0;
  std::vector<double> weights;
};
// A pixel's width, or height, around the centre of emitter e's light. Where the panel derives its white, the
// pixel's own cells: that rule needs the three colours of one place, and displaced ones put through it are worse.
BoxWindow displaced_box(const Layout& layout, int emitter);
BoxWindow displaced_box_rows(const Layout& layout, int emitter);

// Immutable and thread-safe.
class DisplacedBox {
 public:
  explicit DisplacedBox(const Layout& layout);

  // Rows of cells that a row of tiles reads: -above() .. below() - 1, counted from the tiles' own first row, and
  // columns -left() .. right() - 1 around a tile's first. above(), left() >= 0; below(), right() > 0.
  int above() const { return above_; }
  int below() const { return below_; }
  int left() const { return left_; }
  int right() const { return right_; }

  // The drives of `tiles` neighbouring tiles: drives[e * stride + t], emitters in the layout's order. rows[above() +
  // k] points at cell 0 of tile 0 in row k, interleaved RGB, with what left() and right() want around it. Where the
  // panel derives white, in the form that it shows: white, and what is left of red, green and blue.
  template <class Real>
  void tiles(const Real* const* rows, int tiles, Real* drives, ptrdiff_t stride) const;

 private:
  struct Window {
    BoxWindow x, y;
    int channel, white;  // index of the emitter that is white in the same pixel, or -1
  };
  std::vector<Window> windows_;
  int tile_cells_x_, above_ = 0, below_ = 0, left_ = 0, right_ = 0;
};

// rgb[3 * (pixel of the tile) + channel] of each emitter, and back: what a picture stores. Pixels are counted in rows
// of the tile. A channel without an emitter gets the drive of
// the nearest emitter of its colour.
class DriveOrder {
 public:
  explicit DriveOrder(const Layout& layout);
  // Writes the pixels of row `pixel_y` of `tiles` tiles as interleaved RGB, drives as DisplacedBox::tiles gives them.
  template <class Real, class Sample>
  void pixels(const Real* drives, ptrdiff_t stride, int tiles, int pixel_y, Sample* rgb) const;

 private:
  int tile_x_, tile_y_;
  std::vector<int> emitter_;  // [3 * pixel + channel]: its emitter, or -1
  std::vector<int> white_;    // [pixel]
};

}  // namespace triad
