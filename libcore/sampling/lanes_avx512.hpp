// SPDX-License-Identifier: Apache-2.0
// What loops by hand for AVX-512 have in common. Functions, and lambdas in them, are marked one by one, not compiled
// by files: an inline function of a header would be compiled along, and could be the one that is kept for all.
#pragma once

#if defined(__x86_64__)
#include <immintrin.h>

#include <cstddef>
#include <cstdint>
#include <triad/sampling/request_members.hpp>

#define TRIAD_AVX512 __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi2")))
// (GCC 12 warns of values in its own header that are left open on purpose: its bug 105593.)
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"

namespace triad::avx512 {

// owen_scramble_rest() of each.
TRIAD_AVX512 inline __m512i scramble(__m512i x, uint32_t seed) {
  x = _mm512_add_epi32(x, _mm512_set1_epi32(static_cast<int32_t>(seed)));
  x = _mm512_mullo_epi32(x, _mm512_set1_epi32(static_cast<int32_t>(seed >> 16 | 1u)));
  x = _mm512_xor_si512(x, _mm512_mullo_epi32(x, _mm512_set1_epi32(0x05526c56)));
  return _mm512_xor_si512(x, _mm512_mullo_epi32(x, _mm512_set1_epi32(0x53a22864)));
}

// reverse_bits() of each: its bytes' order, and in each byte the halves by a table of four bits.
TRIAD_AVX512 inline __m512i reverse(__m512i x) {
  const __m512i order = _mm512_broadcast_i32x4(_mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
  const __m512i four = _mm512_broadcast_i32x4(_mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15));
  const __m512i half = _mm512_set1_epi8(15);
  const __m512i bytes = _mm512_shuffle_epi8(x, order);
  const __m512i to_high = _mm512_shuffle_epi8(_mm512_slli_epi32(four, 4), _mm512_and_si512(bytes, half));
  const __m512i to_low = _mm512_shuffle_epi8(four, _mm512_and_si512(_mm512_srli_epi32(bytes, 4), half));
  return _mm512_or_si512(to_high, to_low);
}

// Fractions * 2^32 as fractions.
TRIAD_AVX512 inline __m512d fractions(__m256i bits) {
  return _mm512_mul_pd(_mm512_cvtepu32_pd(bits), _mm512_set1_pd(0x1p-32));
}

// What eight requests say besides x and y, and seed: that of the even ones, and of the odd ones, which count up.
struct EightMembers {
  __m512i even, odd;
};
TRIAD_AVX512 inline EightMembers eight_members(const RequestMembers& first) {
  const __m512i all = _mm512_broadcast_i32x4(_mm_loadu_si128(reinterpret_cast<const __m128i*>(&first)));
  return {_mm512_add_epi32(all, _mm512_setr_epi32(0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0, 6)),
          _mm512_add_epi32(all, _mm512_setr_epi32(0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, 5, 0, 0, 0, 7))};
}
TRIAD_AVX512 inline EightMembers next_eight(const EightMembers& members) {
  const __m512i more = _mm512_setr_epi32(0, 0, 0, 8, 0, 0, 0, 8, 0, 0, 0, 8, 0, 0, 0, 8);
  return {_mm512_add_epi32(members.even, more), _mm512_add_epi32(members.odd, more)};
}

// Sets all but the seed of eight requests.
static_assert(offsetof(SampleRequest, x) == 0 && offsetof(SampleRequest, y) == 8 &&
              offsetof(SampleRequest, footprint_px) == 16 && offsetof(SampleRequest, seed) == 32);
TRIAD_AVX512 inline void put_requests(SampleRequest* requests, __m512d x, __m512d y, const EightMembers& members) {
  const __m512d even = _mm512_unpacklo_pd(x, y), odd = _mm512_unpackhi_pd(x, y);
  const __m512d even_members = _mm512_castsi512_pd(members.even), odd_members = _mm512_castsi512_pd(members.odd);
  // Two numbers of one and two of the other, for two requests each.
  const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11),
                high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
  const auto put = [requests](size_t i, __m512d both) TRIAD_AVX512 {
    _mm256_storeu_pd(reinterpret_cast<double*>(requests + i), _mm512_castpd512_pd256(both));
    _mm256_storeu_pd(reinterpret_cast<double*>(requests + i + 2), _mm512_extractf64x4_pd(both, 1));
  };
  put(0, _mm512_permutex2var_pd(even, low, even_members));
  put(1, _mm512_permutex2var_pd(odd, low, odd_members));
  put(4, _mm512_permutex2var_pd(even, high, even_members));
  put(5, _mm512_permutex2var_pd(odd, high, odd_members));
}

}  // namespace triad::avx512
#endif
