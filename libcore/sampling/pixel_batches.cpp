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
    return n == 0 || work_.take({std::span(requests_).first(n), std::span(samples_).first(n), per_pixel_});
  }

 private:
  SampleTaker& taker_;
  const PixelWork& work_;
  const uint32_t first_;
  const size_t per_pixel_;
  std::vector<SampleRequest> requests_;
  std::vector<Sample> samples_;
  size_t size_ = 0;
};

struct Tiles {
  int64_t width, height, side, columns, count;
  Tiles(const SampleTaker& taker, const PixelWork& work)
      : width(work.width),
        height(work.height),
        side(std::max(1, taker.options().tile_px)),
        columns((width + side - 1) / side),
        count(columns * ((height + side - 1) / side)) {}
  // visit(x, y) until it says false.
  template <class Visit>
  void each(int64_t tile, const Visit& visit) const {
    const int64_t x0 = tile % columns * side, y0 = tile / columns * side;
    for (int64_t y = y0; y < std::min(y0 + side, height); ++y)
      for (int64_t x = x0; x < std::min(x0 + side, width); ++x)
        if (!visit(static_cast<int>(x), static_cast<int>(y))) return;
  }
};

}  // namespace

bool take_pixels(SampleTaker& taker, const PixelWork& work, uint32_t first, uint32_t past) {
  // A queue holds only so many of one pixel.
  for (; past - first > kMostTogether; first += kMostTogether)
    if (!take_pixels(taker, work, first, first + static_cast<uint32_t>(kMostTogether))) return false;
  const Tiles tiles(taker, work);
  parallel_for(tiles.count, [&](int64_t t) {
    Queue queue(taker, work, first, past);
    tiles.each(t, [&](int x, int y) { return queue.add(x, y); });
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
