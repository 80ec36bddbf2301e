// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <complex>
#include <cstring>
#include <mutex>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/display/internal/plane_shape.hpp>

namespace triad {
namespace {

// The work of one solve.
template <class Real, class Impl, class Sample>
class Solve {
 public:
  using Complex = std::complex<Real>;
  Solve(const Impl& impl, const Sample* cells, ptrdiff_t stride, void* workspace)
      : s_(impl), a_(impl, workspace), cells_(cells), stride_(stride) {}

  // Drives of the displaced box; their spectrum in `start`.
  void make_box() {
    parallel_for(s_.Ty, [&](int64_t ty) {
      const int rows = s_.box.above() + s_.box.below();
      const size_t floats = aligned_stride<Real>(s_.ring.floats());
      const auto lines = lines_.take([&] { return AlignedBuffer<Real>(floats * static_cast<size_t>(rows)); });
      std::vector<const Real*> pointers;
      for (int r = 0; r < rows; ++r) {
        Real* line = lines->data() + static_cast<size_t>(r) * floats;
        fill(static_cast<int>(ty) * s_.equations.aliases_y() - s_.box.above() + r, line);
        pointers.push_back(line + s_.ring.start());
      }
      Real* out = a_.box + static_cast<size_t>(ty) * s_.row;
      s_.box.tiles(pointers.data(), s_.Tx, out, static_cast<ptrdiff_t>(s_.plane));
      for (int e = 0; e < s_.E; ++e)
        s_.tile_row.forward(out + static_cast<size_t>(e) * s_.plane, spectrum_at(a_.start, e, ty));
    });
    columns([&](int block, Complex* values) {
      load(a_.start, block, values);
      for (int e = 0; e < s_.E; ++e) s_.tile_columns.forward(values + static_cast<size_t>(e) * s_.Ty * kColumns);
      store(values, block, a_.start);
    });
  }

  // b in `spectrum` and J(start) / T, channel by channel.
  double make_residual() {
    std::fill_n(a_.spectrum, static_cast<size_t>(s_.E) * s_.spectrum_plane, Complex{});
    std::vector<double> energies(static_cast<size_t>(s_.blocks()), 0.);
    for (int c = 0; c < 3; ++c) {
      transform_cells(c);
      parallel_for(s_.blocks(), [&](int64_t block) {
        energies[static_cast<size_t>(block)] += residual(c, static_cast<int>(block));
      });
    }
    double sum = 0;
    for (const double energy : energies) sum += energy;
    return sum / s_.equations.tiles() / s_.equations.tiles();
  }

  // K and A, and K b / T in `start`.
  void make_tables() {
    parallel_for(s_.Ty, [&](int64_t my) {
      constexpr int kStep = 64;
      const size_t size = HermitianTable::size(s_.E);
      std::vector<double> packed(size * kStep);
      const double lambda = s_.options.filter.lambda;
      for (int m = 0; m < s_.Mx; m += kStep) {
        const int count = std::min(kStep, s_.Mx - m);
        const size_t at = static_cast<size_t>(my) * s_.spectrum_row + static_cast<size_t>(m);
        const auto keep = [&](Real* table) {
          for (size_t q = 0; q < size; ++q)
            for (int i = 0; i < count; ++i)
              table[q * s_.table + at + static_cast<size_t>(i)] =
                  static_cast<Real>(packed[q * kStep + static_cast<size_t>(i)]);
        };
        s_.equations.gram(m, count, static_cast<int>(my), packed.data(), kStep);
        s_.equations.add_diagonal(lambda * lambda, count, packed.data(), kStep);
        keep(a_.A);
        if (s_.options.bounded) s_.equations.add_diagonal(descent::penalty(lambda), count, packed.data(), kStep);
        invert_hermitian(s_.E, count, packed.data(), kStep);
        keep(a_.K);
        descent::multiply(s_.E, static_cast<size_t>(count), static_cast<Real>(1 / s_.equations.tiles()), a_.K + at,
                          s_.table, a_.spectrum + at, s_.spectrum_plane, a_.start + at, s_.spectrum_plane);
      }
    });
  }

