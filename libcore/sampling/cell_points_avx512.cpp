// SPDX-License-Identifier: Apache-2.0
#if defined(__x86_64__)
#include <immintrin.h>

#include <cstring>
#include <triad/sampling/cell_points_avx512.hpp>

#define TRIAD_AVX512 __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx2,fma")))
// (GCC 12 warns of values in its own header that are left open on purpose: its bug 105593.)
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"

namespace triad::avx512 {
namespace {

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

// CellSide::move() of fractions * 2^32.
TRIAD_AVX512 inline __m512d move(const CellSide& side, __m256i fractions) {
  const __m512d place = _mm512_mul_pd(_mm512_cvtepu32_pd(fractions), _mm512_set1_pd(0x1p-32));
  if (side.stays()) return place;
  const std::span<const CellSide::Cell> cells = side.cells();
  __m512d cell = _mm512_setzero_pd(), start = cell, scale = _mm512_set1_pd(cells[0].scale);
  for (size_t c = 1; c < cells.size(); ++c) {
    const __mmask8 past = _mm512_cmp_pd_mask(place, _mm512_set1_pd(cells[c].start), _CMP_GE_OQ);
    cell = _mm512_mask_mov_pd(cell, past, _mm512_set1_pd(static_cast<double>(c)));
    start = _mm512_mask_mov_pd(start, past, _mm512_set1_pd(cells[c].start));
    scale = _mm512_mask_mov_pd(scale, past, _mm512_set1_pd(cells[c].scale));
  }
  return _mm512_add_pd(cell, _mm512_mul_pd(_mm512_sub_pd(place, start), scale));
}

// Members that lie side by side, in one store each.
static_assert(offsetof(SampleRequest, x) == 0 && offsetof(SampleRequest, y) == sizeof(double) &&
              offsetof(SampleRequest, pixel_y) == offsetof(SampleRequest, pixel_x) + sizeof(int32_t));
TRIAD_AVX512 inline void put(SampleRequest& request, __m128d place, int64_t pixel) {
  _mm_storeu_pd(reinterpret_cast<double*>(&request), place);
  std::memcpy(&request.pixel_x, &pixel, sizeof(pixel));
}

struct Frame {
  __m512d x0, y0;  // the pixel's corner on the film
  __m256i columns;
  int64_t pixel;  // both numbers as they lie in a request
};

// Eight requests from their places in the pixel.
TRIAD_AVX512 inline void put(const Frame& frame, __m512d x, __m512d y, SampleRequest* requests, uint32_t* cell) {
  const __m256i row = _mm256_mullo_epi32(_mm512_cvttpd_epi32(y), frame.columns);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(cell), _mm256_add_epi32(row, _mm512_cvttpd_epi32(x)));
  x = _mm512_add_pd(frame.x0, x);
  y = _mm512_add_pd(frame.y0, y);
  const __m512d even = _mm512_unpacklo_pd(x, y), odd = _mm512_unpackhi_pd(x, y);
  put(requests[0], _mm512_castpd512_pd128(even), frame.pixel);
  put(requests[1], _mm512_castpd512_pd128(odd), frame.pixel);
  put(requests[2], _mm512_extractf64x2_pd(even, 1), frame.pixel);
  put(requests[3], _mm512_extractf64x2_pd(odd, 1), frame.pixel);
  put(requests[4], _mm512_extractf64x2_pd(even, 2), frame.pixel);
  put(requests[5], _mm512_extractf64x2_pd(odd, 2), frame.pixel);
  put(requests[6], _mm512_extractf64x2_pd(even, 3), frame.pixel);
  put(requests[7], _mm512_extractf64x2_pd(odd, 3), frame.pixel);
}

}  // namespace

TRIAD_AVX512 void place_in_cells(const CellPixel& pixel, const CellSide& across, const CellSide& down,
                                 const uint32_t* start_x, const uint32_t* start_y, std::span<SampleRequest> requests,
                                 uint32_t* cell) {
  const auto columns = static_cast<int32_t>(across.count()), rows = static_cast<int32_t>(down.count());
  Frame frame{_mm512_set1_pd(static_cast<double>(pixel.x) * columns),
              _mm512_set1_pd(static_cast<double>(pixel.y) * rows), _mm256_set1_epi32(columns), 0};
  const int32_t both[2] = {pixel.x, pixel.y};
  std::memcpy(&frame.pixel, both, sizeof(both));
  for (size_t i = 0; i < requests.size(); i += kTogether) {
    const __m512i x = reverse(scramble(_mm512_loadu_si512(start_x + i), pixel.seed_x));
    const __m512i y = reverse(scramble(_mm512_loadu_si512(start_y + i), pixel.seed_y));
    put(frame, move(across, _mm512_castsi512_si256(x)), move(down, _mm512_castsi512_si256(y)), &requests[i],
        cell + i);
    put(frame, move(across, _mm512_extracti64x4_epi64(x, 1)), move(down, _mm512_extracti64x4_epi64(y, 1)),
        &requests[i + 8], cell + i + 8);
  }
}

}  // namespace triad::avx512
#endif
