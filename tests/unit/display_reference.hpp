// SPDX-License-Identifier: Apache-2.0
// The display model written out from its definition, in dense matrices over fine cells and pixels: slow, with
// no FFT, no aliasing argument and no shared code but the observer's constants. It judges libcore/display.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <triad/display/row_filter.hpp>
#include <vector>

namespace triad::reference {

// IEC 61966-2-1, rounded as published.
inline constexpr std::array<double, 9> kRec709ToXyz{.4124, .3576, .1805, .2126, .7152, .0722, .0193, .1192, .9505};

inline Observer observer(double ppd, Csf csf = Csf::kScielab) {
  Observer out;
  out.rgb_to_xyz = kRec709ToXyz;
  out.ppd = ppd;
  out.csf = csf;
  return out;
}

// The cell of a pixel that channel o lights, for red-green-blue stripes or the reverse.
inline int cell_of(int o, bool bgr) { return bgr ? 2 - o : o; }

inline std::vector<double> random_cells(int cells, unsigned seed) {
  std::mt19937 bits(seed);
  std::vector<double> out(3 * static_cast<size_t>(cells));
  for (double& value : out) value = static_cast<double>(bits()) / 4294967296.0;
  return out;
}

// A row followed by its mirror image, or as it is.
inline std::vector<double> ring_of(const std::vector<double>& cells, Edge edge) {
  std::vector<double> out = cells;
  if (edge == Edge::kMirror)
    for (size_t k = cells.size() / 3; k-- > 0;) out.insert(out.end(), &cells[3 * k], &cells[3 * k] + 3);
  return out;
}

// Where normal equations in double are not accurate enough to judge anything: 64 bits of mantissa.
using Wide = long double;
using WideMatrix = Eigen::Matrix<Wide, Eigen::Dynamic, Eigen::Dynamic>;
using WideVector = Eigen::Matrix<Wide, Eigen::Dynamic, 1>;
inline constexpr Wide kWidePi = std::numbers::pi_v<Wide>;

// Correlation of the error weight of channel c: w(k) = 1/N sum over n of W(f_n) cos(2 pi k n / N), the sum
// restricted to baseband (|n| < T/2, half weight at |n| = T/2) if asked.
inline std::vector<Wide> weight_kernel(const Observer& o, int c, int tiles, bool baseband_only) {
  const int N = 3 * tiles;
  std::vector<Wide> cosine(static_cast<size_t>(N)), out(static_cast<size_t>(N)), weight(static_cast<size_t>(N));
  for (int n = 0; n < N; ++n) {
    cosine[n] = std::cos(2 * kWidePi * n / N);
    const int low = std::min(n, N - n);
    const Wide share = !baseband_only ? 1 : 2 * low < tiles ? 1 : 2 * low == tiles ? .5L : 0;
    const Wide transfer = mtf(o, c, static_cast<double>(low) / N * 3 * o.ppd);
    weight[n] = share * transfer * transfer / N;
  }
  for (int k = 0; k < N; ++k)
    for (int n = 0; n < N; ++n) out[k] += weight[n] * cosine[static_cast<size_t>((static_cast<int64_t>(k) * n) % N)];
  return out;
}

// Mt w M of the panel: element between drives (t, o) and (t', o'), M_ck = 3 C_c,o at its cell.
inline WideMatrix panel_matrix(const Observer& o, int tiles, bool bgr, bool baseband_only) {
  const auto C = opponent_matrix(o);
  const int N = 3 * tiles;
  WideMatrix A = WideMatrix::Zero(N, N);
  for (int c = 0; c < 3; ++c) {
    const auto w = weight_kernel(o, c, tiles, baseband_only);
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j) {
        const int ki = i / 3 * 3 + cell_of(i % 3, bgr), kj = j / 3 * 3 + cell_of(j % 3, bgr);
        A(i, j) +=
            9 * static_cast<Wide>(C[3 * c + i % 3]) * C[3 * c + j % 3] * w[static_cast<size_t>((ki - kj + N) % N)];
      }
  }
  return A;
}

inline std::vector<double> box_drives(const std::vector<double>& ring, bool bgr) {
  const int N = static_cast<int>(ring.size() / 3);
  std::vector<double> out(ring.size());
  for (int t = 0; t < N / 3; ++t)
    for (int o = 0; o < 3; ++o)
      for (int i = -1; i <= 1; ++i)
        out[3 * t + o] += ring[3 * static_cast<size_t>((3 * t + cell_of(o, bgr) + i + N) % N) + o] / 3;
  return out;
}

struct DenseFilter {
  WideMatrix A, A_baseband, regularised;
  Eigen::LLT<Eigen::MatrixXd> factor;
  Observer observer;
  FilterOptions options;
  int tiles;
  bool bgr;

  DenseFilter(const Observer& o, int T, const FilterOptions& opt, bool reversed = false)
      : A(panel_matrix(o, T, reversed, false)), regularised(A), observer(o), options(opt), tiles(T), bgr(reversed) {
    if (options.exact_flat_fields) A_baseband = panel_matrix(o, T, reversed, true);
    for (int i = 0; i < 3 * T; ++i) regularised(i, i) += regulariser(i % 3);
    factor.compute(regularised.cast<double>());
  }

