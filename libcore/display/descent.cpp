// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <triad/display/internal/descent.hpp>
#include <triad/display/internal/tile_equations.hpp>
#include <triad/numeric/cpu.hpp>

namespace triad {

void SolveResult::add(const SolveResult& other) {
  start += other.start;
  best += other.best;
  bound += other.bound;
  iterations = std::max(iterations, other.iterations);
  converged = converged && other.converged;
}

namespace descent {
namespace {

constexpr size_t kChunk = 16;  // frequencies that are worked on at once

// The loops below are compiled twice, the wider for processors with AVX2. Both give the same bits: no operation is
// fused or reordered. Whatever they call must be part of them.
#define TRIAD_INLINE inline __attribute__((always_inline))
#if defined(__x86_64__)
template <class Body>
__attribute__((target("avx2"))) void run_wide(const Body& body) {
  body();
}
template <class Body>
TRIAD_INLINE void dispatch(const Body& body) {
  static const bool kWide = default_cpu_path() != CpuPath::kBaseline;
  kWide ? run_wide(body) : body();
}
#else
template <class Body>
TRIAD_INLINE void dispatch(const Body& body) {
  body();
}
#endif
#define TRIAD_BODY [&]() __attribute__((always_inline))

template <class Real>
TRIAD_INLINE Real clamped(Real v, Real low, Real high) {
  const Real up = v < low ? low : v;
  return up > high ? high : up;
}

// A chunk of x^ = K v^, split into real and imaginary parts: [e][i].
template <class Real>
struct Chunk {
  Real re[kChunk], im[kChunk];

  TRIAD_INLINE void load(const std::complex<Real>* from, size_t n) {
    const Real* values = reinterpret_cast<const Real*>(from);
    for (size_t i = 0; i < n; ++i) {
      re[i] = values[2 * i];
      im[i] = values[2 * i + 1];
    }
    for (size_t i = n; i < kChunk; ++i) re[i] = im[i] = 0;
  }
};

// out[e] = sum over f of K_ef v_f, for kChunk frequencies of which n have a table.
template <class Real>
TRIAD_INLINE void product(int E, size_t n, const Real* K, size_t stride, const Chunk<Real>* v, Chunk<Real>* out) {
  Real a[kChunk] = {}, b[kChunk] = {};
  for (int e = 0; e < E; ++e) {
    const Real* diagonal = K + static_cast<size_t>(e) * stride;
    std::copy_n(diagonal, n, a);
    for (size_t i = 0; i < kChunk; ++i) {
      out[e].re[i] = a[i] * v[e].re[i];
      out[e].im[i] = a[i] * v[e].im[i];
    }
  }
  for (int e = 0; e < E; ++e)
    for (int f = e + 1; f < E; ++f) {
      const Real* element = K + HermitianTable::above(E, e, f) * stride;
      std::copy_n(element, n, a);
      std::copy_n(element + stride, n, b);
      for (size_t i = 0; i < kChunk; ++i) {
        out[e].re[i] += a[i] * v[f].re[i] - b[i] * v[f].im[i];
        out[e].im[i] += a[i] * v[f].im[i] + b[i] * v[f].re[i];
        out[f].re[i] += a[i] * v[e].re[i] + b[i] * v[e].im[i];
        out[f].im[i] += a[i] * v[e].im[i] - b[i] * v[e].re[i];
      }
    }
}

}  // namespace

void Sums::add(const Sums& other) {
  mu_z += other.mu_z;
  slack += other.slack;
  square += other.square;
}

template <class Real>
void advance(size_t n, const Real* x, const Real* box, Real rho, Real* state, Real* next) {
  constexpr Real kStep = static_cast<Real>(kRelaxation);
  dispatch(TRIAD_BODY {
    for (size_t i = 0; i < n; ++i) {
      const Real low = -box[i], high = 1 - box[i];
      const Real s = state[i] + kStep * (x[i] - clamped(state[i], low, high));
      state[i] = s;
      next[i] = rho * (2 * clamped(s, low, high) - s);
    }
  });
}

namespace {

// Eight sums side by side, so that the loop over them is one of vectors; their order is always the same.
struct Lanes {
  static constexpr size_t kCount = 8;
  double mu_z[kCount] = {}, slack[kCount] = {}, square[kCount] = {};

