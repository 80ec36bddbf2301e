// SPDX-License-Identifier: Apache-2.0
#if defined(__x86_64__)
#include <algorithm>
#include <array>
#include <cstring>
#include <triad/sampling/cell_sums_avx512.hpp>
#include <triad/sampling/film.hpp>
#include <triad/sampling/lanes_avx512.hpp>

namespace triad::avx512 {
namespace {

constexpr size_t kCells = 3;
constexpr size_t kTogether = 16;                // samples whose cells are looked at side by side
constexpr __mmask8 kThree = 0x07, kSix = 0x77;  // the colours of a sample and of two
constexpr uint8_t kOne = 0x0f;                  // lanes of the first of two samples
constexpr uint32_t kInfinite = 0x7ff;           // a double's exponent where it is not finite

static_assert(offsetof(Sample, rgb) == 0 && offsetof(Sample, valid) == 12);
const float* floats(const Sample& sample) { return reinterpret_cast<const float*>(&sample); }

// Sums of the colours in the first three lanes, and how many samples they are of.
struct Sum {
  __m256d rgb;
  uint32_t count;
};
struct Sums {
  Sum of[kCells];
  __m256d first;                // colour that is left out of the sums, though counted
  __mmask8 with_first[kCells];  // the lanes of the cell that it is in
};

TRIAD_AVX512 inline __attribute__((always_inline)) bool all_finite(__m256d x) {
  const __m256i exponents =
      _mm256_and_si256(_mm256_srli_epi64(_mm256_castpd_si256(x), 52), _mm256_set1_epi64x(kInfinite));
  return _mm256_cmpeq_epi64_mask(exponents, _mm256_set1_epi64x(kInfinite)) == 0;
}

// Samples of even and of odd index have sums of their own, which wait for each other half as long; the first one is
// of an even index. False, and they mean nothing, if a sample is not valid or one of the sums is not finite.
TRIAD_AVX512 inline __attribute__((always_inline)) bool sum(const Sample* samples, const uint32_t* cells, size_t n,
                                                            bool first_alone, Sums& sums) {
  __m512d a = _mm512_setzero_pd(), b = a, c = a;
  __m256 all = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
  uint64_t in_a = 0, in_b = 0, in_c = 0;
  sums.first = _mm256_maskz_cvtps_pd(kThree, _mm_loadu_ps(floats(samples[0])));
  const auto add_sixteen = [&](size_t past, bool all_but_one) TRIAD_AVX512 __attribute__((always_inline)) {
    // Four bytes a sample are its cell, and so four bits of a mask are whether it is that.
    const __m512i fours = _mm512_broadcast_i32x4(_mm_setr_epi8(0, 0, 0, 0, 4, 4, 4, 4, 8, 8, 8, 8, 12, 12, 12, 12));
    const auto there = static_cast<__mmask16>(0xffff >> (kTogether - past));
    const __m512i cell = _mm512_shuffle_epi8(_mm512_mask_loadu_epi32(_mm512_set1_epi32(kCells), there, cells), fours);
    alignas(64) uint8_t lanes[kCells][kTogether / 2];
    const auto look_for = [&](size_t number, uint64_t & in) TRIAD_AVX512 __attribute__((always_inline)) {
      const __mmask64 here = _mm512_cmpeq_epi8_mask(cell, _mm512_set1_epi8(static_cast<char>(number)));
      std::memcpy(lanes[number], &here, sizeof(here));
      in += static_cast<uint64_t>(__builtin_popcountll(here));
    };
    look_for(0, in_a);
    look_for(1, in_b);
    look_for(2, in_c);
    // From memory a mask is one load; a compiler that knows what is there shifts it, which takes three steps.
    asm volatile("" : "+m"(lanes));
    if (all_but_one) {
      for (size_t k = 0; k < kCells; ++k) {
        sums.with_first[k] = lanes[k][0] & kOne;
        lanes[k][0] &= static_cast<uint8_t>(~kOne);
      }
    }
#pragma GCC unroll 8
    for (size_t i = 0; i < past; i += 2) {
      const __m256 bits = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(floats(samples[i]))),
                                               _mm_loadu_ps(floats(samples[i + 1 < past ? i + 1 : i])), 1);
      all = _mm256_and_ps(all, bits);
      const __m512d x = _mm512_maskz_cvtps_pd(kSix, bits);
      a = _mm512_mask_add_pd(a, lanes[0][i / 2], a, x);
      b = _mm512_mask_add_pd(b, lanes[1][i / 2], b, x);
      c = _mm512_mask_add_pd(c, lanes[2][i / 2], c, x);
    }
  };
  size_t done = 0;
  for (; done + kTogether <= n; done += kTogether, samples += kTogether, cells += kTogether, first_alone = false)
    add_sixteen(kTogether, first_alone);
  if (done < n) add_sixteen(n - done, first_alone);
  const auto whole = [](const __m512d& x, __m256d& both) TRIAD_AVX512 {
    both = _mm256_add_pd(_mm512_castpd512_pd256(x), _mm512_extractf64x4_pd(x, 1));
  };
  whole(a, sums.of[0].rgb);
  whole(b, sums.of[1].rgb);
  whole(c, sums.of[2].rgb);
  sums.of[0].count = static_cast<uint32_t>(in_a / 4);
  sums.of[1].count = static_cast<uint32_t>(in_b / 4);
  sums.of[2].count = static_cast<uint32_t>(in_c / 4);
  const __m128 both = _mm_and_ps(_mm256_castps256_ps128(all), _mm256_extractf128_ps(all, 1));
  return all_finite(_mm256_add_pd(_mm256_add_pd(sums.of[0].rgb, sums.of[1].rgb), sums.of[2].rgb)) &&
         (_mm_extract_epi32(_mm_castps_si128(both), 3) & 1) != 0;
}

