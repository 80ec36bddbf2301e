// SPDX-License-Identifier: Apache-2.0
// Plain loops compiled for every instruction set that a machine may have, and run on the widest one.
#pragma once

#include <triad/numeric/cpu.hpp>

namespace triad {

#if defined(__x86_64__) && defined(__GNUC__)

template <class Body>
__attribute__((target("avx2,fma"))) void run_avx2(const Body& body) {
  body();
}
template <class Body>
__attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi2"))) void run_avx512(const Body& body) {
  body();
}
#define TRIAD_INLINE_BODY __attribute__((always_inline))

// Calls body(), a lambda marked TRIAD_INLINE_BODY that loops over arrays, with all that it calls inlined, as compiled
// for default_cpu_path(). Products and sums are never fused (-ffp-contract=off), so every path gives the same bits.
// Worth it for a few hundred operations and up.
template <class Body>
void run_widest(const Body& body) {
  static const CpuPath path = default_cpu_path();
  switch (path) {
    case CpuPath::kAvx512: return run_avx512(body);
    case CpuPath::kAvx2: return run_avx2(body);
    case CpuPath::kBaseline: return body();
  }
}

// The same for bodies of short vectors that gain nothing from the widest ones, and whose halves are at hand in those
// of 32 bytes.
template <class Body>
void run_wide(const Body& body) {
  static const bool wide = default_cpu_path() != CpuPath::kBaseline;
  return wide ? run_avx2(body) : body();
}

#else

#define TRIAD_INLINE_BODY
template <class Body>
void run_wide(const Body& body) {
  body();
}
template <class Body>
void run_widest(const Body& body) {
  body();
}

#endif

}  // namespace triad
