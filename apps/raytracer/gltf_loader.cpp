// SPDX-License-Identifier: Apache-2.0
#include "gltf_loader.hpp"

#include <algorithm>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>

#include "gltf.hpp"

namespace triad::raytracer {
namespace {

int choose_camera(const Scene& scene, const std::string& wanted) {
  if (wanted.empty()) return 0;
  std::vector<std::string> names;
  for (const Camera& camera : scene.cameras) names.push_back(camera.name);
  if (const auto found = std::find(names.begin(), names.end(), wanted); found != names.end())
    return static_cast<int>(found - names.begin());
  if (const auto number = parse_int(wanted); number && *number >= 0 && *number < std::ssize(names))
    return static_cast<int>(*number);
  if (names.empty()) throw_usage("'" + scene.file + "' has no camera '" + wanted + "': it has none at all");
  throw_usage("'" + scene.file + "' has no camera '" + wanted + "'" + did_you_mean(wanted, names) + "; it has " +
              join(names, ", ") + " (or by number, 0 to " + std::to_string(names.size() - 1) + ")");
}

bool gives_light(const Scene& scene) {
  if (!scene.environment.black()) return true;
  for (const Light& light : scene.lights)
    if (light.intensity != Float3{}) return true;
  for (const Mesh& mesh : scene.meshes) {
    const Material& material = scene.materials[static_cast<size_t>(mesh.material)];
    if (material.emits() || material.unlit) return true;
  }
  return false;
}

}  // namespace

Scene load_gltf(const std::string& path, const LoadOptions& options) {
  gltf::File file = gltf::parse_file(path);
  file.progress = options.progress;
  file.tell_progress(gltf::File::kParsed);
  Scene scene;
  scene.file = path;
  gltf::Nodes nodes(file);
  const auto uses = gltf::read_cameras(file, nodes, scene);
  scene.camera = choose_camera(scene, options.camera);
  const std::optional<gltf::Shutter> shutter =
      uses.empty() ? std::nullopt : uses[static_cast<size_t>(scene.camera)].shutter;
  if (nodes.has_animations() && !shutter)
    file.warn("its animations are not used: the camera's extras state no shutter_s");
  nodes.place(shutter);
  gltf::read_materials(file, scene);
  gltf::read_environment(file, nodes, scene);
  file.tell_progress(gltf::File::kPicturesRead);
  gltf::read_meshes(file, nodes, scene);
  gltf::place_cameras(file, nodes, uses, scene);
  if (scene.cameras.empty()) gltf::add_default_camera(file, scene);
  gltf::read_lights(file, nodes, scene);
  if (!gives_light(scene)) file.warn("nothing in it gives light, so the picture will be black");
  scene.warnings = std::move(file.warnings);
  return scene;
}

}  // namespace triad::raytracer
