// SPDX-License-Identifier: Apache-2.0
// Studies of filters: work = "filter".
#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/display/layout.hpp>
#include <triad/pipeline/picture_source.hpp>
#include <triad/pipeline/run.hpp>
#include <triad/sampling/strokes.hpp>

#include "bundled_scenes.hpp"
#include "study_work.hpp"

namespace triad::app {
namespace {

// {name} in a text: each name once, in order.
std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> names;
  for (size_t open = text.find('{'); open != std::string::npos; open = text.find('{', open + 1)) {
    const size_t close = text.find('}', open);
    if (close == std::string::npos) break;
    names.push_back(text.substr(open + 1, close - open - 1));
  }
  return names;
}

// Stages or metrics with blanks between them.
std::vector<std::string> words(const std::string& text) {
  std::vector<std::string> found = split_quoted(text, ' ');
  std::erase(found, "");
  return found;
}

const std::vector<std::string>& of_layout() {
  static const std::vector<std::string> kNames{"cells_x", "cells_y"};
  return kNames;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// A picture is drawn, or read, once for each layout; every chain starts from it in memory and leaves its result
// there. Scores are the same in every run, and found in the first.
class FilterWork final : public StudyWork {
 public:
  explicit FilterWork(const StudyPlan& plan) : plan_(plan), colours_(ColourConfig::load()) {
    static const std::vector<std::string> kKnown{"picture", "size",   "spp", "strategy", "seed",
                                                 "camera",  "layout", "ppd", "filter",   "metric"};
    std::vector<std::string> allowed = kKnown, given;
    const auto look = [&](const std::string& name, const std::vector<std::string>& values) {
      given.push_back(name);
      if (name != "filter" && name != "metric") return;
      for (const std::string& value : values)
        for (const std::string& used : names_in(value)) allowed.push_back(used);
    };
    for (const auto& [name, value] : plan.fixed) look(name, {value});
    for (const auto& axis : plan.axes) look(axis.name, axis.values);
    const std::string what = "a filter study, beside what {NAME} in 'filter' and 'metric' stands for,";
    for (const std::string& name : given)
      if (std::find(allowed.begin(), allowed.end(), name) == allowed.end()) check_setting(plan, name, kKnown, what);
  }

  Measurements run(const StudySettings& settings) override {
    std::string key;
    for (const auto& [name, text] : settings) key += name + "=" + text + "\n";
    const auto known = jobs_.find(key);
    Job& job = known == jobs_.end() ? jobs_.emplace(key, prepare(settings)).first->second : known->second;
    try {
      return measure(job);
    } catch (const Error& error) {
      throw Error(error.kind(), "'" + plan_.file + "': filter '" + job.text + "': " + error.what());
    }
  }

 private:
  struct Picture {
    std::string name;  // with what it was made for
    std::shared_ptr<const Image> image;
  };
  struct Job {
    std::string text;  // the chain, filled in
    std::vector<ChainItem> stages;
    std::vector<ChainItem> metrics;
    ChainItem box;             // the panel's own displaced box, to compare with
    Picture input, reference;  // the same picture on the cells the chain works on, and on the panel's
    Measurements scores;       // once found
  };

  Measurements measure(Job& job) {
    const auto start = std::chrono::steady_clock::now();
    RunRequest request;
    request.input = {job.input.name, {}, job.input.image};
    request.stages = job.stages;
    request.keep_picture = true;
    Run chain(request, host_, colours_);
    const double plan_seconds = seconds_since(start);
    const RunResult result = chain.execute();
    Measurements measured{{"seconds", result.seconds}, {"plan-seconds", plan_seconds}};
    if (job.scores.empty()) job.scores = judge(job, result);
    measured.insert(measured.end(), job.scores.begin(), job.scores.end());
    return measured;
  }

  Measurements judge(const Job& job, const RunResult& result) {
    Measurements scores = scores_of(job, result.picture);
    const auto rmse = std::find_if(scores.begin(), scores.end(), [](const auto& s) { return s.first == "rmse"; });
    if (rmse != scores.end()) {
      const double box = box_rmse(job), value = rmse->second;
      scores.emplace_back("box-ratio", value == box ? 1 : value / box);
    }
    for (const auto& stage : result.stages)
      for (const char* name : {"gap", "iterations", "taps", "truncation"}) {
        const auto found = stage.reports.values.find(name);
        if (found != stage.reports.values.end()) scores.emplace_back(name, found->second);
      }
    return scores;
  }

  Measurements scores_of(const Job& job, std::shared_ptr<const Image> shown) {
    RunRequest request;
    request.input = {"what comes out", {}, std::move(shown)};
    for (const ChainItem& metric : job.metrics)
      request.metrics.push_back({metric, {job.reference.name, {}, job.reference.image}, ""});
    const RunResult result = Run(request, host_, colours_).execute();
    Measurements scores;
    for (size_t m = 0; m < result.metrics.size(); ++m) {
      const MetricResult& metric = result.metrics[m];
      if (metric.nonfinite_failed) throw_input("what comes out, or the picture, holds values that are not finite");
      for (const auto& score : metric.scores)
        scores.emplace_back(m == 0 ? score.name : metric.label + "." + score.name, score.value);
    }
    return scores;
  }

  double box_rmse(const Job& job) {
    const ChainItem& metric = job.metrics.front();
    std::string key = job.reference.name + "\n" + metric.id;
    for (const auto& [name, text] : metric.params) key += "\n" + name + "=" + text;
    const auto known = boxes_.find(key);
    if (known != boxes_.end()) return known->second;
    RunRequest request;
    request.input = {job.reference.name, {}, job.reference.image};
    request.stages = {job.box};
    request.keep_picture = true;
    const RunResult made = Run(request, host_, colours_).execute();
    double value = 0;
    for (const auto& [name, score] : scores_of(job, made.picture))
      if (name == "rmse") value = score;
    return boxes_[key] = value;
  }

  Job prepare(const StudySettings& settings) {
    const SettingValues values(plan_.file, settings);
    const std::string layout = values.text("layout"), ppd = values.text("ppd");
    Job job;
    job.text = filled(values.text("filter"), values, layout);
    for (const std::string& stage : words(job.text)) job.stages.push_back(parse_stage(stage));
    if (job.stages.empty()) throw_input(values.where() + ": a 'filter' without stages");
    for (const ChainItem& stage : job.stages)
      if (stage.is_write) throw_input(values.where() + ": filter '" + job.text + "' writes a file; a study does not");
    for (const std::string& text : words(filled(values.text_or("metric", "display"), values, layout))) {
      ChainItem& metric = job.metrics.emplace_back(parse_metric(text));
      if (metric.id != "display") continue;
      metric.params.try_emplace("layout", layout);
      metric.params.try_emplace("ppd", ppd);
    }
    if (job.metrics.empty()) throw_input(values.where() + ": a 'metric' without a name");
    make_labels_unique(job.metrics);
    job.box.id = "displaced-box";
    job.box.params = {{"layout", layout}};
    // A filter for another panel is given what it would be given there.
    const auto& first = job.stages.front().params;
    const auto own = first.find("layout");
    job.reference = picture(values, layout);
    job.input = picture(values, own == first.end() ? layout : own->second);
    return job;
  }

  std::string filled(std::string text, const SettingValues& values, const std::string& layout) const {
    for (const std::string& name : names_in(text)) {
      std::string value;
      if (std::find(of_layout().begin(), of_layout().end(), name) != of_layout().end()) {
        const Layout panel = load_layout(layout);
        value = std::to_string(name == "cells_x" ? panel.cells_x : panel.cells_y);
      } else {
        value = values.text(name);
      }
      const std::string hole = "{" + name + "}";
      for (size_t at = text.find(hole); at != std::string::npos; at = text.find(hole, at + value.size()))
        text.replace(at, hole.size(), value);
    }
    return text;
  }

  // Drawn on the cells of `layout`; files are taken as they are.
  Picture picture(const SettingValues& values, const std::string& layout) {
    const std::string name = values.text("picture");
    const bool drawn = name.find('.') == std::string::npos || name.ends_with(".gltf") || name.ends_with(".glb");
    std::string key = name;
    if (drawn)
      for (const char* setting : {"size", "spp", "strategy", "seed", "camera"})
        key += " " + values.text_or(setting, "-");
    const Layout panel = load_layout(layout);
    const Cells cells{panel.cells_x, panel.cells_y};
    if (drawn) key += " " + std::to_string(cells.x) + "x" + std::to_string(cells.y);
    auto& image = pictures_[key];
    if (!image) image = std::make_shared<const Image>(drawn ? draw(name, values, cells) : read(name));
    return {key, image};
  }

  Image read(const std::string& path) const {
    const auto source = open_file_source(path, {}, colours_);
    Image image{source->spec(), {}};
    image.pixels.resize(image.row_floats() * static_cast<size_t>(image.spec.height));
    source->read_rows({0, image.spec.height}, image.pixels.data(), image.row_floats());
    return image;
  }

  // Refuses what is neither a picture's or scene's name nor a scene's file.
  static void check_name(const std::string& name, const SettingValues& values) {
    std::vector<std::string> names = stroke_picture_names();
    for (const BundledScene& scene : bundled_scenes()) names.push_back(scene.name);
    if (name.find('.') == std::string::npos && std::find(names.begin(), names.end(), name) == names.end())
      throw_input(values.where() + ": no picture is called '" + name + "'" + did_you_mean(name, names) +
                  "; there are '" + join(names, "', '") + "', or name a wide render's file");
  }

  static Image draw(const std::string& name, const SettingValues& values, const Cells& cells) {
    const PictureSize size = values.size(), film = film_size(size, cells);
    const auto& own = stroke_picture_names();
    const auto strategy = values.strategy();
    std::unique_ptr<Source> source;
    if (std::find(own.begin(), own.end(), name) != own.end()) {
      source = make_strokes(name, size.width, size.height, cells, values.seed());
    } else {
      check_name(name, values);
      raytracer::SourceOptions options;
      options.width = film.width;
      options.height = film.height;
      options.geometry = strategy->uses_geometry();
      options.picture_aspect = static_cast<double>(size.width) / size.height;
      const auto scene = load_study_scene(name, values.text_or("camera", ""));
      options.camera = scene->camera;
      source = raytracer::make_scene_source(scene, options);
    }
    RenderOptions options;
    options.seed = values.seed();
    const RenderResult result = render_whole(*strategy, *source, options.seed);
    return render_picture(result, *strategy, options, *source, cells, {});
  }

  const StudyPlan& plan_;
  const ColourConfig colours_;
  PluginHost host_{{}};
  std::map<std::string, std::shared_ptr<const Image>> pictures_;
  std::map<std::string, Job> jobs_;
  std::map<std::string, double> boxes_;
};

}  // namespace

std::unique_ptr<StudyWork> make_filter_work(const StudyPlan& plan) { return std::make_unique<FilterWork>(plan); }

}  // namespace triad::app
