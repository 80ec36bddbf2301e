// SPDX-License-Identifier: Apache-2.0
// `triad plugin check`: does a plugin keep the rules of triad_plugin.h?
#pragma once

#include <string>
#include <vector>

namespace triad {

struct CheckResult {
  std::string rule;   // a stable short name: "file.elf-class", "record.magic", "pixels.writes-past-strip" ...
  std::string stage;  // the stage's id, or "" for the file
  bool passed = false;
  bool skipped = false;  // e.g. a stage whose required parameters cannot be guessed
  std::string message;   // what was found, and what would be right
};

// Checks the file statically, then loads and exercises it in a child process with a time limit, so that a
// crash, an exit() or a hang is a finding and not the end of the caller. Never throws for what a plugin does;
// throws Error(kInput) only when `path` cannot be examined at all.
//
// `stage_params`: "key=value,..." to use for every stage in the file that has these parameters.
std::vector<CheckResult> check_plugin(const std::string& path, const std::string& stage_params = "",
                                      double time_limit_s = 20);

}  // namespace triad
