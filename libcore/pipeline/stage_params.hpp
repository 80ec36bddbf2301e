// SPDX-License-Identifier: Apache-2.0
// A stage's parameters: from the user's text to checked values.
#pragma once

#include <triad/abi/triad_plugin.h>

#include <deque>
#include <string>
#include <triad/pipeline/plugin_host.hpp>
#include <utility>
#include <vector>

namespace triad {

// The values in the table's order, as create() takes them. Owns what they point to; so do not copy.
//
// Texts: TRIAD_BOOL true false yes no on off 1 0; TRIAD_INT and TRIAD_FLOAT a finite number in range;
// TRIAD_CHOICE one of its names; TRIAD_FLOATS numbers with commas or blanks between them, "" for none.
class StageParams {
 public:
  // Throws Error(kUsage) that names the stage, the parameter, what is wrong and what would be right.
  StageParams(const StageInfo& info, const ParamTexts& texts);
  StageParams(const StageParams&) = delete;
  StageParams& operator=(const StageParams&) = delete;

  const triad_value* values() const { return values_.data(); }
  // name -> text of every parameter, given or default, in the table's order.
  const std::vector<std::pair<std::string, std::string>>& texts() const { return texts_; }
  // "id:name=text,..." of the given ones, quoted where a text holds a separator.
  const std::string& summary() const { return summary_; }

 private:
  triad_value parse(const StageInfo& info, const triad_param& param, const std::string& text);

  std::vector<triad_value> values_;
  std::vector<std::pair<std::string, std::string>> texts_;
  std::string summary_;
  std::deque<std::string> strings_;
  std::deque<std::vector<double>> lists_;
};

// "1 to 64 px", "above 0", "at most 3", "" for no limit.
std::string range_text(const triad_param& param);
// A value as the user would write it.
std::string value_text(const triad_param& param, const triad_value& value);

}  // namespace triad
