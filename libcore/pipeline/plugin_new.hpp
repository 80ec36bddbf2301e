// SPDX-License-Identifier: Apache-2.0
// `triad plugin new`: a plugin to start from.
#pragma once

#include <string>
#include <vector>

namespace triad {

// Makes the folder `parent`/NAME with NAME.cpp (a working filter), CMakeLists.txt and test.sh, which builds it
// and runs `triad plugin check`. Returns the paths of the files.
// Throws Error(kUsage) for a name that is no stage id or that CMake keeps for itself, Error(kInput) when
// something of that name exists or the folder cannot be made. What was there before is never touched.
std::vector<std::string> new_plugin(const std::string& name, const std::string& parent);

}  // namespace triad
