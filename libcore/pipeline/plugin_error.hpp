// SPDX-License-Identifier: Apache-2.0
// A rule of triad_plugin.h that a plugin broke.
#pragma once

#include <string>
#include <triad/base/error.hpp>

namespace triad {

// The message names the file, the stage where there is one, what was wrong, and ends with the rule in
// brackets: "plugin file '/x/a.triad.so': it is empty [file.empty]",
// "plugin 'box' (/x/box.triad.so): plan() gave a width of -1 [plan.size]".
class PluginError : public Error {
 public:
  PluginError(std::string rule, const std::string& stage, const std::string& file, std::string what_was_wrong);

  // Stable: "file.elf-class", "record.magic", "plan.size" ...
  const std::string& rule() const { return rule_; }
  // The message without file, stage and rule.
  const std::string& finding() const { return finding_; }

 private:
  std::string rule_, finding_;
};

}  // namespace triad
