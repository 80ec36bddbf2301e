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
  StageReports reports;
  NonFinite nonfinite;  // in test and reference together
  bool nonfinite_failed = false;
  double seconds = 0;  // in the metric's code, summed over threads
};

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
