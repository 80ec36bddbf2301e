// SPDX-License-Identifier: Apache-2.0
// What a study can run, and how it reads its settings.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <triad/base/error.hpp>
#include <triad/evaluation/study.hpp>
#include <triad/pipeline/run.hpp>
#include <triad/sampling/render.hpp>

namespace triad::app {

// Not thread-safe: a study runs one setting at a time.
class StudyWork {
 public:
  virtual ~StudyWork() = default;
  // The combinations of the axes, with settings that stand for several spelled out.
  virtual std::vector<StudySettings> expand(const std::vector<StudySettings>& all) { return all; }
  // Throws what is wrong with settings (as whole_settings() has them) that can be known before anything is run.
  virtual void check(const StudySettings&) {}
  // Whether the first run of a setting is as quick as those that follow, so that no turn need be thrown away.
  virtual bool is_warm() const { return false; }
  // Whether run() writes the picture it is asked for.
  virtual bool makes_pictures() const { return false; }
  // What every run of a setting needs is made the first time and kept; only the work itself is timed. Works that
  // make pictures write theirs to `picture` unless it is "".
  virtual Measurements run(const StudySettings& settings, const std::string& picture) = 0;
};

// By StudyPlan::work: "render", "filter" or "strategy". `references`: a folder to keep what is expensive to make, and
// to find it again; "" none. `plan` must outlive it. Throws Error(kInput) for other work and for settings that it
// does not have.
std::unique_ptr<StudyWork> make_study_work(const StudyPlan& plan, const std::string& references);
std::unique_ptr<StudyWork> make_render_work(const StudyPlan& plan);
// Its settings are explained in data/studies/filter.toml.
std::unique_ptr<StudyWork> make_filter_work(const StudyPlan& plan);
// Its settings are explained in data/studies/everything.toml.
std::unique_ptr<StudyWork> make_strategy_work(const StudyPlan& plan, const std::string& references);

// What `f` returns. Errors that it throws are said of the plan.
template <typename F>
auto naming_plan(const StudyPlan& plan, F f) -> decltype(f()) {
  try {
    return f();
  } catch (const Error& error) {
    const std::string what = error.what(), where = "'" + plan.file + "'";
    if (error.kind() == ErrorKind::kCancelled || what.find(where) != std::string::npos) throw;
    throw Error(error.kind(), where + ": " + what);
  }
}

// One setting's values, by name. Throws Error(kInput) that names the plan's file.
class SettingValues {
 public:
  SettingValues(const std::string& file, const StudySettings& settings) : file_(file), settings_(settings) {}
  const std::string* find(const std::string& name) const;  // null: not set
  std::string text(const std::string& name) const;         // must be set
  std::string text_or(const std::string& name, const std::string& other) const;
  // `text` with {NAME} replaced by the value of the setting NAME, which must be set, or by its value in `known`.
  std::string filled(std::string text, const std::map<std::string, std::string>& known = {}) const;
  // "{cells_x}" and "{cells_y}" for filled(): the cells of the pixels of `layout`; {} if it is not set.
  std::map<std::string, std::string> layout_cells() const;
  PictureSize size() const;
  uint64_t seed() const;                       // 0 if not set
  std::unique_ptr<Strategy> strategy() const;  // "strategy" or "spp", one of them must be set
  std::string where() const { return "'" + file_ + "'"; }

 private:
  const std::string& file_;
  const StudySettings& settings_;
};

// Refuses settings of a plan that are neither `known` nor stand as {NAME} in the values of those in `filled`; `what`
// names the work: "a render". Throws Error(kInput).
void check_settings(const StudyPlan& plan, const std::vector<std::string>& known, const std::string& what,
                    const std::vector<std::string>& filled = {});

// Stages or metrics with blanks between them, without the blanks.
std::vector<std::string> study_words(const std::string& text);
// "{cells_x}" and "{cells_y}": the cells of a layout's pixel.
std::map<std::string, std::string> layout_values(const std::string& layout);
// The stages of a chain that writes no file. Throws Error(kInput), `where` first.
std::vector<ChainItem> study_stages(const std::string& text, const std::string& where);

// A picture to judge by, with a name that no other has.
struct JudgePicture {
  std::string name;
  std::shared_ptr<const Image> image;
};
struct Judge {
  ChainItem metric;
  JudgePicture reference;
};
// The scores of a picture: SCORE of the first metric, LABEL.SCORE of the others. Throws Error(kInput) for values
// that are not finite.
Measurements judge_picture(std::shared_ptr<const Image> picture, const std::vector<Judge>& judges, PluginHost& host,
                           const ColourConfig& colours);

// The whole picture; Ctrl-C ends it with Error(kCancelled).
RenderResult render_whole(const Strategy& strategy, const Source& source, RenderOptions options);

// All bits of every value; also of those that are no colour.
void write_float_picture(const std::string& path, const Image& image);

// What a source has done since `before`, kind by kind, and in all as "all rays".
Measurements work_since(const Source& source, const std::vector<WorkCount>& before);

inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace triad::app
