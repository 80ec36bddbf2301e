// SPDX-License-Identifier: Apache-2.0
// A picture's place on a torus of fine cells, with what lies beyond its borders: where the light of a panel and the
// picture that it should show are compared, and blurred as an eye does.
//
// Mirrored, the torus is twice as wide (high) as the picture, rounded up to whole tiles: the picture lies in its
// first cells, its mirror images on both sides of it, on a panel that goes on as it was. Wrapped, the torus is the
// picture. A row for itself is a torus one cell high: what is constant in y looks the same on both.
#pragma once

#include <cstddef>
#include <triad/display/emission.hpp>
#include <triad/display/layout.hpp>
#include <triad/display/light.hpp>
#include <triad/display/row_filter.hpp>
#include <triad/display/vision.hpp>

namespace triad {

// A picture in memory: interleaved RGB, `stride` floats from a row to the next.
struct PictureView {
  const float* pixels = nullptr;
  ptrdiff_t stride = 0;
  const float* row(int y) const { return pixels + y * stride; }
};

enum class Range {
  kClip,      // test and target are first clamped to [0, 1]: what a panel can show, and what it could
  kUnbounded  // as they are: Platt's own measure
};

// Immutable and thread-safe.
class PanelTorus {
 public:
  struct Shape {
    int width_px = 1, height_px = 1;       // of the picture, in display pixels
    int origin_x_px = 0, origin_y_px = 0;  // the pixel of the panel on which the picture's first one lies
    Edge edge = Edge::kMirror;
    bool one_row = false;  // height_px is 1, of a layout with has_independent_rows()
  };
  // Throws Error(kUsage) for a side below 1, a torus longer than 2^27 pixels, a wrapped side that is not a whole
  // number of tiles, or one_row of another layout or height.
  PanelTorus(const Layout& layout, const Shape& shape);

  const Shape& shape() const { return shape_; }
  size_t width() const { return width_; }  // of the torus, in cells
  size_t height() const { return height_; }
  size_t columns() const { return static_cast<size_t>(shape_.width_px) * cells_x_; }  // of the picture, in cells
  size_t rows() const { return static_cast<size_t>(shape_.height_px) * cells_y_; }
  int cells_x() const { return cells_x_; }
  int cells_y() const { return cells_y_; }

  // The light of the panel that shows `drives`, width_px * height_px pixels, taken as they are.
  Light panel(const PictureView& drives) const;
  // The light of a fine picture of columns() * rows() cells; kClip clamps it.
  Light target(const PictureView& cells, Range range) const;

  // The observer's modulation transfer of an opponent channel at the torus's frequencies (nx, 0) .. (nx, height / 2).
  void transfer(const Observer& observer, int channel, size_t nx, double* values) const;

 private:
  int cells_x_, cells_y_;
  Shape shape_;
  Emission emission_;
  size_t width_, height_;
};

}  // namespace triad
