// SPDX-License-Identifier: Apache-2.0
// What triad render draws: a scene, a function or a picture, by one name.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <triad/sampling/render.hpp>

namespace triad::app {

enum class SourceKind { kScene, kFunction, kPicture };
// A bundled scene's name, then a function's with or without parameters, then a file: a picture by its extension, else
// a scene. Throws Error(kUsage) that lists scenes and functions for a bare name that is none of these.
SourceKind source_kind(const std::string& name);

struct SourceRequest {
  std::string name;
  PictureSize picture;  // display pixels
  Cells cells;          // the film has so many pixels in each, which fit into an int
  bool geometry = false;
  std::string camera, effects;  // of scenes; "": the scene's own
  int bounces = 32;
  std::string colour_space;  // of pictures; "": what the file says
};

struct OpenedSource {
  std::unique_ptr<Source> source;
  Facts facts;                    // for the picture's header
  nlohmann::ordered_json record;  // an object, for --json
  std::string summary;            // lines for the terminal; may be ""
  double load_s = 0, build_s = 0;
};

// Loads and builds it, with bars of progress and its warnings on stderr. Throws what is said of the file, the
// function or the options of the request; `name` is what errors of functions are said of: "SOURCE".
OpenedSource open_source(const SourceRequest& request, const std::string& name);

}  // namespace triad::app
