// SPDX-License-Identifier: Apache-2.0
#include "bundled_scenes.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>

namespace fs = std::filesystem;

namespace triad::app {

std::vector<BundledScene> bundled_scenes() {
  std::vector<BundledScene> scenes;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(data_folder()) / "scenes", error)) {
    const std::string extension = entry.path().extension();
    if (extension == ".gltf" || extension == ".glb") scenes.push_back({entry.path().stem(), entry.path()});
  }
  std::sort(scenes.begin(), scenes.end(),
            [](const BundledScene& a, const BundledScene& b) { return a.name < b.name; });
  return scenes;
}

std::string about_scene(const std::string& file) {
  using Json = nlohmann::json;
  std::ifstream stream(file, std::ios::binary);
  const Json root = Json::parse(stream, nullptr, false);
  const Json::json_pointer where("/scenes/0/extras/about");
  return !root.is_discarded() && root.contains(where) && root[where].is_string() ? root[where].get<std::string>()
                                                                                 : "";
}

std::string scene_file(const std::string& name) {
  if (name.find('/') != std::string::npos || name.find('.') != std::string::npos) return name;
  std::vector<std::string> names;
  for (const BundledScene& scene : bundled_scenes()) {
    if (scene.name == name) return scene.file;
    names.push_back(scene.name);
  }
  std::error_code error;
  if (fs::is_regular_file(name, error)) return name;
  throw_usage("no bundled scene is called '" + name + "'" + did_you_mean(name, names) + ", and no file; there are '" +
              join(names, "', '") + "'");
}

}  // namespace triad::app