  SolveResult descend(double start, const std::function<void(double)>& progress) {
    SolveResult result;
    result.start = result.best = start;
    const double T = s_.equations.tiles();
    parallel_for(s_.Ty * s_.E, [&](int64_t i) {
      std::fill_n(a_.state + static_cast<size_t>(i) * s_.row, s_.row, Real{0});
      std::fill_n(a_.best + static_cast<size_t>(i) * s_.row, s_.row, Real{0});
    });
    if (!s_.options.bounded) {
      // x is the optimum itself: J(x) = J(start) - x^H A x.
      result.best = result.bound = std::max(0., start - inner_step(true, true));
      rows(true, [&](int ty, const auto& row) {
        for (int e = 0; e < s_.E; ++e)
          std::copy_n(row.x + static_cast<size_t>(e) * row.x_stride, s_.row,
                      a_.best + static_cast<size_t>(e) * s_.plane + static_cast<size_t>(ty) * s_.row);
        return false;
      });
      return result;
    }
    descent::Schedule schedule(s_.steps.stages(), s_.options, result, descent::negligible<Real>());
    while (schedule.next()) {
      if (progress) progress(schedule.done());
      const descent::Stage stage = schedule.stage();
      if (schedule.first_of_stage() && !schedule.first()) {
        if (stage == descent::Stage::kFixed)
          rows(false, [&](int, const auto& row) {
            s_.steps.choose_pieces(row);
            return false;
          });
        reflect(stage);
      }
      const double form_x = inner_step(schedule.first(), schedule.check()) * T;
      if (!schedule.check()) {
        rows(true, [&](int, const auto& row) {
          s_.steps.advance(stage, row);
          return true;
        });
        continue;
      }
      std::vector<descent::Sums> parts(static_cast<size_t>(s_.Ty));
      rows(true, [&](int ty, const auto& row) {
        parts[static_cast<size_t>(ty)] = s_.steps.advance_certified(stage, row);
        return true;
      });
      descent::Sums sums;
      for (const auto& part : parts) sums.add(part);
      if (schedule.certify(form_x, difference_form() / T, sums, T))
        rows(false, [&](int ty, const auto& row) {
          s_.steps.project(stage, row);
          for (int e = 0; e < s_.E; ++e)
            std::copy_n(row.next + static_cast<size_t>(e) * row.next_stride, s_.row,
                        a_.best + static_cast<size_t>(e) * s_.plane + static_cast<size_t>(ty) * s_.row);
          return false;
        });
      reflect(stage);
    }
    return schedule.result();
  }

  template <class Out>
  void finish(Out* drives, ptrdiff_t stride) {
    parallel_for(s_.Ty, [&](int64_t ty) {
      std::vector<Real> values(static_cast<size_t>(s_.E) * s_.row);
      std::vector<Real> pixels(3 * static_cast<size_t>(s_.x.length_px()));
      for (int e = 0; e < s_.E; ++e) {
        const size_t at = static_cast<size_t>(e) * s_.plane + static_cast<size_t>(ty) * s_.row;
        Real* to = values.data() + static_cast<size_t>(e) * s_.row;
        if (s_.options.bounded) {
          descent::displayable(static_cast<size_t>(s_.Tx), a_.box + at, a_.best + at, to);
        } else {
          for (size_t i = 0; i < static_cast<size_t>(s_.Tx); ++i) to[i] = a_.box[at + i] + a_.best[at + i];
        }
      }
      for (int p = 0; p < s_.y.tile_px; ++p) {
        const int py = s_.y.picture_px(static_cast<int>(ty) * s_.y.tile_px + p);
        if (py < 0) continue;
        s_.order.pixels(values.data(), static_cast<ptrdiff_t>(s_.row), s_.Tx, p, pixels.data());
        s_.x.cut(pixels.data(), drives + py * stride);
      }
    });
  }

 private:
  // Buffers that threads take and give back.
  template <class T>
  class Shelf {
   public:
    template <class Make>
    std::shared_ptr<T> take(Make&& make) {
      std::unique_ptr<T> item;
      {
        const std::lock_guard lock(mutex_);
        if (!free_.empty()) {
          item = std::move(free_.back());
          free_.pop_back();
        }
      }
      if (!item) item = std::make_unique<T>(make());
      return {item.release(), [this](T* back) {
                const std::lock_guard lock(mutex_);
                free_.emplace_back(back);
              }};
    }

   private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<T>> free_;
  };

  // Row k of the torus's cells; k may lie beyond it.
  void fill(int k, Real* line) const {
    const int wrapped = ((k % s_.Ny) + s_.Ny) % s_.Ny;
    s_.ring.fill(cells_ + s_.y.cell_at(wrapped) * stride_, line);
  }

  Complex* spectrum_at(Complex* base, int e, int64_t ty) const {
    return base + static_cast<size_t>(e) * s_.spectrum_plane + static_cast<size_t>(ty) * s_.spectrum_row;
  }

