// SPDX-License-Identifier: Apache-2.0
// Pixels one by one, their samples asked for in batches: for strategies that look at a pixel's samples together.
#pragma once

#include <functional>
#include <triad/sampling/sample_taker.hpp>

namespace triad {

// What is done in the pixels of a grid that need not be the film's.
struct PixelBatches {
  int width = 0, height = 0;  // of the grid
  float footprint_px = 1;
  // Sets x and y of requests that say all else, as many pixels of them as come together. Pure, any thread.
  std::function<void(std::span<SampleRequest>)> place;
  // One pixel's requests, by ascending index, and their answers, those that are not valid marked so; it may change
  // both. Several threads at once, each with pixels of its own.
  std::function<void(int x, int y, std::span<SampleRequest>, std::span<Sample>)> use;
  bool keep = true;  // as SampleTaker::take()
};

// The samples first .. past - 1 of each pixel, tile by tile on all threads. False: the render was stopped, and some
// pixels did without.
bool take_pixels(SampleTaker& taker, const PixelBatches& batches, uint32_t first, uint32_t past);

// Passes over the whole grid: to 1 sample of each pixel, 16, 32, 64 and so on up to `samples`, all times `together`,
// each a PassRecord. They end where the render is stopped, or where after_pass, if there is one, says false.
void take_in_passes(SampleTaker& taker, const PixelBatches& batches, uint32_t samples, uint32_t together = 1,
                    const std::function<bool(PassRecord&)>& after_pass = {});

}  // namespace triad
