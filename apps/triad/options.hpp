// SPDX-License-Identifier: Apache-2.0
// Options that several verbs share.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <triad/colour/colour.hpp>
#include <triad/evaluation/results.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/run.hpp>
#include <vector>

namespace triad::app {

// Where plugins and colours come from.
struct HostOptions {
  std::vector<std::string> plugin_path;
  std::string ocio;

  void add_plugin_path(CLI::App& verb);
  void add_ocio(CLI::App& verb);
};

// How pictures are read and the work is cut.
struct PictureOptions {
  std::string cells, ref_cells, from, ref_from, to, part, channels, max_memory;
  int threads = 0, strip_rows = 0;

  void add(CLI::App& verb, const std::string& to_doc);
  ReadOptions read() const;
  ReadOptions read_reference() const;
  // Threads and memory take effect here. Throws Error(kUsage).
  void apply(RunRequest& request) const;
};

// Metrics and what becomes of their scores.
struct MetricOptions {
  std::vector<std::string> metrics, references, fail_above, fail_below;
  std::string json, csv, map, crop, mask;

  void add(CLI::App& verb);
  std::vector<Threshold> thresholds() const;
  void apply(RunRequest& request) const;
};

// The path of the map of one test picture and metric; "" if none is wanted. `many`: there are several.
std::string map_path(const std::string& map, const std::string& test, const std::string& label, bool many);

NanPolicy parse_nan(const std::string& text, const std::vector<std::string>& allowed);

// Prints tables, JSON and CSV as asked for, then the failures on stderr. Returns 0 or 1.
int report(const MetricOptions& options, const std::vector<Threshold>& thresholds,
           const std::vector<MetricResult>& results, const std::vector<RunRecord>& runs);

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
