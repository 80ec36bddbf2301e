// SPDX-License-Identifier: Apache-2.0
#if defined(__x86_64__)
#include <triad/sampling/hot_avx512.hpp>
#include <triad/sampling/lanes_avx512.hpp>

namespace triad::avx512 {

TRIAD_AVX512 void place_sixteen(const uint32_t* start_x, const uint32_t* start_y, uint32_t seed_x, uint32_t seed_y,
                                const SampleRequest& first, SampleRequest* requests) {
  const auto index = static_cast<int32_t>(requests - &first);
  const EightMembers members = eight_members(members_of(first) + RequestMembers{0, 0, 0, index});
  const __m512i x = reverse(scramble(_mm512_loadu_si512(start_x), seed_x));
  const __m512i y = reverse(scramble(_mm512_loadu_si512(start_y), seed_y));
  // pixel + fraction * 2^-32, rounded once: the product is exact.
  const __m512d pixel_x = _mm512_set1_pd(first.pixel_x), pixel_y = _mm512_set1_pd(first.pixel_y);
  put_requests(requests, _mm512_add_pd(pixel_x, fractions(_mm512_castsi512_si256(x))),
               _mm512_add_pd(pixel_y, fractions(_mm512_castsi512_si256(y))), members);
  put_requests(requests + 8, _mm512_add_pd(pixel_x, fractions(_mm512_extracti64x4_epi64(x, 1))),
               _mm512_add_pd(pixel_y, fractions(_mm512_extracti64x4_epi64(y, 1))), next_eight(members));
}

}  // namespace triad::avx512
#endif
