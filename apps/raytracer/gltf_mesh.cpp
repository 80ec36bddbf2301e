// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <triad/base/file.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>

#include "gltf.hpp"

namespace triad::raytracer::gltf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Bounds = Eigen::AlignedBox3d;

constexpr uint64_t kMostVertices = uint64_t{1} << 28;  // all instances and instants together: some 10 GB
constexpr double kMotionTolerance = 1e-3;              // of a mesh's diagonal
constexpr double kFar = 16;  // half-diagonals from the origin, beyond which float would lose 4 bits and more

// A glTF primitive as it is in the file, before any node's transform.
struct Primitive {
  std::string user;
  std::vector<float> positions, normals;  // three each
  std::array<std::vector<Float2>, 2> texcoords;
  std::vector<std::array<uint32_t, 3>> triangles;
  int material = -1;
  Bounds bounds;

  size_t vertex_count() const { return positions.size() / 3; }
  std::vector<Vector3d> corners() const {
    std::vector<Vector3d> list;
    for (int i = 0; i < 8; ++i) list.push_back(bounds.corner(static_cast<Bounds::CornerType>(i)));
    return list;
  }
};

// A primitive in a place.
struct Instance {
  const Primitive* primitive = nullptr;
  size_t entry = 0;  // of Nodes
  int steps = 0;     // of motion; 0: at rest
  uint32_t object_id = 0;
  std::string name;
};

std::vector<std::array<uint32_t, 3>> triangles_of(const File& file, const std::vector<uint32_t>& list, int mode,
                                                  const std::string& user) {
  const size_t count = list.size();
  const bool whole = mode == TINYGLTF_MODE_TRIANGLES ? count % 3 == 0 : count >= 3;
  if (!whole) file.fail(user + ": " + std::to_string(count) + " vertices do not make whole triangles");
  std::vector<std::array<uint32_t, 3>> triangles;
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    triangles.reserve(count / 3);
    for (size_t i = 0; i < count; i += 3) triangles.push_back({list[i], list[i + 1], list[i + 2]});
    return triangles;
  }
  triangles.reserve(count - 2);
  for (size_t i = 0; i + 2 < count; ++i) {
    if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
      triangles.push_back({list[i + 1], list[i + 2], list[0]});
    } else {  // every other triangle of a strip is the other way round (glTF 2.0, section 3.7.2.1)
      triangles.push_back({list[i], list[i + 1 + i % 2], list[i + 2 - i % 2]});
    }
  }
  return triangles;
}

// One unit normal for each vertex, or none: where one has no direction, the triangles' own serve better.
std::vector<float> unit_normals(File& file, std::vector<float> normals, const std::string& user) {
  for (size_t i = 0; i < normals.size(); i += 3) {
    const double length = Vector3d(normals[i], normals[i + 1], normals[i + 2]).stableNorm();
    if (length == 0) {
      file.warn(user + " has normals of length 0; it is shaded flat");
      return {};
    }
    for (size_t c = 0; c < 3; ++c) normals[i + c] = static_cast<float>(normals[i + c] / length);
  }
  return normals;
}

Primitive read_primitive(File& file, const tinygltf::Primitive& from, const std::string& user) {
  Primitive primitive;
  primitive.user = user;
  primitive.material = from.material;
  const auto attribute = [&from](const char* name) {
    const auto found = from.attributes.find(name);
    return found == from.attributes.end() ? -1 : found->second;
  };
  const auto present = [&from](const char* name) { return from.attributes.contains(name); };
  const auto same_count = [&](size_t count, const char* name) {
    if (count != primitive.vertex_count())
      file.fail(std::string(name) + " of " + user + " has " + std::to_string(count) + " elements, POSITION has " +
                std::to_string(primitive.vertex_count()));
  };
  primitive.positions = read_floats(file, attribute("POSITION"), 3, "POSITION of " + user);
  for (size_t i = 0; i < primitive.positions.size(); i += 3)
    primitive.bounds.extend(Eigen::Map<const Eigen::Vector3f>(primitive.positions.data() + i).cast<double>());
  if (present("NORMAL")) {
    primitive.normals = unit_normals(file, read_floats(file, attribute("NORMAL"), 3, "NORMAL of " + user), user);
    if (!primitive.normals.empty()) same_count(primitive.normals.size() / 3, "NORMAL");
  }
  for (size_t set = 0; set < 2; ++set) {
    const char* name = set == 0 ? "TEXCOORD_0" : "TEXCOORD_1";
    if (!present(name)) continue;
    const std::vector<float> numbers = read_floats(file, attribute(name), 2, std::string(name) + " of " + user);
    same_count(numbers.size() / 2, name);
    for (size_t i = 0; i < numbers.size(); i += 2) primitive.texcoords[set].push_back({numbers[i], numbers[i + 1]});
  }
  if (present("COLOR_0")) file.warn(user + " has vertex colours, which are not used");
  if (!from.targets.empty()) file.warn(user + " has other shapes (morph targets), which are not drawn");

  std::vector<uint32_t> list;
  if (from.indices != -1) {
    list = read_indices(file, from.indices, primitive.vertex_count(), "the list of indices of " + user);
  } else {
    list.resize(primitive.vertex_count());
    std::iota(list.begin(), list.end(), 0u);
  }
  primitive.triangles = triangles_of(file, list, from.mode, user);
  return primitive;
}

