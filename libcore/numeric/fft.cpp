// SPDX-License-Identifier: Apache-2.0
#include <fftw3.h>

#include <cstdint>
#include <limits>
#include <map>
#include <mutex>
#include <string>
#include <triad/base/error.hpp>
#include <triad/numeric/aligned.hpp>
#include <triad/numeric/fft.hpp>
#include <tuple>
#include <type_traits>

namespace triad {
namespace {

enum class Kind { kForward, kInverse, kCosine, kInverseCosine, kColumns, kInverseColumns };

template <class Real>
using Plan = std::conditional_t<std::is_same_v<Real, float>, fftwf_plan, fftw_plan>;

// FFTW_ESTIMATE does not touch the arrays, it looks at their alignment only.
fftw_complex* as_fftw(std::complex<double>* p) { return reinterpret_cast<fftw_complex*>(p); }
fftwf_complex* as_fftw(std::complex<float>* p) { return reinterpret_cast<fftwf_complex*>(p); }

fftw_plan make(Kind kind, int n, double* values, std::complex<double>* spectrum) {
  switch (kind) {
    case Kind::kForward: return fftw_plan_dft_r2c_1d(n, values, as_fftw(spectrum), FFTW_ESTIMATE);
    case Kind::kInverse: return fftw_plan_dft_c2r_1d(n, as_fftw(spectrum), values, FFTW_ESTIMATE);
    case Kind::kCosine:
      return fftw_plan_r2r_1d(n, values, reinterpret_cast<double*>(spectrum), FFTW_REDFT10, FFTW_ESTIMATE);
    default: return fftw_plan_r2r_1d(n, reinterpret_cast<double*>(spectrum), values, FFTW_REDFT01, FFTW_ESTIMATE);
  }
}

fftwf_plan make(Kind kind, int n, float* values, std::complex<float>* spectrum) {
  switch (kind) {
    case Kind::kForward: return fftwf_plan_dft_r2c_1d(n, values, as_fftw(spectrum), FFTW_ESTIMATE);
    case Kind::kInverse: return fftwf_plan_dft_c2r_1d(n, as_fftw(spectrum), values, FFTW_ESTIMATE);
    case Kind::kCosine:
      return fftwf_plan_r2r_1d(n, values, reinterpret_cast<float*>(spectrum), FFTW_REDFT10, FFTW_ESTIMATE);
    default: return fftwf_plan_r2r_1d(n, reinterpret_cast<float*>(spectrum), values, FFTW_REDFT01, FFTW_ESTIMATE);
  }
}

fftw_plan make_columns(Kind kind, int n, int columns, std::complex<double>* v) {
  return fftw_plan_many_dft(1, &n, columns, as_fftw(v), nullptr, columns, 1, as_fftw(v), nullptr, columns, 1,
                            kind == Kind::kColumns ? FFTW_FORWARD : FFTW_BACKWARD, FFTW_ESTIMATE);
}

fftwf_plan make_columns(Kind kind, int n, int columns, std::complex<float>* v) {
  return fftwf_plan_many_dft(1, &n, columns, as_fftw(v), nullptr, columns, 1, as_fftw(v), nullptr, columns, 1,
                             kind == Kind::kColumns ? FFTW_FORWARD : FFTW_BACKWARD, FFTW_ESTIMATE);
}

// FFTW's planner is one global object for both precisions, hence one lock.
std::mutex& planner_lock() {
  static std::mutex lock;
  return lock;
}

template <class Real>
const void* find_plan(Kind kind, size_t n, size_t columns = 1) {
  if (n < 1 || n > static_cast<size_t>(std::numeric_limits<int>::max()))
    throw_input("a row of " + std::to_string(n) + " samples cannot be transformed: lengths 1 to 2147483647 can");
  const std::lock_guard lock(planner_lock());
  // Never freed: plans are used by objects that live until the process ends.
  static auto& plans = *new std::map<std::tuple<Kind, size_t, size_t>, Plan<Real>>;
  Plan<Real>& plan = plans[{kind, n, columns}];
  if (!plan && (kind == Kind::kColumns || kind == Kind::kInverseColumns)) {
    AlignedBuffer<std::complex<Real>> values(n * columns);
    plan = make_columns(kind, static_cast<int>(n), static_cast<int>(columns), values.data());
  } else if (!plan) {
    AlignedBuffer<Real> values(n);
    AlignedBuffer<std::complex<Real>> spectrum(n / 2 + 1);
    plan = make(kind, static_cast<int>(n), values.data(), spectrum.data());
  }
  if (!plan) throw_internal("FFTW has no plan for length " + std::to_string(n));
  return plan;
}

template <class Real>
Plan<Real> as_plan(const void* plan) {
  return static_cast<Plan<Real>>(const_cast<void*>(plan));
}

// A plan made for aligned memory reads beyond its bounds or crashes on any other.
void require_aligned(const void* a, const void* b) {
  if ((reinterpret_cast<uintptr_t>(a) | reinterpret_cast<uintptr_t>(b)) % kBufferAlignment_bytes != 0)
    throw_internal("FFT buffers must be 64-byte aligned");
  if (a == b) throw_internal("FFT buffers must differ");
}

}  // namespace

template <class Real>
RealFft<Real>::RealFft(size_t n)
    : n_(n), forward_(find_plan<Real>(Kind::kForward, n)), inverse_(find_plan<Real>(Kind::kInverse, n)) {}

template <class Real>
void RealFft<Real>::forward(const Real* values, std::complex<Real>* spectrum) const {
  require_aligned(values, spectrum);
  // FFTW keeps the input of an out-of-place real-to-complex transform, its signature does not say so.
  Real* in = const_cast<Real*>(values);
  if constexpr (std::is_same_v<Real, float>) {
    fftwf_execute_dft_r2c(as_plan<Real>(forward_), in, as_fftw(spectrum));
  } else {
    fftw_execute_dft_r2c(as_plan<Real>(forward_), in, as_fftw(spectrum));
  }
}

template <class Real>
void RealFft<Real>::inverse(std::complex<Real>* spectrum, Real* values) const {
  require_aligned(values, spectrum);
  if constexpr (std::is_same_v<Real, float>) {
    fftwf_execute_dft_c2r(as_plan<Real>(inverse_), as_fftw(spectrum), values);
  } else {
    fftw_execute_dft_c2r(as_plan<Real>(inverse_), as_fftw(spectrum), values);
  }
}

namespace {

template <class Real>
void execute_real(const void* plan, const Real* in, Real* out) {
  require_aligned(in, out);
  if constexpr (std::is_same_v<Real, float>) {
    fftwf_execute_r2r(as_plan<Real>(plan), const_cast<Real*>(in), out);
  } else {
    fftw_execute_r2r(as_plan<Real>(plan), const_cast<Real*>(in), out);
  }
}

}  // namespace

template <class Real>
CosineTransform<Real>::CosineTransform(size_t n)
    : n_(n), forward_(find_plan<Real>(Kind::kCosine, n)), inverse_(find_plan<Real>(Kind::kInverseCosine, n)) {}

template <class Real>
void CosineTransform<Real>::forward(const Real* values, Real* spectrum) const {
  execute_real(forward_, values, spectrum);
}

template <class Real>
void CosineTransform<Real>::inverse(const Real* spectrum, Real* values) const {
  execute_real(inverse_, spectrum, values);
}

template <class Real>
ColumnFft<Real>::ColumnFft(size_t n, size_t columns)
    : n_(n),
      columns_(columns),
      forward_(find_plan<Real>(Kind::kColumns, n, columns)),
      inverse_(find_plan<Real>(Kind::kInverseColumns, n, columns)) {}

namespace {

template <class Real>
void execute_columns(const void* plan, std::complex<Real>* values) {
  require_aligned(values, nullptr);
  if constexpr (std::is_same_v<Real, float>) {
    fftwf_execute_dft(as_plan<Real>(plan), as_fftw(values), as_fftw(values));
  } else {
    fftw_execute_dft(as_plan<Real>(plan), as_fftw(values), as_fftw(values));
  }
}

}  // namespace

template <class Real>
void ColumnFft<Real>::forward(std::complex<Real>* values) const {
  execute_columns(forward_, values);
}

template <class Real>
void ColumnFft<Real>::inverse(std::complex<Real>* values) const {
  execute_columns(inverse_, values);
}

template class RealFft<float>;
template class RealFft<double>;
template class CosineTransform<float>;
template class CosineTransform<double>;
template class ColumnFft<float>;
template class ColumnFft<double>;

}  // namespace triad
