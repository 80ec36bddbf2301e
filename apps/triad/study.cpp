// SPDX-License-Identifier: Apache-2.0
// triad study PLAN
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <map>
#include <raytracer/gltf_loader.hpp>
#include <raytracer/scene_source.hpp>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/study.hpp>
#include <triad/sampling/strategy.hpp>

#include "bundled_scenes.hpp"
#include "options.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

using raytracer::EffectSet;

struct StudyOptions {
  std::string plan, json;
  int repeats = 0, threads = 0;
};

// What a render takes from a plan. Scenes and their acceleration structures are made once and not timed.
class RenderWork {
 public:
  explicit RenderWork(const StudyPlan& plan) : plan_(plan) {
    static const std::vector<std::string> kKnown{"scene", "size", "strategy", "spp", "effects", "seed", "camera"};
    const auto check = [&](const std::string& name) {
      if (std::find(kKnown.begin(), kKnown.end(), name) == kKnown.end())
        throw_input("'" + plan.file + "': a render has no setting '" + name + "'" + did_you_mean(name, kKnown) +
                    "; it has '" + join(kKnown, "', '") + "'");
    };
    for (const auto& [name, value] : plan.fixed) check(name);
    for (const auto& axis : plan.axes) check(axis.name);
  }

  // effects = "each" stands for a setting for none of the scene's effects, then one more for each of them, then
  // "everything": what the scene calls for, drawn by the kernel with everything compiled in.
  std::vector<StudySettings> expand(const std::vector<StudySettings>& all) {
    std::vector<StudySettings> expanded;
    for (const StudySettings& settings : all) {
      const auto effects =
          std::find_if(settings.begin(), settings.end(), [](const auto& s) { return s.first == "effects"; });
      if (effects == settings.end() || effects->second != "each") {
        expanded.push_back(settings);
        continue;
      }
      StudySettings whole = settings;
      whole.insert(whole.end(), plan_.fixed.begin(), plan_.fixed.end());
      const auto scene = load(value(whole, "scene"), value_or(whole, "camera", ""));
      const auto add = [&](const std::string& text) {
        StudySettings one = settings;
        one[static_cast<size_t>(effects - settings.begin())].second = text;
        expanded.push_back(std::move(one));
      };
      add("none");
      std::string names;
      for (const auto& reason : raytracer::analyse_effects(*scene, scene->camera).reasons) {
        names += (names.empty() ? "" : ",") + std::string(raytracer::effect_name(reason.effect));
        add(names);
      }
      add("everything");
    }
    return expanded;
  }

  Measurements run(const StudySettings& settings) {
    const Job& job = prepare(settings);
    const auto before = job.source->work();
    const auto start = std::chrono::steady_clock::now();
    RenderOptions options;
    options.seed = job.seed;
    options.stop = [] { return cancel_requested(); };
    const RenderResult result = job.strategy->render(*job.source, options);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    check_cancel();
    Measurements measured{{"seconds", seconds}, {"samples", static_cast<double>(result.samples)}};
    double rays = 0;
    const auto after = job.source->work();
    for (size_t i = 0; i < after.size(); ++i) {
      const auto count = static_cast<double>(after[i].count - before[i].count);
      measured.emplace_back(after[i].kind, count);
      rays += count;
    }
    measured.emplace_back("all rays", rays);
    return measured;
  }

 private:
  struct Job {
    std::unique_ptr<raytracer::SceneSource> source;
    std::unique_ptr<Strategy> strategy;
    uint64_t seed = 0;
  };

  static std::string value_or(const StudySettings& settings, const std::string& name, const std::string& other) {
    for (const auto& [key, text] : settings)
      if (key == name) return text;
    return other;
  }
  std::string value(const StudySettings& settings, const std::string& name) const {
    const std::string text = value_or(settings, name, "");
    if (text.empty()) throw_input("'" + plan_.file + "': the setting '" + name + "' is missing");
    return text;
  }

