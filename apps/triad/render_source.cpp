// SPDX-License-Identifier: Apache-2.0
#include "render_source.hpp"

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <raytracer/gltf_loader.hpp>
#include <raytracer/scene_source.hpp>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/image/reader.hpp>
#include <triad/sampling/functions.hpp>
#include <triad/sampling/image_source.hpp>

#include "bundled_scenes.hpp"
#include "options.hpp"
#include "stopwatch.hpp"

namespace triad::app {
namespace {

// A bar that any thread may move.
class SharedProgress {
 public:
  explicit SharedProgress(const std::string& what) : progress_(what) {}
  void update(double done) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock) progress_.update(done);
  }

 private:
  std::mutex mutex_;
  Progress progress_;
};

std::shared_ptr<const raytracer::Scene> load_scene(const SourceRequest& request) {
  Progress progress("loading " + request.name);
  const auto update = [&progress](double done) { progress.update(done); };
  return std::make_shared<const raytracer::Scene>(
      raytracer::load_gltf(scene_file(request.name), {request.camera, update}));
}

std::unique_ptr<raytracer::SceneSource> build_scene(std::shared_ptr<const raytracer::Scene> scene,
                                                    const SourceRequest& request) {
  raytracer::SourceOptions options;
  options.width = request.picture.width * request.cells.x;
  options.height = request.picture.height * request.cells.y;
  options.geometry = request.geometry;
  options.picture_aspect = static_cast<double>(request.picture.width) / request.picture.height;
  if (!request.effects.empty()) options.effects = raytracer::parse_effects(request.effects);
  options.max_depth = request.bounces;
  SharedProgress progress("building " + scene->file);
  options.camera = scene->camera;
  options.build_progress_user = &progress;
  options.build_progress = [](void* user, double done) {
    static_cast<SharedProgress*>(user)->update(done);
    return !cancel_requested();
  };
  return raytracer::make_scene_source(std::move(scene), options);
}

std::string camera_name(const raytracer::Scene& scene) {
  const std::string& name = scene.cameras[static_cast<size_t>(scene.camera)].name;
  return name.empty() ? std::to_string(scene.camera) : name;
}

OpenedSource open_scene(const SourceRequest& request) {
  OpenedSource opened;
  Stopwatch watch;
  if (!request.effects.empty()) raytracer::parse_effects(request.effects);  // before minutes of loading
  const auto scene = load_scene(request);
  for (const std::string& line : scene->warnings) warn(line);
  check_cancel();
  opened.load_s = watch.lap();
  auto source = build_scene(scene, request);
  for (const std::string& line : source->analysis().warnings) warn(line);
  opened.build_s = watch.lap();
  const std::string effects = raytracer::effects_text(source->effects());
  opened.summary = source->analysis().text();
  opened.facts = {{"scene", request.name},
                  {"camera", camera_name(*scene)},
                  {"effects", effects},
                  {"bounces", std::to_string(request.bounces)}};
  opened.record = {{"scene", request.name},
                   {"camera", camera_name(*scene)},
                   {"effects", effects},
                   {"kernel", raytracer::effects_text(source->kernel_effects())},
                   {"triangles", scene->triangle_count()},
                   {"memory_bytes", source->memory_bytes()}};
  opened.source = std::move(source);
  return opened;
}

OpenedSource open_function(const SourceRequest& request, const std::string& name) {
  OpenedSource opened;
  opened.source = make_function(request.name, request.picture.width, request.picture.height, request.cells, name);
  const std::string text = function_text(request.name, name);
  opened.facts = {{"function", text}};
  opened.record = {{"function", text}};
  return opened;
}

OpenedSource open_picture(const SourceRequest& request) {
  OpenedSource opened;
  Stopwatch watch;
  opened.source =
      make_image_source(request.name, request.picture.width, request.picture.height, request.cells,
                        ColourConfig::load(), {.geometry = request.geometry, .colour_space = request.colour_space});
  opened.load_s = watch.lap();
  opened.facts = {{"picture", request.name}};
  opened.record = {{"picture", request.name}};
  return opened;
}

}  // namespace

SourceKind source_kind(const std::string& name) {
  std::vector<std::string> scenes, functions;
  for (const BundledScene& scene : bundled_scenes()) scenes.push_back(scene.name);
  for (const FunctionInfo* info : function_list()) functions.push_back(info->name);
  const auto holds = [](const std::vector<std::string>& list, const std::string& each) {
    return std::find(list.begin(), list.end(), each) != list.end();
  };
  if (holds(scenes, name)) return SourceKind::kScene;
  const std::string bare = name.substr(0, name.find(':'));
  if (holds(functions, bare)) return SourceKind::kFunction;
  std::error_code error;
  if (bare.find_first_of("./") == std::string::npos && !std::filesystem::exists(name, error)) {
    std::vector<std::string> all = scenes;
    all.insert(all.end(), functions.begin(), functions.end());
    throw_usage("no bundled scene or function is called '" + bare + "'" + did_you_mean(bare, all) +
                ", and no file; there are the scenes '" + join(scenes, "', '") + "' and the functions '" +
                join(functions, "', '") + "'");
  }
  return has_picture_extension(name) ? SourceKind::kPicture : SourceKind::kScene;
}

OpenedSource open_source(const SourceRequest& request, const std::string& name) {
  switch (source_kind(request.name)) {
    case SourceKind::kFunction: return open_function(request, name);
    case SourceKind::kPicture: return open_picture(request);
    default: return open_scene(request);
  }
}

}  // namespace triad::app