  // lambda^2 |3 C_o|^2: what unit drive would cost if every weight were lambda^2.
  double regulariser(int o) const {
    const auto C = opponent_matrix(observer);
    double norm2 = 0;
    for (int c = 0; c < 3; ++c) norm2 += C[3 * c + o] * C[3 * c + o];
    return options.lambda * options.lambda * 9 * norm2;
  }

  // The drives of all pixels of the ring for interleaved RGB cells of the ring.
  std::vector<double> drives(const std::vector<double>& ring) const {
    const int N = 3 * tiles;
    const auto C = opponent_matrix(observer);
    const auto box = box_drives(ring, bgr);
    WideVector b = WideVector::Zero(N);
    for (int c = 0; c < 3; ++c) {
      const auto w = weight_kernel(observer, c, tiles, false);
      std::vector<Wide> target(static_cast<size_t>(N));
      for (int k = 0; k < N; ++k)
        for (int d = 0; d < 3; ++d)
          target[k] += static_cast<Wide>(C[3 * c + d]) * ring[3 * static_cast<size_t>(k) + d];
      for (int i = 0; i < N; ++i) {
        const int ki = i / 3 * 3 + cell_of(i % 3, bgr);
        for (int k = 0; k < N; ++k)
          b[i] += 3 * static_cast<Wide>(C[3 * c + i % 3]) * w[static_cast<size_t>((ki - k + N) % N)] * target[k];
      }
    }
    for (int i = 0; i < N; ++i) b[i] += regulariser(i % 3) * box[i];
    if (options.exact_flat_fields) {
      // The window as a ring convolution of each emitter's box drives, from its definition in frequencies.
      std::vector<Wide> window(static_cast<size_t>(tiles));
      for (int t = 0; t < tiles; ++t)
        for (int m = 0; m < tiles; ++m) {
          const Wide x = 2 * kWidePi * 1.5L * std::min(m, tiles - m) / tiles;
          const Wide turn = static_cast<Wide>(static_cast<int64_t>(t) * m % tiles) / tiles;
          window[t] += std::exp(-.5L * x * x) * std::cos(2 * kWidePi * turn) / tiles;
        }
      WideVector smooth = WideVector::Zero(N);
      for (int t = 0; t < tiles; ++t)
        for (int s = 0; s < tiles; ++s)
          for (int o = 0; o < 3; ++o)
            smooth[3 * t + o] += window[static_cast<size_t>((t - s + tiles) % tiles)] * box[3 * s + o];
      b += (A - A_baseband) * smooth;
    }
    // Factored in double, for speed, and refined with residuals in long double.
    WideVector x = WideVector::Zero(N);
    for (int round = 0; round < 5; ++round) {
      const Eigen::VectorXd residual = (b - regularised * x).cast<double>();
      x += factor.solve(residual).cast<Wide>();
    }
    std::vector<double> out;
    for (int i = 0; i < N; ++i) out.push_back(static_cast<double>(x[i]));
    return out;
  }
};

// The error's energy straight from its definition: DFT sums, term by term, over the ring of the row (wrap) or
// of the row and its mirror image (mirror, of which the first half counts). share[c] gets the channels' parts.
// whole_ring, if given, gets the sum of W |E|^2 / N^2 over the ring.
inline double row_energy(const Observer& o, const float* test, const float* target, int width, Edge edge, bool clip,
                         bool bgr, double* share, double* whole_ring = nullptr) {
  const auto C = opponent_matrix(o);
  const auto value = [&](float v) { return clip ? std::min(1., std::max(0., static_cast<double>(v))) : v; };
  const int ring = edge == Edge::kMirror ? 2 * width : width, N = 3 * ring;
  double total = 0;
  if (whole_ring) *whole_ring = 0;
  std::vector<std::complex<double>> root;
  for (int k = 0; k < N; ++k) root.push_back(std::polar(1., 2 * std::numbers::pi * k / N));
  const auto turn = [&](int k, int n) { return root[static_cast<size_t>(1LL * k * n % N)]; };
  for (int c = 0; c < 3; ++c) {
    std::vector<double> error;
    for (int k = 0; k < N; ++k) {
      const int x = k / 3 < width ? k / 3 : 2 * width - 1 - k / 3;
      const int cell = k < 3 * width ? k : 6 * width - 1 - k;
      double sum = 0;
      for (int d = 0; d < 3; ++d) {
        if (cell_of(d, bgr) == k % 3) sum += 3 * C[3 * c + d] * value(test[3 * x + d]);
        sum -= C[3 * c + d] * value(target[3 * cell + d]);
      }
      error.push_back(sum);
    }
    std::vector<std::complex<double>> seen(static_cast<size_t>(N));
    for (int n = 0; n < N; ++n) {
      std::complex<double> sum = 0;
      for (int k = 0; k < N; ++k) sum += error[k] * std::conj(turn(k, n));
      const double weight = mtf(o, c, static_cast<double>(std::min(n, N - n)) / N * 3 * o.ppd);
      if (whole_ring) *whole_ring += weight * weight * std::norm(sum) / N / N;
      for (int k = 0; k < N; ++k) seen[k] += weight * sum * turn(k, n) / static_cast<double>(N);
    }
    share[c] = 0;
    for (int k = 0; k < 3 * width; ++k) share[c] += std::norm(seen[k]) / (3 * width);
    total += share[c];
  }
  return total;
}

}  // namespace triad::reference
