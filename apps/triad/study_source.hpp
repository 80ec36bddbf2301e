// SPDX-License-Identifier: Apache-2.0
// What studies draw: scenes and pictures of strokes, by name.
#pragma once

#include <memory>
#include <string>
#include <triad/sampling/render.hpp>

#include "study_work.hpp"

namespace triad::app {

struct StudySource {
  std::string name;  // a picture of strokes, a bundled scene, or a scene's file
  PictureSize size;  // display pixels
  Cells cells;
  std::string camera, effects = "scene";  // "scene": what it calls for; "everything": the kernel with all compiled in
  int bounces = 32;
  bool geometry = false;
  uint64_t seed = 0;  // of pictures of strokes: which strokes

  // The settings size, camera, effects, bounces and `name_of`, all but the first and last optional. Throws
  // Error(kInput).
  static StudySource of(const SettingValues& values, const std::string& name_of);
  // A text that is the same for the same source.
  std::string key() const;
};

// Throws Error(kInput), `where` first, for names that are not there.
std::unique_ptr<Source> make_study_source(const StudySource& source, const std::string& where);

}  // namespace triad::app
