// SPDX-License-Identifier: Apache-2.0
// The layouts that come with the program, for tests that must hold on every one.
#pragma once

#include <string>
#include <triad/display/layout.hpp>
#include <vector>

namespace triad::reference {

inline const std::vector<std::string> kLayoutNames{"rgb",          "bgr",  "vrgb",         "vbgr",     "qd-oled",
                                                   "qd-oled-fine", "rwbg", "pentile-rgbg", "rgb-delta"};

inline Layout layout(const std::string& name) {
  return load_layout(std::string(TRIAD_SOURCE_DIR "/data/layouts/") + name + ".toml");
}

inline std::vector<Layout> all_layouts() {
  std::vector<Layout> out;
  for (const std::string& name : kLayoutNames) out.push_back(layout(name));
  return out;
}

}  // namespace triad::reference
