// SPDX-License-Identifier: Apache-2.0
// What people type to choose one of several things with parameters: "grid:n=4", "checker:cell=3.7,angle=12".
#pragma once

#include <map>
#include <string>
#include <triad/sampling/strategy.hpp>
#include <vector>

namespace triad {

using StrategyValues = std::map<std::string, double>;  // one for each parameter, in range

struct Chosen {
  size_t place = 0;  // in the list
  StrategyValues values;
};

// Reads "name" or "name:key=value,...". `kind` is what the list holds: "strategy". Throws Error(kUsage) naming
// `option`, the name or parameter, and what would be right.
Chosen choose_named(const std::string& kind, const std::vector<const StrategyInfo*>& list, const std::string& text,
                    const std::string& option);
// "grid:n=4": every parameter, as choose_named() reads it.
std::string named_text(const StrategyInfo& info, const StrategyValues& values);

}  // namespace triad
