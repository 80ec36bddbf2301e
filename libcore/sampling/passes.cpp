// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <climits>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/passes.hpp>
#include <utility>

namespace triad {
namespace {

constexpr size_t kBatch = 1024;         // samples asked for at once: 106 kB, and 1 ms at 1 us each
constexpr double kFewestForError = 16;  // samples per pixel before an estimated error is believed

}  // namespace

Passes::Passes(const Strategy& strategy, const Source& source, const RenderOptions& options, float footprint_px,
               Points points, SampleTaker::Weigh weigh)
    : taker_(strategy, source, options),
      footprint_px_(footprint_px),
      points_(std::move(points)),
      weigh_(std::move(weigh)) {}

// A queue of its own for whoever has a group to fill; queues are kept from group to group, for making one costs as
// much as thirty samples.
class Passes::QueueInUse {
 public:
  explicit QueueInUse(Passes& passes) : passes_(passes) {
    const std::lock_guard lock(passes.mutex_);
    if (passes.idle_.empty()) {
      queue_ = std::make_unique<Queue>(passes);
    } else {
      queue_ = std::move(passes.idle_.back());
      passes.idle_.pop_back();
    }
  }
  QueueInUse(const QueueInUse&) = delete;
  QueueInUse& operator=(const QueueInUse&) = delete;
  ~QueueInUse() {
    const std::lock_guard lock(passes_.mutex_);
    passes_.idle_.push_back(std::move(queue_));
  }
  Queue& operator*() { return *queue_; }

