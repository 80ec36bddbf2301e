// SPDX-License-Identifier: Apache-2.0
// The report's page, which apps/viewer builds.
#pragma once

#include <string_view>

namespace triad::app {

// HTML with places for %triad-title%, %triad-facts%, %triad-tables% and %triad-data%; "" in a build without.
std::string_view viewer_page();

}  // namespace triad::app
