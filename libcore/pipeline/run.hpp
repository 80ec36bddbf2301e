// SPDX-License-Identifier: Apache-2.0
// A chain at work: a picture file in, filters, a picture file out, metrics on what comes out.
//
//   PluginHost host;
//   const ColourConfig colours = ColourConfig::load();
//   RunRequest request;
//   request.input.path = "wide.exr";
//   request.stages = {parse_stage("platt:ppd=40")};
//   request.output = "out.png";
//   Run(request, host, colours).execute();
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <triad/colour/colour.hpp>
#include <triad/image/reader.hpp>
#include <triad/image/writer.hpp>
#include <triad/pipeline/chain.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/strip_buffer.hpp>
#include <vector>

namespace triad {

// What to do about values that are not finite.
enum class NanPolicy {
  kKeep,    // leave them; stages whose support is a row or the picture replace them by 0, count and warn
  kFail,    // run: an error; compare: the comparison fails
  kZero,    // replace by 0
  kIgnore,  // metrics: leave the pixel out of the pooling
};

struct PictureRequest {
  std::string path;
  ReadOptions read;
  // The picture itself, in place of a file: then `path` is its name in messages, different for different pictures,
  // and `read` counts for nothing. Its colour_space is a name of the colour configuration, or "".
  std::shared_ptr<const Image> image = nullptr;
};

struct MetricRequest {
  ChainItem item;
  PictureRequest reference;
  std::string map_path;  // "" none
  // A pooled score that somebody named, as in "--fail-above 'flip.p95=0.2'": the Run refuses a metric that makes no
  // map to pool it from, and names this. "" none. RunRequest::pool must be set beside it.
  std::string pooled_by_name = {};
};

struct CropRequest {
  int x = 0, y = 0, width = 0, height = 0;
};

struct RunRequest {
  PictureRequest input;
  std::vector<ChainItem> stages;
  std::string output;         // "" none
  bool keep_picture = false;  // what comes out of the chain, as it is, goes to RunResult::picture
  std::string output_space;   // --to; "" by format
  WriteOptions write;
  std::vector<MetricRequest> metrics;
  bool pool = false;                // MetricResult::pooled of every metric that makes a map of errors
  std::optional<CropRequest> crop;  // pooling is inside; of the metrics' test picture
  // The space in which metrics that take pictures as they are see both of them; "" linear light.
  std::string metric_space;
  std::string mask;                         // a picture whose first channel weights the pooling; "" none
  NanPolicy nan = NanPolicy::kKeep;         // of the input
  NanPolicy metric_nan = NanPolicy::kFail;  // of the metrics' inputs
  int strip_rows = 0;                       // 0: chosen by size
  uint64_t max_memory = 0;                  // bytes; 0: half of the machine's memory
};

struct MetricResult {
  std::string test;  // the chain's input; what is judged is what comes out of the chain, before it is stored
  std::string reference, metric, label;
  std::vector<std::pair<std::string, std::string>> parameters;
  struct Score {
    std::string name, unit;
    double value = 0;
    int better = -1;  // -1 lower, 0 nearer to zero, 1 higher
  };
  std::vector<Score> scores;  // empty when the comparison failed over values that are not finite

  // What the metric's map holds, where the plan of the metric says that it is to be pooled; of a map of three
  // channels each channel's value counts. Weights are those of the mask, in steps of 1/65535; without a mask all
  // are 1. Every number is exact but for its own rounding to double, and the same whatever the threads and strips.
  struct Pooled {
    // Those of pooled_score_names(), in that order. pN: the smallest value v for which the values <= v have N % of
    // the whole weight. weighted-pN: values sorted, the value at which their running sum (each times its weight)
    // reaches N % of the whole sum, so that large errors count for more; 0 when the sum is 0, left out when the map
    // holds negative values. better: of the metric's first score that is bounded and has a better side, else lower.
    std::vector<Score> scores;
    struct Place {
      int x = 0, y = 0, channel = 0;  // the first in reading order
    } min_at, max_at;
    // Bins of equal width from min(0, least) to max(0, largest finite value), in weight; a value on a border is in
    // the bin above, the largest in the last. Infinities are in the first and last.
    struct Histogram {
      double low = 0, high = 0;
      std::vector<double> counts;
    } histogram;
    uint64_t values = 0;  // whose weight is not 0
    double weight = 0;    // of all of them
  };
  std::optional<Pooled> pooled;  // none without RunRequest::pool, a map, or a pixel to pool
  StageReports reports;
  NonFinite nonfinite;  // in test and reference together
  bool nonfinite_failed = false;
  double seconds = 0;  // in the metric's code, summed over threads
};

// mean, min, p5, p25, p50, p75, p95, p99, max, weighted-p5 ... weighted-p99.
const std::vector<std::string>& pooled_score_names();

struct RunResult {
  std::vector<MetricResult> metrics;
  struct Stage {
    std::string text;    // "platt:ppd=40"
    double seconds = 0;  // in the stage's code, summed over threads
    StageReports reports;
  };
  std::vector<Stage> stages;
  std::shared_ptr<const Image> picture;  // with RunRequest::keep_picture
  NonFinite input_nonfinite;             // counted with kFail and kZero
  double seconds = 0;                    // from first read to last rename
};

// Not thread-safe; execute() uses all threads of thread_limit().
class Run {
 public:
  // Opens the inputs' headers, plans every stage and every strip. Reads no pixel, writes no file. `host` and
  // `colours` must outlive it. Throws Error.
  Run(RunRequest request, PluginHost& host, const ColourConfig& colours);
  ~Run();

  // The plan for people: inputs, stages, colour transforms, strips, passes, peak memory.
  std::string explain() const;
  uint64_t peak_memory() const;
  // The header of RunRequest::output's file, which the request must name.
  const ImageSpec& output_spec() const;
  // progress: share done in [0, 1], called now and then from one thread at a time. Once only. Throws Error;
  // then no output file exists that did not exist before.
  RunResult execute(const std::function<void(double)>& progress = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace triad
