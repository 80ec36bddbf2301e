// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <triad/base/parallel.hpp>
#include <triad/sampling/pixel_batches.hpp>
#include <utility>

namespace triad {
namespace {

constexpr size_t kBatch = 256;        // samples asked for at once, or one pixel's if those are more: 34 kB
constexpr uint32_t kSecondPass = 16;  // samples per pixel after the second pass

// Of one thread.
class Queue {
 public:
  Queue(SampleTaker& taker, const PixelWork& work, uint32_t first, uint32_t past)
      : taker_(taker),
        work_(work),
        first_(first),
        per_pixel_(past - first),
        requests_(std::max(kBatch, per_pixel_) / per_pixel_ * per_pixel_),
        spare_(requests_.size()),
        samples_(requests_.size()) {}

  // False: the render was stopped.
  bool add(int x, int y) {
    if (size_ == requests_.size() && !flush()) return false;
    for (size_t i = 0; i < per_pixel_; ++i)
      requests_[size_++] = {0, 0, work_.footprint_px, x, y, first_ + static_cast<uint32_t>(i), taker_.options().seed};
    return true;
  }

  bool flush() {
    const size_t n = std::exchange(size_, 0);
    return n == 0 || work_.take({std::span(requests_).first(n), std::span(spare_).first(n),
                                 std::span(samples_).first(n), per_pixel_});
  }

 private:
  SampleTaker& taker_;
  const PixelWork& work_;
  const uint32_t first_;
  const size_t per_pixel_;
  std::vector<SampleRequest> requests_, spare_;
  std::vector<Sample> samples_;
  size_t size_ = 0;
};

}  // namespace

bool take_pixels(SampleTaker& taker, const PixelWork& work, uint32_t first, uint32_t past) {
  const int64_t tile = std::max(1, taker.options().tile_px), width = work.width, height = work.height;
  const int64_t columns = (width + tile - 1) / tile, rows = (height + tile - 1) / tile;
  parallel_for(columns * rows, [&](int64_t t) {
    const int64_t x0 = t % columns * tile, x1 = std::min(x0 + tile, width);
    const int64_t y0 = t / columns * tile, y1 = std::min(y0 + tile, height);
    Queue queue(taker, work, first, past);
    for (int64_t y = y0; y < y1; ++y)
      for (int64_t x = x0; x < x1; ++x)
        if (!queue.add(static_cast<int>(x), static_cast<int>(y))) return;
    queue.flush();
  });
  return !taker.stopped();
}

void take_in_passes(SampleTaker& taker, const PixelWork& work, uint32_t samples, uint32_t together,
                    const std::function<bool(PassRecord&)>& after_pass) {
  for (uint32_t first = 0, past = 0; first < samples; first = past) {
    past = std::min(
        samples,
        first == 0 ? 1
                   : std::max(kSecondPass, first + std::min(first, static_cast<uint32_t>(kMostTogether) / together)));
    const bool whole = take_pixels(taker, work, first * together, past * together);
    PassRecord& pass = taker.end_pass();
    if (!whole || (after_pass && !after_pass(pass))) return;
  }
}

}  // namespace triad
