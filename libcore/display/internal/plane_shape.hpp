// SPDX-License-Identifier: Apache-2.0
// What a PlaneSolver knows before it sees a picture: shapes, plans of transforms, the arrays of a solve.
#pragma once

#include <algorithm>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/display/constrained.hpp>
#include <triad/display/internal/descent.hpp>
#include <triad/display/internal/drive_steps.hpp>
#include <triad/display/internal/ring_rows.hpp>
#include <triad/display/internal/tile_equations.hpp>
#include <triad/numeric/fft.hpp>
#include <vector>

namespace triad {

inline constexpr int kColumns = 16;  // transformed side by side: two cache lines of complex floats

// Numbers of `n` bytes each carved from a workspace one after the other, on cache lines.
class Carver {
 public:
  explicit Carver(void* start) : start_(static_cast<std::byte*>(start)) {}
  template <class T>
  T* take(size_t n) {
    T* out = start_ ? reinterpret_cast<T*>(start_ + used_) : nullptr;
    used_ += aligned_stride<T>(n) * sizeof(T);
    return out;
  }
  size_t used() const { return used_; }
  void rewind(size_t to) { used_ = to; }

 private:
  std::byte* start_;
  size_t used_ = 0;
};

template <class Real>
struct PlaneSolver<Real>::Impl {
  using Complex = std::complex<Real>;
  SolveOptions options;
  TorusAxis x, y;
  TileEquations equations;
  DisplacedBox box;
  DriveOrder order;
  RingRows<Real> ring;
  descent::DriveSteps<Real> steps;
  RealFft<Real> tile_row, cell_row;
  ColumnFft<Real> tile_columns, cell_columns;
  int E, Tx, Ty, Mx, Nx, Ny, Fx;  // Mx and Fx: frequencies of half a row of tiles, of cells
  size_t row, plane;              // drives from row to row, and from emitter to emitter
  size_t spectrum_row, spectrum_plane, cells_spectrum_row;
  size_t table;  // of a packed number, from one to the next
  std::vector<Real> share;

  Impl(const Layout& layout, const Observer& observer, int width_px, int height_px, int origin_x, int origin_y,
       Edge edge, const SolveOptions& asked)
      : options(asked),
        x(torus_axis(width_px, layout.cells_x, layout.tile_x, origin_x, edge, observer.ppd)),
        y(torus_axis(height_px, layout.cells_y, layout.tile_y, origin_y, edge, observer.ppd)),
        equations(layout, observer, asked.filter, x.tiles, y.tiles),
        box(layout),
        order(layout),
        ring(x, box.left(), box.right(), asked.clamp_input),
        steps(equations, asked.filter.lambda),
        tile_row(static_cast<size_t>(x.tiles)),
        cell_row(static_cast<size_t>(x.length_cells())),
        tile_columns(static_cast<size_t>(y.tiles), kColumns),
        cell_columns(static_cast<size_t>(y.length_cells()), kColumns),
        E(equations.emitters()),
        Tx(x.tiles),
        Ty(y.tiles),
        Mx(Tx / 2 + 1),
        Nx(x.length_cells()),
        Ny(y.length_cells()),
        Fx(Nx / 2 + 1),
        row(aligned_stride<Real>(static_cast<size_t>(Tx))),
        plane(row * static_cast<size_t>(Ty)),
        spectrum_row(static_cast<size_t>((Mx + kColumns - 1) / kColumns * kColumns)),
        spectrum_plane(spectrum_row * static_cast<size_t>(Ty)),
        cells_spectrum_row(aligned_stride<Complex>(static_cast<size_t>(Fx))),
        table(spectrum_plane),
        share(descent::half_shares<Real>(Tx)) {
    if (options.bounded) return;
    if (layout.derives_white)
      throw_usage("layout '" + layout.name +
                  "' derives its white: its light is no linear function of a picture, and " +
                  "there is no linear filter for it");
    if (options.filter.lambda < kLeastLinearLambda)
      throw_usage("lambda is " + format_double(options.filter.lambda) + ": the linear filter in the plane needs " +
                  format_double(kLeastLinearLambda) + " or more");
  }

  // The arrays of a solve. The cells' spectrum is needed before the tables are made, and shares their place.
  struct Arrays {
    Real *box, *state, *best;
    Complex *spectrum, *start, *cells;
    Real *K, *A;
    uint8_t* pieces;
    size_t bytes;
    Arrays(const Impl& s, void* workspace) {
      Carver from(workspace);
      const auto E = static_cast<size_t>(s.E);
      box = from.take<Real>(E * s.plane);
      state = from.take<Real>(E * s.plane);
      best = from.take<Real>(E * s.plane);
      spectrum = from.take<Complex>(E * s.spectrum_plane);
      start = from.take<Complex>(E * s.spectrum_plane);
      pieces = from.take<uint8_t>(static_cast<size_t>(s.steps.whites()) * s.plane);
      const size_t shared = from.used();
      cells = from.take<Complex>(s.cells_spectrum_row * static_cast<size_t>(s.Ny));
      const size_t first = from.used();
      from.rewind(shared);
      K = from.take<Real>(HermitianTable::size(s.E) * s.table);
      A = from.take<Real>(HermitianTable::size(s.E) * s.table);
      bytes = std::max(first, from.used());
    }
  };

  int blocks() const { return (Mx + kColumns - 1) / kColumns; }
};

}  // namespace triad
