// SPDX-License-Identifier: Apache-2.0
// Studies of renders: work = "render".
#include <algorithm>
#include <map>
#include <raytracer/gltf_loader.hpp>
#include <raytracer/scene_source.hpp>
#include <triad/base/log.hpp>

#include "bundled_scenes.hpp"
#include "study_work.hpp"

namespace triad::app {
namespace {

// Scenes and their acceleration structures are made once and not timed.
class RenderWork final : public StudyWork {
 public:
  explicit RenderWork(const StudyPlan& plan) : plan_(plan) {
    check_settings(plan, {"scene", "size", "strategy", "spp", "effects", "seed", "camera"}, "a render");
  }

  // effects = "each" stands for a setting for none of the scene's effects, then one more for each of them, then
  // "everything": what the scene calls for, drawn by the kernel with everything compiled in.
  std::vector<StudySettings> expand(const std::vector<StudySettings>& all) override {
    std::vector<StudySettings> expanded;
    for (const StudySettings& settings : all) {
      const auto effects =
          std::find_if(settings.begin(), settings.end(), [](const auto& s) { return s.first == "effects"; });
      if (effects == settings.end() || effects->second != "each") {
        expanded.push_back(settings);
        continue;
      }
      const StudySettings whole = whole_settings(plan_, settings);
      const auto scene = load({plan_.file, whole});
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

  Measurements run(const StudySettings& settings, const std::string&) override {
    const Job& job = prepare(settings);
    RenderOptions options;
    options.seed = job.seed;
    const auto before = job.source->work();
    const auto start = std::chrono::steady_clock::now();
    const RenderResult result = render_whole(*job.strategy, *job.source, options);
    Measurements measured{{"seconds", seconds_since(start)}, {"samples", static_cast<double>(result.samples)}};
    const Measurements work = work_since(*job.source, before);
    measured.insert(measured.end(), work.begin(), work.end());
    return measured;
  }

 private:
  struct Job {
    std::unique_ptr<raytracer::SceneSource> source;
    std::unique_ptr<Strategy> strategy;
    uint64_t seed = 0;
  };

  std::shared_ptr<const raytracer::Scene> load(const SettingValues& values) {
    const std::string name = values.text("scene"), camera = values.text_or("camera", "");
    auto& scene = scenes_[{name, camera}];
    if (scene) return scene;
    scene = std::make_shared<const raytracer::Scene>(raytracer::load_gltf(scene_file(name), {camera}));
    for (const std::string& warning : scene->warnings) warn(warning);
    return scene;
  }

  const Job& prepare(const StudySettings& settings) {
    std::string key;
    for (const auto& [name, text] : settings) key += name + "=" + text + "\n";
    Job& job = jobs_[key];
    if (job.source) return job;
    const SettingValues values(plan_.file, settings);
    const PictureSize size = values.size();
    job.seed = values.seed();
    job.strategy = values.strategy();
    raytracer::SourceOptions options;
    options.width = size.width;
    options.height = size.height;
    options.geometry = job.strategy->uses_geometry();
    const std::string effects = values.text_or("effects", "scene");
    if (effects == "everything")
      options.specialise = false;
    else if (effects != "scene")
      options.effects = raytracer::parse_effects(effects);
    job.source = raytracer::make_scene_source(load(values), options);
    return job;
  }

  const StudyPlan& plan_;
  std::map<std::pair<std::string, std::string>, std::shared_ptr<const raytracer::Scene>> scenes_;
  std::map<std::string, Job> jobs_;
};

}  // namespace

std::unique_ptr<StudyWork> make_render_work(const StudyPlan& plan) { return std::make_unique<RenderWork>(plan); }

}  // namespace triad::app
