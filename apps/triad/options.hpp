// SPDX-License-Identifier: Apache-2.0
// Options that several verbs share.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <triad/colour/colour.hpp>
#include <triad/evaluation/results.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/run.hpp>
#include <vector>

#include "maps.hpp"

namespace triad::app {

// Refuses an empty text.
const CLI::Validator& not_empty();

// Where plugins and colours come from.
struct HostOptions {
  std::vector<std::string> plugin_path;
  std::string ocio;

  void add_plugin_path(CLI::App& verb);
  void add_ocio(CLI::App& verb);
};

// How pictures are read and the work is cut.
struct PictureOptions {
  std::string cells, ref_cells, from, ref_from, to, part, ref_part, channels, ref_channels, layer, ref_layer,
      max_memory;
  int threads = 0, strip_rows = 0;

  void add(CLI::App& verb, const std::string& to_doc);
  // Whether an option was given that only a reference has a use for.
  bool names_reference() const;
  ReadOptions read() const;
  ReadOptions read_reference() const;
  // Threads and memory take effect here. Throws Error(kUsage).
  void apply(RunRequest& request) const;
};

// Metrics and what becomes of their scores.
struct MetricOptions {
  std::vector<std::string> metrics, references, fail_above, fail_below;
  std::string json, csv, crop, mask, pool;
  MapOptions maps;

  void add(CLI::App& verb, const std::string& reference_doc);
  std::vector<Threshold> thresholds() const;
  void apply(RunRequest& request) const;
  // The pooled scores that --pool and thresholds name, which must have passed check_threshold_names(). Throws
  // Error(kUsage).
  std::vector<PooledName> pooled(const std::vector<ChainItem>& metric_items, PluginHost& host) const;
  // Throws before the work what would otherwise be found after it: a results file that cannot be written, or
  // that is one of `others` or named twice.
  void check_outputs(const std::vector<std::string>& others) const;
};

// Bytes, of --max-memory's text. Throws Error(kUsage).
uint64_t parse_memory(const std::string& text);
NanPolicy parse_nan(const std::string& text, const std::vector<std::string>& allowed);

// Whether `path` (""/"-": none, standard output) can be written for `option` and is none of `others`, the files that
// this call reads or writes already ("" is none). Throws Error(kUsage), or Error(kInput) naming the path.
void check_report_file(const std::string& option, const std::string& path, const std::vector<std::string>& others);

// Why a picture has no scores. policies: those of the verb's --nan that would give it some.
std::string nonfinite_refusal(const NonFinite& found, const std::vector<std::string>& policies);
// Prints tables, JSON and CSV as asked for, then the failures on stderr. Returns 0 or 1.
int report(const MetricOptions& options, const std::vector<Threshold>& thresholds,
           const std::vector<PooledName>& pooled, const std::vector<MetricResult>& results,
           const std::vector<RunRecord>& runs, const std::vector<std::string>& policies);
// The failures alone: a line for each picture that holds NaN and for each threshold crossed.
int report_failures(const std::vector<Threshold>& thresholds, const std::vector<MetricResult>& results,
                    const std::vector<std::string>& policies);

// One of several pictures: an error with it is said at once, sets the exit status and lets the others go on;
// Ctrl-C and defects end all. Returns whether the work was done. With several = false errors pass through.
bool attempt(bool several, const std::function<void()>& work);

// A bar on stderr while it is a terminal; nothing otherwise. Use from one thread.
class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress();
  void update(double done);

 private:
  std::string what_;
  bool terminal_ = false;
  double start_s_ = 0, last_s_ = 0;
  bool shown_ = false;
};

}  // namespace triad::app
