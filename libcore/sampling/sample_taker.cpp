// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/sample_taker.hpp>

namespace triad {
namespace {

constexpr size_t kBatch = 256;  // samples asked for at once: 34 kB, and .25 ms at 1 us each

FilmPlanes planes_for(const Strategy& strategy, const RenderOptions& options) {
  if (options.until_rmse > 0 && !strategy.estimates_error())
    throw_usage("the strategy '" + strategy.info().name +
                "' has no independent samples in each pixel, from which an error can be estimated; take sobol-owen");
  FilmPlanes planes = options.planes;
  planes.error = strategy.estimates_error() && (planes.error || options.until_rmse > 0);
  return planes;
}

}  // namespace

bool usable(const Sample& sample) {
  return sample.valid && std::isfinite(sample.rgb[0]) && std::isfinite(sample.rgb[1]) && std::isfinite(sample.rgb[2]);
}

SampleTaker::SampleTaker(const Strategy& strategy, const Source& source, const RenderOptions& options,
                         Film::Holds holds)
    : source_(source),
      options_(options),
      result_{.film = Film(source.width(), source.height(), planes_for(strategy, options), holds), .passes = {}},
      expected_(static_cast<double>(strategy.most_samples(source.width(), source.height()))),
      pass_start_(std::chrono::steady_clock::now()) {}

bool SampleTaker::stop() {
  if (!stopped_ && options_.stop && options_.stop()) stopped_ = true;
  return stopped_;
}

void SampleTaker::tell_progress() {
  if (!options_.progress) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (lock) options_.progress(std::min(1., static_cast<double>(samples()) / expected_));
}

void SampleTaker::expect(double samples) { expected_ = std::min(expected_, samples); }

void SampleTaker::drop(int32_t pixel_x, int32_t pixel_y) {
  const int x = std::clamp(pixel_x, 0, film().width() - 1);
  const int y = std::clamp(pixel_y, 0, film().height() - 1);
  const std::lock_guard lock(mutex_);
  ++result_.dropped;
  first_dropped_ = std::min(first_dropped_, film().pixel(x, y));
}

bool SampleTaker::ask(std::span<const SampleRequest> requests, std::span<Sample> samples) {
  const size_t batches = (requests.size() + kBatch - 1) / kBatch;
  parallel_for(static_cast<int64_t>(batches), [&](int64_t batch) {
    const size_t first = static_cast<size_t>(batch) * kBatch, count = std::min(kBatch, requests.size() - first);
    take(requests.subspan(first, count), samples.subspan(first, count), false);
  });
  if (stopped_) return false;
  film().add(requests, samples);
  return true;
}

bool SampleTaker::take(std::span<const SampleRequest> requests, std::span<Sample> samples, bool keep) {
  if (stop()) return false;
  source_.eval(requests, samples);
  const int width = film().width(), height = film().height();
  const auto inside = [&](const SampleRequest& r) {
    return r.pixel_x >= 0 && r.pixel_x < width && r.pixel_y >= 0 && r.pixel_y < height;
  };
  size_t run = 0;  // samples from here on are to be kept, together
  for (size_t i = 0; i <= requests.size(); ++i) {
    if (i < requests.size()) {
      samples[i].valid = usable(samples[i]);
      if (!samples[i].valid) drop(requests[i]);
      if (!keep || inside(requests[i])) continue;
    }
    if (keep && i > run) film().add(requests.subspan(run, i - run), samples.subspan(run, i - run));
    run = i + 1;
  }
  tell_progress();
  return true;
}

bool SampleTaker::add(std::span<const SampleRequest> requests, std::span<Sample> samples, const FilmRows& rows,
                      const Weigh& weigh) {
  if (stop()) return false;
  source_.eval(requests, samples);
  if (weigh) weigh(requests, samples);
  keep(requests, samples, rows);
  return true;
}

void SampleTaker::keep(std::span<const SampleRequest> requests, std::span<const Sample> samples,
                       const FilmRows& rows) {
  for (const size_t left_out : film().add(requests, samples, rows)) drop(requests[left_out]);
  tell_progress();
}

PassRecord& SampleTaker::end_pass() {
  const auto now = std::chrono::steady_clock::now();
  result_.passes.push_back({samples() - pass_samples_, std::chrono::duration<double>(now - pass_start_).count()});
  pass_start_ = now;
  pass_samples_ = samples();
  return result_.passes.back();
}

RenderResult SampleTaker::finish() {
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