  // body(block, values) for each block of columns: E planes of Ty rows of kColumns.
  template <class Body>
  void columns(const Body& body) {
    parallel_for(s_.blocks(), [&](int64_t block) {
      const auto values = columns_.take(
          [&] { return AlignedBuffer<Complex>(static_cast<size_t>(s_.E) * static_cast<size_t>(s_.Ty) * kColumns); });
      body(static_cast<int>(block), values->data());
    });
  }
  void load(const Complex* from, int block, Complex* values) const {
    for (int e = 0; e < s_.E; ++e) {
      const Complex* line = from + static_cast<size_t>(e) * s_.spectrum_plane + static_cast<size_t>(block) * kColumns;
      for (int ty = 0; ty < s_.Ty; ++ty, values += kColumns, line += s_.spectrum_row)
        std::memcpy(values, line, sizeof(Complex) * kColumns);
    }
  }
  void store(const Complex* values, int block, Complex* to) const {
    for (int e = 0; e < s_.E; ++e) {
      Complex* line = to + static_cast<size_t>(e) * s_.spectrum_plane + static_cast<size_t>(block) * kColumns;
      for (int ty = 0; ty < s_.Ty; ++ty, values += kColumns, line += s_.spectrum_row)
        std::memcpy(line, values, sizeof(Complex) * kColumns);
    }
  }
  size_t column_values() const { return static_cast<size_t>(s_.Ty) * kColumns; }
  int count_of(int block) const { return std::min(kColumns, s_.Mx - block * kColumns); }

  // Rows of the picture in opponent channel c, over S, transformed along x.
  void transform_cells(int c) {
    Real C[3];
    for (int d = 0; d < 3; ++d)
      C[d] = static_cast<Real>(s_.equations.opponent()[static_cast<size_t>(3 * c + d)] / s_.equations.aliases());
    parallel_for(s_.Ny, [&](int64_t ny) {
      const size_t floats = aligned_stride<Real>(s_.ring.floats());
      const auto lines = cell_lines_.take(
          [&] { return AlignedBuffer<Real>(floats + aligned_stride<Real>(static_cast<size_t>(s_.Nx))); });
      fill(static_cast<int>(ny), lines->data());
      const Real* rgb = lines->data() + s_.ring.start();
      Real* line = lines->data() + floats;
      for (int k = 0; k < s_.Nx; ++k) line[k] = C[0] * rgb[3 * k] + C[1] * rgb[3 * k + 1] + C[2] * rgb[3 * k + 2];
      s_.cell_row.forward(line, a_.cells + static_cast<size_t>(ny) * s_.cells_spectrum_row);
    });
  }

  // What channel c adds to b and to J(start), for one block of columns.
  double residual(int c, int block) {
    const int Sx = s_.equations.aliases_x(), Sy = s_.equations.aliases_y(), E = s_.E;
    const int mx = block * kColumns, count = count_of(block);
    const size_t fine = static_cast<size_t>(s_.Ny) * kColumns;
    const auto buffer = fine_columns_.take([&] { return AlignedBuffer<Complex>(fine * static_cast<size_t>(Sx)); });
    for (int jx = 0; jx < Sx; ++jx) {
      Complex* values = buffer->data() + fine * static_cast<size_t>(jx);
      for (int ny = 0; ny < s_.Ny; ++ny, values += kColumns) {
        const Complex* from = a_.cells + static_cast<size_t>(ny) * s_.cells_spectrum_row;
        for (int i = 0; i < kColumns; ++i) {
          const int nx = mx + i + s_.Tx * jx;
          values[i] = i >= count ? Complex{} : from[2 * nx <= s_.Nx ? nx : s_.Nx - nx];
        }
      }
      s_.cell_columns.forward(buffer->data() + fine * static_cast<size_t>(jx));
    }
    Scratch t(E);
    for (int e = 0; e < E; ++e) t.P[static_cast<size_t>(e)] = static_cast<Real>(s_.equations.weight(c, e));
    double energy = 0;
    for (int my = 0; my < s_.Ty; ++my) {
      std::fill(std::begin(t.energy), std::end(t.energy), Real{0});
      for (int e = 0; e < E; ++e)
        for (int i = 0; i < kColumns; ++i) {
          const auto at = static_cast<size_t>(e * kColumns + i);
          const Complex box = spectrum_at(a_.start, e, my)[mx + (i < count ? i : 0)];
          const Complex b = spectrum_at(a_.spectrum, e, my)[mx + (i < count ? i : 0)];
          t.box_re[at] = box.real(), t.box_im[at] = box.imag();
          t.b_re[at] = b.real(), t.b_im[at] = b.imag();
        }
      for (int jy = 0; jy < Sy; ++jy)
        for (int jx = 0; jx < Sx; ++jx) {
          const int ny = my + s_.Ty * jy;
          t.look_up(s_.equations, c, mx, count, my, jx, jy);
          const Complex* values = buffer->data() + fine * static_cast<size_t>(jx);
          for (int i = 0; i < count; ++i) {
            const bool straight = 2 * (mx + i + s_.Tx * jx) <= s_.Nx;
            const Complex v = values[(straight || ny == 0 ? straight ? ny : 0 : s_.Ny - ny) * kColumns + i];
            t.target_re[i] = v.real();
            t.target_im[i] = straight ? v.imag() : -v.imag();
          }
          t.residual(E, count).add();
        }
      for (int e = 0; e < E; ++e)
        for (int i = 0; i < count; ++i) {
          const auto at = static_cast<size_t>(e * kColumns + i);
          spectrum_at(a_.spectrum, e, my)[mx + i] = {t.b_re[at], t.b_im[at]};
        }
      for (int i = 0; i < count; ++i)
        energy += static_cast<double>(s_.share[static_cast<size_t>(mx + i)]) * static_cast<double>(t.energy[i]);
    }
    return energy;
  }

