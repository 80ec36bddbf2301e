// SPDX-License-Identifier: Apache-2.0
#if defined(__x86_64__)
#include <triad/sampling/cell_points_avx512.hpp>
#include <triad/sampling/lanes_avx512.hpp>

namespace triad::avx512 {
namespace {

// CellSide::move() of fractions * 2^32.
TRIAD_AVX512 inline __m512d move(const CellSide& side, __m256i bits) {
  const __m512d place = fractions(bits);
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

struct Frame {
  __m512d x0, y0;  // the pixel's corner on the film
  __m256i columns;
};

// Eight requests from their places in the pixel.
TRIAD_AVX512 inline void put(const Frame& frame, __m512d x, __m512d y, const EightMembers& members,
                             SampleRequest* requests, uint32_t* cell) {
  const __m256i row = _mm256_mullo_epi32(_mm512_cvttpd_epi32(y), frame.columns);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(cell), _mm256_add_epi32(row, _mm512_cvttpd_epi32(x)));
  put_requests(requests, _mm512_add_pd(frame.x0, x), _mm512_add_pd(frame.y0, y), members);
}

}  // namespace

TRIAD_AVX512 void place_in_cells(const CellPixel& pixel, const CellSide& across, const CellSide& down,
                                 const uint32_t* start_x, const uint32_t* start_y, std::span<SampleRequest> requests,
                                 uint32_t* cell) {
  const auto columns = static_cast<int32_t>(across.count()), rows = static_cast<int32_t>(down.count());
  const Frame frame{_mm512_set1_pd(static_cast<double>(pixel.x) * columns),
              _mm512_set1_pd(static_cast<double>(pixel.y) * rows), _mm256_set1_epi32(columns)};
  EightMembers members = eight_members(request_members(requests[0].footprint_px, pixel.x, pixel.y, requests[0].index));
  for (size_t i = 0; i < requests.size(); i += kTogether) {
    const __m512i x = reverse(scramble(_mm512_loadu_si512(start_x + i), pixel.seed_x));
    const __m512i y = reverse(scramble(_mm512_loadu_si512(start_y + i), pixel.seed_y));
    put(frame, move(across, _mm512_castsi512_si256(x)), move(down, _mm512_castsi512_si256(y)), members, &requests[i],
        cell + i);
    members = next_eight(members);
    put(frame, move(across, _mm512_extracti64x4_epi64(x, 1)), move(down, _mm512_extracti64x4_epi64(y, 1)), members,
        &requests[i + 8], cell + i + 8);
    members = next_eight(members);
  }
}

}  // namespace triad::avx512
#endif
