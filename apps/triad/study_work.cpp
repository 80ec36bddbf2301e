// SPDX-License-Identifier: Apache-2.0
#include "study_work.hpp"

#include <algorithm>
#include <raytracer/gltf_loader.hpp>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>

#include "bundled_scenes.hpp"

namespace triad::app {

std::unique_ptr<StudyWork> make_study_work(const StudyPlan& plan) {
  if (plan.work == "render") return make_render_work(plan);
  if (plan.work == "filter") return make_filter_work(plan);
  throw_input("'" + plan.file + "': work '" + plan.work + "' is unknown; a study can vary 'render' and 'filter'");
}

const std::string* SettingValues::find(const std::string& name) const {
  for (const auto& [key, text] : settings_)
    if (key == name) return &text;
  return nullptr;
}

std::string SettingValues::text_or(const std::string& name, const std::string& other) const {
  const std::string* found = find(name);
  return found ? *found : other;
}

std::string SettingValues::text(const std::string& name) const {
  const std::string* found = find(name);
  if (!found || found->empty()) throw_input(where() + ": the setting '" + name + "' is missing");
  return *found;
}

PictureSize SettingValues::size() const {
  constexpr int kMost = 65536;  // far beyond what a study is for
  const PictureSize size = parse_size(text("size"), where());
  if (size.width > kMost || size.height > kMost)
    throw_input(where() + ": size '" + text("size") + "' has a side of more than " + std::to_string(kMost) +
                " pixels");
  return size;
}

uint64_t SettingValues::seed() const {
  const std::string seed = text_or("seed", "0");
  const auto number = parse_int(seed);
  if (!number || *number < 0) throw_input(where() + ": seed '" + seed + "' is not a whole number from 0");
  return static_cast<uint64_t>(*number);
}

std::unique_ptr<Strategy> SettingValues::strategy() const {
  const std::string spp = text_or("spp", ""), strategy = text_or("strategy", "");
  if (spp.empty() == strategy.empty()) throw_input(where() + ": a render takes either 'spp' or 'strategy'");
  return make_strategy(spp.empty() ? strategy : "sobol-owen:spp=" + spp, where());
}

void check_setting(const StudyPlan& plan, const std::string& name, const std::vector<std::string>& known,
                   const std::string& what) {
  if (std::find(known.begin(), known.end(), name) == known.end())
    throw_input("'" + plan.file + "': " + what + " has no setting '" + name + "'" + did_you_mean(name, known) +
                "; it has '" + join(known, "', '") + "'");
}

std::shared_ptr<const raytracer::Scene> load_study_scene(const std::string& name, const std::string& camera) {
  auto scene = std::make_shared<const raytracer::Scene>(raytracer::load_gltf(scene_file(name), {camera}));
  for (const std::string& warning : scene->warnings) warn(warning);
  return scene;
}

RenderResult render_whole(const Strategy& strategy, const Source& source, uint64_t seed) {
  RenderOptions options;
  options.seed = seed;
  options.stop = [] { return cancel_requested(); };
  RenderResult result = strategy.render(source, options);
  check_cancel();
  return result;
}

}  // namespace triad::app
