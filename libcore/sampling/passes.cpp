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
constexpr double kFewestForError = 16;  // samples per pixel before an estimated error is believed

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

FilmPlanes planes_for(const Strategy& strategy, const RenderOptions& options) {
  if (options.until_rmse > 0 && !strategy.estimates_error())
    throw_usage("the strategy '" + strategy.info().name +
                "' takes the same points each time, from which no error can be estimated; take sobol-owen");
  FilmPlanes planes = options.planes;
  planes.error = strategy.estimates_error() && (planes.error || options.until_rmse > 0);
  return planes;
}

}  // namespace

Passes::Passes(const Strategy& strategy, const Source& source, const RenderOptions& options, float footprint_px,
               Place place)
    : source_(source),
      options_(options),
      footprint_px_(footprint_px),
      place_(std::move(place)),
      result_{.film = Film(source.width(), source.height(), planes_for(strategy, options)), .passes = {}},
      expected_(static_cast<double>(strategy.most_samples(source.width(), source.height()))) {}

bool Passes::stop() {
  if (!stopped_ && options_.stop && options_.stop()) stopped_ = true;
  return stopped_;
}

void Passes::tell_progress() {
  if (!options_.progress) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (lock) options_.progress(std::min(1., static_cast<double>(samples()) / expected_));
}

void Passes::expect(double samples) { expected_ = std::min(expected_, samples); }

Passes::Queue::Queue(Passes& passes) : passes_(passes), requests_(kBatch), samples_(kBatch) {}

bool Passes::Queue::add(int x, int y, uint32_t first, uint32_t past) {
  for (uint32_t i = first; i < past; ++i) {
    if (size_ == kBatch && !flush()) return false;
    requests_[size_++] = {0, 0, passes_.footprint_px_, x, y, i, passes_.options_.seed};
  }
  return true;
}

bool Passes::Queue::flush() {
  if (passes_.stop()) return false;
  const std::span<SampleRequest> asked(requests_.data(), size_);
  passes_.place_(asked);
  const std::span<Sample> answers(samples_.data(), size_);
  passes_.source_.eval(asked, answers);
  RenderResult& result = passes_.result_;
  for (const size_t left_out : result.film.add(asked, answers)) {
    const size_t pixel = result.film.pixel(asked[left_out].pixel_x, asked[left_out].pixel_y);
    const std::lock_guard lock(passes_.mutex_);
    ++result.dropped;
    passes_.first_dropped_ = std::min(passes_.first_dropped_, pixel);
  }
  size_ = 0;
  passes_.tell_progress();
  return true;
}

bool Passes::run(int64_t groups, const std::function<void(int64_t, Queue&)>& fill, bool estimate) {
  const double start_s = now_s();
  const uint64_t before = samples();
  parallel_for(groups, [&](int64_t group) {
    Queue queue(*this);
    fill(group, queue);
    queue.flush();
  });
  PassRecord pass{samples() - before, now_s() - start_s};
  if (estimate && film().planes().error && !stopped_) {
    pass.rmse = film().estimated_rmse();
    if (options_.until_rmse > 0 &&
        static_cast<double>(samples()) >= kFewestForError * static_cast<double>(film().pixels())) {
      result_.reached = pass.rmse <= options_.until_rmse;
      // Without stratification an error falls with the root of the samples; with it, faster.
      const double ratio = pass.rmse / options_.until_rmse;
      expect(static_cast<double>(samples()) * std::max(1., ratio * ratio));
    }
  }
  result_.passes.push_back(pass);
  return !stopped_ && !result_.reached;
}

bool Passes::run_all(uint32_t first, uint32_t past, bool estimate) {
  const int tile = std::max(1, options_.tile_px), width = film().width(), height = film().height();
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

RenderResult Passes::finish() {
  result_.samples = samples();
  if (result_.dropped > 0) {
    const auto width = static_cast<size_t>(film().width());
    result_.dropped_x = static_cast<int>(first_dropped_ % width);
    result_.dropped_y = static_cast<int>(first_dropped_ / width);
  }
  result_.complete = !stopped_;
  if (result_.complete && film().planes().error && !result_.passes.empty() && std::isnan(result_.passes.back().rmse))
    result_.passes.back().rmse = film().estimated_rmse();
  if (result_.complete && options_.progress) options_.progress(1);
  return std::move(result_);
}

}  // namespace triad
