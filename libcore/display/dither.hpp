// SPDX-License-Identifier: Apache-2.0
// Rounding a picture for a panel to the few values that a file or a cable holds, so that an eye sees as little of it
// as possible.
//
// What is kept small is the visible energy of (light of the rounded picture) - (light of the picture): the display
// error with the picture itself as its target. For a picture that solver or filter have made optimal for a fine
// target it is, to second order, also what rounding adds to the error against that target, for the gradient there
// vanishes for every drive that is free to move.
#pragma once

#include <cstdint>
#include <triad/display/panel_torus.hpp>
#include <triad/display/vision.hpp>
#include <vector>

namespace triad {

enum class Dither {
  kNone,       // each value to the nearest code: what a file does anyway
  kOrdered,    // up or down by an 8 x 8 matrix of thresholds (Bayer 1973), the same for all channels
  kPerceptual  // up or down by the least visible energy, drive after drive, and again in the light of what followed
};

struct DitherOptions {
  Dither mode = Dither::kPerceptual;
  int passes = 3;     // over all drives; the first decides, the others revise. 1 .. 16
  int radius_px = 0;  // how far a drive's light is followed; 0: .15 degrees, from 3 to 10 px. At most 16
};

// The values of codes 0 .. 2^bits - 1, and where the nearest code changes: limits[k] lies between levels k and k + 1.
struct StoredLevels {
  std::vector<double> levels, limits;
};
// Codes of the sRGB curve (IEC 61966-2-1), as PNG and JPEG hold them, or of linear light. bits 1 .. 16.
StoredLevels srgb_levels(int bits);
StoredLevels linear_levels(int bits);

// Immutable and thread-safe; works on all threads of the process, with the same bits for any number of them.
class PanelDither {
 public:
  // Throws Error(kUsage): observer refused, options out of range.
  PanelDither(const Layout& layout, const Observer& observer, int origin_x_px, int origin_y_px, StoredLevels levels,
              const DitherOptions& options);

  // What apply() holds in memory for a picture of this size.
  uint64_t work_bytes(int width_px, int height_px) const;

  // drives and out: interleaved RGB, `stride` floats from row to row; they may be the same. Every value of out is a
  // level: one of the two around the drive, or the drive itself where it is one, so that doing it twice changes
  // nothing. Drives are clamped to [0, 1] first; those that light nothing (PenTile's) go to the nearest code.
  void apply(const PictureView& drives, int width_px, int height_px, float* out, ptrdiff_t out_stride) const;

 private:
  struct Picture;
  void decide_tile(Picture& picture, int tile_x, int tile_y, bool first) const;
  const float* kernel(int phase, int channel) const;

  int radius_, tile_x_, tile_y_, origin_x_, origin_y_, passes_;
  Dither mode_;
  StoredLevels levels_;
  // [phase of the tile * 3 + channel][other channel][dy + radius][dx + radius]: the energy that full steps of two
  // drives share.
  std::vector<float> kernels_;
};

}  // namespace triad
