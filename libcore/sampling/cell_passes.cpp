// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <triad/base/parallel.hpp>
#include <triad/sampling/cell_passes.hpp>
#include <triad/sampling/cell_sums.hpp>
#include <triad/sampling/passes.hpp>

namespace triad {
namespace {

constexpr uint32_t kSecondPass = Passes::kSecondPass;
constexpr uint32_t kMostSoon = 64;        // that a tile takes at once where there is time
constexpr uint32_t kMostTogether = 4096;  // of one pixel in a batch, which stays below a megabyte so

// What a pass takes each pixel to that has `first`.
uint32_t next_past(uint32_t first, uint32_t spp) { return std::min(spp, first + std::min(first, kMostTogether)); }

}  // namespace

// Pixels that wait for their samples first .. past - 1.
class CellPasses::Queue {
 public:
  Queue(const CellPasses& passes, uint32_t first, uint32_t past)
      : taker_(passes.taker_),
        cells_(passes.points_.cells()),
        batch_(passes.points_, first, past, passes.footprint_px_, passes.taker_.options().seed),
        samples_(batch_.most()) {}
  bool is_for(uint32_t first, uint32_t past) const { return batch_.first() == first && batch_.past() == past; }

  // Of pixels in a row. False: the render was stopped.
  bool add(int x0, int x1, int y) {
    const Film& film = taker_.film();
    for (int x = x0; x < x1;) {
      const size_t n = std::min(batch_.room(), static_cast<size_t>(x1 - x));
      for (int row = 0; row < cells_.y; ++row)
        film.expect(film.pixel(x * cells_.x, y * cells_.y + row), n * static_cast<size_t>(cells_.x));
      batch_.add(x, y, n);
      if (batch_.room() == 0 && !flush()) return false;
      x += static_cast<int>(n);
    }
    return true;
  }
  bool flush() {
    if (batch_.pixels() == 0) return true;
    batch_.place();
    const bool goes_on = take_into_cells(taker_, cells_, batch_, samples_);
    batch_.clear();
    return goes_on;
  }

 private:
  SampleTaker& taker_;
  const Cells cells_;
  CellBatch batch_;
  std::vector<Sample> samples_;
};

// A queue of its own for whoever has pixels to add; queues are kept, for making one costs as much as fifty samples.
class CellPasses::QueueInUse {
 public:
  QueueInUse(CellPasses& passes, uint32_t first, uint32_t past) : passes_(passes) {
    const std::lock_guard lock(passes.mutex_);
    std::vector<std::unique_ptr<Queue>>& idle = passes.idle_;
    const auto found = std::find_if(idle.begin(), idle.end(), [&](const auto& q) { return q->is_for(first, past); });
    if (found == idle.end()) {
      queue_ = std::make_unique<Queue>(passes, first, past);
    } else {
      queue_ = std::move(*found);
      idle.erase(found);
    }
  }
  QueueInUse(const QueueInUse&) = delete;
  QueueInUse& operator=(const QueueInUse&) = delete;
  ~QueueInUse() {
    const std::lock_guard lock(passes_.mutex_);
    passes_.idle_.push_back(std::move(queue_));
  }
  Queue* operator->() { return queue_.get(); }

 private:
  CellPasses& passes_;
  std::unique_ptr<Queue> queue_;
};

CellPasses::CellPasses(SampleTaker& taker, const CellPoints& points, int width, int height, float footprint_px)
    : taker_(taker),
      points_(points),
      width_(width),
      height_(height),
      side_(std::max(1, taker.options().tile_px)),
      footprint_px_(footprint_px),
      columns_((int64_t{width} + side_ - 1) / side_),
      tiles_(columns_ * ((int64_t{height} + side_ - 1) / side_)) {}

CellPasses::~CellPasses() = default;

CellPasses::Rows CellPasses::tile(int64_t number) const {
  const int x0 = static_cast<int>(number % columns_) * side_, y0 = static_cast<int>(number / columns_) * side_;
  return {x0, x0 + std::min(side_, width_ - x0), y0, y0 + std::min(side_, height_ - y0)};
}

std::vector<size_t> CellPasses::pixels_in_tiles() const {
  std::vector<size_t> pixels;
  pixels.reserve(static_cast<size_t>(width_) * static_cast<size_t>(height_));
  for (int64_t t = 0; t < tiles_; ++t) {
    const Rows rows = tile(t);
    for (int y = rows.y0; y < rows.y1; ++y)
      for (int x = rows.x0; x < rows.x1; ++x)
        pixels.push_back(static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x));
  }
  return pixels;
}

