// SPDX-License-Identifier: Apache-2.0
// The inside of the glTF loader: a parsed file, and the steps from it to a Scene.
#pragma once

// TinyGLTF parses; pictures are decoded by Triad's own reader, after the parse.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gltf_loader.hpp"

namespace triad::raytracer::gltf {

// A parsed file. Indices in the model are unchecked until at() saw them.
struct File {
  std::string path;
  tinygltf::Model model;
  std::vector<std::string> warnings;
  std::function<void(double)> progress{};

  // Shares of the seconds that a large file takes: parsed; materials and pictures read; accessors decoded; placed.
  static constexpr double kParsed = .3, kPicturesRead = .4, kMeshesRead = .7;
  void tell_progress(double done) const {
    if (progress) progress(done);
  }

  // Throws Error(kInput): "cannot read 'path': what".
  [[noreturn]] void fail(const std::string& what) const;
  // "'path': what"; the same words twice count once.
  void warn(const std::string& what);
  // list[index], or an error that says that `user` refers to `what` `index`, which is not there.
  template <typename T>
  const T& at(const std::vector<T>& list, int index, const char* what, const std::string& user) const {
    if (index < 0 || static_cast<size_t>(index) >= list.size()) fail_index(index, list.size(), what, user);
    return list[static_cast<size_t>(index)];
  }
  // The file that a relative URI of the scene means.
  std::string resolve(const std::string& uri) const;

 private:
  [[noreturn]] void fail_index(int index, size_t size, const char* what, const std::string& user) const;
};

// Largest coordinate, relative to the scene's origin, of what rays begin at or meet: its square fits a float and it
// is below the 1.8e18 that Embree allows, whose assertions end the program.
inline constexpr double kMostCoordinate_m = 1e15;
// Largest half-height and lens of a camera: a picture a million times as wide as high still stays within the above.
inline constexpr double kMostView_m = 1e9;

// Reads and parses; checks versions, nesting, required extensions. No accessor is looked at yet.
File parse_file(const std::string& path);

// "mesh 3 'chair'": how messages name a thing.
std::string describe(const char* what, size_t index, const std::string& name);

// A number or numbers of an extension or of extras; `fallback` where there is no such key. A value of another
// kind or one that is not finite is an error that names `key` and `user`.
double number_of(const File& file, const tinygltf::Value& object, const char* key, double fallback,
                 const std::string& user);
// The same for the number of a thing: whole, of either sign.
int index_of(const File& file, const tinygltf::Value& object, const char* key, int fallback, const std::string& user);
std::vector<double> numbers_of(const File& file, const tinygltf::Value& object, const char* key, size_t count,
                               std::vector<double> fallback, const std::string& user);
bool has(const tinygltf::Value& object, const char* key);

// --- accessors (gltf_accessor.cpp) ---

// count * components numbers. Integers become numbers as glTF 2.0 section 3.11 says if normalised, else as they
// are. Checks bounds, types, sparse entries and that every number is finite.
std::vector<float> read_floats(const File& file, int accessor, int components, const std::string& user);
// Scalar unsigned integers, each below `limit`.
std::vector<uint32_t> read_indices(const File& file, int accessor, uint64_t limit, const std::string& user);

// --- nodes (gltf_nodes.cpp) ---

using Transform = Eigen::Affine3d;

struct Shutter {
  double open_s = 0, close_s = 0;
};

// The nodes of the scene, parents before children, and where each is at each instant.
class Nodes {
 public:
  // A node with parents and its place in the world.
  struct Entry {
    int node = 0;           // index into Model::nodes
    int parent = -1;        // index into entries(), -1: a root
    bool animated = false;  // it or an ancestor
  };
  // Checks the hierarchy: every index, that no node is its own ancestor or has two parents.
  explicit Nodes(File& file);
  const std::vector<Entry>& entries() const { return entries_; }
  // Index into Model::scenes, -1 if the file has none.
  int scene() const { return scene_; }

  bool has_animations() const { return !animated_.empty(); }

  // Fills the table below. Without a shutter the nodes stand as in the file, whatever animations say.
  void place(const std::optional<Shutter>& shutter);
  // The world transform of an entry, at kSteps + 1 instants evenly spaced over the shutter's time if the entry
  // is animated and that time is not 0, else one.
  const std::vector<Transform>& worlds(size_t entry) const { return worlds_[entry]; }
  static constexpr int kSteps = 64;  // a power of two; Embree takes up to 128

 private:
  struct Channel {  // one animated property of one node
    std::vector<float> times_s, values;
    int components = 3;
    enum class Kind { kStep, kLinear, kCubic } kind = Kind::kLinear;
    Eigen::Vector4d at(double time_s) const;
  };
  struct Animated {
    int translation = -1, rotation = -1, scale = -1;  // indices into channels_
  };
  void read_scene();
  void read_animations();
  Transform local(int node, bool animate, double time_s) const;

  File& file_;
  int scene_ = -1;
  std::vector<Entry> entries_;
  std::vector<Channel> channels_;
  std::map<int, Animated> animated_;  // by node
  std::vector<std::vector<Transform>> worlds_;
};

// How many even steps (1, 2, 4 ... kSteps) a moving thing needs so that straight
// lines between them stray by no more than `tolerance` from each of the points' true paths; 0 if it stays put.
int steps_needed(const std::vector<Transform>& worlds, const std::vector<Eigen::Vector3d>& points, double tolerance);

// --- the parts of a scene ---

void read_materials(File& file, Scene& scene);  // gltf_material.cpp
// gltf_picture.cpp. Colour is decoded to linear light and keeps its alpha; data are as stored, without alpha.
Texture read_picture(const File& file, int image, bool colour);
// `user` is who asks, for the message.
Texture read_picture_file(const File& file, const std::string& uri, bool colour, const std::string& user);
void read_environment(File& file, const Nodes& nodes, Scene& scene);  // gltf_view.cpp
// A camera hangs on an entry of the nodes; its file says whether it has a shutter.
struct CameraUse {
  size_t entry = 0;
  std::optional<Shutter> shutter;
};
// Fills scene.cameras but for the poses, which place_cameras does, relative to scene.origin_m.
std::vector<CameraUse> read_cameras(File& file, const Nodes& nodes, Scene& scene);
void place_cameras(const File& file, const Nodes& nodes, const std::vector<CameraUse>& uses, Scene& scene);
void add_default_camera(File& file, Scene& scene);
void read_lights(File& file, const Nodes& nodes, Scene& scene);
void read_meshes(File& file, const Nodes& nodes, Scene& scene);  // gltf_mesh.cpp; sets origin and bounds

}  // namespace triad::raytracer::gltf
