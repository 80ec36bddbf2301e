// SPDX-License-Identifier: Apache-2.0
// Compiled with AVX2 and FMA enabled; called only where cpu_can_run(CpuPath::kAvx2).
#if defined(__AVX2__) && defined(__FMA__)
#include "polyphase_loops.inc"
#include "polyphase_x86.inc"

namespace triad::polyphase {
namespace {

struct Avx2 {
  using Real = float;
  using Register = __m256;
  static constexpr int kLanes = 8;
  static constexpr int kTile = 4;
  static Register zero() { return _mm256_setzero_ps(); }
  static Register load(const float* p) {
    Register v = _mm256_loadu_ps(p);
    asm("" : "+x"(v));  // or GCC loads it once for each use, and loads are what limits the loop
    return v;
  }
  static void store(float* p, Register v) { _mm256_storeu_ps(p, v); }
  static Register broadcast(float v) { return _mm256_set1_ps(v); }
  static Register add(Register a, Register b) { return _mm256_add_ps(a, b); }
  static Register multiply_add(Register a, Register b, Register c) { return _mm256_fmadd_ps(a, b, c); }
  static constexpr auto& deinterleave = deinterleave_avx2;
  static constexpr auto& interleave = interleave_avx2;
};

}  // namespace

void apply_row_avx2(const Plan<float>& plan, const float* in, float* out, int n_pixels, float* scratch) {
  apply_row<Avx2>(plan, in, out, n_pixels, scratch);
}

}  // namespace triad::polyphase
#endif