  // Arrays for kColumns frequencies of one row.
  struct Scratch {
    std::vector<double> re, im;
    std::vector<Real> light_re, light_im, box_re, box_im, b_re, b_im, P;
    double line[kColumns];
    Real keep[kColumns], weight[kColumns], target_re[kColumns], target_im[kColumns], energy[kColumns];
    explicit Scratch(int E)
        : re(static_cast<size_t>(E) * kColumns),
          im(re.size()),
          light_re(re.size()),
          light_im(re.size()),
          box_re(re.size()),
          box_im(re.size()),
          b_re(re.size()),
          b_im(re.size()),
          P(static_cast<size_t>(E)) {}
    void look_up(const TileEquations& equations, int c, int mx, int count, int my, int jx, int jy) {
      const int nx = mx + equations.tiles_x() * jx, ny = my + equations.tiles_y() * jy;
      equations.light(nx, count, ny, re.data(), im.data(), kColumns);
      for (size_t i = 0; i < re.size(); ++i) {
        light_re[i] = static_cast<Real>(re[i]);
        light_im[i] = static_cast<Real>(im[i]);
      }
      equations.transfer(c, nx, count, ny, line);
      for (int i = 0; i < count; ++i) weight[i] = static_cast<Real>(line[i] * line[i]);
      equations.keep(mx, count, my, jx, jy, line);
      for (int i = 0; i < count; ++i) keep[i] = static_cast<Real>(line[i]);
    }
    descent::Residual<Real> residual(int E, int count) {
      return {E,      count,     kColumns,  light_re.data(), light_im.data(), box_re.data(), box_im.data(), keep,
              weight, target_re, target_im, P.data(),        b_re.data(),     b_im.data(),   energy};
    }
  };

  // x's spectrum over T, transformed back along y, in `spectrum`; if asked the sum of x^H A x.
  double inner_step(bool first, bool form) {
    std::vector<double> forms(static_cast<size_t>(s_.blocks()), 0.);
    columns([&](int block, Complex* values) {
      const size_t at = static_cast<size_t>(block) * kColumns, count = static_cast<size_t>(count_of(block));
      load(first ? a_.start : a_.spectrum, block, values);
      if (!first)
        for (int e = 0; e < s_.E; ++e) s_.tile_columns.forward(values + static_cast<size_t>(e) * column_values());
      for (int my = 0; my < s_.Ty; ++my) {
        const size_t from = static_cast<size_t>(my) * s_.spectrum_row + at;
        Complex* v = values + static_cast<size_t>(my) * kColumns;
        if (!first)
          descent::apply(s_.E, count, a_.K + from, s_.table, a_.start + from, s_.spectrum_plane, v, column_values());
        if (form)
          forms[static_cast<size_t>(block)] +=
              descent::quadratic(s_.E, count, a_.A + from, s_.table, v, column_values(), s_.share.data() + at);
      }
      for (int e = 0; e < s_.E; ++e) s_.tile_columns.inverse(values + static_cast<size_t>(e) * column_values());
      store(values, block, a_.spectrum);
    });
    double sum = 0;
    for (const double f : forms) sum += f;
    return sum;
  }

