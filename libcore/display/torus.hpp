// SPDX-License-Identifier: Apache-2.0
// The ring of pixels, or torus of two rings, on which a picture is solved or scored: whole tiles, of a length
// that transforms like, with the picture's surroundings in it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <triad/display/layout.hpp>
#include <triad/display/row_filter.hpp>

namespace triad {

// One direction of a torus. Ring pixel r lies on the panel at phase r modulo the tile.
struct TorusAxis {
  int size_px = 0;    // of the picture
  int tiles = 0;      // of the ring
  int tile_px = 1;    // pixels of a tile
  int cells = 1;      // fine cells of a pixel
  int before_px = 0;  // the ring pixel of the picture's pixel 0, below tile_px
  Edge edge = Edge::kMirror;

  int length_px() const { return tiles * tile_px; }
  int length_cells() const { return length_px() * cells; }
  // The pixel, or fine cell, of the picture that ring pixel (or cell) r shows. Behind the picture's end follows
  // its mirror image up to half the gap, then the mirror image of what comes before its start.
  int pixel_at(int ring_px) const { return at(ring_px, 1); }
  int cell_at(int ring_cell) const { return at(ring_cell, cells); }
  // The pixel of the picture itself that lies at ring pixel r; -1 where there is none.
  int picture_px(int ring_px) const {
    const int x = (ring_px - before_px + length_px()) % length_px();
    return x < size_px ? x : -1;
  }
  // The picture's pixels out of the ring's: interleaved RGB, length_px() pixels to size_px.
  template <class Real, class Sample>
  void cut(const Real* ring, Sample* picture) const {
    const int straight = std::min(size_px, length_px() - before_px);
    for (ptrdiff_t i = 0; i < 3 * static_cast<ptrdiff_t>(size_px); ++i) {
      const ptrdiff_t from = i + 3 * static_cast<ptrdiff_t>(before_px);
      picture[i] =
          static_cast<Sample>(ring[i < 3 * straight ? from : from - 3 * static_cast<ptrdiff_t>(length_px())]);
    }
  }

 private:
  int at(int r, int scale) const;
};

// The pixels that a mirrored picture is continued by, to each side, before its ring closes: what lies farther
// has less than 2e-5 of its own size of influence (tests/unit/constrained_test.cpp).
int mirror_margin_px(double ppd);

// For pictures of size_px pixels whose pixel 0 lies at phase `origin_px` of the panel. kMirror: at least
// mirror_margin_px on each side, the length a product of small primes. kWrap: size_px rounded up to whole tiles.
// Throws Error(kUsage) for sizes outside 1 .. 2^26.
TorusAxis torus_axis(int size_px, int cells, int tile_px, int origin_px, Edge edge, double ppd);

// The smallest number at least n, and a multiple of 4 or, above 512, of 32, whose prime factors are 2, 3, 5 and 7:
// 4000 transforms in a sixth less time than 3920.
int good_length(int n);

}  // namespace triad
