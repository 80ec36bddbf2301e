// SPDX-License-Identifier: Apache-2.0
// Structural similarity of two pictures: Z. Wang, A. C. Bovik, H. R. Sheikh and E. P. Simoncelli, "Image Quality
// Assessment: From Error Visibility to Structural Similarity", IEEE Trans. Image Processing 13(4), 2004.
//
// With the means m, variances v and the covariance c of two windows x and y, weighted by a Gaussian of sigma 1.5
// pixels over 11 x 11 pixels that sums to 1 (so population variances), C1 = (.01 L)^2 and C2 = (.03 L)^2 for data
// range L:
//
//   luminance = (2 mx my + C1) / (mx^2 + my^2 + C1)       structure = (2 c + C2) / (vx + vy + C2)
//   ssim = luminance * structure                           (equation 13; structure is its contrast times structure)
//
// Functions are thread-safe as long as each thread has a sink of its own.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <triad/numeric/sum.hpp>

namespace triad {

inline constexpr int kSsimRadius_px = 5;
inline constexpr int kSsimWindow_px = 2 * kSsimRadius_px + 1;

// A part of a picture, in the picture's own pixels, half open.
struct SsimArea {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int channels = 3;  // interleaved, at least 1
};

// Samples of a picture: pixel (area.x0, area.y0), channel 0, and how many samples it is to the row below. Readable
// kSsimRadius_px beyond the area on every side.
template <class Sample>
struct SsimSamples {
  const Sample* first = nullptr;
  ptrdiff_t stride = 0;
};

// Receives pixels x .. x + pixels - 1 of row y, each of area.channels values, at most 1. Valid until it returns.
using SsimSink = std::function<void(int x, int y, int pixels, const double* ssim, const double* structure)>;

// Each pixel of the area once, by tiles that begin at multiples of kSsimTile_px from x = 0, in each from top to
// bottom. The same area gives the same bits on every processor. Equal pictures give exactly 1.
//
// Computed in double, from samples less what those of a tile have in common: the error of a variance is about 1e-16
// of the largest square of what is left, whatever pedestal it stood on (SsimTest.StaysRightOnAPedestal). Takes about
// 300 kB of memory for three channels.
inline constexpr int kSsimTile_px = 128;
template <class Sample>
void local_ssim(const SsimSamples<Sample>& test, const SsimSamples<Sample>& reference, const SsimArea& area,
                double data_range, const SsimSink& sink);
extern template void local_ssim(const SsimSamples<float>&, const SsimSamples<float>&, const SsimArea&, double,
                                const SsimSink&);
extern template void local_ssim(const SsimSamples<double>&, const SsimSamples<double>&, const SsimArea&, double,
                                const SsimSink&);

// Weighted sums over pixels of up to three channels. A plain record: zero bytes are an empty sum.
struct SsimTotals {
  NeumaierSum weight;
  std::array<NeumaierSum, 3> ssim, structure;

  // What a sink gets, of a picture of width x height pixels; weights: of pixel x and those that follow, or nullptr
  // for ones. Pixels whose window leaves the picture are left out, and those whose weight is not above 0.
  void add(int x, int y, int pixels, int width, int height, int channels, const float* weights, const double* values,
           const double* structures);
  void merge(const SsimTotals& later);
};

}  // namespace triad
