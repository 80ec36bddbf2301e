// SPDX-License-Identifier: Apache-2.0
// What benchmarks measure with.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <ctime>
#include <triad/sampling/source.hpp>
#include <vector>

namespace triad::bench {

// Seconds of the processor, summed over this process's threads or of this one: they leave out what other programs
// take.
inline double processor_s(clockid_t clock = CLOCK_PROCESS_CPUTIME_ID) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Of at least one value; of an even number the upper of the middle two.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Adds up the time that threads spend in another source, and what the asking for time takes itself. It is the time
// that passes, so have a processor for each thread: the kernel would be asked for a thread's own time, at a price
// and with effects on caches that are a tenth of the cheapest batches.
class TimedSource final : public Source {
 public:
  explicit TimedSource(const Source& source) : source_(source), clock_s_(one_call_s()) {}
  int width() const override { return source_.width(); }
  int height() const override { return source_.height(); }
  SourceAbilities abilities() const override { return source_.abilities(); }
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const override {
    const double start_s = processor_s(CLOCK_MONOTONIC);
    source_.eval(requests, samples);
    ns_ += static_cast<int64_t>(1e9 * (processor_s(CLOCK_MONOTONIC) - start_s));
    ++batches_;
  }
  // In the source.
  double inside_s() const { return 1e-9 * static_cast<double>(ns_) - clock_s_ * static_cast<double>(batches_); }
  // In this class, inside and outside of what was measured.
  double clocks_s() const { return 2 * clock_s_ * static_cast<double>(batches_); }

 private:
  static double one_call_s() {
    constexpr int kCalls = 20000;
    const double start_s = processor_s(CLOCK_MONOTONIC);
    double last_s = start_s;
    for (int i = 0; i < kCalls; ++i) last_s = processor_s(CLOCK_MONOTONIC);
    return (last_s - start_s) / kCalls;
  }

  const Source& source_;
  const double clock_s_;
  mutable std::atomic<int64_t> ns_{0}, batches_{0};
};

}  // namespace triad::bench
