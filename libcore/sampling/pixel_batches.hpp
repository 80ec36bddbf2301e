// SPDX-License-Identifier: Apache-2.0
// Pixels one by one, their samples asked for in batches: for strategies that look at a pixel's samples together.
#pragma once

#include <functional>
#include <triad/sampling/sample_taker.hpp>

namespace triad {

// Samples of whole pixels that one thread is to take.
struct PixelBatch {
  // One pixel's after the other's, by ascending index; all is set but x and y.
  std::span<SampleRequest> requests;
  std::span<Sample> samples;  // as many, for the answers
  size_t per_pixel = 0;
};

inline constexpr size_t kMostTogether = 4096;  // the most of one pixel in a batch, which stays below a megabyte so

// What is done in the pixels of a grid, which need not be the film's.
struct PixelWork {
  int width = 0, height = 0;  // of the grid
  float footprint_px = 1;
  // Places them, asks for them, and uses what comes back. Several threads at once, each with pixels of its own.
  // False: the render was stopped.
  std::function<bool(const PixelBatch&)> take{};
};

// The samples first .. past - 1 of each pixel, tile by tile on all threads. False: the render was stopped, and some
// pixels did without.
bool take_pixels(SampleTaker& taker, const PixelWork& work, uint32_t first, uint32_t past);

// Passes over the whole grid: to 1 sample of each pixel, 16, 32, 64 and so on up to `samples`, all times `together`,
// each a PassRecord. They end where the render is stopped, or where after_pass, if there is one, says false.
void take_in_passes(SampleTaker& taker, const PixelWork& work, uint32_t samples, uint32_t together = 1,
                    const std::function<bool(PassRecord&)>& after_pass = {});

}  // namespace triad
