// SPDX-License-Identifier: Apache-2.0
// The half of `triad plugin check` that runs in the child process.
#pragma once

#include <string>
#include <triad/pipeline/plugin_host.hpp>

namespace triad {

// Findings, one line each, on a pipe to the parent: kind, rule, stage, message, separated by tabs. Kinds:
// 'F' failed, 'P' passed, 'S' skipped, 'M' a mark: what is about to be done, 'D' done.
class ProbeReport {
 public:
  explicit ProbeReport(int descriptor) : descriptor_(descriptor) {}
  void send(char kind, const std::string& rule, const std::string& stage, const std::string& message);

 private:
  int descriptor_;
};

// Loads `path`, exercises every stage and reports. Ends the process.
[[noreturn]] void probe_plugin(const std::string& path, const ParamTexts& params, int report_descriptor);

}  // namespace triad
