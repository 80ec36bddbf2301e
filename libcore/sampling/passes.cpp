// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/passes.hpp>

namespace triad {
namespace {

constexpr size_t kBatch = 256;          // samples asked for at once: 34 kB, and .25 ms at 1 us each
constexpr uint32_t kSecondPass = 16;    // samples per pixel after the second of all passes
constexpr double kFewestForError = 16;  // samples per pixel before an estimated error is believed

}  // namespace

Passes::Passes(const Strategy& strategy, const Source& source, const RenderOptions& options, float footprint_px,
               Place place, SampleTaker::Weigh weigh)
    : taker_(strategy, source, options),
      footprint_px_(footprint_px),
      place_(std::move(place)),
      weigh_(std::move(weigh)) {}

Passes::Queue::Queue(Passes& passes) : passes_(passes), requests_(kBatch), samples_(kBatch) {}

bool Passes::Queue::add(int x, int y, uint32_t first, uint32_t past) {
  const Film& film = passes_.film();
  film.expect(film.pixel(x, y));
  SampleRequest request{0, 0, passes_.footprint_px_, x, y, first, passes_.taker_.options().seed};
  while (request.index < past) {
    if (size_ == kBatch && !flush()) return false;
    SampleRequest* const run = requests_.data() + size_;
    const size_t n = std::min<size_t>(kBatch - size_, past - request.index);
    for (size_t i = 0; i < n; ++i, ++request.index) run[i] = request;
    size_ += n;
  }
  return true;
}

bool Passes::Queue::flush() {
  const std::span<SampleRequest> asked(requests_.data(), size_);
  passes_.place_(asked);
  size_ = 0;
  return passes_.taker_.add(asked, std::span(samples_).first(asked.size()), passes_.weigh_);
}

bool Passes::run(int64_t groups, const std::function<void(int64_t, Queue&)>& fill, bool estimate) {
  parallel_for(groups, [&](int64_t group) {
    Queue queue(*this);
    fill(group, queue);
    queue.flush();
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

bool Passes::run_all(uint32_t first, uint32_t past, bool estimate) {
  const int tile = std::max(1, taker_.options().tile_px), width = film().width(), height = film().height();
  const int64_t columns = (int64_t{width} + tile - 1) / tile, rows = (int64_t{height} + tile - 1) / tile;
  return run(
      columns * rows,
      [&](int64_t t, Queue& queue) {
        const int x0 = static_cast<int>(t % columns) * tile, y0 = static_cast<int>(t / columns) * tile;
        const int x1 = x0 + std::min(tile, width - x0), y1 = y0 + std::min(tile, height - y0);
        for (int y = y0; y < y1; ++y)
          for (int x = x0; x < x1; ++x)
            if (!queue.add(x, y, first, past)) return;
      },
      estimate);
}

void Passes::run_all_in_turn(uint32_t spp) {
  const auto next = [spp](uint32_t last) { return std::min(spp, std::max(last * 2, kSecondPass)); };
  for (uint32_t first = 0, last = 1; first < spp; first = last, last = next(last))
    if (!run_all(first, last)) return;
}

}  // namespace triad