bool CellPasses::take(uint32_t first, uint32_t past) {
  for (; past - first > kMostTogether; first += kMostTogether)
    if (!take(first, first + kMostTogether)) return false;
  parallel_for(tiles_, [&](int64_t t) { take_tile(t, 0, first, past); });
  return !taker_.stopped();
}

bool CellPasses::take(uint32_t first, uint32_t past, std::span<const size_t> list) {
  for (; past - first > kMostTogether; first += kMostTogether)
    if (!take(first, first + kMostTogether, list)) return false;
  // So that there is work for every thread where there are few.
  const size_t at_once = std::clamp<size_t>(list.size() / 64, 16, 1024);
  parallel_for(static_cast<int64_t>((list.size() + at_once - 1) / at_once), [&](int64_t group) {
    QueueInUse queue(*this, first, past);
    const size_t begin = static_cast<size_t>(group) * at_once, width = static_cast<size_t>(width_);
    for (const size_t p : list.subspan(begin, std::min(at_once, list.size() - begin))) {
      const int x = static_cast<int>(p % width);
      if (!queue->add(x, x + 1, static_cast<int>(p / width))) return;
    }
    queue->flush();
  });
  return !taker_.stopped();
}

bool CellPasses::take_tile(int64_t number, int first_row, uint32_t first, uint32_t past) {
  QueueInUse queue(*this, first, past);
  const Rows rows = tile(number);
  for (int y = rows.y0 + first_row; y < rows.y1; ++y)
    if (!queue->add(rows.x0, rows.x1, y)) return false;
  return queue->flush();
}

CellPasses::AtOnce CellPasses::take_tile_soon(int64_t number, uint32_t spp, const std::function<bool()>& in_time) {
  const uint32_t second = std::min(spp, kSecondPass);
  const Rows rows = tile(number);
  AtOnce done;
  {
    QueueInUse queue(*this, 0, second);
    // To look at the clock costs as much as five samples: that is done after 1, 2, 4 and so on rows.
    for (int y = rows.y0, next = y; y < rows.y1 && (y < next || in_time()); ++y, ++done.rows) {
      if (y == next) next = rows.y0 + std::max(1, 2 * (y - rows.y0));
      if (!queue->add(rows.x0, rows.x1, y)) return done;
    }
    if (!queue->flush()) return done;
  }
  if (rows.y0 + done.rows < rows.y1) {
    take_tile(number, done.rows, 0, 1);
    return done;
  }
  done.samples = second;
  // Errors are estimated between passes, and may be small enough.
  if (taker_.film().planes().error) return done;
  const uint32_t most = std::min(spp, kMostSoon);
  while (done.samples < most && in_time()) {
    const uint32_t past = next_past(done.samples, most);
    if (!take_tile(number, 0, done.samples, past)) return done;
    done.samples = past;
  }
  return done;
}

void CellPasses::take_in_turn(uint32_t spp, const std::function<bool(PassRecord&)>& after_pass) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  const std::chrono::duration<double> soon(taker_.options().soon_s);
  const auto in_time = [&] { return Clock::now() - start < soon; };
  std::vector<AtOnce> done(static_cast<size_t>(tiles_));
  parallel_for(tiles_, [&](int64_t t) { done[static_cast<size_t>(t)] = take_tile_soon(t, spp, in_time); });
  const auto goes_on = [&] {
    PassRecord& pass = taker_.end_pass();
    return !taker_.stopped() && after_pass(pass);
  };
  if (!goes_on()) return;
  for (uint32_t first = 1, past = std::min(spp, kSecondPass); first < spp;
       first = past, past = next_past(past, spp)) {
    std::atomic<bool> any = false;
    parallel_for(tiles_, [&](int64_t t) {
      const AtOnce& tile = done[static_cast<size_t>(t)];
      if (tile.samples >= past) return;
      any = true;
      take_tile(t, first == 1 ? tile.rows : 0, first, past);
    });
    if (any && !goes_on()) return;
  }
}

}  // namespace triad
