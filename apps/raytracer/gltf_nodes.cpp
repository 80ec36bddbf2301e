// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "gltf.hpp"

namespace triad::raytracer::gltf {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector4d;

std::string name_of(const File& file, int node) {
  return describe("node", static_cast<size_t>(node), file.model.nodes[static_cast<size_t>(node)].name);
}

void require_length(const File& file, int node, const std::vector<double>& list, size_t length, const char* what) {
  if (!list.empty() && list.size() != length)
    file.fail(name_of(file, node) + " has a " + what + " of " + std::to_string(list.size()) + " numbers; it takes " +
              std::to_string(length));
}

Transform compose(const Vector3d& translation, const Vector4d& rotation, const Vector3d& scale) {
  Transform transform = Transform::Identity();
  transform.translate(translation);
  transform.rotate(Quaterniond(rotation[3], rotation[0], rotation[1], rotation[2]));
  transform.scale(scale);
  return transform;
}

}  // namespace

Nodes::Nodes(File& file) : file_(file) {
  read_scene();
  read_animations();
}

void Nodes::read_scene() {
  const auto& model = file_.model;
  std::vector<int> roots;
  if (model.scenes.empty()) {  // legal: then every node that is nobody's child is drawn
    std::vector<bool> is_child(model.nodes.size());
    for (const auto& node : model.nodes)
      for (const int child : node.children)
        if (child >= 0 && static_cast<size_t>(child) < is_child.size()) is_child[static_cast<size_t>(child)] = true;
    for (size_t i = 0; i < model.nodes.size(); ++i)
      if (!is_child[i]) roots.push_back(static_cast<int>(i));
  } else {
    scene_ = model.defaultScene < 0 ? 0 : model.defaultScene;
    roots = file_.at(model.scenes, scene_, "scene", "the file's 'scene'").nodes;
  }

  struct Visit {
    int node, parent;
  };
  std::vector<bool> seen(model.nodes.size());
  std::vector<Visit> stack;  // not recursion: chains may be long
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, -1});
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const std::string user =
        visit.parent < 0 ? "the scene" : name_of(file_, entries_[static_cast<size_t>(visit.parent)].node);
    const auto& node = file_.at(model.nodes, visit.node, "node", user);
    if (seen[static_cast<size_t>(visit.node)]) {
      for (int up = visit.parent; up >= 0; up = entries_[static_cast<size_t>(up)].parent)
        if (entries_[static_cast<size_t>(up)].node == visit.node)
          file_.fail(name_of(file_, visit.node) + " is its own ancestor; nodes must form a tree");
      file_.fail(name_of(file_, visit.node) + " has two parents; nodes must form a tree");
    }
    seen[static_cast<size_t>(visit.node)] = true;
    require_length(file_, visit.node, node.translation, 3, "translation");
    require_length(file_, visit.node, node.rotation, 4, "rotation");
    require_length(file_, visit.node, node.scale, 3, "scale");
    require_length(file_, visit.node, node.matrix, 16, "matrix");
    const auto index = static_cast<int>(entries_.size());
    entries_.push_back({visit.node, visit.parent, false});
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
      stack.push_back({*child, index});
  }
}

void Nodes::read_animations() {
  const auto& model = file_.model;
  for (size_t a = 0; a < model.animations.size(); ++a) {
    const auto& animation = model.animations[a];
    const std::string user = describe("animation", a, animation.name);
    for (const auto& from : animation.channels) {
      if (from.target_node < 0) continue;  // meant for an extension
      const auto& node = file_.at(model.nodes, from.target_node, "node", user);
      if (from.target_path == "weights") {
        file_.warn(user + " changes shapes (morph targets), which are not drawn");
        continue;
      }
      const bool rotation = from.target_path == "rotation";
      if (!rotation && from.target_path != "translation" && from.target_path != "scale") {
        file_.warn(user + " changes '" + from.target_path + "', which is not known and is ignored");
        continue;
      }
      if (!node.matrix.empty())
        file_.fail(user + " moves " + name_of(file_, from.target_node) + ", which has a matrix");
      const auto& sampler = file_.at(animation.samplers, from.sampler, "sampler", user);
      Channel channel;
      channel.components = rotation ? 4 : 3;
      if (sampler.interpolation == "STEP") {
        channel.kind = Channel::Kind::kStep;
      } else if (sampler.interpolation == "CUBICSPLINE") {
        channel.kind = Channel::Kind::kCubic;
      } else if (sampler.interpolation != "LINEAR") {
        file_.fail(user + " has the interpolation '" + sampler.interpolation +
                   "'; there are LINEAR, STEP and CUBICSPLINE");
      }
      channel.times_s = read_floats(file_, sampler.input, 1, "the times of " + user);
      channel.values = read_floats(file_, sampler.output, channel.components, "the values of " + user);
      for (size_t i = 1; i < channel.times_s.size(); ++i)
        if (!(channel.times_s[i] > channel.times_s[i - 1]))
          file_.fail("the times of " + user + " do not increase: element " + std::to_string(i));
      const size_t each = static_cast<size_t>(channel.components) * (channel.kind == Channel::Kind::kCubic ? 3 : 1);
      if (channel.values.size() != channel.times_s.size() * each)
        file_.fail(user + " has " + std::to_string(channel.times_s.size()) + " times but values for " +
                   std::to_string(channel.values.size() / each));
      Animated& animated = animated_[from.target_node];
      int& slot = rotation                            ? animated.rotation
                  : from.target_path == "translation" ? animated.translation
                                                      : animated.scale;
      if (slot >= 0) {
        file_.warn("the " + from.target_path + " of " + name_of(file_, from.target_node) +
                   " is animated more than once; the first animation counts");
        continue;
      }
      slot = static_cast<int>(channels_.size());
      channels_.push_back(std::move(channel));
    }
  }
  for (Entry& entry : entries_)
    entry.animated =
        animated_.contains(entry.node) || (entry.parent >= 0 && entries_[static_cast<size_t>(entry.parent)].animated);
}

