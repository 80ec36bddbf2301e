// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <complex>
#include <triad/base/error.hpp>
#include <triad/display/constrained.hpp>
#include <triad/display/internal/descent.hpp>
#include <triad/display/internal/drive_steps.hpp>
#include <triad/display/internal/ring_rows.hpp>
#include <triad/display/internal/tile_equations.hpp>
#include <triad/numeric/fft.hpp>

namespace triad {
namespace {

const Layout& checked(const Layout& layout) {
  if (!layout.has_independent_rows())
    throw_usage("layout '" + layout.name + "' has no independent rows: mode=plane solves it");
  return layout;
}

}  // namespace

template <class Real>
struct RowSolver<Real>::Impl {
  SolveOptions options;
  TorusAxis axis;
  TileEquations equations;
  DisplacedBox box;
  DriveOrder order;
  RingRows<Real> ring;
  descent::DriveSteps<Real> steps;
  RealFft<Real> tiles_fft, cells_fft;
  int E, T, S, M;          // M = T / 2 + 1 frequencies
  size_t stride, spectra;  // from plane to plane of T drives, of M frequencies
  // Tables for all m: [alias][e][m], [alias][channel][m], [alias][m], [packed][m].
  std::vector<Real> light_re, light_im, weight, keep, K, A, P, share;

  Impl(const Layout& layout, const Observer& observer, int width_px, int origin_px, Edge edge,
       const SolveOptions& asked)
      : options(asked),
        axis(torus_axis(width_px, checked(layout).cells_x, layout.tile_x, origin_px, edge, observer.ppd)),
        equations(layout, observer, asked.filter, axis.tiles, 1),
        box(layout),
        order(layout),
        ring(axis, box.left(), box.right(), true),
        steps(equations, asked.filter.lambda),
        tiles_fft(static_cast<size_t>(axis.tiles)),
        cells_fft(static_cast<size_t>(axis.length_cells())),
        E(equations.emitters()),
        T(axis.tiles),
        S(equations.aliases_x()),
        M(T / 2 + 1),
        stride(aligned_stride<Real>(static_cast<size_t>(T))),
        spectra(aligned_stride<std::complex<Real>>(static_cast<size_t>(M))) {
    std::vector<double> re(static_cast<size_t>(E) * M), im(re.size()), line(static_cast<size_t>(M));
    const auto append = [](std::vector<Real>& to, const std::vector<double>& from) {
      for (const double v : from) to.push_back(static_cast<Real>(v));
    };
    for (int j = 0; j < S; ++j) {
      equations.light(T * j, M, 0, re.data(), im.data(), M);
      append(light_re, re);
      append(light_im, im);
      for (int c = 0; c < 3; ++c) {
        equations.transfer(c, T * j, M, 0, line.data());
        for (double& v : line) v *= v;
        append(weight, line);
      }
      equations.keep(0, M, 0, j, 0, line.data());
      append(keep, line);
    }
    for (int c = 0; c < 3; ++c)
      for (int e = 0; e < E; ++e) P.push_back(static_cast<Real>(equations.weight(c, e)));
    share = descent::half_shares<Real>(T);
    const double lambda = options.filter.lambda;
    std::vector<double> packed(HermitianTable::size(E) * M);
    equations.gram(0, M, 0, packed.data(), M);
    equations.add_diagonal(lambda * lambda, M, packed.data(), M);
    append(A, packed);
    equations.add_diagonal(descent::penalty(lambda), M, packed.data(), M);
    invert_hermitian(E, M, packed.data(), M);
    append(K, packed);
  }
};

template <class Real>
struct RowSolver<Real>::Workspace::Buffers {
  AlignedBuffer<Real> cells, plane, x, box, state, next, best, energy;
  AlignedBuffer<std::complex<Real>> fine[3], spectrum, start;
  std::vector<uint8_t> pieces;
  std::vector<Real> box_re, box_im, b_re, b_im, target_re, target_im, pixels;

