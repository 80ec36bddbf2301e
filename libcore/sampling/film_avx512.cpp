// SPDX-License-Identifier: Apache-2.0
#if defined(__x86_64__)
#include <bit>
#include <triad/sampling/film.hpp>
#include <triad/sampling/hot_avx512.hpp>
#include <triad/sampling/lanes_avx512.hpp>
#include <triad/sampling/sobol.hpp>

namespace triad::avx512 {
namespace {

constexpr __mmask8 kThree = 0x07, kOdd = 0x70, kSix = kThree | kOdd;
constexpr uint32_t kInfinite = 0x7ff;  // a double's exponent where it is not finite

static_assert(offsetof(Sample, rgb) == 0 && offsetof(Sample, valid) == 12);
const float* floats(const Sample& sample) { return reinterpret_cast<const float*>(&sample); }

// As exact as a division, and sooner there.
double one_over_power_of_2(uint32_t n) {
  constexpr uint64_t kBias = 1023;
  return std::bit_cast<double>((kBias - static_cast<uint64_t>(std::countr_zero(n))) << 52);
}

// Whether the bits and-ed together, of colours with `valid` behind them in the fourth lane, are of valid ones.
TRIAD_AVX512 bool valid(__m128 bits) { return (_mm_extract_epi32(_mm_castps_si128(bits), 3) & 1) != 0; }

struct Sums {
  __m256d sum, compensation, half;
  uint32_t in_half = 0;  // of the samples added
};

// Adds to them. `fresh`: as add_run() has it. False, and they mean nothing, if a sample is not valid or not finite.
template <bool kHalves>
TRIAD_AVX512 inline __attribute__((always_inline)) bool add(Sums& sums, bool fresh, const SampleRequest* requests,
                                                            const Sample* samples, size_t n) {
  __m512d sum = _mm512_zextpd256_pd512(sums.sum), compensation = _mm512_zextpd256_pd512(sums.compensation);
  __m512d half = _mm512_setzero_pd();
  if constexpr (kHalves) half = _mm512_zextpd256_pd512(sums.half);
  const auto in_half_1 = [&](size_t at, __mmask8 lanes) TRIAD_AVX512 {
    if (!sobol_half(requests[at].index)) return __mmask8{0};
    ++sums.in_half;
    return lanes;
  };
  const auto add_pair = [&](__m512d x) TRIAD_AVX512 {
    const __m512d after = _mm512_add_pd(sum, x), came = _mm512_sub_pd(after, sum);
    const __m512d lost = _mm512_add_pd(_mm512_sub_pd(sum, _mm512_sub_pd(after, came)), _mm512_sub_pd(x, came));
    compensation = _mm512_add_pd(compensation, lost);
    sum = after;
  };
  __m256 all = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
  __m128 alone = _mm256_castps256_ps128(all);  // of samples that came without a second one
  size_t i = 0;
  if (fresh) {
    alone = _mm_loadu_ps(floats(samples[0]));
    const __m512d x = _mm512_zextpd256_pd512(_mm256_maskz_cvtps_pd(kThree, alone));
    sum = _mm512_add_pd(x, _mm512_setzero_pd());
    if constexpr (kHalves) half = _mm512_mask_add_pd(half, in_half_1(0, kThree), half, x);
    i = 1;
  }
  for (; i + 1 < n; i += 2) {
    const __m256 bits = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(floats(samples[i]))),
                                             _mm_loadu_ps(floats(samples[i + 1])), 1);
    all = _mm256_and_ps(all, bits);
    const __m512d x = _mm512_maskz_cvtps_pd(kSix, bits);
    add_pair(x);
    if constexpr (kHalves) {
      const __mmask8 lanes = static_cast<__mmask8>(in_half_1(i, kThree) | in_half_1(i + 1, kOdd));
      half = _mm512_mask_add_pd(half, lanes, half, x);
    }
  }
  if (i < n) {
    const __m128 bits = _mm_loadu_ps(floats(samples[i]));
    alone = _mm_and_ps(alone, bits);
    const __m512d x = _mm512_zextpd256_pd512(_mm256_maskz_cvtps_pd(kThree, bits));
    add_pair(x);
    if constexpr (kHalves) half = _mm512_mask_add_pd(half, in_half_1(i, kThree), half, x);
  }
  const __m256d total = _mm512_castpd512_pd256(sum), others = _mm512_extractf64x4_pd(sum, 1);
  const __m256d after = _mm256_add_pd(total, others), came = _mm256_sub_pd(after, total);
  const __m256d lost = _mm256_add_pd(_mm256_sub_pd(total, _mm256_sub_pd(after, came)), _mm256_sub_pd(others, came));
  // What is not finite stays so in a sum. (A sum of huge ones may be sent away for nothing, to be added one by one.)
  const __m256i exponents =
      _mm256_and_si256(_mm256_srli_epi64(_mm256_castpd_si256(after), 52), _mm256_set1_epi64x(kInfinite));
  const __mmask8 infinite = _mm256_cmpeq_epi64_mask(exponents, _mm256_set1_epi64x(kInfinite));
  alone = _mm_and_ps(alone, _mm_and_ps(_mm256_castps256_ps128(all), _mm256_extractf128_ps(all, 1)));
  if (!valid(alone) || (infinite & kThree) != 0) return false;
  sums.sum = after;
  sums.compensation = _mm256_add_pd(_mm256_add_pd(_mm512_castpd512_pd256(compensation), lost),
                                    _mm512_extractf64x4_pd(compensation, 1));
  if constexpr (kHalves) sums.half = _mm256_add_pd(_mm512_castpd512_pd256(half), _mm512_extractf64x4_pd(half, 1));
  return true;
}

