// SPDX-License-Identifier: Apache-2.0
#include "study_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/sampling/functions.hpp>
#include <triad/sampling/strokes.hpp>

#include "bundled_scenes.hpp"

namespace triad::app {

StudySource StudySource::of(const SettingValues& values, const std::string& name_of) {
  StudySource source;
  source.name = values.text(name_of);
  source.size = values.size();
  source.camera = values.text_or("camera", "");
  source.effects = values.text_or("effects", source.effects);
  const std::string bounces = values.text_or("bounces", std::to_string(source.bounces));
  const auto count = parse_int(bounces);
  if (!count || *count < 0 || *count > 1000)
    throw_input(values.where() + ": bounces '" + bounces + "' is not a whole number from 0 to 1000");
  source.bounces = static_cast<int>(*count);
  return source;
}

std::string StudySource::key() const {
  return fmt::format("{} {}x{} cells {}x{} camera '{}' effects {} bounces {} seed {}{}", name, size.width,
                     size.height, cells.x, cells.y, camera, effects, bounces, seed, geometry ? " geometry" : "");
}

std::unique_ptr<Source> make_study_source(const StudySource& source, const std::string& where) {
  const auto& strokes = stroke_picture_names();
  if (std::find(strokes.begin(), strokes.end(), source.name) != strokes.end())
    return make_strokes(source.name, source.size.width, source.size.height, source.cells, source.seed);
  std::vector<std::string> names;
  for (const FunctionInfo* function : function_list()) names.push_back(function->name);
  if (std::find(names.begin(), names.end(), source.name.substr(0, source.name.find(':'))) != names.end())
    return make_function(source.name, source.size.width, source.size.height, source.cells, where);
  for (const BundledScene& scene : bundled_scenes()) names.push_back(scene.name);
  if (source.name.find('.') == std::string::npos && std::find(names.begin(), names.end(), source.name) == names.end())
    throw_input(where + ": no picture is called '" + source.name + "'" + did_you_mean(source.name, names) +
                "; there are '" + join(names, "', '") + "', or name a file");
  const PictureSize film = film_size(source.size, source.cells);
  raytracer::SourceOptions options;
  options.width = film.width;
  options.height = film.height;
  options.geometry = source.geometry;
  options.picture_aspect = static_cast<double>(source.size.width) / source.size.height;
  options.max_depth = source.bounces;
  if (source.effects == "everything")
    options.specialise = false;
  else if (source.effects != "scene")
    options.effects = raytracer::parse_effects(source.effects);
  const auto scene = load_study_scene(source.name, source.camera);
  options.camera = scene->camera;
  return raytracer::make_scene_source(scene, options);
}

}  // namespace triad::app
