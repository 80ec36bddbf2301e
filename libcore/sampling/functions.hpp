// SPDX-License-Identifier: Apache-2.0
// Functions with known integrals by name, as sources for strategies: "zone-plate", "checker:cell=3.7,angle=12".
#pragma once

#include <memory>
#include <string>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/strategy.hpp>
#include <vector>

namespace triad {

// The same kind of name, summary, doc and parameters as strategies have.
using FunctionInfo = StrategyInfo;

// All functions, in the order in which they are listed.
std::vector<const FunctionInfo*> function_list();
// Throws Error(kUsage) naming `option`, the function or parameter, and what would be right. The film has width_px *
// cells.x by height_px * cells.y pixels, both below 2^31, and shows the same picture whatever the cells.
std::unique_ptr<Source> make_function(const std::string& text, int width_px, int height_px, const Cells& cells,
                                      const std::string& option);
// "checker:cell=3.7,angle=12,rows=0,low=0,high=1": every parameter, as make_function() reads it.
std::string function_text(const std::string& text, const std::string& option);

}  // namespace triad
