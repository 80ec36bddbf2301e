// SPDX-License-Identifier: Apache-2.0
// What studies draw, by the settings of a plan.
#pragma once

#include <memory>
#include <string>

#include "render_source.hpp"
#include "study_work.hpp"

namespace triad::app {

// The settings size, camera, effects, bounces and `name_of`, a source's name; all but the first and last optional,
// and cells and geometry left as they are. Camera, effects and bounces hold for scenes, and are left out for others.
// Throws Error(kInput).
SourceRequest study_source(const SettingValues& values, const std::string& name_of);
// Throws Error(kInput) for camera, effects or bounces in a plan without any scene.
void require_scene(const StudyPlan& plan, const std::string& name_of);
// open_source(), whose errors say `where` first.
std::unique_ptr<Source> open_study_source(const SourceRequest& request, const std::string& where);
// A text that is the same for the same source.
std::string source_key(const SourceRequest& request);

}  // namespace triad::app
