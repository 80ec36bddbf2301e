// SPDX-License-Identifier: Apache-2.0
// Studies of strategies: work = "strategy".
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/display/layout.hpp>

#include "study_references.hpp"

namespace triad::app {
namespace {

const std::vector<std::string> kSettings{"source", "size",    "strategy", "cells",     "filter", "layout", "ppd",
                                         "camera", "effects", "bounces",  "reference", "second", "metric", "seed"};

// Nothing to see, and able to do everything: has a strategy say whether it goes with cells, at no cost.
class OnePixel final : public Source {
 public:
  explicit OnePixel(const Cells& cells) : cells_(cells) {}
  int width() const override { return cells_.x; }
  int height() const override { return cells_.y; }
  SourceAbilities abilities() const override {
    return {.geometry = true, .exact_integral = true, .deterministic = true};
  }
  void eval(std::span<const SampleRequest>, std::span<Sample> samples) const override {
    std::fill(samples.begin(), samples.end(), Sample{});
  }
  std::optional<std::array<double, 3>> integral(double, double, double, double) const override {
    return std::array<double, 3>{};
  }
  std::optional<std::array<double, 3>> filtered(double, double, const SeparableFilter&) const override {
    return std::array<double, 3>{};
  }

 private:
  Cells cells_;
};

// Sources and references are made once and not timed; what comes out is judged once for each seed.
class StrategyWork final : public StudyWork {
 public:
  StrategyWork(const StudyPlan& plan, const std::string& references)
      : plan_(plan), colours_(ColourConfig::load()), references_(references, colours_) {
    check_settings(plan, kSettings, "a study of strategies", {"strategy", "filter", "metric", "reference", "second"});
    naming_plan(plan, [&] { require_scene(plan, "source"); });
  }

  void check(const StudySettings& settings) override { find_job(settings); }

  bool is_warm() const override { return true; }
  bool makes_pictures() const override { return true; }

  Measurements run(const StudySettings& settings, const std::string& picture) override {
    Job& job = find_job(settings);
    const uint64_t seed = SettingValues(plan_.file, settings).seed();
    try {
      make_ready(job);
      return measure(job, seed, picture);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::kCancelled) throw;
      throw Error(error.kind(), std::string(error.what()).starts_with("'" + plan_.file)
                                    ? error.what()
                                    : "'" + plan_.file + "': " + job.what() + ": " + error.what());
    }
  }

 private:
  struct Metric {
    ChainItem item;
    bool wide = false;  // judges by the cells of a panel's pixels
  };
  struct Job {
    SourceRequest wanted, wide;                     // wide: the film with a panel's cells, if a metric wants it
    std::string layout, filter, reference, second;  // "": none
    Facts facts;                                    // what a filter may ask of the render
    std::unique_ptr<Strategy> strategy;
    std::vector<ChainItem> stages;
    std::vector<Metric> metrics;
    const Source* source = nullptr;
    bool second_geometry = false;  // whether what draws it looks at it
    // Once it is ready.
    std::vector<Judge> truth;
    double reference_error = 0;
    std::map<uint64_t, Measurements> scores{};  // by seed

    std::string what() const { return wanted.name + ", " + strategy->text() + (filter.empty() ? "" : ", " + filter); }
  };

  Job& find_job(const StudySettings& settings) {
    std::string key;
    for (const auto& [name, text] : settings)
      if (name != "seed") key += name + "=" + text + "\n";
    const auto known = jobs_.find(key);
    return known == jobs_.end() ? jobs_.emplace(key, prepare(settings)).first->second : known->second;
  }

  // Names, parameters, files, what goes with what, sizes and the plan of the chain are looked at here, before
  // anything is drawn. What comes out only then: a reconstruction filter that a source has no closed form for, values
  // that are not finite, memory.
  Job prepare(const StudySettings& settings) {
    const SettingValues values(plan_.file, settings);
    Job job;
    values.seed();
    job.wanted = study_source(values, "source");
    job.layout = values.text_or("layout", "");
    const auto filled = [&, known = values.layout_cells()](const std::string& text) {
      return values.filled(text, known);
    };
    const std::string cells = values.text_or("cells", "");
    if (!cells.empty()) {
      const CellsOfLayout chosen = parse_cells_or_layout(cells, values.where() + ": cells");
      job.wanted.cells = chosen.cells;
      if (!chosen.layout.empty()) job.facts = {{"layout", chosen.layout}};
    }
    job.strategy = make_strategy(filled(values.text("strategy")), values.where());
    job.wanted.geometry = job.strategy->uses_geometry();
    job.filter = filled(values.text_or("filter", ""));
    if (!job.filter.empty()) job.stages = study_stages(job.filter, values.where());
    read_metrics(values, filled(values.text_or("metric", "error")), job);
    job.reference = filled(values.text("reference"));
    job.second = filled(values.text_or("second", "control"));
    if (job.second == "none") job.second.clear();

    job.wide = job.wanted;
    job.wide.cells = {};
    if (std::any_of(job.metrics.begin(), job.metrics.end(), [](const auto& m) { return m.wide; })) {
      const Layout panel = load_layout(job.layout);
      job.wide.cells = {panel.cells_x, panel.cells_y};
    }
    job.source = &find_source(job.wanted);
    check_draws(*job.strategy, job, job.wanted.cells);
    job.wide.geometry = check_reference(job.reference, job, job.wide.cells);
    if (!job.second.empty()) {
      job.second_geometry = check_reference(job.second, job, {});
      check_reference(job.second, job, job.wide.cells);
    }
    require_film_memory(job.source->width(), job.source->height(), {});
    check_chain(job);
    return job;
  }