constexpr auto kShares = [] {
  std::array<double, Film::kMostFew + 1> shares{1};
  for (size_t n = 1; n < shares.size(); ++n) shares[n] = 1 / static_cast<double>(n);
  return shares;
}();

}  // namespace

TRIAD_AVX512 bool put_few_in_three(float* records, const Sample* samples, const uint32_t* cells, size_t n,
                                   bool first_alone) {
  constexpr __mmask16 kThreeRecords = 0xfff, kCounts = 0x888;
  if (n > Film::kMostFew) return false;
  const __m512i before = _mm512_maskz_loadu_epi32(kThreeRecords, records);
  if (_mm512_mask_test_epi32_mask(kCounts, before, before) != 0) return false;
  Sums sums;
  if (!sum(samples, cells, n, first_alone, sums)) return false;
  if (first_alone) {
    if (!all_finite(sums.first)) return false;
    for (size_t c = 0; c < kCells; ++c)
      sums.of[c].rgb = _mm256_mask_add_pd(sums.of[c].rgb, sums.with_first[c], sums.of[c].rgb, sums.first);
  }
  for (size_t c = 0; c < kCells; ++c) {
    // Nothing before, but a 0 that keeps the sign of none.
    const __m256d all = _mm256_add_pd(_mm256_setzero_pd(), sums.of[c].rgb);
    const __m128 mean = _mm256_cvtpd_ps(_mm256_mul_pd(all, _mm256_set1_pd(kShares[sums.of[c].count])));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(records + 4 * c),
                     _mm_insert_epi32(_mm_castps_si128(mean), static_cast<int32_t>(sums.of[c].count), 3));
  }
  return true;
}

TRIAD_AVX512 bool add_to_three(double* records, const Sample* samples, const uint32_t* cells, size_t n,
                               bool first_alone) {
  constexpr __mmask8 kCounts = 0x08;
  Sums sums;
  if (!sum(samples, cells, n, first_alone, sums)) return false;
  __m256d record[kCells];
  for (size_t c = 0; c < kCells; ++c) record[c] = _mm256_loadu_pd(records + 4 * c);
  if (first_alone) {
    const __m256d any = _mm256_or_pd(_mm256_or_pd(record[0], record[1]), record[2]);
    if (_mm256_mask_test_epi64_mask(kCounts, _mm256_castpd_si256(any), _mm256_castpd_si256(any)) != 0 ||
        !all_finite(sums.first))
      return false;
    for (size_t c = 0; c < kCells; ++c)
      record[c] = _mm256_mask_add_pd(record[c], sums.with_first[c] & kThree, record[c], sums.first);
  }
  for (size_t c = 0; c < kCells; ++c) {
    const __m256i all = _mm256_castpd_si256(_mm256_mask_add_pd(record[c], kThree, record[c], sums.of[c].rgb));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(records + 4 * c),
                        _mm256_mask_add_epi64(all, kCounts, all, _mm256_set1_epi64x(sums.of[c].count)));
  }
  return true;
}

TRIAD_AVX512 bool sums_of_three(const Sample* samples, const uint32_t* cells, size_t n, bool first_alone, void* sums,
                                void* first) {
  constexpr __mmask8 kFourth = 0x08;
  const auto store = [](const __m256d& rgb, uint32_t count, void* to) TRIAD_AVX512 {
    _mm256_storeu_pd(static_cast<double*>(to), _mm256_mask_mov_pd(rgb, kFourth, _mm256_set1_pd(count)));
  };
  Sums each;
  if (!sum(samples, cells, n, first_alone, each) || (first_alone && !all_finite(each.first))) return false;
  if (first_alone) store(each.first, 1, first);
  for (size_t c = 0; c < kCells; ++c)
    store(each.of[c].rgb, each.of[c].count - (first_alone && cells[0] == c), static_cast<double*>(sums) + 4 * c);
  return true;
}

}  // namespace triad::avx512
#endif
