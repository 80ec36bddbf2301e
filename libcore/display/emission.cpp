// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <triad/base/error.hpp>
#include <triad/display/emission.hpp>

namespace triad {
namespace {

int modulo(int a, int n) { return (a % n + n) % n; }
int floor_div(int a, int n) { return (a - modulo(a, n)) / n; }

}  // namespace

int continued(int i, int size, Beyond beyond) {
  if (i >= 0 && i < size) return i;
  if (beyond == Beyond::kDark) return -1;
  if (beyond == Beyond::kWrap) return modulo(i, size);
  const int k = modulo(i, 2 * size);
  return k < size ? k : 2 * size - 1 - k;
}

Emission::Emission(const Layout& layout, int origin_x_px, int origin_y_px, const std::array<double, 9>& matrix)
    : cells_x_(layout.cells_x),
      cells_y_(layout.cells_y),
      tile_x_(layout.tile_x),
      tile_y_(layout.tile_y),
      origin_x_(modulo(origin_x_px, layout.tile_x)),
      origin_y_(modulo(origin_y_px, layout.tile_y)),
      derives_white_(layout.derives_white),
      terms_(static_cast<size_t>(layout.tile_cells())) {
  const int width = cells_x_ * tile_x_, height = cells_y_ * tile_y_;
  for (const Emitter& emitter : layout.emitters)
    for (const EmitterCell& cell : emitter.cells) {
      // Seen from the tile in which the cell lies.
      const int x = modulo(cell.x, width), y = modulo(cell.y, height);
      Term term{};
      term.dx = emitter.pixel_x - tile_x_ * floor_div(cell.x, width) - x / cells_x_;
      term.dy = emitter.pixel_y - tile_y_ * floor_div(cell.y, height) - y / cells_y_;
      term.channel = emitter.channel;
      for (size_t i = 0; i < 3; ++i)
        for (size_t d = 0; d < 3; ++d)
          term.light[i] += matrix[3 * i + d] * emitter.primary[d] * cell.share * layout.pixel_cells();
      terms_[static_cast<size_t>(y * width + x)].push_back(term);
      reach_[0] = std::max(reach_[0], -term.dx);
      reach_[1] = std::max(reach_[1], term.dx);
      reach_[2] = std::max(reach_[2], -term.dy);
      reach_[3] = std::max(reach_[3], term.dy);
    }
}

template <class Sample, class Real>
void Emission::light(const DriveRows<Sample>& picture, Beyond beyond, const CellRect& cells, Real* light) const {
  const int width = cells_x_ * tile_x_, height = cells_y_ * tile_y_;
  // Which pixel of a row lights: looked up, for it is asked for once a term.
  const int first = floor_div(cells.x0, cells_x_) - reach_[0];
  std::vector<ptrdiff_t> column;
  for (int x = first; x <= floor_div(cells.x1 - 1, cells_x_) + reach_[1]; ++x) {
    const int at = continued(x, picture.width_px, beyond);
    column.push_back(at < 0 ? -1 : 3 * static_cast<ptrdiff_t>(at));
  }
  for (int y = cells.y0; y < cells.y1; ++y) {
    const int pixel_y = floor_div(y, cells_y_);
    const std::vector<Term>* row =
        terms_.data() + static_cast<ptrdiff_t>(modulo(y + origin_y_ * cells_y_, height)) * width;
    for (int x = cells.x0; x < cells.x1; ++x, light += 3) {
      double sum[3] = {0, 0, 0};
      const int pixel_x = floor_div(x, cells_x_);
      for (const Term& term : row[modulo(x + origin_x_ * cells_x_, width)]) {
        const int from_y = continued(pixel_y + term.dy, picture.height_px, beyond);
        const ptrdiff_t from_x = column[static_cast<size_t>(pixel_x + term.dx - first)];
        if (from_y < 0 || from_x < 0) continue;
        if (from_y < picture.y0 || from_y >= picture.y1) throw_internal("a row that lights a cell is missing");
        const Sample* rgb = picture.pixels + (from_y - picture.y0) * picture.stride + from_x;
        double drive = static_cast<double>(term.channel < 3 ? rgb[term.channel] : 0);
        if (derives_white_) {
          const double white = static_cast<double>(std::min({rgb[0], rgb[1], rgb[2]}));
          drive = term.channel == kWhiteChannel ? white : drive - white;
        }
        for (int i = 0; i < 3; ++i) sum[i] += drive * term.light[i];
      }
      for (int i = 0; i < 3; ++i) light[i] = static_cast<Real>(sum[i]);
    }
  }
}

template void Emission::light(const DriveRows<float>&, Beyond, const CellRect&, float*) const;
template void Emission::light(const DriveRows<float>&, Beyond, const CellRect&, double*) const;
template void Emission::light(const DriveRows<double>&, Beyond, const CellRect&, double*) const;

}  // namespace triad
