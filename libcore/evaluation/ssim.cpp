// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/evaluation/ssim.hpp>
#include <triad/numeric/aligned.hpp>
#include <triad/numeric/widest.hpp>

namespace triad {
namespace {

constexpr double kSigma_px = 1.5, kK1 = .01, kK2 = .03;
constexpr int kPlanes = 4;  // x + y, x - y, and their squares

// The right half of the window in one direction, its middle first; both halves sum to 1.
std::array<double, kSsimRadius_px + 1> half_window() {
  std::array<double, kSsimRadius_px + 1> half{};
  double sum = 0;
  for (int k = 0; k <= kSsimRadius_px; ++k) {
    half[k] = std::exp(-.5 * k * k / (kSigma_px * kSigma_px));
    sum += k == 0 ? half[k] : 2 * half[k];
  }
  for (double& weight : half) weight /= sum;
  return half;
}
const std::array<double, kSsimRadius_px + 1> kHalf = half_window();

// out = the window over `at`, whose neighbours lie `step` away in one row, or in rows of their own.
TRIAD_INLINE_BODY inline void blur_along(const double* __restrict at, ptrdiff_t step, ptrdiff_t count,
                                         double* __restrict out) {
  static_assert(kSsimRadius_px == 5);
  const double g0 = kHalf[0], g1 = kHalf[1], g2 = kHalf[2], g3 = kHalf[3], g4 = kHalf[4], g5 = kHalf[5];
#pragma GCC ivdep
  for (ptrdiff_t i = 0; i < count; ++i)
    out[i] = g0 * at[i] + g1 * (at[i - step] + at[i + step]) + g2 * (at[i - 2 * step] + at[i + 2 * step]) +
             g3 * (at[i - 3 * step] + at[i + 3 * step]) + g4 * (at[i - 4 * step] + at[i + 4 * step]) +
             g5 * (at[i - 5 * step] + at[i + 5 * step]);
}
TRIAD_INLINE_BODY inline void blur_down(const std::array<const double*, kSsimWindow_px>& rows, ptrdiff_t offset,
                                        ptrdiff_t count, double* __restrict out) {
  const double g0 = kHalf[0], g1 = kHalf[1], g2 = kHalf[2], g3 = kHalf[3], g4 = kHalf[4], g5 = kHalf[5];
  const double *const a = rows[0] + offset, *const b = rows[1] + offset, *const c = rows[2] + offset,
                      *const d = rows[3] + offset, *const e = rows[4] + offset, *const f = rows[5] + offset,
                      *const g = rows[6] + offset, *const h = rows[7] + offset, *const j = rows[8] + offset,
                      *const k = rows[9] + offset, *const l = rows[10] + offset;
#pragma GCC ivdep
  for (ptrdiff_t i = 0; i < count; ++i)
    out[i] = g0 * f[i] + g1 * (e[i] + g[i]) + g2 * (d[i] + h[i]) + g3 * (c[i] + j[i]) + g4 * (b[i] + k[i]) +
             g5 * (a[i] + l[i]);
}

// Sum and difference of two rows, each less its own shift (a row of the test's, then one of the reference's), and
// their squares, one plane after the other.
template <class Sample>
TRIAD_INLINE_BODY inline void spread(const Sample* __restrict x, const Sample* __restrict y,
                                     const double* __restrict shift, ptrdiff_t count, ptrdiff_t pitch,
                                     double* __restrict out) {
  double *const sums = out, *const differences = out + pitch, *const sums2 = out + 2 * pitch,
                *const differences2 = out + 3 * pitch;
#pragma GCC ivdep
  for (ptrdiff_t i = 0; i < count; ++i) {
    const double a = x[i] - shift[i], b = y[i] - shift[pitch + i], s = a + b, d = a - b;
    sums[i] = s;
    differences[i] = d;
    sums2[i] = s * s;
    differences2[i] = d * d;
  }
}

// With s = x + y and d = x - y: 2 mx my = (ms^2 - md^2) / 2, mx^2 + my^2 = (ms^2 + md^2) / 2, and so for variances.
TRIAD_INLINE_BODY inline void compare(const double* __restrict moments, const double* __restrict shift,
                                      ptrdiff_t count, ptrdiff_t pitch, double c1, double c2, double* __restrict ssim,
                                      double* __restrict structure) {
  const double *const sums = moments, *const differences = moments + pitch, *const sums2 = moments + 2 * pitch,
                      *const differences2 = moments + 3 * pitch;
#pragma GCC ivdep
  for (ptrdiff_t i = 0; i < count; ++i) {
    const double rough_s = sums2[i] - sums[i] * sums[i], rough_d = differences2[i] - differences[i] * differences[i];
    const double vs = rough_s > 0 ? rough_s : 0, vd = rough_d > 0 ? rough_d : 0;
    const double ms = sums[i] + (shift[i] + shift[pitch + i]), md = differences[i] + (shift[i] - shift[pitch + i]);
    const double s = ms * ms, d = md * md, same = (vs - vd + 2 * c2) / (vs + vd + 2 * c2);
    structure[i] = same;
    ssim[i] = (s - d + 2 * c1) / (s + d + 2 * c1) * same;
  }
}

// What the pixels of a tile have in common, to be taken away before anything is squared: the least of 16 of them, so
// that a few bright ones do not matter. A row of it.
template <class Sample>
void find_shift(const Sample* first, ptrdiff_t stride, int width, int height, int channels, ptrdiff_t pitch,
                double* shift) {
  constexpr int kPerSide = 4;
  for (int c = 0; c < channels; ++c) {
    double least = INFINITY;
    for (int j = 0; j < kPerSide; ++j)
      for (int i = 0; i < kPerSide; ++i) {
        const ptrdiff_t y = j * (height - 1) / (kPerSide - 1), x = i * (width - 1) / (kPerSide - 1);
        const double value = first[y * stride + x * channels + c];
        if (std::abs(value) < std::abs(least)) least = value;
      }
    for (ptrdiff_t i = c; i < pitch; i += channels) shift[i] = std::isfinite(least) ? least : 0;
  }
}

}  // namespace

template <class Sample>
void local_ssim(const SsimSamples<Sample>& test, const SsimSamples<Sample>& reference, const SsimArea& area,
                double data_range, const SsimSink& sink) {
  const double c1 = kK1 * data_range * kK1 * data_range, c2 = kK2 * data_range * kK2 * data_range;
  const ptrdiff_t channels = area.channels, halo = kSsimRadius_px * channels;
  const ptrdiff_t wide = kSsimTile_px * channels, pitch = (wide + 2 * halo + 7) / 8 * 8;
  // Eleven rows that are blurred along; one row before that; one blurred both ways; two of results, two of shifts.
  AlignedBuffer<double> memory(static_cast<size_t>(pitch * kPlanes * (kSsimWindow_px + 2) + 4 * pitch));
  double *const ring = memory.data(), *const fresh = ring + pitch * kPlanes * kSsimWindow_px,
                *const moments = fresh + pitch * kPlanes, *const ssim = moments + pitch * kPlanes,
                *const structure = ssim + pitch, *const shift = structure + pitch;
  for (int x0 = area.x0, x1; x0 < area.x1; x0 = x1) {
    x1 = std::min(area.x1, (x0 / kSsimTile_px + 1) * kSsimTile_px);
    const ptrdiff_t count = (x1 - x0) * channels, left = (x0 - area.x0) * channels - halo;
    const int width = x1 - x0, height = area.y1 - area.y0;
    find_shift(test.first + left + halo, test.stride, width, height, area.channels, pitch, shift);
    find_shift(reference.first + left + halo, reference.stride, width, height, area.channels, pitch, shift + pitch);
    for (int k = 0; k < height + 2 * kSsimRadius_px; ++k) {
      const ptrdiff_t row = k - kSsimRadius_px;
      run_widest([&]() TRIAD_INLINE_BODY {
        spread(test.first + row * test.stride + left, reference.first + row * reference.stride + left, shift,
               count + 2 * halo, pitch, fresh);
        double* const slot = ring + k % kSsimWindow_px * (pitch * kPlanes);
        for (int p = 0; p < kPlanes; ++p) blur_along(fresh + p * pitch + halo, channels, count, slot + p * pitch);
        if (k < kSsimWindow_px - 1) return;
        std::array<const double*, kSsimWindow_px> rows;
        for (int j = 0; j < kSsimWindow_px; ++j) rows[j] = ring + (k + 1 + j) % kSsimWindow_px * (pitch * kPlanes);
        for (int p = 0; p < kPlanes; ++p) blur_down(rows, p * pitch, count, moments + p * pitch);
        compare(moments, shift, count, pitch, c1, c2, ssim, structure);
      });
      if (k >= kSsimWindow_px - 1) sink(x0, area.y0 + k - (kSsimWindow_px - 1), x1 - x0, ssim, structure);
    }
  }
}

template void local_ssim(const SsimSamples<float>&, const SsimSamples<float>&, const SsimArea&, double,
                         const SsimSink&);
template void local_ssim(const SsimSamples<double>&, const SsimSamples<double>&, const SsimArea&, double,
                         const SsimSink&);

void SsimTotals::add(int x, int y, int pixels, int width, int height, int channels, const float* weights,
                     const double* values, const double* structures) {
  if (y < kSsimRadius_px || y >= height - kSsimRadius_px) return;
  const int from = std::max(x, kSsimRadius_px) - x, to = std::min(x + pixels, width - kSsimRadius_px) - x;
  // Plain sums of at most a tile's row inside compensated ones: they lose no more than 1e-14.
  double total = 0, ssims[3]{}, same[3]{};
  for (int i = from; i < to; ++i) {
    const double w = weights ? static_cast<double>(weights[i]) : 1;
    if (!(w > 0)) continue;
    total += w;
    for (int c = 0; c < channels; ++c) {
      ssims[c] += w * values[i * channels + c];
      same[c] += w * structures[i * channels + c];
    }
  }
  weight.add(total);
  for (int c = 0; c < channels; ++c) {
    ssim[c].add(ssims[c]);
    structure[c].add(same[c]);
  }
}

void SsimTotals::merge(const SsimTotals& later) {
  weight.merge(later.weight);
  for (size_t c = 0; c < ssim.size(); ++c) {
    ssim[c].merge(later.ssim[c]);
    structure[c].merge(later.structure[c]);
  }
}

}  // namespace triad
