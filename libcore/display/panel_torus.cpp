// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <triad/base/error.hpp>
#include <triad/display/panel_torus.hpp>

namespace triad {
namespace {

constexpr int64_t kMostTorus_px = int64_t{1} << 27;

// Cells of a side of the torus.
size_t torus_cells(const Layout& layout, const char* side, int size_px, int tile_px, int cells, Edge edge) {
  if (size_px < 1) throw_usage("a picture's " + std::string(side) + " must be at least 1 pixel");
  if (edge == Edge::kWrap && size_px % tile_px != 0)
    throw_usage("edge=wrap needs a " + std::string(side) + " of whole tiles: " + std::to_string(size_px) +
                " pixels are not a multiple of layout " + layout.name + "'s " + std::to_string(tile_px));
  const int64_t wanted = edge == Edge::kWrap ? size_px : int64_t{2} * size_px;
  const int64_t torus = (wanted + tile_px - 1) / tile_px * tile_px;
  if (torus > kMostTorus_px)
    throw_usage("a " + std::string(side) + " of " + std::to_string(size_px) + " pixels is too long");
  return static_cast<size_t>(torus * cells);
}

// The cell of the endless continued picture at cell k of the torus: the part after the middle of what is beyond the
// picture belongs to the left of it.
int unrolled(size_t k, size_t torus, size_t picture) {
  const size_t middle = picture + (torus - picture + 1) / 2;
  return k < middle ? static_cast<int>(k) : static_cast<int>(k) - static_cast<int>(torus);
}

Beyond beyond(Edge edge) { return edge == Edge::kMirror ? Beyond::kMirror : Beyond::kWrap; }

}  // namespace

PanelTorus::PanelTorus(const Layout& layout, const Shape& shape)
    : cells_x_(layout.cells_x),
      cells_y_(layout.cells_y),
      shape_(shape),
      emission_(layout, shape.origin_x_px, shape.origin_y_px),
      width_(torus_cells(layout, "width", shape.width_px, layout.tile_x, layout.cells_x, shape.edge)),
      height_(shape.one_row
                  ? 1
                  : torus_cells(layout, "height", shape.height_px, layout.tile_y, layout.cells_y, shape.edge)) {
  if (!shape.one_row) return;
  if (!layout.has_independent_rows())
    throw_usage("layout '" + layout.name + "' has no independent rows: it needs mode=plane");
  if (shape.height_px != 1) throw_internal("one row of a picture of " + std::to_string(shape.height_px));
}

Light PanelTorus::panel(const PictureView& drives) const {
  return [this, drives](size_t y, double* rgb) {
    const DriveRows<float> rows{drives.pixels, drives.stride, shape_.width_px, shape_.height_px, 0, shape_.height_px};
    const int at = unrolled(y, height_, this->rows());
    const int middle = static_cast<int>(columns() + (width_ - columns() + 1) / 2);
    emission_.light(rows, beyond(shape_.edge), {0, at, middle, at + 1}, rgb);
    const int rest = static_cast<int>(width_) - middle;
    if (rest > 0)
      emission_.light(rows, beyond(shape_.edge), {-rest, at, 0, at + 1}, rgb + 3 * static_cast<ptrdiff_t>(middle));
  };
}

void PanelTorus::transfer(const Observer& observer, int channel, size_t nx, double* values) const {
  const double fx = static_cast<double>(nx) / static_cast<double>(width_) * cells_x_ * observer.ppd;
  for (size_t ny = 0; ny <= height_ / 2; ++ny) {
    const double fy = static_cast<double>(ny) / static_cast<double>(height_) * cells_y_ * observer.ppd;
    values[ny] = mtf(observer, channel, std::sqrt(fx * fx + fy * fy));
  }
}

Light PanelTorus::target(const PictureView& cells, Range range) const {
  return [this, cells, range](size_t y, double* rgb) {
    const int picture_columns = static_cast<int>(columns());
    const float* row =
        cells.row(continued(unrolled(y, height_, rows()), static_cast<int>(rows()), beyond(shape_.edge)));
    for (size_t k = 0; k < width_; ++k) {
      const int x = continued(unrolled(k, width_, columns()), picture_columns, beyond(shape_.edge));
      for (size_t d = 0; d < 3; ++d) {
        const double value = static_cast<double>(row[3 * static_cast<ptrdiff_t>(x) + static_cast<ptrdiff_t>(d)]);
        rgb[3 * k + d] = range == Range::kClip ? std::clamp(value, 0., 1.) : value;
      }
    }
  };
}

}  // namespace triad
