// SPDX-License-Identifier: Apache-2.0
// What a scene is seen by and lit by: cameras, lights, surroundings.
#include <cmath>
#include <numbers>

#include "gltf.hpp"

namespace triad::raytracer::gltf {
namespace {

using Eigen::Vector3d;

Double3 to_double3(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Vector3d to_vector(const Double3& v) { return {v.x, v.y, v.z}; }
Vector3d to_vector(const Float3& v) { return {v.x, v.y, v.z}; }
Float3 to_float3(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

std::string name_of(const File& file, const Nodes& nodes, size_t entry) {
  const auto node = static_cast<size_t>(nodes.entries()[entry].node);
  return describe("node", node, file.model.nodes[node].name);
}

void require(const File& file, bool ok, const std::string& user, const std::string& what) {
  if (!ok) file.fail(user + " has " + what);
}

// Of a camera's extras and its node's, the camera's own win.
void read_lens(const File& file, const tinygltf::Value& extras, const std::string& user, Camera& camera,
               CameraUse& use) {
  camera.aperture_radius_m = number_of(file, extras, "aperture_radius_m", camera.aperture_radius_m, user);
  require(file, camera.aperture_radius_m >= 0 && camera.aperture_radius_m <= kMostView_m, user,
          "an aperture_radius_m below 0 or above 1e9");
  camera.focus_distance_m = number_of(file, extras, "focus_distance_m", camera.focus_distance_m, user);
  constexpr double kLeastFocus_m = 1e-9;  // its square does not vanish beside that of a lens
  require(file, camera.focus_distance_m >= kLeastFocus_m && camera.focus_distance_m <= kMostCoordinate_m, user,
          "a focus_distance_m that is not from 1e-9 to 1e15");
  if (!has(extras, "shutter_s")) return;
  Shutter shutter;
  if (extras.Get("shutter_s").IsArray()) {
    const auto times = numbers_of(file, extras, "shutter_s", 2, {}, user);
    shutter = {times[0], times[1]};
  } else {
    shutter.close_s = number_of(file, extras, "shutter_s", 0, user);
  }
  require(file, shutter.close_s >= shutter.open_s, user, "a shutter_s that closes before it opens");
  use.shutter = shutter;
}

void read_projection(const File& file, const tinygltf::Camera& from, const std::string& user, Camera& camera) {
  if (from.type == "perspective") {
    camera.yfov_rad = from.perspective.yfov;
    require(file, camera.yfov_rad > 0 && camera.yfov_rad < std::numbers::pi, user,
            "a yfov that is not between 0 and pi");
    camera.aspect_ratio = std::max(0., from.perspective.aspectRatio);
  } else if (from.type == "orthographic") {
    camera.orthographic = true;
    camera.half_height_m = std::abs(from.orthographic.ymag);
    require(file, camera.half_height_m > 0 && camera.half_height_m <= kMostView_m, user, "a ymag of 0 or above 1e9");
    camera.aspect_ratio = std::abs(from.orthographic.xmag) / camera.half_height_m;
  } else {
    file.fail(user + " is of type '" + from.type + "'; there are perspective and orthographic");
  }
}

Vector3d placed(const File& file, const Transform& world, const Vector3d& origin, const std::string& user) {
  const Vector3d position = world.translation() - origin;
  require(file, position.norm() <= kMostCoordinate_m, user, "a place more than 1e15 m from the scene");
  return position;
}

CameraPose pose_of(const File& file, const Transform& world, const Vector3d& origin, const std::string& user) {
  const Vector3d back = world.linear().col(2).stableNormalized();
  Vector3d up = world.linear().col(1).stableNormalized();
  up = (up - back * back.dot(up)).stableNormalized();
  Vector3d right = up.cross(back);
  if (world.linear().determinant() < 0) right = -right;  // a mirrored node shows a mirrored picture
  if (std::abs(right.norm() - 1) > 1e-6) file.fail("the camera of " + user + " has a singular matrix");
  return {to_double3(placed(file, world, origin, "the camera of " + user)), to_double3(right), to_double3(up),
          to_double3(-back)};
}

// Whether axes half way between the two have lengths to divide by: the turn is well below half a circle.
bool near(const CameraPose& a, const CameraPose& b) {
  const auto dot = [](const Double3& u, const Double3& v) { return u.x * v.x + u.y * v.y + u.z * v.z; };
  const double trace = dot(a.right, b.right) + dot(a.up, b.up) + dot(a.forward, b.forward);  // 1 + 2 cos(turn)
  return trace > -.9;
}

}  // namespace

std::vector<CameraUse> read_cameras(File& file, const Nodes& nodes, Scene& scene) {
  std::vector<CameraUse> uses;
  for (size_t e = 0; e < nodes.entries().size(); ++e) {
    const auto& node = file.model.nodes[static_cast<size_t>(nodes.entries()[e].node)];
    if (node.camera == -1) continue;
    const auto& from = file.at(file.model.cameras, node.camera, "camera", name_of(file, nodes, e));
    const std::string user = describe("camera", static_cast<size_t>(node.camera), from.name);
    Camera camera;
    CameraUse use{e, std::nullopt};
    camera.name = node.name.empty() ? from.name : node.name;
    read_projection(file, from, user, camera);
    read_lens(file, node.extras, name_of(file, nodes, e), camera, use);
    read_lens(file, from.extras, user, camera, use);
    if (use.shutter) {
      camera.shutter_open_s = use.shutter->open_s;
      camera.shutter_close_s = use.shutter->close_s;
    }
    scene.cameras.push_back(std::move(camera));
    uses.push_back(use);
  }
  return uses;
}

void place_cameras(const File& file, const Nodes& nodes, const std::vector<CameraUse>& uses, Scene& scene) {
  constexpr double kTolerance = 1e-4;  // of the scene's size: far below a pixel
  const Vector3d origin = to_vector(scene.origin_m);
  const double size_m = (to_vector(scene.bounds_max_m) - to_vector(scene.bounds_min_m)).norm();
  const std::vector<Vector3d> frame{Vector3d::Zero(), size_m * Vector3d::UnitX(), size_m * Vector3d::UnitY()};
  for (size_t i = 0; i < uses.size(); ++i) {
    const auto& worlds = nodes.worlds(uses[i].entry);
    const std::string user = name_of(file, nodes, uses[i].entry);
    const int steps = steps_needed(worlds, frame, kTolerance * size_m);
    auto& poses = scene.cameras[i].poses;
    poses.clear();
    for (int step = 0; step <= steps; ++step) {
      poses.push_back(
          pose_of(file, worlds[static_cast<size_t>(steps == 0 ? 0 : step * Nodes::kSteps / steps)], origin, user));
      if (step > 0 && !near(poses[poses.size() - 2], poses.back()))
        file.fail("the camera of " + user + " turns too fast: about half round between two of " +
                  std::to_string(steps + 1) + " instants");
    }
  }
}

void add_default_camera(File& file, Scene& scene) {
  Camera camera;
  camera.name = "default";
  const Vector3d low = to_vector(scene.bounds_min_m), high = to_vector(scene.bounds_max_m);
  const double radius_m = (high - low).norm() / 2;
  const Vector3d back = Vector3d(.5, .35, 1).normalized();  // from the front, a little from the right and above
  const Vector3d right = Vector3d::UnitY().cross(back).normalized();
  camera.yfov_rad = .8;
  // The bounding sphere touches the upper and lower edges of the picture.
  const double distance_m = radius_m / std::sin(camera.yfov_rad / 2);
  camera.focus_distance_m = distance_m;
  camera.poses = {{to_double3((low + high) / 2 + distance_m * back), to_double3(right), to_double3(back.cross(right)),
                   to_double3(-back)}};
  scene.cameras.push_back(std::move(camera));
  file.warn("it has no camera; it is seen by one that frames it");
}

void read_lights(File& file, const Nodes& nodes, Scene& scene) {
  const Vector3d origin = to_vector(scene.origin_m);
  for (size_t e = 0; e < nodes.entries().size(); ++e) {
    const auto& node = file.model.nodes[static_cast<size_t>(nodes.entries()[e].node)];
    const auto found = node.extensions.find("KHR_lights_punctual");
    if (found == node.extensions.end()) continue;
    const std::string user = name_of(file, nodes, e);
    const int index = index_of(file, found->second, "light", -1, user);
    const auto& from = file.at(file.model.lights, index, "light", user);
    const std::string whose = describe("light", static_cast<size_t>(index), from.name);
    Light light;
    light.name = node.name.empty() ? from.name : node.name;
    const auto& world = nodes.worlds(e).front();
    const auto& later = nodes.worlds(e).back();
    if (world.matrix() != later.matrix())
      file.warn(user + " moves a light while the shutter is open; the light stays where it was when it opened");
    const Vector3d direction = -world.linear().col(2).stableNormalized();
    if (from.type == "directional") {
      light.kind = LightKind::kDirectional;
    } else if (from.type == "spot") {
      light.kind = LightKind::kSpot;
      const double inner = from.spot.innerConeAngle, outer = from.spot.outerConeAngle;
      require(file, inner >= 0 && inner < outer && outer <= std::numbers::pi / 2 + 1e-6, whose,
              "cone angles that are not 0 <= inner < outer <= pi/2");
      light.inner_cone_rad = static_cast<float>(inner);
      light.outer_cone_rad = static_cast<float>(outer);
    } else if (from.type != "point") {
      file.fail(whose + " is of type '" + from.type + "'; there are directional, point and spot");
    }
    if (light.kind != LightKind::kPoint && !(std::abs(direction.norm() - 1) < 1e-6))
      file.fail(whose + " hangs on " + user + ", which has a singular matrix");
    if (light.kind != LightKind::kDirectional) light.position_m = to_float3(placed(file, world, origin, user));
    light.direction = to_float3(direction);
    if (!from.color.empty() && from.color.size() != 3) file.fail(whose + " has a colour that is not three numbers");
    Vector3d intensity = Vector3d::Constant(from.intensity);
    if (!from.color.empty()) intensity = intensity.cwiseProduct(Vector3d(from.color.data()));
    constexpr double kMost = 1e30;  // room in a float for sums and products
    require(file, intensity.minCoeff() >= 0 && intensity.maxCoeff() <= kMost, whose,
            "an intensity or colour that is below 0 or too large");
    if (from.range > 0)
      file.warn(whose + " has a range, which is ignored: light falls off with the square of distance");
    light.intensity = to_float3(intensity);
    scene.lights.push_back(std::move(light));
  }
}

void read_environment(File& file, const Nodes& nodes, Scene& scene) {
  if (nodes.scene() < 0) return;
  const auto& extras = file.model.scenes[static_cast<size_t>(nodes.scene())].extras;
  const std::string user = "the scene's extras";
  constexpr double kMost = 1e18;
  const auto check = [&](double value, const char* key) {
    if (!(value >= 0 && value <= kMost)) file.fail(std::string(key) + " of " + user + " is below 0 or too large");
    return static_cast<float>(value);
  };
  if (has(extras, "background") && has(extras, "environment"))
    file.fail(user + " have both 'background' and 'environment'; one of them is possible");
  if (has(extras, "background")) {
    const auto rgb = numbers_of(file, extras, "background", 3, {}, user);
    scene.environment.radiance = {check(rgb[0], "background"), check(rgb[1], "background"),
                                  check(rgb[2], "background")};
  }
  if (!has(extras, "environment")) return;
  if (!extras.Get("environment").IsString()) file.fail("'environment' of " + user + " is not the name of a picture");
  const float strength = check(number_of(file, extras, "environment_strength", 1, user), "environment_strength");
  scene.environment.radiance = {strength, strength, strength};
  scene.environment.texture = static_cast<int>(scene.textures.size());
  scene.textures.push_back(
      read_picture_file(file, extras.Get("environment").Get<std::string>(), true, "the scene's 'environment'"));
}

}  // namespace triad::raytracer::gltf
