// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/display/internal/tile_equations.hpp>

namespace triad {
namespace {

constexpr double kFlatWindow_px = 1.5;  // sigma of the window in which flat fields are protected
using Complex = std::complex<double>;

int folded(int n, int N) { return std::min(n, N - n); }

// Cycles per degree at each of N frequencies.
std::vector<double> frequencies(int N, double cells_per_degree) {
  std::vector<double> out(static_cast<size_t>(N));
  for (int n = 0; n < N; ++n) out[static_cast<size_t>(n)] = folded(n, N) / static_cast<double>(N) * cells_per_degree;
  return out;
}

std::vector<double> window(int tiles, int tile_px) {
  std::vector<double> out(static_cast<size_t>(tiles));
  for (int m = 0; m < tiles; ++m) {
    const double phase =
        2 * std::numbers::pi * kFlatWindow_px * folded(m, tiles) / (static_cast<double>(tiles) * tile_px);
    out[static_cast<size_t>(m)] = std::exp(-.5 * phase * phase);
  }
  return out;
}

// 1 within baseband. At half the tile frequency two aliases are equally low and share the name; real results
// need that.
std::vector<double> baseband(int tiles, int aliases) {
  std::vector<double> out(static_cast<size_t>(tiles) * aliases);
  for (int n = 0; n < tiles * aliases; ++n) {
    const int64_t twice = 2 * int64_t{folded(n, tiles * aliases)};
    out[static_cast<size_t>(n)] = aliases == 1 || twice < tiles ? 1 : twice == tiles ? .5 : 0;
  }
  return out;
}

}  // namespace

std::complex<double> turned(int64_t k, int64_t n, int64_t N) {
  int64_t r = k * n % N;
  if (r < 0) r += N;
  const double angle = -2 * std::numbers::pi * static_cast<double>(r) / static_cast<double>(N);
  return {std::cos(angle), std::sin(angle)};
}

TileEquations::TileEquations(const Layout& layout, const Observer& observer, const FilterOptions& options,
                             int tiles_x, int tiles_y)
    : layout_(layout),
      observer_(observer),
      options_(options),
      Tx_(tiles_x),
      Ty_(tiles_y),
      Sx_(layout.cells_x * layout.tile_x),
      Sy_(layout.cells_y * layout.tile_y),
      opponent_(opponent_matrix(observer)) {
  check_observer(observer);
  if (!(options.lambda >= 0 && options.lambda <= 1))
    throw_usage("lambda is " + format_double(options.lambda) + ": 0 to 1 are possible");
  constexpr int64_t kMaxTiles = 1 << 27, kMaxCells = 1 << 30;
  if (tiles_x < 1 || tiles_y < 1 || int64_t{tiles_x} * tiles_y > kMaxTiles || int64_t{tiles_x} * Sx_ > kMaxCells ||
      int64_t{tiles_y} * Sy_ > kMaxCells)
    throw_usage("a filter for " + std::to_string(tiles_x) + "x" + std::to_string(tiles_y) + " tiles of layout " +
                layout.name + ": at most " + std::to_string(kMaxTiles) + " tiles are possible");

  const int Nx = cells_x(), Ny = cells_y();
  const double G = layout.pixel_cells(), S = aliases();
  for (int e = 0; e < emitters(); ++e) {
    const Emitter& emitter = layout_.emitters[static_cast<size_t>(e)];
    double norm2 = 0, shares2 = 0;
    for (int c = 0; c < 3; ++c) {
      double sum = 0;
      for (int d = 0; d < 3; ++d) sum += opponent_[3 * c + d] * emitter.primary[d];
      weight_.push_back(G / S * sum);
      norm2 += sum * sum;
    }
    for (const EmitterCell& cell : emitter.cells) shares2 += cell.share * cell.share;
    regulariser_.push_back(G * G / S * shares2 * norm2);
    for (const EmitterCell& cell : emitter.cells) {
      auto group = std::find_if(groups_.begin(), groups_.end(),
                                [&](const Group& g) { return g.emitter == e && g.row == cell.y; });
      if (group == groups_.end()) {
        group = groups_.insert(group, {e, cell.y, std::vector<Complex>(static_cast<size_t>(Nx)), {}});
        for (int n = 0; n < Ny; ++n) group->y.push_back(turned(cell.y, n, Ny));
      }
      for (int n = 0; n < Nx; ++n) group->x[static_cast<size_t>(n)] += cell.share * turned(cell.x, n, Nx);
    }
  }
  frequency_x_cpd_ = frequencies(Nx, layout.cells_x * observer.ppd);
  frequency_y_cpd_ = frequencies(Ny, layout.cells_y * observer.ppd);
  if (observer.csf == Csf::kScielab)
    for (int c = 0; c < 3; ++c)
      for (int term = 0; term < 2; ++term) {
        const auto k = static_cast<size_t>(2 * c + term);
        for (const double f : frequency_x_cpd_) gauss_x_[k].push_back(scielab_term(c, term, f));
        for (const double f : frequency_y_cpd_)
          gauss_y_[k].push_back(scielab_term(c, term, f) / scielab_term(c, term, 0));
      }
  window_x_ = window(Tx_, layout.tile_x);
  window_y_ = window(Ty_, layout.tile_y);
  baseband_x_ = baseband(Tx_, Sx_);
  baseband_y_ = baseband(Ty_, Sy_);
}

void TileEquations::light(int nx0, int count, int ny, double* re, double* im, int stride) const {
  for (int e = 0; e < emitters(); ++e) {
    std::fill_n(re + static_cast<ptrdiff_t>(e) * stride, count, 0.);
    std::fill_n(im + static_cast<ptrdiff_t>(e) * stride, count, 0.);
  }
  for (const Group& group : groups_) {
    const Complex turn = group.y[static_cast<size_t>(ny)];
    const double turn_re = turn.real(), turn_im = turn.imag();
    const Complex* x = group.x.data() + nx0;
    double* to_re = re + static_cast<ptrdiff_t>(group.emitter) * stride;
    double* to_im = im + static_cast<ptrdiff_t>(group.emitter) * stride;
    for (int i = 0; i < count; ++i) {
      to_re[i] += x[i].real() * turn_re - x[i].imag() * turn_im;
      to_im[i] += x[i].real() * turn_im + x[i].imag() * turn_re;
    }
  }
}

void TileEquations::transfer(int channel, int nx0, int count, int ny, double* out) const {
  if (observer_.csf == Csf::kScielab) {
    const size_t k = 2 * static_cast<size_t>(channel);
    const double *first = gauss_x_[k].data() + nx0, *second = gauss_x_[k + 1].data() + nx0;
    const double y0 = gauss_y_[k][static_cast<size_t>(ny)], y1 = gauss_y_[k + 1][static_cast<size_t>(ny)];
    for (int i = 0; i < count; ++i) out[i] = first[i] * y0 + second[i] * y1;
    return;
  }
  const double fy = frequency_y_cpd_[static_cast<size_t>(ny)];
  for (int i = 0; i < count; ++i) {
    const double fx = frequency_x_cpd_[static_cast<size_t>(nx0 + i)];
    out[i] = mtf(observer_, channel, std::sqrt(fx * fx + fy * fy));
  }
}

void TileEquations::keep(int mx0, int count, int my, int jx, int jy, double* out) const {
  if (!options_.exact_flat_fields) {
    std::fill_n(out, count, 1.);
    return;
  }
  const double wy = window_y_[static_cast<size_t>(my)], by = baseband_y_[static_cast<size_t>(my + Ty_ * jy)];
  const double* wx = window_x_.data() + mx0;
  const double* bx = baseband_x_.data() + mx0 + static_cast<ptrdiff_t>(Tx_) * jx;
  for (int i = 0; i < count; ++i) out[i] = 1 - wx[i] * wy * (1 - bx[i] * by);
}

void TileEquations::gram(int mx0, int count, int my, double* packed, int stride) const {
  const int E = emitters();
  for (size_t q = 0; q < HermitianTable::size(E); ++q)
    std::fill_n(packed + static_cast<ptrdiff_t>(q) * stride, count, 0.);
  std::vector<double> re(static_cast<size_t>(E) * count), im(re.size()), weights(3 * static_cast<size_t>(count));
  for (int jy = 0; jy < Sy_; ++jy)
    for (int jx = 0; jx < Sx_; ++jx) {
      const int nx0 = mx0 + Tx_ * jx, ny = my + Ty_ * jy;
      light(nx0, count, ny, re.data(), im.data(), count);
      for (int c = 0; c < 3; ++c) transfer(c, nx0, count, ny, weights.data() + static_cast<ptrdiff_t>(c) * count);
      for (double& w : weights) w *= w;
      const double *w0 = weights.data(), *w1 = w0 + count, *w2 = w1 + count;
      for (int e = 0; e < E; ++e)
        for (int f = e; f < E; ++f) {
          const double a0 = weight(0, e) * weight(0, f), a1 = weight(1, e) * weight(1, f),
                       a2 = weight(2, e) * weight(2, f);
          const double *re_e = re.data() + static_cast<ptrdiff_t>(e) * count,
                       *im_e = im.data() + static_cast<ptrdiff_t>(e) * count;
          const double *re_f = re.data() + static_cast<ptrdiff_t>(f) * count,
                       *im_f = im.data() + static_cast<ptrdiff_t>(f) * count;
          const size_t q = e == f ? static_cast<size_t>(e) : HermitianTable::above(E, e, f);
          double* real = packed + static_cast<ptrdiff_t>(q) * stride;
          for (int i = 0; i < count; ++i)
            real[i] += (a0 * w0[i] + a1 * w1[i] + a2 * w2[i]) * (re_e[i] * re_f[i] + im_e[i] * im_f[i]);
          if (e == f) continue;
          double* imaginary = real + stride;
          for (int i = 0; i < count; ++i)
            imaginary[i] += (a0 * w0[i] + a1 * w1[i] + a2 * w2[i]) * (re_e[i] * im_f[i] - im_e[i] * re_f[i]);
        }
    }
}

void TileEquations::add_diagonal(double factor, int count, double* packed, int stride) const {
  for (int e = 0; e < emitters(); ++e)
    for (int i = 0; i < count; ++i) packed[static_cast<ptrdiff_t>(e) * stride + i] += factor * regulariser(e);
}

void invert_hermitian(int E, int count, double* packed, int stride) {
  const auto n = static_cast<size_t>(E);
  std::vector<Complex> L(n * n), inverse(n * n);
  for (int i = 0; i < count; ++i) {
    const auto at = [&](int e, int f) {  // e >= f: the lower triangle
      if (e == f) return Complex(packed[static_cast<ptrdiff_t>(e) * stride + i]);
      const auto q = static_cast<ptrdiff_t>(HermitianTable::above(E, f, e));
      return Complex(packed[q * stride + i], -packed[(q + 1) * stride + i]);
    };
    const auto times_conj = [](Complex a, Complex b) {  // plain products, without looking for infinities
      return Complex(a.real() * b.real() + a.imag() * b.imag(), a.imag() * b.real() - a.real() * b.imag());
    };
    for (int f = 0; f < E; ++f) {
      double diagonal = at(f, f).real();
      for (int k = 0; k < f; ++k) diagonal -= std::norm(L[f * n + k]);
      diagonal = std::sqrt(diagonal);
      L[f * n + f] = diagonal;
      for (int e = f + 1; e < E; ++e) {
        Complex sum = at(e, f);
        for (int k = 0; k < f; ++k) sum -= times_conj(L[e * n + k], L[f * n + k]);
        L[e * n + f] = sum / diagonal;
      }
    }
    // The inverse of L, below its diagonal, then of L L^H.
    for (int f = 0; f < E; ++f) {
      inverse[f * n + f] = 1 / L[f * n + f].real();
      for (int e = f + 1; e < E; ++e) {
        Complex sum = 0;
        for (int k = f; k < e; ++k) sum -= times_conj(L[e * n + k], std::conj(inverse[k * n + f]));
        inverse[e * n + f] = sum / L[e * n + e].real();
      }
    }
    for (int e = 0; e < E; ++e)
      for (int f = e; f < E; ++f) {
        Complex sum = 0;  // of conj(inverse(k, e)) inverse(k, f)
        for (int k = f; k < E; ++k) sum += times_conj(inverse[k * n + f], inverse[k * n + e]);
        if (e == f) {
          packed[static_cast<ptrdiff_t>(e) * stride + i] = sum.real();
        } else {
          const auto q = static_cast<ptrdiff_t>(HermitianTable::above(E, e, f));
          packed[q * stride + i] = sum.real();
          packed[(q + 1) * stride + i] = sum.imag();
        }
      }
  }
}

}  // namespace triad