  std::shared_ptr<const raytracer::Scene> load(const std::string& name, const std::string& camera) {
    auto& scene = scenes_[{name, camera}];
    if (!scene) {
      scene = std::make_shared<const raytracer::Scene>(raytracer::load_gltf(scene_file(name), {camera}));
      for (const std::string& warning : scene->warnings) warn(warning);
    }
    return scene;
  }

  const Job& prepare(const StudySettings& settings) {
    std::string key;
    for (const auto& [name, text] : settings) key += name + "=" + text + "\n";
    Job& job = jobs_[key];
    if (job.source) return job;
    const std::string size = value(settings, "size");
    const auto parts = split_quoted(size, 'x');
    const auto width = parts.size() == 2 ? parse_int(parts[0]) : std::nullopt;
    const auto height = parts.size() == 2 ? parse_int(parts[1]) : std::nullopt;
    if (!width || !height || *width < 1 || *height < 1 || *width > 65536 || *height > 65536)
      throw_input("'" + plan_.file + "': size '" + size + "' is not WxH in pixels, as in 400x225");
    const std::string seed = value_or(settings, "seed", "0");
    const auto number = parse_int(seed);
    if (!number || *number < 0) throw_input("'" + plan_.file + "': seed '" + seed + "' is not a whole number from 0");
    job.seed = static_cast<uint64_t>(*number);
    const std::string where = "'" + plan_.file + "'";
    const std::string spp = value_or(settings, "spp", ""), strategy = value_or(settings, "strategy", "");
    if (spp.empty() == strategy.empty()) throw_input(where + ": a render takes either 'spp' or 'strategy'");
    job.strategy = make_strategy(spp.empty() ? strategy : "sobol-owen:spp=" + spp, where);
    raytracer::SourceOptions options;
    options.width = static_cast<int>(*width);
    options.height = static_cast<int>(*height);
    options.geometry = false;
    const std::string effects = value_or(settings, "effects", "scene");
    if (effects == "everything")
      options.specialise = false;
    else if (effects != "scene")
      options.effects = raytracer::parse_effects(effects);
    job.source =
        raytracer::make_scene_source(load(value(settings, "scene"), value_or(settings, "camera", "")), options);
    return job;
  }

  const StudyPlan& plan_;
  std::map<std::pair<std::string, std::string>, std::shared_ptr<const raytracer::Scene>> scenes_;
  std::map<std::string, Job> jobs_;
};

void study(const StudyOptions& options) {
  if (options.threads > 0) set_thread_limit(options.threads);
  StudyPlan plan = load_study(options.plan);
  if (options.repeats > 0) plan.repeats = options.repeats;
  if (plan.work != "render")
    throw_input("'" + plan.file + "': work '" + plan.work + "' is unknown; a study can vary 'render'");
  RenderWork work(plan);
  const std::vector<StudySettings> settings = work.expand(study_settings(plan));
  Progress progress("study " + plan.name);
  const auto records = run_study(
      plan, settings, [&](const StudySettings& s) { return work.run(s); },
      [&](double done) { progress.update(done); });
  if (options.json != "-") std::cout << study_table(plan, records) << std::flush;
  if (!options.json.empty()) write_text_file(options.json, study_to_json(plan, records));
}

}  // namespace

void setup_study(CLI::App& app) {
  auto options = std::make_shared<StudyOptions>();
  CLI::App* verb = app.add_subcommand("study", "Measure what settings cost: runs in turns, medians, a table");
  verb->add_option("plan", options->plan, "A bundled plan's name, or a plan's TOML file")
      ->required()
      ->type_name("PLAN");
  verb->add_option("--repeats", options->repeats, "Counted runs of each setting (default: the plan's)")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  verb->add_option("--threads", options->threads, "Threads (default: all cores)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  verb->add_option("--json", options->json, "Write the results as JSON; - for standard output")->type_name("FILE");
  verb->footer(
      "Example:\n  triad study effects --repeats 3 --json effects.json\nNumbers are medians, ± half the range "
      "between the quartiles.");
  verb->callback([options] { study(*options); });
}

}  // namespace triad::app