 private:
  Passes& passes_;
  std::unique_ptr<Queue> queue_;
};

Passes::Queue::Queue(Passes& passes)
    : passes_(passes),
      requests_(kBatch, {.footprint_px = passes.footprint_px_, .seed = passes.taker_.options().seed}),
      samples_(kBatch) {}

// Of each of n pixels from x on, `each` requests, for which there is room.
void Passes::Queue::put(int x, int y, size_t n, uint32_t index, size_t each) {
  const Pattern* const pattern = std::get_if<Pattern>(&passes_.points_);
  if (size_ == 0) {
    each_ = each;
    rows_.clear();  // here, for what was asked for last may have ended with an exception
  } else if (each_ != each && each_ != 0) {
    if (!pattern) say_all(std::span(requests_).first(size_), each_);
    each_ = 0;
  }
  SampleRequest* request = requests_.data() + size_;
  RequestMembers members = request_members(passes_.footprint_px_, x, y, index);
  if (pattern) {
    run_wide([&]() TRIAD_INLINE_BODY { put_pattern(*pattern, request, members, n, each); });
  } else {
    for (size_t i = 0; i < n; ++i, members += kNextPixel) put_members(request[i * each], members);
    if (each_ == 0) say_all({request, n * each}, each);
  }
  size_ += n * each;
  rows_.push_back({passes_.film().pixel(x, y), n});
}

// Sets all that requests say but the seed, which they have.
TRIAD_INLINE_BODY inline void Passes::Queue::put_pattern(Pattern pattern, SampleRequest* request,
                                                         RequestMembers members, size_t n, size_t each) {
  typedef double Two __attribute__((vector_size(16)));
  typedef int64_t TwoWords __attribute__((vector_size(16)));
  typedef int64_t FourWords __attribute__((vector_size(32)));
  static_assert(offsetof(SampleRequest, x) == 0 && offsetof(SampleRequest, y) == sizeof(double) &&
                offsetof(SampleRequest, footprint_px) == sizeof(Two) &&
                offsetof(SampleRequest, seed) == sizeof(FourWords));
  const bool one = pattern.size() == 1;
  const std::array<double, 2>* const places = &pattern[one ? 0 : static_cast<uint32_t>(members[3])];
  Two corner{static_cast<double>(members[1]), static_cast<double>(members[2])};
  const auto put_next = [&](const std::array<double, 2>& place_in_pixel,
                            const RequestMembers& own) TRIAD_INLINE_BODY {
    Two place;
    std::memcpy(&place, &place_in_pixel, sizeof(place));
    place += corner;
    const FourWords all = __builtin_shufflevector((TwoWords)place, (TwoWords)own, 0, 1, 2, 3);
    std::memcpy(static_cast<void*>(request++), &all, sizeof(all));
  };
  if (each == 1) {
    for (size_t p = 0; p < n; ++p, members += kNextPixel, corner += Two{1, 0}) put_next(*places, members);
    return;
  }
  for (size_t p = 0; p < n; ++p, members += kNextPixel, corner += Two{1, 0}) {
    RequestMembers own = members;
    for (size_t i = 0; i < each; ++i, own += kNextIndex) put_next(places[one ? 0 : i], own);
  }
}

bool Passes::Queue::add_row(int x0, int x1, int y, uint32_t first, uint32_t past) {
  const Film& film = passes_.film();
  const size_t each = past - first;
  if (each == 0) return true;
  for (int x = x0; x < x1;) {
    // A pixel's samples of one pass are parted in the same way wherever the pixel lies, for the film sums what it is
    // given at once as a whole.
    if (each > kBatch - size_ && !flush()) return false;
    const size_t n = std::clamp<size_t>((kBatch - size_) / each, 1, static_cast<size_t>(x1 - x));
    film.expect(film.pixel(x, y), n);
    if (each <= kBatch) {
      put(x, y, n, first, each);
    } else {
      for (uint32_t index = first; index < past;) {
        if (size_ == kBatch && !flush()) return false;
        const size_t some = std::min<size_t>(kBatch - size_, past - index);
        put(x, y, 1, index, some);
        index += static_cast<uint32_t>(some);
      }
    }
    x += static_cast<int>(n);
  }
  return true;
}

bool Passes::Queue::flush() {
  const std::span<SampleRequest> asked(requests_.data(), std::exchange(size_, 0));
  if (asked.empty()) return true;
  if (const Place* place = std::get_if<Place>(&passes_.points_)) (*place)(asked, each_);
  return passes_.taker_.add(asked, std::span(samples_).first(asked.size()), {each_, rows_}, passes_.weigh_);
}

bool Passes::run(int64_t groups, const std::function<void(int64_t, Queue&)>& fill, bool estimate) {
  parallel_for(groups, [&](int64_t group) {
    QueueInUse queue(*this);
    fill(group, *queue);
    (*queue).flush();
  });
  PassRecord& pass = taker_.end_pass();
  bool& reached = taker_.result().reached;
  if (estimate && film().planes().error && !taker_.stopped()) {
    pass.rmse = film().estimated_rmse();
    const double until_rmse = taker_.options().until_rmse;
    if (until_rmse > 0 && static_cast<double>(samples()) >= kFewestForError * static_cast<double>(film().pixels())) {
      reached = pass.rmse <= until_rmse;
      // Without stratification an error falls with the root of the samples; with it, faster.
      const double ratio = pass.rmse / until_rmse;
      expect(static_cast<double>(samples()) * std::max(1., ratio * ratio));
    }
  }
  return !taker_.stopped() && !reached;
}

struct Passes::Tiles {
  int width, height, side;
  int64_t columns, count;
  explicit Tiles(const Passes& passes)
      : width(passes.film().width()),
        height(passes.film().height()),
        side(std::max(1, passes.taker_.options().tile_px)),
        columns((int64_t{width} + side - 1) / side),
        count(columns * ((int64_t{height} + side - 1) / side)) {}
  // row(x0, x1, y) for each of a tile's rows from the top, until it says false.
  template <class Row>
  void each_row(int64_t tile, const Row& row) const {
    const int x0 = static_cast<int>(tile % columns) * side, y0 = static_cast<int>(tile / columns) * side;
    const int x1 = x0 + std::min(side, width - x0), y1 = y0 + std::min(side, height - y0);
    for (int y = y0; y < y1; ++y)
      if (!row(x0, x1, y)) return;
  }
};

bool Passes::run_all(uint32_t first, uint32_t past, bool estimate) {
  const Tiles tiles(*this);
  return run(
      tiles.count,
      [&](int64_t tile, Queue& queue) {
        tiles.each_row(tile, [&](int x0, int x1, int y) { return queue.add_row(x0, x1, y, first, past); });
      },
      estimate);
}

void Passes::run_all_in_turn(uint32_t spp) {
  using Clock = std::chrono::steady_clock;
  const Tiles tiles(*this);
  const uint32_t second = std::min(spp, kSecondPass);
  std::vector<int> rows_at_once(static_cast<size_t>(tiles.count));  // of each tile, from its top
  std::atomic<bool> all_at_once = true;
  const Clock::time_point start = Clock::now();
  const std::chrono::duration<double> soon(taker_.options().soon_s);
  bool goes_on = run(tiles.count, [&](int64_t tile, Queue& queue) {
    int& rows = rows_at_once[static_cast<size_t>(tile)];
    // To look at the clock costs as much as a sample: that is done after 0, 1, 2, 4 and so on rows, where it matters.
    int next = second > 1 ? 0 : INT_MAX;
    bool in_time = true;
    tiles.each_row(tile, [&](int x0, int x1, int y) {
      if (in_time && rows == next) {
        in_time = Clock::now() - start < soon;
        next = std::max(1, 2 * rows);
      }
      rows += in_time;
      return queue.add_row(x0, x1, y, 0, in_time ? second : 1);
    });
    if (!in_time) all_at_once = false;
  });
  if (goes_on && !all_at_once && second > 1)
    goes_on = run(tiles.count, [&](int64_t tile, Queue& queue) {
      int rows = rows_at_once[static_cast<size_t>(tile)];
      tiles.each_row(tile, [&](int x0, int x1, int y) { return rows-- > 0 || queue.add_row(x0, x1, y, 1, second); });
    });
  for (uint32_t first = second, past; goes_on && first < spp; first = past) {
    past = std::min(spp, first * 2);
    goes_on = run_all(first, past);
  }
}

}  // namespace triad
