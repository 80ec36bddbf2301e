// SPDX-License-Identifier: Apache-2.0
// What an observer sees of light on a panel: each opponent channel loses the detail that an eye does, and the result
// is linear RGB again, to be looked at from near.
//
// Each channel's transfer is MTF_c(f) / MTF_c(0), so that flat fields stay what they are. In kOpponent the difference
// of two such pictures on the grid of cells, in opponent space and times MTF_c(0), is therefore the blurred error
// that DisplayError squares.
#pragma once

#include <cstdint>
#include <triad/display/panel_torus.hpp>
#include <triad/display/vision.hpp>
#include <triad/numeric/plane_blur.hpp>
#include <vector>

namespace triad {

enum class EyeGrid {
  kPixels,  // a value for each display pixel: the mean of its cells
  kCells    // a value for each fine cell
};

enum class EyeSpace {
  // Chroma is what a colour differs from the grey of its luminance by: greys stay grey wherever they lie.
  kNeutral,
  // The channels of the display error as they are. White is not quite neutral in them (red-green -.06 and blue-yellow
  // .05 of its luminance), and as chroma is blurred more widely than luminance, black and white edges get tinted
  // halos.
  kOpponent
};

// Immutable and thread-safe; works on all threads of the process, with the same bits for any number of them.
class Eye {
 public:
  // Throws Error(kUsage): observer or shape refused.
  Eye(const Layout& layout, const Observer& observer, const PanelTorus::Shape& shape, EyeGrid grid,
      EyeSpace space = EyeSpace::kNeutral);

  const PanelTorus& torus() const { return torus_; }
  int width() const {
    return grid_ == EyeGrid::kPixels ? torus_.shape().width_px : static_cast<int>(torus_.columns());
  }
  int height() const {
    return grid_ == EyeGrid::kPixels ? torus_.shape().height_px : static_cast<int>(torus_.rows());
  }
  // What look() holds in memory.
  uint64_t work_bytes() const;

  // rgb: width() * height() pixels of interleaved linear RGB, `stride` floats from a row to the next. Not confined to
  // [0, 1]: light that is blurred in one channel more than in another may leave the gamut.
  void look(const Light& light, float* rgb, ptrdiff_t stride) const;

 private:
  PanelTorus torus_;
  EyeGrid grid_;
  PlaneBlur blur_;
  std::array<double, 9> to_opponent_, to_rgb_;
  PlaneBlur::Transfer transfer_[3];
};

}  // namespace triad
