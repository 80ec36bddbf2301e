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
// throws Error(kInput) only when `path` cannot be examined at all (no process or pipe to be had), and
// Error(kUsage) when stage_params cannot be read.
//
// The child is made by fork() without exec: call this before the process has started other threads, such as
// those of the first parallel loop; a lock one of them held would stay held in the child.
//
// `stage_params`: "key=value,..." to use for every stage in the file that has these parameters. Required
// parameters that are not among them are guessed from type and range.
//
// Rules beyond those that PluginError carries elsewhere (file.*, symbol.*, record.*, plan.*, need.*, score.*,
// create.null-instance, call.exception, call.status ...):
//   call.crash, call.exit, call.hang        the child's end, with the function it was in
//   call.stdout, call.locale, call.signal-handlers, float.control-word   what a plugin must leave alone
//   pixels.writes-past-strip, pixels.unwritten, pixels.writes-input, pixels.reads-past-input
//   pixels.depends-on-split, pixels.not-repeatable, threads.race, state.writes-past-end
//   stage.accepts                           skipped: create() or plan() took none of the pictures offered
std::vector<CheckResult> check_plugin(const std::string& path, const std::string& stage_params = "",
                                      double time_limit_s = 20);

}  // namespace triad
