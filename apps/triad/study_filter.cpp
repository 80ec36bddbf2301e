// SPDX-License-Identifier: Apache-2.0
// Studies of filters: work = "filter".
#include <algorithm>
#include <map>
#include <triad/base/error.hpp>
#include <triad/display/layout.hpp>
#include <triad/pipeline/picture_source.hpp>
#include <triad/pipeline/run.hpp>
#include <triad/sampling/strokes.hpp>

#include "study_source.hpp"

namespace triad::app {
namespace {

// A picture is drawn, or read, once for each layout; every chain starts from it in memory and leaves its result
// there. Scores are the same in every run, and found in the first.
class FilterWork final : public StudyWork {
 public:
  explicit FilterWork(const StudyPlan& plan) : plan_(plan), colours_(ColourConfig::load()) {
    check_settings(plan,
                   {"picture", "size", "spp", "strategy", "seed", "camera", "layout", "ppd", "filter", "metric"},
                   "a filter study", {"filter", "metric"});
    naming_plan(plan, [&] { require_scene(plan, "picture"); });
  }

  Measurements run(const StudySettings& settings, const std::string&) override {
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
  struct Job {
    std::string text;  // the chain, filled in
    std::vector<ChainItem> stages;
    std::vector<ChainItem> metrics;
    ChainItem box;                  // the panel's own displaced box, to compare with
    JudgePicture input, reference;  // the same picture on the cells the chain works on, and on the panel's
    Measurements scores;            // once found
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
    std::vector<Judge> judges;
    for (const ChainItem& metric : job.metrics) judges.push_back({metric, job.reference});
    return judge_picture(std::move(shown), judges, host_, colours_);
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
    const auto cells = layout_values(layout);
    job.text = values.filled(values.text("filter"), cells);
    job.stages = study_stages(job.text, values.where());
    for (const std::string& text : study_words(values.filled(values.text_or("metric", "display"), cells))) {
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

  // Drawn on the cells of `layout`; files are taken as they are.
  JudgePicture picture(const SettingValues& values, const std::string& layout) {
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
    if (!image) image = std::make_shared<const Image>(drawn ? draw(values, cells) : read(name));
    return {key, image};
  }

  Image read(const std::string& path) const {
    const auto source = open_file_source(path, {}, colours_);
    Image image{source->spec(), {}};
    image.pixels.resize(image.row_floats() * static_cast<size_t>(image.spec.height));
    source->read_rows({0, image.spec.height}, image.pixels.data(), image.row_floats());
    return image;
  }

  static Image draw(const SettingValues& values, const Cells& cells) {
    SourceRequest wanted = study_source(values, "picture");
    const auto& strokes = stroke_picture_names();
    if (std::find(strokes.begin(), strokes.end(), wanted.name) != strokes.end())
      wanted.name += ":seed=" + std::to_string(values.seed());
    wanted.cells = cells;
    const auto strategy = values.strategy();
    wanted.geometry = strategy->uses_geometry();
    const auto source = open_study_source(wanted, values.where());
    RenderOptions options;
    options.seed = values.seed();
    const RenderResult result = render_whole(*strategy, *source, options);
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
