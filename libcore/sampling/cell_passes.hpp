// SPDX-License-Identifier: Apache-2.0
// Passes over display pixels, whose samples are binned into cells.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <triad/sampling/cell_points.hpp>
#include <triad/sampling/sample_taker.hpp>
#include <vector>

namespace triad {

// Takes a render's samples. Not for several threads at once.
class CellPasses {
 public:
  // Of a display of width x height pixels. The taker and the points must outlive it.
  CellPasses(SampleTaker& taker, const CellPoints& points, int width, int height, float footprint_px);
  ~CellPasses();

  // The samples first .. past - 1 of each pixel, tile by tile on all threads, or of those on a list (y * width + x),
  // each once, in its order. False: the render was stopped, and some pixels did without.
  bool take(uint32_t first, uint32_t past);
  bool take(uint32_t first, uint32_t past, std::span<const size_t> list);
  // All passes over the whole picture: to 1 sample of each pixel, 16, 32, 64 and so on up to spp. In the first, while
  // options.soon_s have not gone by, a row of a tile takes its samples to 16 at once, and then a tile those to 64,
  // unless errors are estimated in between; a pass that all tiles have been through so is none. They end where the
  // render is stopped, or where after_pass says false.
  void take_in_turn(uint32_t spp, const std::function<bool(PassRecord&)>& after_pass);
  // The numbers of all pixels, tile by tile.
  std::vector<size_t> pixels_in_tiles() const;

 private:
  class Queue;
  class QueueInUse;
  struct Rows {
    int x0, x1, y0, y1;
  };
  // What the first pass did in a tile.
  struct AtOnce {
    int rows = 0;          // from its top with more than one sample in each pixel
    uint32_t samples = 0;  // in each pixel, if that was done in all rows
  };
  Rows tile(int64_t number) const;
  // In a tile's rows from first_row on. False: the render was stopped.
  bool take_tile(int64_t number, int first_row, uint32_t first, uint32_t past);
  AtOnce take_tile_soon(int64_t number, uint32_t spp, const std::function<bool()>& in_time);

  SampleTaker& taker_;
  const CellPoints& points_;
  const int width_, height_, side_;  // side_ of a tile
  const float footprint_px_;
  int64_t columns_, tiles_;
  std::mutex mutex_;  // of what follows
  std::vector<std::unique_ptr<Queue>> idle_;
};

}  // namespace triad
