// SPDX-License-Identifier: Apache-2.0
// A panel's light and what an eye sees of it, written out from the definitions: emitters scattered one by one onto a
// torus, Fourier sums term by term. Slow, with no code of the library but the observer's constants.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <triad/display/layout.hpp>
#include <triad/display/vision.hpp>
#include <vector>

#include "display_reference.hpp"

namespace triad::reference {

// The torus of a picture of width x height pixels: the picture itself, or followed by its mirror images.
struct Torus {
  const Layout* layout;
  int width_px, height_px;
  bool mirror;
  int origin_x = 0, origin_y = 0;

  static int up(int n, int tile) { return (n + tile - 1) / tile * tile; }
  int px_x() const { return mirror ? up(2 * width_px, layout->tile_x) : width_px; }
  int px_y() const { return mirror ? up(2 * height_px, layout->tile_y) : height_px; }
  int cells_x() const { return px_x() * layout->cells_x; }
  int cells_y() const { return px_y() * layout->cells_y; }
  static int fold(int i, int size) { return i < size ? i : 2 * size - 1 - i; }
};

using Field = std::vector<std::array<double, 3>>;  // RGB, row by row over the torus's cells

inline double clipped(float v, bool clip) {
  return clip ? std::min(1., std::max(0., static_cast<double>(v))) : static_cast<double>(v);
}

// For torus sides that are even numbers of whole tiles, or wrapped ones.
inline Field panel_light(const Torus& t, const std::vector<float>& drives, bool clip) {
  const Layout& l = *t.layout;
  Field out(static_cast<size_t>(t.cells_x() * t.cells_y()));
  for (int y = 0; y < t.px_y(); ++y)
    for (int x = 0; x < t.px_x(); ++x) {
      const int from = Torus::fold(y, t.height_px) * t.width_px + Torus::fold(x, t.width_px);
      double drive[4];
      for (int d = 0; d < 3; ++d) drive[d] = clipped(drives[static_cast<size_t>(3 * from + d)], clip);
      drive[3] = std::min({drive[0], drive[1], drive[2]});
      if (l.derives_white)
        for (int d = 0; d < 3; ++d) drive[d] -= drive[3];
      const int phase_x = ((x + t.origin_x) % l.tile_x + l.tile_x) % l.tile_x;
      const int phase_y = ((y + t.origin_y) % l.tile_y + l.tile_y) % l.tile_y;
      for (const Emitter& e : l.emitters) {
        if (e.pixel_x != phase_x || e.pixel_y != phase_y) continue;
        for (const EmitterCell& cell : e.cells) {
          const int nx = t.cells_x(), ny = t.cells_y();
          const int kx = (((x - phase_x) * l.cells_x + cell.x) % nx + nx) % nx;
          const int ky = (((y - phase_y) * l.cells_y + cell.y) % ny + ny) % ny;
          for (size_t d = 0; d < 3; ++d)
            out[static_cast<size_t>(ky * nx + kx)][d] +=
                drive[e.channel] * e.primary[d] * cell.share * l.pixel_cells();
        }
      }
    }
  return out;
}

inline Field target_light(const Torus& t, const std::vector<float>& cells, bool clip) {
  const int nx = t.cells_x(), width = t.width_px * t.layout->cells_x, height = t.height_px * t.layout->cells_y;
  Field out(static_cast<size_t>(nx * t.cells_y()));
  for (int y = 0; y < t.cells_y(); ++y)
    for (int x = 0; x < nx; ++x)
      for (size_t d = 0; d < 3; ++d)
        out[static_cast<size_t>(y * nx + x)][d] =
            clipped(cells[3 * static_cast<size_t>(Torus::fold(y, height) * width + Torus::fold(x, width)) + d], clip);
  return out;
}

// Channel c of the field in opponent space, each frequency times transfer(f in cpd).
template <class Transfer>
std::vector<double> seen(const Torus& t, const Field& field, const double* opponent_row, double ppd,
                         const Transfer& transfer) {
  using Complex = std::complex<double>;
  const int nx = t.cells_x(), ny = t.cells_y();
  const auto at = [nx](int y, int x) { return static_cast<size_t>(y * nx + x); };
  std::vector<Complex> values(field.size());
  for (size_t k = 0; k < field.size(); ++k)
    for (size_t d = 0; d < 3; ++d) values[k] += opponent_row[d] * field[k][d];
  const auto transform = [&](double sign) {
    std::vector<Complex> rows(values.size()), out(values.size());
    for (int y = 0; y < ny; ++y)
      for (int n = 0; n < nx; ++n)
        for (int x = 0; x < nx; ++x)
          rows[at(y, n)] += values[at(y, x)] * std::polar(1., sign * 2 * std::numbers::pi * (n * x % nx) / nx);
    for (int m = 0; m < ny; ++m)
      for (int n = 0; n < nx; ++n)
        for (int y = 0; y < ny; ++y)
          out[at(m, n)] += rows[at(y, n)] * std::polar(1., sign * 2 * std::numbers::pi * (m * y % ny) / ny);
    values = out;
  };
  transform(-1);
  for (int m = 0; m < ny; ++m)
    for (int n = 0; n < nx; ++n)
      values[at(m, n)] *= transfer(std::hypot(static_cast<double>(std::min(n, nx - n)) / t.px_x() * ppd,
                                              static_cast<double>(std::min(m, ny - m)) / t.px_y() * ppd)) /
                          (nx * ny);
  transform(1);
  std::vector<double> out;
  for (const Complex& v : values) out.push_back(v.real());
  return out;
}

// energy[pixel * 3 + c] of the picture's own pixels.
inline std::vector<double> plane_energy(const Torus& t, const Observer& o, const std::vector<float>& drives,
                                        const std::vector<float>& cells, bool clip) {
  const Layout& l = *t.layout;
  Field error = panel_light(t, drives, clip);
  const Field meant = target_light(t, cells, clip);
  for (size_t k = 0; k < error.size(); ++k)
    for (size_t d = 0; d < 3; ++d) error[k][d] -= meant[k][d];
  const auto C = opponent_matrix(o);
  std::vector<double> out(3 * static_cast<size_t>(t.width_px * t.height_px));
  for (int c = 0; c < 3; ++c) {
    const auto eye = seen(t, error, &C[static_cast<size_t>(3 * c)], o.ppd, [&](double f) { return mtf(o, c, f); });
    for (int y = 0; y < t.height_px * l.cells_y; ++y)
      for (int x = 0; x < t.width_px * l.cells_x; ++x)
        out[static_cast<size_t>((y / l.cells_y * t.width_px + x / l.cells_x) * 3 + c)] +=
            std::pow(eye[static_cast<size_t>(y * t.cells_x() + x)], 2) / l.pixel_cells();
  }
  return out;
}

}  // namespace triad::reference
