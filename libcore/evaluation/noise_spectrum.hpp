// SPDX-License-Identifier: Apache-2.0
// The power spectrum of a difference picture, averaged over tiles and directions, and how alike neighbours are.
#pragma once

#include <array>
#include <cstdint>
#include <triad/numeric/sum.hpp>
#include <vector>

namespace triad {

inline constexpr int kLeastSpectrumTile_px = 8, kMostSpectrumTile_px = 512;
inline constexpr int kMostNoisePlanes = 3;

// Sums over tiles and pixels, of which finish() makes a spectrum. A plain record: all bytes zero is an empty one.
struct NoiseSums {
  // One for each distance from the origin, 0 .. round(512 sqrt(1/2)), in steps of one cycle per tile.
  static constexpr int kMostBins = 363;
  static constexpr int kLow = kMostBins;  // one more: all coefficients below NoiseSpectrum's `cut`, once again
  struct Lag {                            // over pairs of neighbours a, b, weighted by both weights
    NeumaierSum product, sum, weight;     // a b, a + b, 1
  };
  double power[kMostBins + 1], window[kMostBins + 1];  // |Y|^2 over all planes, |W|^2
  double cross[kMostNoisePlanes][kMostBins + 1];       // Re(Y W*)
  NeumaierSum energy;                                  // squares of the window with the weights
  NeumaierSum weight, value[kMostNoisePlanes], square[kMostNoisePlanes];
  Lag x[kMostNoisePlanes], y[kMostNoisePlanes];
};

// Rows [y0, y1) of a difference picture, each `width` numbers that follow each other.
struct NoiseRows {
  int y0 = 0, y1 = 0;
  std::array<const double*, kMostNoisePlanes> plane{};  // test - reference, 0 where the weight is 0
  const double* weight = nullptr;                       // in [0, 1]; nullptr: all 1
};

struct NoiseResult {
  // Correlation of neighbours around the mean, sum of cov / sum of variance over the planes; 0 for a constant.
  double lag_x = 0, lag_y = 0;
  double low_share = 0;    // of the power: that at frequencies below `cut`
  double white_share = 0;  // the same of white noise
  double variance = 0;     // mean over the planes
  // Power per (cycle per pixel)^2, so that white noise of variance v has v everywhere; the mean frequency of each
  // bin, cycles per pixel. Bins of one cycle per tile around 0, 1, 2 ... cycles per tile.
  std::vector<double> frequency, power;
};

// Welch's method (IEEE Transactions on Audio and Electroacoustics 15(2), 1967) in two dimensions: periodograms of
// tiles that overlap by half or a little more, so spaced that they cover the picture, are averaged. A tile is
// weighted by the Hann window .5 - .5 cos(2 pi (j + .5) / n) in x and y, whose sides fall off so steeply that what
// lies at the edges leaks into no distant frequency, and divided by the window's own energy, so that
// by Parseval's theorem the spectrum's mean over all coefficients is the windowed mean square.
//
// The mean of the whole picture is subtracted, not each tile's, which would take away power below one cycle per tile.
// It is known only at the end: |Y - m W|^2 = |Y|^2 - 2 m Re(Y W*) + m^2 |W|^2 for each coefficient, W the window's.
//
// Weights multiply the window, as a mask does. Thread-safe: all functions are const.
class NoiseSpectrum {
 public:
  // Tiles have min(tile, width) x min(tile, height) pixels. cut: cycles per pixel, above 0.
  NoiseSpectrum(int width, int height, int tile, int planes, double cut);

  int tile_width() const { return tile_x_; }
  int tile_height() const { return tile_y_; }
  // Rows of a strip, for a metric: 64, 128 or 256, the least that no two beginnings of tiles lie further apart than,
  // so that strips do about as much work each, and fit those of other metrics.
  int strip_rows() const { return strip_rows_; }
  // The rows that add() for [y0, y1) looks at are [y0, last_row(y0, y1)).
  int last_row(int y0, int y1) const;
  // Bytes that add() allocates.
  uint64_t work_bytes() const;

  // Adds the tiles that begin in rows [y0, y1) and the pixels in them with their neighbours to the right and below.
  // The bits of the result depend on where the picture is cut.
  void add(const NoiseRows& rows, int y0, int y1, NoiseSums& sums) const;
  static void merge(NoiseSums& into, const NoiseSums& later);
  // Needs a weight above 0.
  NoiseResult finish(const NoiseSums& sums) const;

 private:
  struct Work;
  void add_lags(const NoiseRows& rows, int y0, int y1, NoiseSums& sums) const;
  void add_tile(const NoiseRows& rows, int x0, int y0, Work& work, NoiseSums& sums) const;
  void transform(const double* values, const double* weights, int x0, int y_offset, Work& work, bool window) const;

  int width_, height_, planes_, tile_x_, tile_y_, strip_rows_, columns_, bins_;
  std::vector<int> begin_x_, begin_y_;
  std::vector<double> window_x_, window_y_;
  std::vector<int16_t> bin_;   // per coefficient, tile_y_ rows of tile_x_ / 2 + 1
  std::vector<bool> low_;      // the same
  std::vector<double> count_;  // per bin and of kLow: coefficients, mirrored ones as well
  std::vector<double> frequency_;
};

}  // namespace triad
