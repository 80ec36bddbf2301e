// SPDX-License-Identifier: Apache-2.0
// Compiled with AVX-512 F, BW, DQ and VL enabled.
#if defined(__AVX512F__)
#include <immintrin.h>

#include <triad/sampling/hot_avx512.hpp>

namespace triad::avx512 {
namespace {

// owen_scramble_rest() of each.
__m512i scramble(__m512i x, uint32_t seed) {
  x = _mm512_add_epi32(x, _mm512_set1_epi32(static_cast<int32_t>(seed)));
  x = _mm512_mullo_epi32(x, _mm512_set1_epi32(static_cast<int32_t>(seed >> 16 | 1u)));
  x = _mm512_xor_si512(x, _mm512_mullo_epi32(x, _mm512_set1_epi32(0x05526c56)));
  return _mm512_xor_si512(x, _mm512_mullo_epi32(x, _mm512_set1_epi32(0x53a22864)));
}

// reverse_bits() of each: its bytes, and the bits of each byte's halves by tables.
__m512i reverse(__m512i x) {
  const __m512i bytes = _mm512_broadcast_i32x4(_mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
  const __m512i low = _mm512_broadcast_i32x4(
      _mm_setr_epi8(0x0, 0x8, 0x4, 0xc, 0x2, 0xa, 0x6, 0xe, 0x1, 0x9, 0x5, 0xd, 0x3, 0xb, 0x7, 0xf));
  const __m512i high = _mm512_slli_epi32(low, 4), half = _mm512_set1_epi8(0xf);
  x = _mm512_shuffle_epi8(x, bytes);
  const __m512i of_low = _mm512_shuffle_epi8(high, _mm512_and_si512(x, half));
  return _mm512_or_si512(of_low, _mm512_shuffle_epi8(low, _mm512_and_si512(_mm512_srli_epi32(x, 4), half)));
}

// pixel + fraction * 2^-32, rounded once: the product is exact.
__m512d place(double pixel, __m256i fraction) {
  return _mm512_add_pd(_mm512_set1_pd(pixel), _mm512_mul_pd(_mm512_cvtepu32_pd(fraction), _mm512_set1_pd(0x1p-32)));
}

static_assert(offsetof(SampleRequest, x) == 0 && offsetof(SampleRequest, y) == sizeof(double));
void put(SampleRequest& request, __m128d place) { _mm_storeu_pd(reinterpret_cast<double*>(&request), place); }

// Of eight requests.
void put(SampleRequest* requests, __m512d x, __m512d y) {
  const __m512d even = _mm512_unpacklo_pd(x, y), odd = _mm512_unpackhi_pd(x, y);
  put(requests[0], _mm512_castpd512_pd128(even));
  put(requests[1], _mm512_castpd512_pd128(odd));
  put(requests[2], _mm512_extractf64x2_pd(even, 1));
  put(requests[3], _mm512_extractf64x2_pd(odd, 1));
  put(requests[4], _mm512_extractf64x2_pd(even, 2));
  put(requests[5], _mm512_extractf64x2_pd(odd, 2));
  put(requests[6], _mm512_extractf64x2_pd(even, 3));
  put(requests[7], _mm512_extractf64x2_pd(odd, 3));
}

}  // namespace

void place_sixteen(const uint32_t* start_x, const uint32_t* start_y, uint32_t seed_x, uint32_t seed_y,
                   SampleRequest* requests) {
  const __m512i x = reverse(scramble(_mm512_loadu_si512(start_x), seed_x));
  const __m512i y = reverse(scramble(_mm512_loadu_si512(start_y), seed_y));
  const double pixel_x = requests->pixel_x, pixel_y = requests->pixel_y;
  put(requests, place(pixel_x, _mm512_castsi512_si256(x)), place(pixel_y, _mm512_castsi512_si256(y)));
  put(requests + 8, place(pixel_x, _mm512_extracti64x4_epi64(x, 1)), place(pixel_y, _mm512_extracti64x4_epi64(y, 1)));
}

}  // namespace triad::avx512
#endif