std::vector<Primitive> read_mesh(File& file, int index) {
  const auto& mesh = file.model.meshes[static_cast<size_t>(index)];
  std::vector<Primitive> primitives;
  for (size_t p = 0; p < mesh.primitives.size(); ++p) {
    const auto& from = mesh.primitives[p];
    std::string user = describe("mesh", static_cast<size_t>(index), mesh.name);
    if (mesh.primitives.size() > 1) user += ", primitive " + std::to_string(p);
    if (from.mode >= TINYGLTF_MODE_POINTS && from.mode <= TINYGLTF_MODE_LINE_STRIP) {
      file.warn(user + " is made of points or lines, which are not drawn");
      continue;
    }
    if (from.mode < TINYGLTF_MODE_TRIANGLES || from.mode > TINYGLTF_MODE_TRIANGLE_FAN)
      file.fail(user + " has the mode " + std::to_string(from.mode) + "; there are 0 to 6");
    if (from.material != -1) file.at(file.model.materials, from.material, "material", user);
    primitives.push_back(read_primitive(file, from, user));
  }
  return primitives;
}

std::string instance_name(const std::string& node, const std::string& mesh, const Primitive& primitive) {
  if (!node.empty()) return node;
  return mesh.empty() ? primitive.user : mesh;
}

// Where a float has too few bits for coordinates this far out, the middle of the scene, in whole metres so
// that distances between vertices survive exactly.
Vector3d choose_origin(File& file, const Bounds& bounds) {
  const Vector3d centre = bounds.center();
  if (!(bounds.diagonal().norm() <= kMostCoordinate_m))
    file.fail("its coordinates are too large: it is " + format_double(bounds.diagonal().norm()) +
              " m across; at most 1e15 m are possible");
  if (centre.cwiseAbs().maxCoeff() <= kFar * bounds.diagonal().norm() / 2) return Vector3d::Zero();
  Vector3d origin = centre.array().round();
  if (bounds.diagonal().norm() < 1) origin = centre;  // a metre is too coarse for it
  file.warn("it lies far from the origin; it is drawn relative to (" + std::to_string(origin.x()) + ", " +
            std::to_string(origin.y()) + ", " + std::to_string(origin.z()) + ")");
  return origin;
}

Float3 to_float(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

std::vector<Float3> transformed_positions(const Primitive& primitive, const Transform& world,
                                          const Vector3d& origin) {
  std::vector<Float3> out(primitive.vertex_count());
  const Matrix3d linear = world.linear();
  const Vector3d offset = world.translation() - origin;
  for (size_t i = 0; i < out.size(); ++i) {
    const float* p = primitive.positions.data() + 3 * i;
    out[i] = to_float(linear * Vector3d(p[0], p[1], p[2]) + offset);
  }
  return out;
}

// Normals go by the matrix of cofactors, det(M) M^-T, which exists for flattened nodes too.
std::vector<Float3> transformed_normals(const Primitive& primitive, const Matrix3d& linear) {
  std::vector<Float3> out(primitive.normals.size() / 3);
  Matrix3d cofactors;
  cofactors << linear.col(1).cross(linear.col(2)), linear.col(2).cross(linear.col(0)),
      linear.col(0).cross(linear.col(1));
  if (linear.determinant() < 0) cofactors = -cofactors;
  for (size_t i = 0; i < out.size(); ++i) {
    const float* n = primitive.normals.data() + 3 * i;
    const Vector3d normal = cofactors * Vector3d(n[0], n[1], n[2]);
    const double length = normal.stableNorm();
    if (!(length > 0)) return {};  // flattened edge-on: no direction is left
    out[i] = to_float(normal / length);
  }
  return out;
}

double area_of(const std::vector<Float3>& positions, const std::vector<std::array<uint32_t, 3>>& triangles) {
  const auto at = [&positions](uint32_t i) { return Vector3d(positions[i].x, positions[i].y, positions[i].z); };
  double sum = 0;
  for (const auto& t : triangles) sum += (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).norm();
  return sum / 2;
}

Mesh build(const Instance& instance, const Nodes& nodes, const Vector3d& origin) {
  const Primitive& primitive = *instance.primitive;
  const auto& worlds = nodes.worlds(instance.entry);
  Mesh mesh;
  mesh.name = instance.name;
  mesh.object_id = instance.object_id;
  mesh.material = primitive.material;
  mesh.texcoords = primitive.texcoords;
  mesh.indices = primitive.triangles;
  if (worlds[0].linear().determinant() < 0)  // a mirrored node turns triangles round (glTF 2.0, section 3.5.3)
    for (auto& triangle : mesh.indices) std::swap(triangle[1], triangle[2]);
  mesh.positions = transformed_positions(primitive, worlds[0], origin);
  mesh.normals = transformed_normals(primitive, worlds[0].linear());
  for (int step = 1; step <= instance.steps; ++step) {
    const auto& world = worlds[static_cast<size_t>(step * Nodes::kSteps / instance.steps)];
    mesh.motion_positions.push_back(transformed_positions(primitive, world, origin));
    if (mesh.normals.empty()) continue;
    mesh.motion_normals.push_back(transformed_normals(primitive, world.linear()));
    if (mesh.motion_normals.back().empty()) {  // vanishes on the way: shade flat at all times
      mesh.normals.clear();
      mesh.motion_normals.clear();
    }
  }
  return mesh;
}

void extend(Bounds& bounds, const std::vector<Float3>& positions) {
  for (const Float3& p : positions) bounds.extend(Vector3d(p.x, p.y, p.z));
}

}  // namespace