  // Whether it is a strategy that looks at geometry.
  bool check_reference(const std::string& text, const Job& job, const Cells& cells) const {
    const std::string where = "'" + plan_.file + "'";
    if (StudyReferences::is_file(text)) {
      SourceRequest wanted = job.wanted;
      wanted.cells = cells;
      references_.check_file(text, wanted, where);
      return false;
    }
    const auto strategy = make_strategy(text, where);
    check_draws(*strategy, job, cells);
    return strategy->uses_geometry();
  }

  // Whether a strategy goes with a source and with cells.
  void check_draws(const Strategy& strategy, const Job& job, const Cells& cells) const {
    const std::string where = "'" + plan_.file + "'";
    if (strategy.info().name == "exact" && !job.source->abilities().exact_integral)
      throw_input(where + ": '" + job.wanted.name +
                  "' has no exact integral; take samples in its place, as sobol-owen:spp=1024 does");
    RenderOptions options;
    options.cells = cells;
    options.stop = [] { return true; };
    strategy.render(OnePixel(cells), options);
  }

  // The filter's plan, what comes out of it, and whether the metrics can judge that: by headers, without pixels.
  void check_chain(const Job& job) {
    const auto header = [&](const Cells& cells) {
      return Image{render_spec(film_size(job.wanted.picture, cells), cells, {}, *job.strategy), {}};
    };
    Image film = header(job.wanted.cells);
    for (const auto& [name, text] : job.facts) film.spec.metadata.set("triad:" + name, text);
    if (job.stages.empty()) require_size(job, film.spec);
    RunRequest request;
    request.input = {"what comes out", {}, std::make_shared<const Image>(std::move(film))};
    request.stages = job.stages;
    for (const Metric& metric : job.metrics) {
      const Cells cells = metric.wide ? job.wide.cells : Cells{};
      request.metrics.push_back({metric.item,
                                 {fmt::format("the reference of {}x{} cells a pixel", cells.x, cells.y),
                                  {},
                                  std::make_shared<const Image>(header(cells))},
                                 ""});
    }
    try {
      Run(request, host_, colours_);
    } catch (const Error& error) {
      throw Error(error.kind(), "'" + plan_.file + "': " + job.what() + ": " + error.what());
    }
  }

  void require_size(const Job& job, const ImageSpec& spec) const {
    const PictureSize& size = job.wanted.picture;
    if (spec.width != size.width || spec.height != size.height)
      throw_input(fmt::format(
          "'{}': {}: what comes out has {}x{} pixels, not {}x{}; a 'filter' such as box:x={},y={} or platt "
          "makes pixels of cells",
          plan_.file, job.what(), spec.width, spec.height, size.width, size.height, job.wanted.cells.x,
          job.wanted.cells.y));
  }

  void read_metrics(const SettingValues& values, const std::string& text, Job& job) {
    std::vector<ChainItem> items;
    for (const std::string& word : study_words(text)) items.push_back(parse_metric(word));
    if (items.empty()) throw_input(values.where() + ": a 'metric' without a name");
    make_labels_unique(items);
    for (ChainItem& item : items) {
      const StageInfo& info = host_.find(item.id);
      if (!info.is_metric()) throw_input(values.where() + ": '" + item.id + "' is a filter, not a metric");
      Metric metric{item, false};
      for (uint32_t p = 0; p < info.desc->n_params; ++p) {
        const std::string name = info.desc->params[p]->name;
        // A metric that knows panels is told which one, and looks at a render of its cells.
        if (name == "layout") metric.wide = true;
        if (name == "layout" || name == "ppd") metric.item.params.try_emplace(name, values.text(name));
      }
      StageInstance(info, metric.item.params);
      job.metrics.push_back(std::move(metric));
    }
  }

  const Source& find_source(const SourceRequest& wanted) {
    auto& source = sources_[source_key(wanted)];
    if (!source) source = open_study_source(wanted, "'" + plan_.file + "'");
    return *source;
  }

  void make_ready(Job& job) {
    if (!job.truth.empty()) return;
    const std::string where = "'" + plan_.file + "'";
    const StudyReference& truth =
        references_.get(job.wide, find_source(job.wide), job.reference, StudyReferences::kTruthSeed, where);
    const StudyReference& averaged = references_.averaged(truth);
    job.reference_error = job.metrics[0].wide ? truth.rmse : averaged.rmse;
    for (const Metric& metric : job.metrics)
      job.truth.push_back({metric.item, (metric.wide ? truth : averaged).picture});
    // Memory, clocks and the machine's caches warm up.
    render_whole(*make_strategy("control", where), *job.source, {});
  }