  Sums sum() const {
    Sums out;
    for (size_t k = 0; k < kCount; ++k) out.add({mu_z[k], slack[k], square[k]});
    return out;
  }
};

template <bool kFloored, class Real>
TRIAD_INLINE Sums certified(size_t n, const Real* x, const Real* box, Real penalty, Real floor, Real* state,
                            Real* difference) {
  constexpr Real kStep = static_cast<Real>(kRelaxation);
  const Real over_floor = kFloored ? 1 / floor : 0;
  Lanes lanes;
  const auto one = [&](size_t i, size_t lane) __attribute__((always_inline)) {
    const Real low = -box[i], high = 1 - box[i];
    const Real old = clamped(state[i], low, high);
    const Real mu = penalty * (x[i] - (2 * old - state[i]));
    const Real s = state[i] + kStep * (x[i] - old);
    const Real z = clamped(s, low, high), d = z - x[i];
    state[i] = s;
    difference[i] = d;
    // The least of phi within the bounds; without a floor it lies on one of them.
    const Real least = kFloored ? clamped(x[i] + mu * over_floor, low, high) : mu > 0 ? high : low;
    lanes.mu_z[lane] += static_cast<double>(mu * z);
    lanes.slack[lane] += static_cast<double>((z - least) * (floor * ((z - x[i]) + (least - x[i])) - 2 * mu));
    lanes.square[lane] += static_cast<double>(floor * d * d);
  };
  const size_t whole = n - n % Lanes::kCount;
  for (size_t i = 0; i < whole; i += Lanes::kCount)
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) one(i + lane, lane);
  for (size_t i = whole; i < n; ++i) one(i, 0);
  return lanes.sum();
}

}  // namespace

template <class Real>
Sums advance_certified(size_t n, const Real* x, const Real* box, Real penalty, Real floor, Real* state,
                       Real* difference) {
  Sums sums;
  dispatch(TRIAD_BODY {
    sums = floor > 0 ? certified<true>(n, x, box, penalty, floor, state, difference)
                     : certified<false>(n, x, box, penalty, floor, state, difference);
  });
  return sums;
}

template <class Real>
void project(size_t n, const Real* box, const Real* state, Real* z) {
  for (size_t i = 0; i < n; ++i) z[i] = clamped(state[i], -box[i], 1 - box[i]);
}

template <class Real>
void displayable(size_t n, const Real* box, const Real* z, Real* drives) {
  for (size_t i = 0; i < n; ++i) drives[i] = clamped(box[i] + z[i], Real{0}, Real{1});
}

template <class Real>
void apply(int E, size_t n, const Real* K, size_t K_stride, const std::complex<Real>* h, size_t h_stride,
           std::complex<Real>* v, size_t v_stride) {
  Chunk<Real> in[kMaxEmitters], out[kMaxEmitters];
  dispatch(TRIAD_BODY {
    for (size_t from = 0; from < n; from += kChunk) {
      const size_t count = std::min(kChunk, n - from);
      for (int e = 0; e < E; ++e) in[e].load(v + static_cast<size_t>(e) * v_stride + from, count);
      product(E, count, K + from, K_stride, in, out);
      for (int e = 0; e < E; ++e) {
        const Real* start = reinterpret_cast<const Real*>(h + static_cast<size_t>(e) * h_stride + from);
        Real* to = reinterpret_cast<Real*>(v + static_cast<size_t>(e) * v_stride + from);
        for (size_t i = 0; i < count; ++i) {
          to[2 * i] = start[2 * i] + out[e].re[i];
          to[2 * i + 1] = start[2 * i + 1] + out[e].im[i];
        }
      }
    }
  });
}

template <class Real>
void multiply(int E, size_t n, Real scale, const Real* K, size_t K_stride, const std::complex<Real>* b,
              size_t b_stride, std::complex<Real>* to, size_t out_stride) {
  Chunk<Real> in[kMaxEmitters], out[kMaxEmitters];
  for (size_t from = 0; from < n; from += kChunk) {
    const size_t count = std::min(kChunk, n - from);
    for (int e = 0; e < E; ++e) in[e].load(b + static_cast<size_t>(e) * b_stride + from, count);
    product(E, count, K + from, K_stride, in, out);
    for (int e = 0; e < E; ++e)
      for (size_t i = 0; i < count; ++i)
        to[static_cast<size_t>(e) * out_stride + from + i] = {scale * out[e].re[i], scale * out[e].im[i]};
  }
}

template <class Real>
double quadratic(int E, size_t n, const Real* A, size_t A_stride, const std::complex<Real>* x, size_t x_stride,
                 const Real* share) {
  Chunk<Real> in[kMaxEmitters], out[kMaxEmitters];
  double sum = 0;
  dispatch(TRIAD_BODY {
    for (size_t from = 0; from < n; from += kChunk) {
      const size_t count = std::min(kChunk, n - from);
      for (int e = 0; e < E; ++e) in[e].load(x + static_cast<size_t>(e) * x_stride + from, count);
      product(E, count, A + from, A_stride, in, out);
      for (int e = 0; e < E; ++e)
        for (size_t i = 0; i < count; ++i)
          sum += static_cast<double>(share[from + i]) *
                 (static_cast<double>(in[e].re[i]) * static_cast<double>(out[e].re[i]) +
                  static_cast<double>(in[e].im[i]) * static_cast<double>(out[e].im[i]));
    }
  });
  return sum;
}

template <class Real>
void Residual<Real>::add() const {
  Real r_re[kChunk], r_im[kChunk];
  dispatch(TRIAD_BODY {
    for (int from = 0; from < n; from += static_cast<int>(kChunk)) {
      const int count = std::min(static_cast<int>(kChunk), n - from);
      for (int i = 0; i < count; ++i) r_re[i] = r_im[i] = 0;
      for (int e = 0; e < E; ++e) {
        const ptrdiff_t at = static_cast<ptrdiff_t>(e) * stride + from;
        const Real *lr = light_re + at, *li = light_im + at, *br = box_re + at, *bi = box_im + at;
        const Real p = P[e];
        for (int i = 0; i < count; ++i) {
          r_re[i] += p * (lr[i] * br[i] - li[i] * bi[i]);
          r_im[i] += p * (lr[i] * bi[i] + li[i] * br[i]);
        }
      }
      for (int i = 0; i < count; ++i) {
        r_re[i] = target_re[from + i] - keep[from + i] * r_re[i];
        r_im[i] = target_im[from + i] - keep[from + i] * r_im[i];
      }
      for (int i = 0; i < count; ++i) {
        const Real w = weight[from + i];
        energy[from + i] += w * (r_re[i] * r_re[i] + r_im[i] * r_im[i]);
        r_re[i] *= w;
        r_im[i] *= w;
      }
      for (int e = 0; e < E; ++e) {
        const ptrdiff_t at = static_cast<ptrdiff_t>(e) * stride + from;
        const Real *lr = light_re + at, *li = light_im + at;
        Real *to_re = b_re + at, *to_im = b_im + at;
        const Real p = P[e];
        for (int i = 0; i < count; ++i) {
          to_re[i] += p * (lr[i] * r_re[i] + li[i] * r_im[i]);
          to_im[i] += p * (lr[i] * r_im[i] - li[i] * r_re[i]);
        }
      }
    }
  });
}

template <class Real>
std::vector<Real> half_shares(int tiles_x) {
  std::vector<Real> out(static_cast<size_t>(tiles_x) / 2 + 1, 2);
  out[0] = 1;
  if (tiles_x % 2 == 0) out.back() = 1;
  return out;
}

bool certify(SolveResult& result, double quadratic_x, double quadratic_d, const Sums& sums, double tiles,
             double tolerance) {
  const double value = result.start - (quadratic_x + 2 * sums.mu_z - quadratic_d) / tiles;
  const double gap = std::max(0., (quadratic_d - sums.square + sums.slack) / tiles);
  const bool improved = value < result.best;
  if (improved) result.best = value;
  result.bound = std::min(result.best, std::max(result.bound, value - gap));
  result.converged = result.best - result.bound <= tolerance * result.start;
  return improved;
}

#define TRIAD_DESCENT(Real)                                                                                     \
  template void advance(size_t, const Real*, const Real*, Real, Real*, Real*);                                  \
  template Sums advance_certified(size_t, const Real*, const Real*, Real, Real, Real*, Real*);                  \
  template void project(size_t, const Real*, const Real*, Real*);                                               \
  template void displayable(size_t, const Real*, const Real*, Real*);                                           \
  template void apply(int, size_t, const Real*, size_t, const std::complex<Real>*, size_t, std::complex<Real>*, \
                      size_t);                                                                                  \
  template void multiply(int, size_t, Real, const Real*, size_t, const std::complex<Real>*, size_t,             \
                         std::complex<Real>*, size_t);                                                          \
  template double quadratic(int, size_t, const Real*, size_t, const std::complex<Real>*, size_t, const Real*);  \
  template struct Residual<Real>;                                                                               \
  template std::vector<Real> half_shares(int);
TRIAD_DESCENT(float)
TRIAD_DESCENT(double)
#undef TRIAD_DESCENT

}  // namespace descent
}  // namespace triad