  // body(ty, row) for each row of tiles. row.x is what `spectrum` holds, transformed back, if asked; where body
  // returns true, row.next is transformed and stored there.
  template <class Body>
  void rows(bool back, const Body& body) {
    parallel_for(s_.Ty, [&](int64_t ty) {
      const auto lines =
          tile_lines_.take([&] { return AlignedBuffer<Real>(2 * s_.row * static_cast<size_t>(s_.E)); });
      Real *x = lines->data(), *next = x + s_.row * static_cast<size_t>(s_.E);
      const size_t at = static_cast<size_t>(ty) * s_.row;
      if (back)
        for (int e = 0; e < s_.E; ++e)
          s_.tile_row.inverse(spectrum_at(a_.spectrum, e, ty), x + static_cast<size_t>(e) * s_.row);
      const descent::TileRow<Real> row{static_cast<size_t>(s_.Tx),
                                       x,
                                       s_.row,
                                       a_.box + at,
                                       a_.state + at,
                                       s_.plane,
                                       next,
                                       s_.row,
                                       a_.pieces + at,
                                       s_.plane};
      if (!body(static_cast<int>(ty), row)) return;
      for (int e = 0; e < s_.E; ++e)
        s_.tile_row.forward(next + static_cast<size_t>(e) * s_.row, spectrum_at(a_.spectrum, e, ty));
    });
  }
  void reflect(descent::Stage stage) {
    rows(false, [&](int, const auto& row) {
      s_.steps.reflect(stage, row);
      return true;
    });
  }
  // The sum of d^H A d for the difference that `spectrum` holds, transformed along x.
  double difference_form() {
    std::vector<double> forms(static_cast<size_t>(s_.blocks()), 0.);
    columns([&](int block, Complex* values) {
      const size_t at = static_cast<size_t>(block) * kColumns, count = static_cast<size_t>(count_of(block));
      load(a_.spectrum, block, values);
      for (int e = 0; e < s_.E; ++e) s_.tile_columns.forward(values + static_cast<size_t>(e) * column_values());
      for (int my = 0; my < s_.Ty; ++my)
        forms[static_cast<size_t>(block)] +=
            descent::quadratic(s_.E, count, a_.A + static_cast<size_t>(my) * s_.spectrum_row + at, s_.table,
                               values + static_cast<size_t>(my) * kColumns, column_values(), s_.share.data() + at);
    });
    double sum = 0;
    for (const double f : forms) sum += f;
    return sum;
  }
  const Impl& s_;
  typename Impl::Arrays a_;
  const Sample* cells_;
  ptrdiff_t stride_;
  Shelf<AlignedBuffer<Real>> lines_, cell_lines_, tile_lines_;
  Shelf<AlignedBuffer<Complex>> columns_, fine_columns_;
};

}  // namespace

template <class Real>
PlaneSolver<Real>::PlaneSolver(const Layout& layout, const Observer& observer, int width_px, int height_px,
                               int origin_x_px, int origin_y_px, Edge edge, const SolveOptions& options)
    : impl_(std::make_unique<Impl>(layout, observer, width_px, height_px, origin_x_px, origin_y_px, edge, options)) {}
template <class Real>
PlaneSolver<Real>::~PlaneSolver() = default;
template <class Real>
PlaneSolver<Real>::PlaneSolver(PlaneSolver&&) noexcept = default;

template <class Real>
uint64_t PlaneSolver<Real>::workspace_bytes() const {
  return typename Impl::Arrays(*impl_, nullptr).bytes;
}

template <class Real>
template <class Sample>
SolveResult PlaneSolver<Real>::solve(const Sample* cells, ptrdiff_t stride, Sample* drives, ptrdiff_t drives_stride,
                                     void* workspace, const std::function<void(double)>& progress) const {
  if (reinterpret_cast<uintptr_t>(workspace) % kBufferAlignment_bytes != 0)
    throw_internal("the workspace of a solve must be 64-byte aligned");
  Solve<Real, Impl, Sample> solve(*impl_, cells, stride, workspace);
  solve.make_box();
  const double start = solve.make_residual();
  solve.make_tables();
  const SolveResult result = solve.descend(start, progress);
  solve.finish(drives, drives_stride);
  return result;
}

template class PlaneSolver<float>;
template class PlaneSolver<double>;
template SolveResult PlaneSolver<float>::solve(const float*, ptrdiff_t, float*, ptrdiff_t, void*,
                                               const std::function<void(double)>&) const;
template SolveResult PlaneSolver<double>::solve(const float*, ptrdiff_t, float*, ptrdiff_t, void*,
                                                const std::function<void(double)>&) const;
template SolveResult PlaneSolver<double>::solve(const double*, ptrdiff_t, double*, ptrdiff_t, void*,
                                                const std::function<void(double)>&) const;

}  // namespace triad
