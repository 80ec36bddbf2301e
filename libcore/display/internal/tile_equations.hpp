// SPDX-License-Identifier: Apache-2.0
// The error of a panel's drives, frequency by frequency: what couples the emitters of one tile frequency.
#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <triad/display/filter_design.hpp>
#include <triad/display/layout.hpp>
#include <triad/display/vision.hpp>
#include <vector>

namespace triad {

// On a torus of Tx x Ty tiles with Sx x Sy cells each, T = Tx Ty, S = Sx Sy, N = S T cells. E drives per tile,
// a_e(t); hats are unnormalised DFTs over tiles, or over cells for what lives on cells. Frequency n = m + T j of the
// cells is the alias j of tile frequency m.
//
//   light of emitter e at n:  l_e(n) = sum of its cells' shares times exp(-2 pi i k n / N)
//   its weight in channel c:  P_ce = G / S (C primary_e)_c,  p_ce(n) = P_ce l_e(n)
//   error of drives a:        J(a) = 1 / T sum over n, c of W_c(n) |sum_e p_ce(n) a_e(m) - target_c(n) / S|^2
//
// so that J / T is the mean squared error of a cell as the eye blurs it. target is (C g) for the picture g; where
// flat fields are kept exactly, plus what the displaced box itself shows outside baseband, through a window of 1.5
// px: then target_c(n) / S - sum_e p_ce box_e = (C g)_c(n) / S - keep(n) sum_e p_ce box_e.
//
// One row of tiles with one row of cells is Platt's rows mode; any other torus weighs by f = sqrt(fx^2 + fy^2).
// Immutable, so safe on many threads.
class TileEquations {
 public:
  // Throws Error(kUsage) for an observer or a lambda refused, and for tori of more than 2^27 tiles or so long that
  // 2^30 cells lie in one direction.
  TileEquations(const Layout& layout, const Observer& observer, const FilterOptions& options, int tiles_x,
                int tiles_y);

  int emitters() const { return static_cast<int>(layout_.emitters.size()); }
  int tiles_x() const { return Tx_; }
  int tiles_y() const { return Ty_; }
  int aliases_x() const { return Sx_; }
  int aliases_y() const { return Sy_; }
  int cells_x() const { return Tx_ * Sx_; }
  int cells_y() const { return Ty_ * Sy_; }
  double tiles() const { return static_cast<double>(Tx_) * Ty_; }
  int aliases() const { return Sx_ * Sy_; }
  const Layout& layout() const { return layout_; }
  const std::array<double, 9>& opponent() const { return opponent_; }

  // P_ce.
  double weight(int channel, int emitter) const { return weight_[static_cast<size_t>(3 * emitter + channel)]; }
  // D_e: what unit drive would cost if every W were 1.
  double regulariser(int emitter) const { return regulariser_[static_cast<size_t>(emitter)]; }

  // For the frequencies nx0 .. nx0 + count - 1, below cells_x(), of row ny: l_e at [e * stride + i].
  void light(int nx0, int count, int ny, double* re, double* im, int stride) const;
  // MTF of one channel there, not its square.
  void transfer(int channel, int nx0, int count, int ny, double* out) const;
  // keep(n) for the alias (jx, jy) of the tile frequencies mx0 .. mx0 + count - 1 of row my.
  void keep(int mx0, int count, int my, int jx, int jy, double* out) const;

  // A_ef = sum over aliases and channels of conj(p_ce) W_c p_cf for mx0 .. of row my. Packed as HermitianTable says,
  // real numbers at [q * stride + i].
  void gram(int mx0, int count, int my, double* packed, int stride) const;
  // Adds factor D_e to the diagonals.
  void add_diagonal(double factor, int count, double* packed, int stride) const;

 private:
  struct Group {  // cells of one emitter in one row of cells
    int emitter, row;
    std::vector<std::complex<double>> x;  // at [nx]: sum of share * exp(-2 pi i kx nx / Nx)
    std::vector<std::complex<double>> y;  // at [ny]: exp(-2 pi i row ny / Ny)
  };
  Layout layout_;
  Observer observer_;
  FilterOptions options_;
  int Tx_, Ty_, Sx_, Sy_;
  std::array<double, 9> opponent_;
  std::vector<double> weight_, regulariser_;
  std::vector<Group> groups_;
  std::vector<double> frequency_x_cpd_, frequency_y_cpd_;
  // For sums of Gaussians, which are products over x and y: [2 channel + term][n].
  std::array<std::vector<double>, 6> gauss_x_, gauss_y_;
  std::vector<double> window_x_, window_y_;      // [m]
  std::vector<double> baseband_x_, baseband_y_;  // [n]
};

// exp(-2 pi i k n / N) with the product reduced exactly, so that no accuracy is lost on long rows.
std::complex<double> turned(int64_t k, int64_t n, int64_t N);

// Hermitian E x E matrices of many frequencies as E^2 real numbers each: first the diagonal, then for e < f in
// row order the real and the imaginary part of element (e, f).
struct HermitianTable {
  static size_t size(int E) { return static_cast<size_t>(E) * E; }
  // Where element (e, f), e < f, has its real part; the imaginary part follows.
  static size_t above(int E, int e, int f) {
    return static_cast<size_t>(E + 2 * (e * E - e * (e + 1) / 2 + f - e - 1));
  }
};

// Inverts positive definite packed matrices in place, by Cholesky factors. count matrices, [q * stride + i].
void invert_hermitian(int E, int count, double* packed, int stride);

}  // namespace triad
