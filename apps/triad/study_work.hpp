// SPDX-License-Identifier: Apache-2.0
// What a study can run, and how it reads its settings.
#pragma once

#include <memory>
#include <raytracer/scene.hpp>
#include <raytracer/scene_source.hpp>
#include <triad/evaluation/study.hpp>
#include <triad/sampling/render.hpp>

namespace triad::app {

// Not thread-safe: a study runs one setting at a time.
class StudyWork {
 public:
  virtual ~StudyWork() = default;
  // The combinations of the axes, with settings that stand for several spelled out.
  virtual std::vector<StudySettings> expand(const std::vector<StudySettings>& all) { return all; }
  // What every run of a setting needs is made the first time and kept; only the work itself is timed.
  virtual Measurements run(const StudySettings& settings) = 0;
};

// By StudyPlan::work, "render" or "filter". `plan` must outlive it. Throws Error(kInput) for other work and for
// settings that it does not have.
std::unique_ptr<StudyWork> make_study_work(const StudyPlan& plan);
std::unique_ptr<StudyWork> make_render_work(const StudyPlan& plan);
// Its settings are explained in data/studies/filter.toml.
std::unique_ptr<StudyWork> make_filter_work(const StudyPlan& plan);

// One setting's values, by name. Throws Error(kInput) that names the plan's file.
class SettingValues {
 public:
  SettingValues(const std::string& file, const StudySettings& settings) : file_(file), settings_(settings) {}
  const std::string* find(const std::string& name) const;  // null: not set
  std::string text(const std::string& name) const;         // must be set
  std::string text_or(const std::string& name, const std::string& other) const;
  PictureSize size() const;
  uint64_t seed() const;                       // 0 if not set
  std::unique_ptr<Strategy> strategy() const;  // "strategy" or "spp", one of them must be set
  std::string where() const { return "'" + file_ + "'"; }

 private:
  const std::string& file_;
  const StudySettings& settings_;
};

// Throws Error(kInput) for a name of a setting that is none of `known`; `what` names the work: "a render".
void check_setting(const StudyPlan& plan, const std::string& name, const std::vector<std::string>& known,
                   const std::string& what);

// A bundled scene's name or a glTF file, loaded; its warnings are said.
std::shared_ptr<const raytracer::Scene> load_study_scene(const std::string& name, const std::string& camera);

// The whole picture; Ctrl-C ends it with Error(kCancelled).
RenderResult render_whole(const Strategy& strategy, const Source& source, uint64_t seed);

}  // namespace triad::app
