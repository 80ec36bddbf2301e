// SPDX-License-Identifier: Apache-2.0
// Compiled with AVX-512F, AVX2 and FMA enabled; called only where cpu_can_run(CpuPath::kAvx512).
#if defined(__AVX512F__)
#include "polyphase_loops.inc"
#include "polyphase_x86.inc"

namespace triad::polyphase {
namespace {

struct Avx512 {
  using Real = float;
  using Register = __m512;
  static constexpr int kLanes = 16;
  static constexpr int kTile = 4;
  static Register zero() { return _mm512_setzero_ps(); }
  static Register load(const float* p) {
    Register v = _mm512_loadu_ps(p);
    asm("" : "+v"(v));  // or GCC loads it once for each use, and loads are what limits the loop
    return v;
  }
  static void store(float* p, Register v) { _mm512_storeu_ps(p, v); }
  static Register broadcast(float v) { return _mm512_set1_ps(v); }
  static Register add(Register a, Register b) { return _mm512_add_ps(a, b); }
  static Register multiply_add(Register a, Register b, Register c) { return _mm512_fmadd_ps(a, b, c); }
  static constexpr auto& deinterleave = deinterleave_avx2;
  static constexpr auto& interleave = interleave_avx2;
};

}  // namespace

void apply_row_avx512(const Plan<float>& plan, const float* in, float* out, int n_pixels, float* scratch) {
  apply_row<Avx512>(plan, in, out, n_pixels, scratch);
}

}  // namespace triad::polyphase
#endif