  Measurements measure(Job& job, uint64_t seed, const std::string& picture) {
    RenderOptions options;
    options.seed = seed;
    options.cells = job.wanted.cells;
    options.planes.samples = true;
    options.planes.reasons = !job.strategy->reason_channels().empty();
    const auto before = job.source->work();
    const auto start = std::chrono::steady_clock::now();
    const RenderResult result = render_whole(*job.strategy, *job.source, options);
    const double seconds = seconds_since(start);
    const Measurements work = work_since(*job.source, before);

    auto image = std::make_shared<const Image>(
        render_picture(result, *job.strategy, options, *job.source, job.wanted.cells, job.facts));
    Measurements filtered{{"filter-seconds", 0}, {"plan-seconds", 0}};
    if (!job.stages.empty()) image = filter(job, *image, filtered);
    Measurements measured{{"seconds", seconds}, {"total-seconds", seconds + filtered[0].second}};
    measured.insert(measured.end(), filtered.begin(), filtered.end());
    const auto samples = static_cast<double>(result.samples);
    measured.emplace_back("samples", samples);
    measured.emplace_back("spp",
                          samples / (static_cast<double>(job.wanted.picture.width) * job.wanted.picture.height));
    measured.emplace_back("dropped", static_cast<double>(result.dropped));
    measured.insert(measured.end(), work.begin(), work.end());
    auto& scores = job.scores[seed];
    if (scores.empty()) scores = judge(job, *image, seed);
    measured.insert(measured.end(), scores.begin(), scores.end());
    if (!picture.empty()) write_float_picture(picture, *image);
    return measured;
  }

  std::shared_ptr<const Image> filter(const Job& job, const Image& image, Measurements& filtered) {
    const auto start = std::chrono::steady_clock::now();
    RunRequest request;
    request.input = {"the render", {}, std::make_shared<const Image>(colour_only(image))};
    request.stages = job.stages;
    request.keep_picture = true;
    Run chain(request, host_, colours_);
    filtered[1].second = seconds_since(start);
    const RunResult result = chain.execute();
    filtered[0].second = result.seconds;
    for (const auto& stage : result.stages)
      for (const char* name : {"gap", "iterations"}) {
        const auto found = stage.reports.values.find(name);
        if (found != stage.reports.values.end()) filtered.emplace_back(name, found->second);
      }
    return result.picture;
  }

  Measurements judge(const Job& job, const Image& image, uint64_t seed) {
    require_size(job, image.spec);
    const auto shown = std::make_shared<const Image>(colour_only(image));
    Measurements scores = judge_picture(shown, job.truth, host_, colours_);
    if (job.reference_error > 0) scores.emplace_back("reference-error", job.reference_error);
    if (!job.second.empty()) judge_by_second(job, shown, seed, scores);
    return scores;
  }

  // The second reference has the seed of what it judges: a strategy that leaves samples out, and takes others as
  // they are there, has the same pixels where it took them.
  void judge_by_second(const Job& job, const std::shared_ptr<const Image>& shown, uint64_t seed,
                       Measurements& scores) {
    SourceRequest pixels = job.wide, wide = job.wide;
    pixels.cells = {};
    pixels.geometry = wide.geometry = job.second_geometry;
    const auto picture = [&](const SourceRequest& wanted) {
      return references_.get(wanted, find_source(wanted), job.second, seed, "'" + plan_.file + "'").picture;
    };
    const JudgePicture full = picture(pixels);
    std::vector<Judge> judges;
    for (const Metric& metric : job.metrics) judges.push_back({metric.item, metric.wide ? picture(wide) : full});
    for (const auto& [name, value] : judge_picture(shown, judges, host_, colours_))
      scores.emplace_back("second." + name, value);
    scores.emplace_back("unchanged", unchanged(*shown, *full.image));
  }

  // The share of pixels that have the same 8-bit sRGB codes.
  double unchanged(const Image& one, const Image& other) const {
    const auto codes = [&](const Image& image) {
      std::vector<float> values = image.pixels;
      colours_.transform(colours_.lin_rec709(), colours_.srgb()).apply(values.data(), values.size() / 3, 3, -1);
      for (float& value : values) value = std::round(std::clamp(value, 0.f, 1.f) * 255);
      return values;
    };
    const std::vector<float> a = codes(one), b = codes(other);
    size_t same = 0;
    for (size_t p = 0; p < a.size(); p += 3) same += a[p] == b[p] && a[p + 1] == b[p + 1] && a[p + 2] == b[p + 2];
    return static_cast<double>(same) / (static_cast<double>(a.size()) / 3);
  }

  const StudyPlan& plan_;
  const ColourConfig colours_;
  PluginHost host_{{}};
  StudyReferences references_;
  std::map<std::string, std::unique_ptr<Source>> sources_;
  std::map<std::string, Job> jobs_;
};

}  // namespace

std::unique_ptr<StudyWork> make_strategy_work(const StudyPlan& plan, const std::string& references) {
  return std::make_unique<StrategyWork>(plan, references);
}

}  // namespace triad::app
