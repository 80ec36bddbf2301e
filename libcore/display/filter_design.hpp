// SPDX-License-Identifier: Apache-2.0
// The linear filter that drives a panel's emitters so that an eye sees as little as possible of the
// difference to the picture meant: after Platt, "Optimal Filtering for Patterned Displays" (IEEE Signal
// Processing Letters 7(7), 2000), generalised to any layout of vertical stripes, and regularised.
//
// What is minimised, for a row of T pixels on a ring, N = S T fine cells, over the drives a:
//
//   sum over opponent channels c and frequencies n of  W_c(f_n) |E_c(n)|^2
//     + lambda^2 * (the same with W = 1 of the light that a adds to the displaced box)
//
// with E = M a - C g (the panel's light minus the target's, in opponent space), W = MTF^2 and
// f_n = min(n, N - n) / N * cells_x * ppd. The displaced box sets each emitter to the mean of its own channel
// over a pixel's width around it. Only the S frequencies n = m + T j that alias to the same m interact, so
// each m is a problem of 3 S equations: the cost is O(T), where the dense system costs O(T^3).
#pragma once

#include <array>
#include <complex>
#include <triad/display/displaced_box.hpp>
#include <triad/display/layout.hpp>
#include <triad/display/vision.hpp>
#include <triad/numeric/polyphase.hpp>
#include <vector>

namespace triad {

struct FilterOptions {
  // Share of the displaced box in what the eye can hardly see: a floor of lambda^2 under W. 0 .. 1.
  double lambda = .01;
  // Exact: constant pictures come out constant. The carrier of the panel is then left out of the error in
  // flat places, by a Gaussian window of 1.5 px: b += G (A - A_baseband) a_box. Free: the plain optimum, which
  // shows white as something else when the eye can see the subpixels (off by .04 at 20 ppd, .8 at 10).
  bool exact_flat_fields = true;
};

// The filter's transfer functions on a ring of `tiles` pixels. Immutable, so safe on many threads.
class FilterDesign {
 public:
  // Throws Error(kUsage): layout not is_rows(), observer refused, lambda outside 0..1, tiles outside
  // 1 .. 2^27. Takes time and memory proportional to `tiles`: about 1 us and 220 bytes each.
  FilterDesign(const Layout& layout, const Observer& observer, int tiles, const FilterOptions& options = {});

  const Layout& layout() const { return layout_; }
  int tiles() const { return tiles_; }              // T, pixels of the ring
  int aliases() const { return layout_.cells_x; }   // S, fine cells of a pixel
  int cells() const { return tiles_ * aliases(); }  // N

  // H: the spectrum of emitter e's drives is sum over j and d of H(m, e, j, d) * target_d(m + T j), with
  // unnormalised DFTs. m in 0 .. T/2; beyond, conjugates: H(T - m, j) = conj(H(m, S - 1 - j)).
  std::complex<double> transfer(int m, int emitter, int alias, int rgb) const {
    return transfer_[((static_cast<size_t>(m) * 3 + emitter) * aliases() + alias) * 3 + rgb];
  }

  // The largest over all frequencies of ||R|| ||R^-1|| (Frobenius) of the weighted equations, lambda's
  // included: 1e3 at 40 ppd and 1e15 at 120 for lambda 0. Mostly the weights' ratio, which the solver does
  // not suffer from; it tells when other methods would.
  double condition() const { return condition_; }
  // Frequencies whose weights underflowed, so that some drives fall back to the displaced box.
  int fallback_frequencies() const { return fallback_frequencies_; }
  bool exact_flat_fields() const { return exact_flat_fields_; }

 private:
  Layout layout_;
  int tiles_;
  bool exact_flat_fields_;
  double condition_ = 0;
  int fallback_frequencies_ = 0;
  std::vector<std::complex<double>> transfer_;
};

// The design's kernels, once in full, from which truncated ones are cut.
class ImpulseResponse {
 public:
  explicit ImpulseResponse(const FilterDesign& design);

  // One kernel per output channel: taps cells around its emitter's centre cell, (taps - 1) / 2 to either
  // side, for an even number one more to the left. 1 .. cells() of the design. Where flat fields were asked for
  // exactly, what truncation takes from them is given back through the displaced box. Throws Error(kUsage) for
  // taps out of range.
  std::array<FirKernel, 3> truncated(int taps) const;
  // What truncated(taps) leaves out: the largest over the outputs of sum|cut| / sum|all|.
  double truncation_error(int taps) const;
  // The smallest odd number of taps, at least a pixel's cells, with truncation_error <= target; all cells if
  // there is none.
  int taps_for(double target) const;
  // Largest over the outputs of the sum of absolute coefficients: what a value of 1 may become.
  double l1_norm() const;

 private:
  double at(int output, int rgb, int cell) const;  // cell may be negative: the ring continues
  void restore_flat_fields(FirKernel& kernel, int output, int taps) const;

  Layout layout_;
  int cells_;
  bool exact_flat_fields_;
  std::vector<double> response_;  // [output][rgb][cell of the ring]
  int centre_cell_[3];
};

// Plain convolution of a row: out[(x - x0) * 3 + o] = sum over taps t and channels d of
// kernels[o].coefficients[3 t + d] * cell(S x + first_cell + t)[d] for x in [x0, x1). `cells` points at the row's
// cell 0; whatever the kernels reach must be there, also before it. One term after another, in Real: the
// reference for faster code.
template <class Real>
void convolve_row(const std::array<FirKernel, 3>& kernels, int cells_per_pixel, const Real* cells, int x0, int x1,
                  Real* out);

}  // namespace triad
