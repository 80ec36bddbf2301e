// SPDX-License-Identifier: Apache-2.0
// How a Run is organised; for run*.cpp only.
//
// Pictures between stages are LEVELS: level 0 is the input, level i+1 what filter i makes. Work happens in
// DRIVES. A drive takes the rows of one level, from the file or from a picture held in memory, strip by strip
// (a strip in flight is a TOKEN) through some filters to a sink. Most chains are a single drive. Another one
// is needed where something wants a whole level before it can go on: a stage that takes the whole picture,
// earlier passes of a stage or metric, or a stage whose overlapping needs would make others work twice.
#pragma once

#include <algorithm>
#include <atomic>
#include <optional>
#include <triad/numeric/pooling.hpp>
#include <triad/pipeline/picture_source.hpp>
#include <triad/pipeline/run.hpp>
#include <triad/pipeline/stage_node.hpp>

namespace triad {

// Rows of a metric's strip when it leaves the height to the host.
inline constexpr int kMetricStripRows = 64;

struct PictureOutput {
  int level = 0;
  std::string path;  // "": kept in memory
  ColourTransform transform;
  ImageSpec spec;  // as written
};

struct Reference {
  std::string path;
  std::unique_ptr<PictureSource> source;
};

struct MetricNode {
  StageInstance instance;
  std::string label, map_path;
  size_t reference = 0;                                      // index into Impl::references
  int test_input = 0, reference_input = 1, mask_input = -1;  // -1: not declared
  int variance_input = -1;                                   // -1: not declared, or absent
  InputBinding test_binding, reference_binding;
  StageInstance::Plan plan;
  ImageSpec map_spec;
  triad_rect pool{};  // where the map is pooled; empty: it is not
  std::atomic<int64_t> nanoseconds{0};

  explicit MetricNode(StageInstance made) : instance(std::move(made)) {}
  int strip_rows(int height) const {
    const int rows = plan.plan.strip_rows;
    return rows > 0 ? rows : rows < 0 ? height : kMetricStripRows;
  }
  bool pools() const { return pool.x0 < pool.x1 && pool.y0 < pool.y1; }
  // Whether the last pass makes a map.
  bool makes_map() const { return !map_path.empty() || pools(); }
  uint64_t pooled_values(RowRange rows) const {
    const int64_t down = std::max(0, std::min(rows.y1, pool.y1) - std::max(rows.y0, pool.y0));
    return pools() ? static_cast<uint64_t>(down) * static_cast<uint64_t>(pool.x1 - pool.x0) *
                         static_cast<uint64_t>(map_spec.channel_count())
                   : 0;
  }
};

enum class Sink {
  kHold,   // keep level `last` in memory
  kPass,   // an earlier pass of filter `last`
  kWrite,  // nothing but the outputs on the way
  kFinal   // outputs and metrics
};

struct Drive {
  int first = 0, last = 0;  // levels: filters [first, last) run in it
  Sink sink = Sink::kFinal;
  int pass = 0;              // of filter `last` (kPass) or of the metrics (kFinal)
  bool from_memory = false;  // an earlier drive held level `first`, and wrote what was to be written of it
  bool writes = false;       // the outputs at the levels it passes,
  int writes_from = 0;       // from this level on
  int token_rows = 0;        // of the sink's picture
  int sink_height = 0;
  int in_flight = 1;
  uint64_t token_bytes = 0;  // at most

  int64_t tokens() const { return (static_cast<int64_t>(sink_height) + token_rows - 1) / token_rows; }
};

struct MetricCall {
  RowRange out;
  std::vector<triad_rect> needs;  // one per input
};

struct TokenPlan {
  RowRange sink;
  std::vector<StripNeeds> stages;  // of filters first, first + 1 ... (and of `last` for kPass)
  std::vector<RowRange> rows;      // held of the levels first ... last
  std::vector<int> fresh;          // of each of these levels: the first row that no earlier token held
  std::vector<Pads> pads;
  std::vector<std::vector<MetricCall>> metrics;
  std::vector<RowRange> reference_rows;
  std::vector<Pads> reference_pads;
  RowRange mask_rows, variance_rows;
  Pads mask_pads, variance_pads;
  uint64_t bytes = 0;
};

struct Run::Impl {
  Impl(RunRequest request, PluginHost& host, const ColourConfig& colours);

  // run_plan.cpp
  void open_input();
  void add_filters(PluginHost& host);
  void add_outputs();
  void check_paths() const;
  void add_metrics(PluginHost& host);
  void add_variance(const std::string& metric, bool optional);
  void add_map(MetricNode& node, const MetricRequest& asked) const;

  // run_drives.cpp
  void plan_drives();
  int uneven_level(int first) const;
  // Two metrics and the heights of their strips, in words; "" unless strips that are whole for all of them are higher
  // than those of any. rows: what the drive's strips are made of then.
  std::string uneven_strips(const Drive& drive, int64_t* rows = nullptr) const;
  void fit_memory();
  void choose_rows(Drive& drive, int rows) const;
  // Strip n; covered: of each level, the rows that the strips before it held.
  TokenPlan plan_token(const Drive& drive, int64_t n, bool last, const std::vector<int>& covered) const;
  uint64_t estimate(const Drive& drive, const TokenPlan& token) const;
  const ImageSpec& level(int i) const { return i == 0 ? input->spec() : filters[static_cast<size_t>(i) - 1]->out(); }
  int levels() const { return static_cast<int>(filters.size()); }  // the last level's index
  bool uses_mask() const;
  // Whether this drive writes output pictures of that level.
  bool writes_at(const Drive& drive, int at) const;

  // run_execute.cpp
  class TokenPlanner;
  struct Token;
  struct Execution;
  class DriveWork;
  // In what the metric compares, as far as it has been read (run_nonfinite.cpp).
  static NonFinite nonfinite_of(const MetricNode& metric, const Execution& execution);
  RunResult execute(const std::function<void(double)>& progress);

  // run_pool.cpp
  bool pools_by_weight() const { return mask || request.metric_nan == NanPolicy::kIgnore; }
  uint64_t pool_keep_bytes() const;  // for each metric
  std::unique_ptr<Pooling> make_pooling(const MetricNode& metric) const;
  std::optional<MetricResult::Pooled> pooled_result(const MetricNode& metric, Pooling& pooling) const;

  // run_explain.cpp
  std::string explain() const;

  RunRequest request;
  const ColourConfig& colours;
  std::unique_ptr<PictureSource> input;
  FileInfo input_info;
  std::vector<std::unique_ptr<FilterNode>> filters;
  std::vector<std::string> filter_texts;
  std::vector<PictureOutput> outputs;  // taps and the last one, by level
  std::vector<Reference> references;
  std::unique_ptr<PictureSource> mask;
  std::unique_ptr<PictureSource> variance;  // of the test picture, for metrics that ask for it
  std::vector<std::unique_ptr<MetricNode>> metrics;
  std::vector<Drive> drives;
  uint64_t peak_bytes = 0;
};

// The strips of a drive, one after the other: however many there are, one plan at a time is in memory.
class Run::Impl::TokenPlanner {
 public:
  TokenPlanner(const Impl& run, const Drive& drive);
  std::optional<TokenPlan> next();  // none after the last

 private:
  const Impl& run_;
  const Drive& drive_;
  std::vector<int> covered_;  // of each level: the rows that earlier strips held
  int64_t n_ = 0;
};

}  // namespace triad
