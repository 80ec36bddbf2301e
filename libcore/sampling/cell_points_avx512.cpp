// SPDX-License-Identifier: Apache-2.0
#if defined(__x86_64__)
#include <triad/sampling/cell_points_avx512.hpp>
#include <triad/sampling/lanes_avx512.hpp>

namespace triad::avx512 {
namespace {

struct Sixteen {
  __m512d low, high;  // places from the pixel's edge, in cells
  __m512i cell;
};

// One side of a pixel, ready for CellSide::move() of fractions * 2^32. Where strata are told apart, cells start at
// multiples of a power of 2, and so the distance from there is exact as a whole number.
class Side {
 public:
  TRIAD_AVX512 explicit Side(const CellSide& side) : cells_(side.cells()), stays_(side.stays()) {}
  TRIAD_AVX512 __attribute__((always_inline)) Sixteen move(__m512i bits) const {
    constexpr double kUnit = 0x1p-32;
    if (stays_)
      return {fractions(_mm512_castsi512_si256(bits)), fractions(_mm512_extracti64x4_epi64(bits, 1)),
              _mm512_setzero_si512()};
    if (cells_.size() == 1) {
      const __m512d scale = _mm512_set1_pd(cells_[0].scale);
      const __m512d low = _mm512_mul_pd(fractions(_mm512_castsi512_si256(bits)), scale);
      const __m512d high = _mm512_mul_pd(fractions(_mm512_extracti64x4_epi64(bits, 1)), scale);
      return {low, high,
              _mm512_inserti64x4(_mm512_castsi256_si512(_mm512_cvttpd_epi32(low)), _mm512_cvttpd_epi32(high), 1)};
    }
    __m512i cell = _mm512_setzero_si512(), from = bits;
    __m512d low = _mm512_setzero_pd(), high = low;
    __m512d low_scale = _mm512_set1_pd(cells_[0].scale * kUnit), high_scale = low_scale;
    for (size_t c = 1; c < cells_.size(); ++c) {
      const __m512i start = _mm512_set1_epi32(static_cast<int32_t>(static_cast<uint32_t>(cells_[c].start / kUnit)));
      const __mmask16 past = _mm512_cmpge_epu32_mask(bits, start);
      const auto past_low = static_cast<__mmask8>(past), past_high = static_cast<__mmask8>(past >> 8);
      const __m512d number = _mm512_set1_pd(static_cast<double>(c)), scale = _mm512_set1_pd(cells_[c].scale * kUnit);
      cell = _mm512_mask_mov_epi32(cell, past, _mm512_set1_epi32(static_cast<int32_t>(c)));
      from = _mm512_mask_sub_epi32(from, past, bits, start);
      low = _mm512_mask_mov_pd(low, past_low, number);
      high = _mm512_mask_mov_pd(high, past_high, number);
      low_scale = _mm512_mask_mov_pd(low_scale, past_low, scale);
      high_scale = _mm512_mask_mov_pd(high_scale, past_high, scale);
    }
    return {_mm512_add_pd(low, _mm512_mul_pd(_mm512_cvtepu32_pd(_mm512_castsi512_si256(from)), low_scale)),
            _mm512_add_pd(high, _mm512_mul_pd(_mm512_cvtepu32_pd(_mm512_extracti64x4_epi64(from, 1)), high_scale)),
            cell};
  }

 private:
  std::span<const CellSide::Cell> cells_;
  bool stays_;
};

}  // namespace

TRIAD_AVX512 void place_in_cells(const CellPixels& pixels, const CellSide& across, const CellSide& down,
                                 const uint32_t* start_x, const uint32_t* start_y, std::span<SampleRequest> requests,
                                 uint32_t* cell) {
  const Side along_x(across), along_y(down);
  const auto columns = static_cast<int32_t>(across.count()), rows = static_cast<int32_t>(down.count());
  const size_t each = requests.size() / pixels.n;
  SampleRequest* request = requests.data();
  for (size_t k = 0; k < pixels.n; ++k) {
    const __m512d x0 = _mm512_set1_pd(static_cast<double>(pixels.x[k]) * columns);
    const __m512d y0 = _mm512_set1_pd(static_cast<double>(pixels.y[k]) * rows);
    EightMembers members =
        eight_members(request_members(request->footprint_px, pixels.x[k], pixels.y[k], request->index));
    for (size_t i = 0; i < each; i += kTogether, request += kTogether, cell += kTogether) {
      const Sixteen x = along_x.move(reverse(scramble(_mm512_loadu_si512(start_x + i), pixels.seed_x[k])));
      const Sixteen y = along_y.move(reverse(scramble(_mm512_loadu_si512(start_y + i), pixels.seed_y[k])));
      const __m512i in =
          rows == 1 ? x.cell : _mm512_add_epi32(_mm512_mullo_epi32(y.cell, _mm512_set1_epi32(columns)), x.cell);
      _mm512_storeu_si512(cell, in);
      put_requests(request, _mm512_add_pd(x0, x.low), _mm512_add_pd(y0, y.low), members);
      members = next_eight(members);
      put_requests(request + 8, _mm512_add_pd(x0, x.high), _mm512_add_pd(y0, y.high), members);
      members = next_eight(members);
    }
  }
}

}  // namespace triad::avx512
#endif