template <bool kHalves>
TRIAD_AVX512 inline __attribute__((always_inline)) bool add_to_record(double* record, bool fresh,
                                                                      const SampleRequest* requests,
                                                                      const Sample* samples, size_t n,
                                                                      double* half_sums, uint32_t* in_half) {
  Sums sums{_mm256_maskz_loadu_pd(kThree, record), _mm256_maskz_loadu_pd(kThree, record + 3), _mm256_setzero_pd()};
  if constexpr (kHalves) sums.half = _mm256_maskz_loadu_pd(kThree, half_sums);
  if (!add<kHalves>(sums, fresh, requests, samples, n)) return false;
  _mm256_mask_storeu_pd(record, kThree, sums.sum);
  _mm256_mask_storeu_pd(record + 3, kThree, sums.compensation);
  if constexpr (kHalves) {
    _mm256_mask_storeu_pd(half_sums, kThree, sums.half);
    *in_half += sums.in_half;
  }
  return true;
}

}  // namespace

TRIAD_AVX512 bool add_run(double* sum, bool fresh, const SampleRequest* requests, const Sample* samples, size_t n,
                          double* half, uint32_t* in_half) {
  return half ? add_to_record<true>(sum, fresh, requests, samples, n, half, in_half)
              : add_to_record<false>(sum, fresh, requests, samples, n, nullptr, nullptr);
}

TRIAD_AVX512 size_t add_few(float* record, size_t pixels, const Sample* samples, size_t each) {
  for (size_t i = 0; i < pixels; ++i, record += 4, samples += each) {
    const __m128 before = _mm_loadu_ps(record);
    const auto counts = static_cast<uint32_t>(_mm_extract_epi32(_mm_castps_si128(before), 3));
    const uint32_t kept = counts & 0xffff, all = kept + static_cast<uint32_t>(each);
    if (kept > 1 || all + (counts >> 16) > Film::kMostFew) return i;
    Sums sums{_mm256_maskz_cvtps_pd(kThree, before), _mm256_setzero_pd(), _mm256_setzero_pd()};
    if (!add<false>(sums, each > 1 && counts == 0, nullptr, samples, each)) return i;
    const __m256d total = _mm256_add_pd(sums.sum, sums.compensation);
    const __m128i mean = _mm_castps_si128(
        _mm256_cvtpd_ps(std::has_single_bit(all) ? _mm256_mul_pd(total, _mm256_set1_pd(one_over_power_of_2(all)))
                                                 : _mm256_div_pd(total, _mm256_set1_pd(all))));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(record),
                     _mm_insert_epi32(mean, static_cast<int32_t>(counts + static_cast<uint32_t>(each)), 3));
  }
  return pixels;
}

}  // namespace triad::avx512
#endif
