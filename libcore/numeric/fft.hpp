// SPDX-License-Identifier: Apache-2.0
// Real Fourier and cosine transforms of any length, in float and double, by FFTW.
//
// Plans are made once per length, kind and precision, kept for the life of the process and shared. They are
// made without timing anything, so the same length gives the same bits run after run on the same machine.
// All buffers must begin on a 64-byte boundary (AlignedBuffer does); Error(kInternal) otherwise.
//
// Constructing and using these objects is thread-safe; one object may transform on many threads at once.
#pragma once

#include <complex>
#include <cstddef>

namespace triad {

// DFT of n real numbers. Throws Error(kInput) for lengths outside 1 .. 2^31 - 1.
template <class Real>
class RealFft {
 public:
  explicit RealFft(size_t n);
  size_t size() const { return n_; }
  size_t spectrum_size() const { return n_ / 2 + 1; }

  // spectrum[k] = sum_j values[j] exp(-2 pi i jk / n) for k in 0 .. n/2. `values` is kept.
  void forward(const Real* values, std::complex<Real>* spectrum) const;
  // values[j] = sum over all n frequencies of spectrum[k] exp(+2 pi i jk / n), the upper half being the
  // conjugate of the lower: n times the inverse of forward(). DESTROYS the spectrum. The imaginary parts at
  // k = 0 and, for even n, at k = n/2 count as zero.
  void inverse(std::complex<Real>* spectrum, Real* values) const;

 private:
  size_t n_;
  const void *forward_, *inverse_;
};

// DCT of n real numbers: the Fourier transform of a row continued by its mirror image (c b a | a b c).
template <class Real>
class CosineTransform {
 public:
  explicit CosineTransform(size_t n);
  size_t size() const { return n_; }

  // DCT-II: spectrum[k] = 2 sum_j values[j] cos(pi k (j + 1/2) / n). The DFT of the mirrored row of 2n values
  // is exp(i pi k / (2n)) spectrum[k] for k < n, 0 for k = n. `values` is kept; in place is an error.
  void forward(const Real* values, Real* spectrum) const;
  // DCT-III: values[j] = spectrum[0] + 2 sum_{k>0} spectrum[k] cos(pi k (j + 1/2) / n): 2n times the inverse
  // of forward(). `spectrum` is kept; in place is an error.
  void inverse(const Real* spectrum, Real* values) const;

 private:
  size_t n_;
  const void *forward_, *inverse_;
};

// DFT of `columns` columns of n complex numbers that lie side by side: column c is values[c], values[columns + c],
// values[2 columns + c] ... In place.
template <class Real>
class ColumnFft {
 public:
  ColumnFft(size_t n, size_t columns);
  size_t size() const { return n_; }
  size_t columns() const { return columns_; }

  // values[k] = sum_j values[j] exp(-2 pi i jk / n), down each column.
  void forward(std::complex<Real>* values) const;
  // The same with exp(+2 pi i jk / n): n times the inverse of forward().
  void inverse(std::complex<Real>* values) const;

 private:
  size_t n_, columns_;
  const void *forward_, *inverse_;
};

}  // namespace triad
