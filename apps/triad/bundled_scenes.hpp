// SPDX-License-Identifier: Apache-2.0
// The scenes that come with the program, by name.
#pragma once

#include <string>
#include <vector>

namespace triad::app {

struct BundledScene {
  std::string name, file;
};

// Those in the data folder, by name in alphabetical order. Throws Error(kInput) if there is no data folder.
std::vector<BundledScene> bundled_scenes();

// What a scene's author says of it in one line ("about" in the extras of its first scene); "" where a file says
// nothing or is not JSON.
std::string about_scene(const std::string& file);

// The file that is meant: a bundled scene's name ("cornell") stands for its file, all else is a file's own name. A
// file that has the name of a bundled scene and no extension is reached as "./cornell".
//
// Throws Error(kUsage) for a name that is neither, with the nearest bundled one; whether a name with a dot or a
// slash is there, whoever reads it says.
std::string scene_file(const std::string& name);

}  // namespace triad::app
