// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/point_strategy.hpp>

namespace triad {
namespace {

constexpr size_t kBatch = 256;            // samples asked for at once: 34 kB, and .25 ms at 1 us each
constexpr uint32_t kFewestForError = 16;  // samples per pixel before an estimated error is believed
constexpr uint32_t kSecondPass = 16;      // samples per pixel after the second pass

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// What the threads of one render share.
struct Shared {
  Shared(const CountingSource& asked, Film& sums, const RenderOptions& wanted)
      : source(asked), film(sums), options(wanted) {}
  const CountingSource& source;
  Film& film;
  const RenderOptions& options;
  double expected = 0;  // samples, for progress; falls when the error estimate says that fewer will do
  std::atomic<bool> stopped{false};
  std::mutex mutex;  // guards what follows, and calls of options.progress
  uint64_t dropped = 0;
  size_t first_dropped = SIZE_MAX;  // pixel

  bool stop() {
    if (!stopped && options.stop && options.stop()) stopped = true;
    return stopped;
  }
  void tell_progress() {
    if (!options.progress) return;
    const std::unique_lock lock(mutex, std::try_to_lock);
    if (lock) options.progress(std::min(1., static_cast<double>(source.samples()) / expected));
  }
};

using Place = std::function<void(std::span<SampleRequest>)>;

// Requests of one thread, and where their answers go.
class Batch {
 public:
  Batch(Shared& shared, Place place) : shared_(shared), place_(std::move(place)) {
    requests_.resize(kBatch);
    samples_.resize(kBatch);
  }
  size_t room() const { return kBatch - size_; }
  void add(const SampleRequest& request) { requests_[size_++] = request; }
  // False: the render was stopped, and the batch is lost.
  bool flush() {
    if (shared_.stop()) return false;
    const std::span<SampleRequest> asked(requests_.data(), size_);
    place_(asked);
    const std::span<Sample> answers(samples_.data(), size_);
    shared_.source.eval(asked, answers);
    for (const size_t left_out : shared_.film.add(asked, answers)) {
      const size_t pixel = shared_.film.pixel(asked[left_out].pixel_x, asked[left_out].pixel_y);
      const std::lock_guard lock(shared_.mutex);
      ++shared_.dropped;
      shared_.first_dropped = std::min(shared_.first_dropped, pixel);
    }
    size_ = 0;
    shared_.tell_progress();
    return true;
  }

 private:
  Shared& shared_;
  Place place_;
  std::vector<SampleRequest> requests_;
  std::vector<Sample> samples_;
  size_t size_ = 0;
};

}  // namespace

std::string PointStrategy::text() const {
  std::string text = info_.name;
  char separator = ':';
  for (const StrategyParam& param : info_.params) {
    text += separator + param.name + "=" + std::to_string(values_.at(param.name));
    separator = ',';
  }
  return text;
}

uint64_t PointStrategy::most_samples(int width, int height) const {
  return uint64_t{samples_per_pixel()} * static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
}

RenderResult PointStrategy::render(const Source& source, const RenderOptions& options) const {
  if (options.until_rmse > 0 && !estimates_error())
    throw_usage("the strategy '" + info_.name +
                "' takes the same points each time, from which no error can be estimated; take sobol-owen");
  const CountingSource counted(source);
  const int width = source.width(), height = source.height();
  FilmPlanes planes = options.planes;
  if (options.until_rmse > 0) planes.error = true;
  planes.error = planes.error && estimates_error();
  RenderResult result{.film = Film(width, height, planes), .passes = {}};
  Shared shared(counted, result.film, options);
  shared.expected = static_cast<double>(most_samples(width, height));

  const int tile = std::max(1, options.tile_px);
  const int64_t columns = (int64_t{width} + tile - 1) / tile, rows = (int64_t{height} + tile - 1) / tile;
  const uint32_t spp = samples_per_pixel();
  const float footprint = 1 / std::sqrt(static_cast<float>(spp));
  const auto next = [spp](uint32_t last) { return std::min(spp, std::max(last * 2, kSecondPass)); };
  for (uint32_t first = 0, last = 1; first < spp && !shared.stopped; first = last, last = next(last)) {
    const double start_s = now_s();
    const uint64_t before = counted.samples();
    parallel_for(columns * rows, [&](int64_t t) {
      const int x0 = static_cast<int>(t % columns) * tile, y0 = static_cast<int>(t / columns) * tile;
      const int x1 = x0 + std::min(tile, width - x0), y1 = y0 + std::min(tile, height - y0);
      Batch batch(shared, [this](std::span<SampleRequest> requests) { place(requests); });
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x)
          for (uint32_t i = first; i < last; ++i) {
            if (batch.room() == 0 && !batch.flush()) return;
            batch.add({0, 0, footprint, x, y, i, options.seed});
          }
      batch.flush();
    });
    PassRecord pass{counted.samples() - before, now_s() - start_s};
    if (planes.error && !shared.stopped) {
      pass.rmse = result.film.estimated_rmse();
      if (options.until_rmse > 0 && last >= kFewestForError) {
        result.reached = pass.rmse <= options.until_rmse;
        // Without stratification an error falls with the root of the samples; with it, faster.
        const double ratio = pass.rmse / options.until_rmse;
        shared.expected =
            std::min(shared.expected, static_cast<double>(counted.samples()) * std::max(1., ratio * ratio));
      }
    }
    result.passes.push_back(pass);
    if (result.reached) break;
  }
  result.samples = counted.samples();
  result.dropped = shared.dropped;
  if (shared.dropped > 0) {
    result.dropped_x = static_cast<int>(shared.first_dropped % static_cast<size_t>(width));
    result.dropped_y = static_cast<int>(shared.first_dropped / static_cast<size_t>(width));
  }
  result.complete = !shared.stopped;
  return result;
}

}  // namespace triad
