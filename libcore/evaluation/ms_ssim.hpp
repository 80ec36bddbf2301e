// SPDX-License-Identifier: Apache-2.0
// Structural similarity over five scales: Z. Wang, E. P. Simoncelli and A. C. Bovik, "Multi-scale structural
// similarity for image quality assessment", Asilomar Conference on Signals, Systems and Computers 2003. From a scale
// to the next both pictures are averaged over 2 x 2 pixels; an odd last row or column is averaged with itself.
//
//   ms_ssim = mean(ssim at scale 5)^w5 * product over scales 1..4 of mean(structure at scale k)^wk      (equation 7)
//
// with ssim and structure of ssim.hpp, whose windows lie wholly inside the picture of their scale. Means that are
// negative count as 0, as a negative number has no such power; then the pictures have nothing in common.
#pragma once

#include <array>
#include <cstdint>
#include <triad/evaluation/ssim.hpp>

namespace triad {

inline constexpr int kMsSsimScales = 5;
// As published; they sum to 1.0001.
inline constexpr std::array<double, kMsSsimScales> kMsSsimWeights{.0448, .2856, .3001, .2363, .1333};
// Strips begin at multiples of a pixel of the coarsest scale, and see so many rows more above and below.
inline constexpr int kMsSsimPixel_px = 1 << (kMsSsimScales - 1);
inline constexpr int kMsSsimReach_px = kSsimRadius_px * kMsSsimPixel_px;
// The least width and height: one window at the coarsest scale.
inline constexpr int kMsSsimLeast_px = kSsimWindow_px * kMsSsimPixel_px;

// A plain record: zero bytes are an empty sum.
struct MsSsimTotals {
  std::array<SsimTotals, kMsSsimScales> scales;  // finest first

  void merge(const MsSsimTotals& later);
  // The mean of one channel at a scale: of structure, at the coarsest of ssim.
  double mean(int scale, int channel) const;
  // The formula above for each channel; their mean.
  double ms_ssim(int channels) const;
};

// Rows y0 .. y1 of a picture of width x height pixels, each at least kMsSsimLeast_px. y0 is a multiple of
// kMsSsimPixel_px, y1 as well or the height.
struct MsSsimStrip {
  int width = 0, height = 0, y0 = 0, y1 = 0;
  int channels = 3;
  const float* weights = nullptr;  // of pixel (0, y0), one each; nullptr for ones. Coarser scales average them
  ptrdiff_t weights_stride = 0;    // floats to the row below
};

// Adds a strip to the totals. Samples begin at pixel (0, y0). Readable are the rows from max(y0 - kMsSsimReach_px,
// -kSsimRadius_px) to min(y1 + kMsSsimReach_px, height + kSsimRadius_px), and kSsimRadius_px columns on both sides;
// what lies outside the picture is its mirror image, c b a | a b c. map, unless nullptr: one value for each pixel of
// the strip from (0, y0) on, the formula of its own windows at the scales it falls into instead of their means
// (windows at the edges see the picture mirrored), mean over channels.
template <class Sample>
void add_ms_ssim(const SsimSamples<Sample>& test, const SsimSamples<Sample>& reference, const MsSsimStrip& strip,
                 double data_range, MsSsimTotals& totals, float* map, ptrdiff_t map_stride);
extern template void add_ms_ssim(const SsimSamples<float>&, const SsimSamples<float>&, const MsSsimStrip&, double,
                                 MsSsimTotals&, float*, ptrdiff_t);
extern template void add_ms_ssim(const SsimSamples<double>&, const SsimSamples<double>&, const MsSsimStrip&, double,
                                 MsSsimTotals&, float*, ptrdiff_t);

// Bytes that a strip of so many rows allocates, at most.
uint64_t ms_ssim_work_bytes(int width, int rows, int channels);

}  // namespace triad