void read_meshes(File& file, const Nodes& nodes, Scene& scene) {
  std::map<int, std::vector<Primitive>> primitives;  // by mesh; a map, so that addresses stay
  std::vector<Instance> instances;
  Bounds bounds;
  uint32_t object_id = 0;
  double vertices = 0;
  for (size_t e = 0; e < nodes.entries().size(); ++e) {
    const auto index = static_cast<size_t>(nodes.entries()[e].node);
    const auto& node = file.model.nodes[index];
    if (node.mesh == -1) continue;
    const std::string user = describe("node", index, node.name);
    const auto& mesh = file.at(file.model.meshes, node.mesh, "mesh", user);
    if (node.skin >= 0) file.warn(user + " has a skin, which is not applied: its mesh is drawn as it was modelled");
    const auto [place, fresh] = primitives.try_emplace(node.mesh);
    if (fresh) {
      check_cancel();
      place->second = read_mesh(file, node.mesh);
      const double share = static_cast<double>(primitives.size()) / static_cast<double>(file.model.meshes.size());
      file.tell_progress(std::lerp(File::kPicturesRead, File::kMeshesRead, share));
    }
    const Matrix3d linear = nodes.worlds(e)[0].linear();
    if (!(std::abs(linear.determinant()) > 1e-15 * std::pow(linear.norm(), 3)))
      file.warn(user + " has a singular matrix: what hangs on it is flat");
    ++object_id;
    for (const Primitive& primitive : place->second) {
      const auto corners = primitive.corners();
      Bounds own;
      for (const Transform& world : nodes.worlds(e))
        for (const Vector3d& corner : corners) own.extend(world * corner);
      const int steps = steps_needed(nodes.worlds(e), corners, kMotionTolerance * own.diagonal().norm());
      bounds.extend(own);
      vertices += static_cast<double>(primitive.vertex_count()) * (1 + steps);
      instances.push_back({&primitive, e, steps, object_id, instance_name(node.name, mesh.name, primitive)});
    }
  }
  if (instances.empty()) file.fail("it has no triangles to draw");
  if (vertices > static_cast<double>(kMostVertices))
    file.fail("it needs " + std::to_string(vertices) + " vertices, instances and motion counted; at most " +
              std::to_string(kMostVertices) + " are possible");

  const Vector3d origin = choose_origin(file, bounds);
  scene.origin_m = {origin.x(), origin.y(), origin.z()};
  std::vector<Mesh> built(instances.size());
  std::vector<double> areas(instances.size());
  parallel_for(static_cast<int64_t>(instances.size()), [&](int64_t i) {
    check_cancel();
    const auto k = static_cast<size_t>(i);
    built[k] = build(instances[k], nodes, origin);
    areas[k] = area_of(built[k].positions, built[k].indices);
    if (built[k].moves()) areas[k] += area_of(built[k].motion_positions.back(), built[k].indices);
  });

  file.tell_progress(1);
  Bounds final_bounds;
  for (size_t k = 0; k < built.size(); ++k) {
    Mesh& mesh = built[k];
    if (!std::isfinite(areas[k])) file.fail(instances[k].primitive->user + " is too large: its area is not finite");
    if (areas[k] == 0) {
      file.warn(instances[k].primitive->user + " has no area; it is left out");
      continue;
    }
    if (mesh.material < 0) {  // glTF's default material, once
      if (scene.materials.size() == file.model.materials.size()) scene.materials.emplace_back().name = "default";
      mesh.material = static_cast<int>(file.model.materials.size());
    }
    extend(final_bounds, mesh.positions);
    for (const auto& positions : mesh.motion_positions) extend(final_bounds, positions);
    scene.meshes.push_back(std::move(mesh));
  }
  if (scene.meshes.empty()) file.fail("it has no triangles to draw: none has an area");
  scene.bounds_min_m = to_float(final_bounds.min());
  scene.bounds_max_m = to_float(final_bounds.max());
}

}  // namespace triad::raytracer::gltf
