// SPDX-License-Identifier: Apache-2.0
// One drive of a Run at work; for run*.cpp only.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <triad/pipeline/run_impl.hpp>

namespace triad {

// A strip in flight.
struct Run::Impl::Token {
  std::optional<TokenPlan> plan;
  StripBuffer current;
  std::vector<StripBuffer> references;
  StripBuffer mask, variance;
  std::vector<std::pair<size_t, StripBuffer>> to_write;  // index into outputs
  std::vector<std::vector<StageState>> states;           // per metric, per call; one list for a filter's pass
  std::vector<std::vector<StageState>> filter_states;    // per filter of the drive, of its last pass
  std::vector<StripBuffer> maps;
};

// What the drives of one execution share.
struct Run::Impl::Execution {
  BufferPool pool;
  std::vector<std::unique_ptr<ImageWriter>> writers;  // one per output
  std::vector<std::unique_ptr<ImageWriter>> map_writers;
  std::vector<std::unique_ptr<Pooling>> poolings;  // per metric, or none
  StageState state;                                // of a filter's pass
  std::vector<StageState> metric_states;
  std::vector<bool> failed;  // metrics, over values that are not finite
  std::vector<NonFinite> nonfinite_of_references;
  NonFinite nonfinite_of_test, nonfinite_of_variance, input_nonfinite;
  std::vector<std::unique_ptr<std::atomic<int64_t>>> filter_ns;
  std::mutex mutex;  // of the counts below
  std::vector<NonFinite> replaced;
  std::unique_ptr<Image> held;
  std::unique_ptr<PictureSource> held_source;
  std::unique_ptr<Image> next_held;
  std::shared_ptr<Image> kept;  // with keep_picture
  std::function<void(double)> progress;
  int64_t tokens_done = 0, tokens_total = 0;
  RunResult result;
};

// The steps that a strip goes through. They work on different strips at the same time, except read() and
// merge_and_write(), which see the strips one by one from top to bottom.
class Run::Impl::DriveWork {
 public:
  DriveWork(Impl& impl, const Drive& drive, Execution& run);
  // All strips, and what comes after the last.
  void operator()();

 private:
  struct Step {
    bool serial;
    std::function<void(Token&)> work;
  };

  // run_read.cpp
  // The rows that the strip needs of all pictures, which are decoded side by side.
  void read(Token& token);
  void read_input(Token& token);
  void read_mask(Token& token);

  // run_nonfinite.cpp
  // Values that are not finite in what the metrics compare: counted once, weighted out, replaced by 0.
  void examine(Token& token);
  void count_nonfinite_values(const Token& token);
  void leave_out_nonfinite(Token& token) const;
  NonFinite pooled_nonfinite(const Token& token, const StripBuffer& buffer, const ImageSpec& spec,
                             RowRange rows) const;

  // run_stages.cpp
  // What is to be written of a level, encoded for its file. `last_use`: nobody reads the strip after this.
  void keep_for_writing(Token& token, int at, bool last_use);
  void run_filter(Token& token, int at);
  void run_metric(Token& token, size_t m);
  void pool_map(const MetricNode& metric, const Token& token, const StripBuffer& map, Pooling& pooling) const;

  // run_drive.cpp
  std::vector<Step> steps();
  void merge_and_write(Token& token);
  void finish();

  Impl& impl_;
  const Drive& drive_;
  Execution& run_;
  PictureSource& source_;
  const ImageSpec& sink_spec_;
  bool final_sink_, counts_;
  std::vector<StageState> filter_totals_;  // of the last pass of each filter that is not the sink
};

// Adds the time of a scope to a counter of nanoseconds.
class ScopedNanoseconds {
 public:
  explicit ScopedNanoseconds(std::atomic<int64_t>& sum) : sum_(sum), start_(Clock::now()) {}
  ~ScopedNanoseconds() {
    sum_ += std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::atomic<int64_t>& sum_;
  Clock::time_point start_;
};

// Counts the values of some rows that are not finite, and replaces them by 0 if asked to.
NonFinite treat_nonfinite(const StripBuffer& buffer, RowRange rows, bool zero);
StripBuffer copy_of(BufferPool& pool, const StripBuffer& from, RowRange rows, const Pads& pads);

}  // namespace triad
