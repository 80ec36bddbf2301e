// SPDX-License-Identifier: Apache-2.0
// What the strategies share that take samples at the centres of a pixel's three subpixels, stripes side by side.
#pragma once

#include <triad/sampling/pixel_batches.hpp>

namespace triad {

inline constexpr int kSubpixels = 3;

// Throws Error(kUsage) where the film's pixels are not those of a display.
void require_whole_pixels(const StrategyInfo& info, const RenderOptions& options);

// Samples summed by pixel and subpixel. Several threads may add to different pixels at once.
class SubpixelSums {
 public:
  // Sizes in pixels, at least 1.
  SubpixelSums(int width, int height);

  // Takes the samples of a batch at the centres of the subpixels that subpixel(request) names, 0 .. 2 from the left,
  // and adds them here and to the film. False: the render was stopped.
  template <class Subpixel>
  bool take(SampleTaker& taker, const PixelBatch& batch, const Subpixel& subpixel) {
    for (SampleRequest& request : batch.requests) {
      request.x = request.pixel_x + (2 * subpixel(request) + 1) / 6.;
      request.y = request.pixel_y + .5;
    }
    if (!taker.take(batch.requests, batch.samples)) return false;
    for (size_t i = 0; i < batch.requests.size(); ++i) {
      const SampleRequest& request = batch.requests[i];
      add(request.pixel_x, request.pixel_y, subpixel(request), batch.samples[i]);
    }
    return true;
  }

  // Samples that were asked for there, those that are not valid included.
  uint32_t asked(int x, int y, int subpixel) const { return at(x, y, subpixel).asked; }
  // Of each subpixel of a row, from the left: the mean of the valid samples. Without any, that of the nearest
  // subpixel in the row that has some, the one to the left before the one to the right; 0 if there is none.
  std::vector<std::array<double, 3>> means(int y) const;

 private:
  void add(int x, int y, int subpixel, const Sample& sample);
  struct Sum {
    std::array<double, 3> rgb{};
    uint32_t asked = 0, valid = 0;
  };
  const Sum& at(int x, int y, int subpixel) const {
    return sums_[row(y) + static_cast<size_t>(x * kSubpixels + subpixel)];
  }
  size_t row(int y) const { return static_cast<size_t>(y) * static_cast<size_t>(width_) * kSubpixels; }

  int width_;
  std::vector<Sum> sums_;
};

}  // namespace triad