// glTF 2.0, appendix C: interpolation.
Eigen::Vector4d Nodes::Channel::at(double time_s) const {
  const auto key = [this](size_t i, size_t part) {
    const size_t parts = kind == Kind::kCubic ? 3 : 1;
    const float* from = values.data() + (i * parts + part) * static_cast<size_t>(components);
    Vector4d value(from[0], from[1], from[2], components == 4 ? from[3] : 0);
    return value;
  };
  const size_t point = kind == Kind::kCubic ? 1 : 0;  // a spline's keys are in-tangent, point, out-tangent
  const bool rotation = components == 4;
  const auto after = std::upper_bound(times_s.begin(), times_s.end(), time_s);
  if (after == times_s.begin()) return key(0, point);
  const auto i = static_cast<size_t>(after - times_s.begin()) - 1;
  if (after == times_s.end() || kind == Kind::kStep) return key(i, point);
  const double span_s = double{times_s[i + 1]} - double{times_s[i]}, t = (time_s - double{times_s[i]}) / span_s;
  if (kind == Kind::kCubic) {
    const double t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * key(i, 1) + span_s * (t3 - 2 * t2 + t) * key(i, 2) +
           (3 * t2 - 2 * t3) * key(i + 1, 1) + span_s * (t3 - t2) * key(i + 1, 0);
  }
  if (!rotation) return (1 - t) * key(i, 0) + t * key(i + 1, 0);
  const Vector4d a = key(i, 0), b = key(i + 1, 0);
  return Quaterniond(a[3], a[0], a[1], a[2])
      .normalized()
      .slerp(t, Quaterniond(b[3], b[0], b[1], b[2]).normalized())
      .coeffs();  // Eigen keeps x y z w, as glTF does; slerp takes the short way round
}

Transform Nodes::local(int index, bool animate, double time_s) const {
  const auto& node = file_.model.nodes[static_cast<size_t>(index)];
  if (!node.matrix.empty()) {
    const Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());  // columns first, as Eigen
    if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
      file_.fail(name_of(file_, index) + " has a matrix whose last row is not 0 0 0 1");
    Transform transform;
    transform.matrix() = matrix;
    return transform;
  }
  Vector3d translation = Vector3d::Zero(), scale = Vector3d::Ones();
  Vector4d rotation(0, 0, 0, 1);
  if (!node.translation.empty()) translation = Vector3d(node.translation.data());
  if (!node.rotation.empty()) rotation = Vector4d(node.rotation.data());
  if (!node.scale.empty()) scale = Vector3d(node.scale.data());
  if (const auto found = animated_.find(index); animate && found != animated_.end()) {
    const auto value = [&](int channel) { return channels_[static_cast<size_t>(channel)].at(time_s); };
    if (found->second.translation >= 0) translation = value(found->second.translation).head<3>();
    if (found->second.rotation >= 0) rotation = value(found->second.rotation);
    if (found->second.scale >= 0) scale = value(found->second.scale).head<3>();
  }
  const double length = rotation.stableNorm();
  if (!(length > 0) || !std::isfinite(length))
    file_.fail(name_of(file_, index) + " has a rotation of length " + (length == 0 ? "0" : "that is not finite"));
  return compose(translation, rotation / length, scale);
}

void Nodes::place(const std::optional<Shutter>& shutter) {
  worlds_.assign(entries_.size(), {});
  const bool lasts = shutter && shutter->close_s > shutter->open_s;
  for (size_t i = 0; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    const int instants = entry.animated && lasts ? kSteps + 1 : 1;
    for (int k = 0; k < instants; ++k) {
      const double time_s = shutter ? shutter->open_s + (shutter->close_s - shutter->open_s) * k / double{kSteps} : 0;
      Transform world = local(entry.node, shutter.has_value(), time_s);
      if (entry.parent >= 0) {
        const auto& above = worlds_[static_cast<size_t>(entry.parent)];
        world = above[std::min(static_cast<size_t>(k), above.size() - 1)] * world;
      }
      if (!world.matrix().allFinite()) file_.fail(name_of(file_, entry.node) + " has a transform that is not finite");
      worlds_[i].push_back(world);
    }
  }
}

int steps_needed(const std::vector<Transform>& worlds, const std::vector<Eigen::Vector3d>& points, double tolerance) {
  const bool rests = std::all_of(worlds.begin(), worlds.end(), [&worlds](const Transform& world) {
    return world.matrix() == worlds.front().matrix();
  });
  if (rests) return 0;
  const auto last = worlds.size() - 1;
  for (size_t steps = 1; steps < last; steps *= 2) {
    const size_t stride = last / steps;
    bool near = true;
    for (size_t k = 0; near && k < last; ++k) {
      const size_t begin = k / stride * stride;
      const double t = static_cast<double>(k - begin) / static_cast<double>(stride);
      for (const Vector3d& point : points) {
        const Vector3d line = (1 - t) * (worlds[begin] * point) + t * (worlds[begin + stride] * point);
        near = near && (line - worlds[k] * point).norm() <= tolerance;
      }
    }
    if (near) return static_cast<int>(steps);
  }
  return static_cast<int>(last);
}

}  // namespace triad::raytracer::gltf
