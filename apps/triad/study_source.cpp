// SPDX-License-Identifier: Apache-2.0
#include "study_source.hpp"

#include <fmt/format.h>

#include <triad/base/error.hpp>
#include <triad/base/text.hpp>

namespace triad::app {

SourceRequest study_source(const SettingValues& values, const std::string& name_of) {
  SourceRequest request;
  request.name = values.text(name_of);
  request.picture = values.size();
  request.camera = values.text_or("camera", "");
  request.effects = values.text_or("effects", "");
  const std::string bounces = values.text_or("bounces", std::to_string(request.bounces));
  const auto count = parse_int(bounces);
  if (!count || *count < 0 || *count > 1000)
    throw_input(values.where() + ": bounces '" + bounces + "' is not a whole number from 0 to 1000");
  request.bounces = static_cast<int>(*count);
  if (source_kind(request.name) == SourceKind::kScene) return request;
  // In a plan with scenes beside (require_scene()), these are theirs.
  request.camera = request.effects = "";
  request.bounces = SourceRequest{}.bounces;
  return request;
}

void require_scene(const StudyPlan& plan, const std::string& name_of) {
  const auto given = plan.given();
  const auto sources = given.find(name_of);
  if (sources == given.end()) return;
  for (const std::string& name : sources->second)
    if (source_kind(name) == SourceKind::kScene) return;
  for (const char* setting : {"camera", "effects", "bounces"})
    if (given.contains(setting))
      throw_input("'" + plan.file + "': the setting '" + setting + "' is for scenes, and no '" + name_of +
                  "' is one; leave it out");
}

std::unique_ptr<Source> open_study_source(const SourceRequest& request, const std::string& where) {
  try {
    return open_source(request, where).source;
  } catch (const Error& error) {
    const std::string what = error.what();
    throw Error(error.kind(), what.starts_with(where) ? what : where + ": " + what);
  }
}

std::string source_key(const SourceRequest& request) {
  return fmt::format("{} {}x{} cells {}x{} camera '{}' effects '{}' bounces {}{}", request.name,
                     request.picture.width, request.picture.height, request.cells.x, request.cells.y, request.camera,
                     request.effects, request.bounces, request.geometry ? " geometry" : "");
}

}  // namespace triad::app
