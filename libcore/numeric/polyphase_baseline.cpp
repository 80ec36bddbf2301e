// SPDX-License-Identifier: Apache-2.0
// For any processor, through the compiler's own vectors of 16 bytes.
#include <cstring>

#include "polyphase_loops.inc"

namespace triad::polyphase {
namespace {

template <typename T>
struct Baseline {
  using Real = T;
  static constexpr int kLanes = 16 / sizeof(T);
  typedef T Register __attribute__((vector_size(16)));
  static constexpr int kTile = 3;
  static Register zero() { return Register{}; }
  static Register load(const T* p) {
    Register v;
    std::memcpy(&v, p, sizeof v);
    return v;
  }
  static void store(T* p, Register v) { std::memcpy(p, &v, sizeof v); }
  static Register broadcast(T v) { return v - Register{}; }  // minus zero, so that -0 stays -0
  static Register add(Register a, Register b) { return a + b; }
  static Register multiply_add(Register a, Register b, Register c) { return a * b + c; }
  // Nothing to gain without shuffles across three vectors: the scalar loops that follow do it all.
  static ptrdiff_t deinterleave(const T*, ptrdiff_t, ptrdiff_t, ptrdiff_t, T*, size_t) { return 0; }
  static int interleave(const T*, T*, int) { return 0; }
};

}  // namespace

void apply_row_baseline(const Plan<float>& plan, const float* in, float* out, int n_pixels, float* scratch) {
  apply_row<Baseline<float>>(plan, in, out, n_pixels, scratch);
}

void apply_row_baseline(const Plan<double>& plan, const double* in, double* out, int n_pixels, double* scratch) {
  apply_row<Baseline<double>>(plan, in, out, n_pixels, scratch);
}

}  // namespace triad::polyphase
