// SPDX-License-Identifier: Apache-2.0
// A finite impulse response that turns a row of fine cells into a row of pixels: the filter that places a wide
// render on the subpixels of a display.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <triad/numeric/cpu.hpp>
#include <vector>

namespace triad {

// How one output channel (an emitter) of pixel x is computed: from the cells cells·x + first_cell,
// cells·x + first_cell + 1, … . first_cell may be negative.
struct FirKernel {
  int first_cell = 0;
  std::vector<double> coefficients;  // [tap][input channel R, G, B], so 3 times the number of taps; may be empty
};

// Working memory of PolyphaseFir::apply_row. It grows to what the largest filter it was used with needs
// (for three cells a pixel 9 planes of 64 values and a kernel's length in pixels) and may serve any number of
// filters, one call at a time: keep one for each thread.
class PolyphaseScratch {
 public:
  // At least `bytes` of memory aligned to a cache line; earlier contents may be lost.
  void* reserve(size_t bytes);

 private:
  std::vector<std::byte> storage_;
};

// With h_e the kernel of output channel e, and in and out interleaved RGB rows,
//
//   out[3x + e] = Σ_t Σ_d h_e[t][d] · in[3·(cells·x + first_cell_e + t) + d],  x in [0, n), d and e in [0, 3).
//
// Coefficients that are exactly zero (after rounding to Real) take no part: an infinity or NaN in the input
// reaches precisely those outputs that have a non-zero coefficient for it. (Which of the many NaNs comes out is
// unspecified.)
//
// Every output is summed in an order that depends on the kernels alone: first the terms whose (cell, channel)
// all three outputs use, then those of two, then of one, left to right within each, in partial sums of at most
// 64 terms. So a pixel's value does not depend on n, on alignment, on threads or on where a row was cut; and
// CpuPath::kAvx2 and kAvx512, which fuse multiplication and addition, agree bit for bit. kBaseline does not
// fuse, and differs from these by rounding. Rounding errors are below 1e-6 · max|in| · Σ|h_e| in practice
// (Real = float).
//
// Real is float (the fast one) or double (the same loops, baseline instructions whatever path is asked for).
// Objects are immutable; all members may be called from any number of threads.
template <typename Real>
class PolyphaseFir {
 public:
  // cells: fine cells per output pixel, 1 to 8. Throws an internal error if that range is left, if a kernel's
  // coefficients are not a multiple of three or not finite as Real, if cells lie beyond ±2^24 of the pixel, or
  // if this machine cannot run `path`.
  PolyphaseFir(int cells, const std::array<FirKernel, 3>& kernels, CpuPath path = default_cpu_path());
  ~PolyphaseFir();
  PolyphaseFir(PolyphaseFir&&) noexcept;
  PolyphaseFir& operator=(PolyphaseFir&&) noexcept;

  int cells() const;
  // The cells, relative to the first cell of a pixel, that its three outputs may read: first_cell() ≤
  // last_cell(), or 0 and −1 if all kernels are empty.
  int first_cell() const;
  int last_cell() const;

  // in: points at cell 0 of output pixel 0. The cells from first_cell() to cells·(n_pixels − 1) + last_cell()
  // must exist; nothing else is read. out: 3·n_pixels values, not overlapping the input. No alignment is needed.
  void apply_row(const Real* in, Real* out, int n_pixels, PolyphaseScratch& scratch) const;

 private:
  struct State;
  std::unique_ptr<const State> state_;
};

extern template class PolyphaseFir<float>;
extern template class PolyphaseFir<double>;

}  // namespace triad