  explicit Buffers(const Impl& s)
      : cells(s.ring.floats()),
        plane(s.cells_fft.size()),
        x(s.stride * s.E),
        box(x.size()),
        state(box.size()),
        next(box.size()),
        best(box.size()),
        energy(static_cast<size_t>(s.M)),
        spectrum(s.spectra * s.E),
        start(s.spectra * s.E),
        pieces(static_cast<size_t>(s.steps.whites()) * s.T),
        box_re(static_cast<size_t>(s.E) * s.M),
        box_im(box_re.size()),
        b_re(box_re.size()),
        b_im(box_re.size()),
        target_re(static_cast<size_t>(s.M)),
        target_im(target_re.size()),
        pixels(3 * static_cast<size_t>(s.axis.length_px())) {
    for (auto& channel : fine) channel = AlignedBuffer<std::complex<Real>>(s.cells_fft.spectrum_size());
  }

  // The displaced box, and the start's residual: h = K b over T in `start`, J(start) / T returned.
  double begin(const Impl& s);
};

template <class Real>
double RowSolver<Real>::Workspace::Buffers::begin(const Impl& s) {
  const Real* ring = cells.data() + s.ring.start();
  s.box.tiles(&ring, s.T, box.data(), static_cast<ptrdiff_t>(s.stride));
  const int M = s.M, N = s.T * s.S;
  for (int e = 0; e < s.E; ++e) {
    s.tiles_fft.forward(box.data() + static_cast<size_t>(e) * s.stride, spectrum.data());
    for (int m = 0; m < M; ++m) {
      box_re[static_cast<size_t>(e * M + m)] = spectrum[static_cast<size_t>(m)].real();
      box_im[static_cast<size_t>(e * M + m)] = spectrum[static_cast<size_t>(m)].imag();
    }
  }
  const Real over = static_cast<Real>(1.0 / s.S);
  for (int c = 0; c < 3; ++c) {
    Real C[3];
    for (int d = 0; d < 3; ++d)
      C[d] = over * static_cast<Real>(s.equations.opponent()[static_cast<size_t>(3 * c + d)]);
    for (int k = 0; k < N; ++k)
      plane[static_cast<size_t>(k)] = C[0] * ring[3 * k] + C[1] * ring[3 * k + 1] + C[2] * ring[3 * k + 2];
    s.cells_fft.forward(plane.data(), fine[c].data());
  }
  std::fill(b_re.begin(), b_re.end(), Real{0});
  std::fill(b_im.begin(), b_im.end(), Real{0});
  std::fill(energy.begin(), energy.end(), Real{0});
  for (int j = 0; j < s.S; ++j)
    for (int c = 0; c < 3; ++c) {
      const int n0 = s.T * j;
      // Below the middle as it is, above it the conjugate of N - n.
      const int straight = std::clamp(N / 2 + 1 - n0, 0, M);
      const auto* from = fine[c].data();
      for (int m = 0; m < straight; ++m) {
        target_re[static_cast<size_t>(m)] = from[n0 + m].real();
        target_im[static_cast<size_t>(m)] = from[n0 + m].imag();
      }
      for (int m = straight; m < M; ++m) {
        target_re[static_cast<size_t>(m)] = from[N - n0 - m].real();
        target_im[static_cast<size_t>(m)] = -from[N - n0 - m].imag();
      }
      const auto planes = static_cast<ptrdiff_t>(s.E) * M * j;
      descent::Residual<Real>{s.E,
                              M,
                              M,
                              s.light_re.data() + planes,
                              s.light_im.data() + planes,
                              box_re.data(),
                              box_im.data(),
                              s.keep.data() + static_cast<ptrdiff_t>(M) * j,
                              s.weight.data() + static_cast<ptrdiff_t>(M) * (3 * j + c),
                              target_re.data(),
                              target_im.data(),
                              s.P.data() + static_cast<ptrdiff_t>(s.E) * c,
                              b_re.data(),
                              b_im.data(),
                              energy.data()}
          .add();
    }
  for (int e = 0; e < s.E; ++e)
    for (int m = 0; m < M; ++m) {
      const auto at = static_cast<size_t>(e * M + m);
      spectrum[static_cast<size_t>(e) * s.spectra + static_cast<size_t>(m)] = {b_re[at], b_im[at]};
    }
  descent::multiply(s.E, static_cast<size_t>(M), static_cast<Real>(1.0 / s.T), s.K.data(), static_cast<size_t>(M),
                    spectrum.data(), s.spectra, start.data(), s.spectra);
  double sum = 0;
  for (int m = 0; m < M; ++m)
    sum += static_cast<double>(s.share[static_cast<size_t>(m)]) * static_cast<double>(energy[static_cast<size_t>(m)]);
  return sum / s.T / s.T;
}

template <class Real>
RowSolver<Real>::RowSolver(const Layout& layout, const Observer& observer, int width_px, int origin_px, Edge edge,
                           const SolveOptions& options)
    : impl_(std::make_unique<Impl>(layout, observer, width_px, origin_px, edge, options)) {}
template <class Real>
RowSolver<Real>::~RowSolver() = default;
template <class Real>
RowSolver<Real>::RowSolver(RowSolver&&) noexcept = default;

template <class Real>
RowSolver<Real>::Workspace::Workspace(const RowSolver& solver) : buffers_(std::make_unique<Buffers>(*solver.impl_)) {}
template <class Real>
RowSolver<Real>::Workspace::~Workspace() = default;
template <class Real>
RowSolver<Real>::Workspace::Workspace(Workspace&&) noexcept = default;

template <class Real>
template <class Sample>
SolveResult RowSolver<Real>::solve(const Sample* wide, Sample* drives, Workspace& workspace) const {
  const Impl& s = *impl_;
  auto& w = *workspace.buffers_;
  s.ring.fill(wide, w.cells.data());
  SolveResult result;
  result.start = result.best = w.begin(s);
  std::fill(w.state.begin(), w.state.end(), Real{0});
  std::fill(w.best.begin(), w.best.end(), Real{0});

  const size_t M = static_cast<size_t>(s.M);
  const auto plane = [&](AlignedBuffer<Real>& of, int e) { return of.data() + static_cast<size_t>(e) * s.stride; };
  const auto spectrum = [&](int e) { return w.spectrum.data() + static_cast<size_t>(e) * s.spectra; };
  const auto transform = [&] {
    for (int e = 0; e < s.E; ++e) s.tiles_fft.forward(plane(w.next, e), spectrum(e));
  };
  const auto form = [&] {
    return descent::quadratic(s.E, M, s.A.data(), M, w.spectrum.data(), s.spectra, s.share.data());
  };
  descent::TileRow<Real> row{static_cast<size_t>(s.T),
                             w.x.data(),
                             s.stride,
                             w.box.data(),
                             w.state.data(),
                             s.stride,
                             w.next.data(),
                             s.stride,
                             w.pieces.data(),
                             static_cast<size_t>(s.T)};
  descent::Schedule schedule(s.steps.stages(), s.options, result, descent::negligible<Real>());
  while (schedule.next()) {
    const descent::Stage stage = schedule.stage();
    if (schedule.first_of_stage() && !schedule.first()) {
      if (stage == descent::Stage::kFixed) s.steps.choose_pieces(row);
      s.steps.reflect(stage, row);
    }
    if (schedule.first()) {
      std::copy(w.start.begin(), w.start.end(), w.spectrum.begin());
    } else {
      transform();
      descent::apply(s.E, M, s.K.data(), M, w.start.data(), s.spectra, w.spectrum.data(), s.spectra);
    }
    const double form_x = schedule.check() ? form() * s.T : 0;
    for (int e = 0; e < s.E; ++e) s.tiles_fft.inverse(spectrum(e), plane(w.x, e));
    if (!schedule.check()) {
      s.steps.advance(stage, row);
      continue;
    }
    const descent::Sums sums = s.steps.advance_certified(stage, row);
    transform();
    if (schedule.certify(form_x, form() / s.T, sums, s.T)) {
      s.steps.project(stage, row);
      std::copy(w.next.begin(), w.next.end(), w.best.begin());
    }
    s.steps.reflect(stage, row);
  }
  result = schedule.result();

  for (int e = 0; e < s.E; ++e)
    descent::displayable(static_cast<size_t>(s.T), plane(w.box, e), plane(w.best, e), plane(w.next, e));
  s.order.pixels(w.next.data(), static_cast<ptrdiff_t>(s.stride), s.T, 0, w.pixels.data());
  s.axis.cut(w.pixels.data(), drives);
  return result;
}

template class RowSolver<float>;
template class RowSolver<double>;
template SolveResult RowSolver<float>::solve(const float*, float*, Workspace&) const;
template SolveResult RowSolver<double>::solve(const float*, float*, Workspace&) const;
template SolveResult RowSolver<double>::solve(const double*, double*, Workspace&) const;

}  // namespace triad
