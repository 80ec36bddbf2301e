// SPDX-License-Identifier: Apache-2.0
// Triangles for the bundled scenes, and the glTF file that they go into.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

namespace make_scenes {

using nlohmann::json;
constexpr double kPi = std::numbers::pi;

struct Vec {
  double x = 0, y = 0, z = 0;
};
inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(double s, Vec v) { return {s * v.x, s * v.y, s * v.z}; }
inline Vec cross(Vec a, Vec b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec unit(Vec v) { return 1 / std::sqrt(dot(v, v)) * v; }

// Triangles with normals and, if has_uv, texture coordinates.
struct Shape {
  std::vector<Vec> positions, normals;
  std::vector<std::array<double, 2>> uvs;
  std::vector<uint32_t> indices;
  bool has_uv = false;

  uint32_t vertex(Vec position, Vec normal, double u = 0, double v = 0);
  // Corners counter-clockwise seen from the front; `across` by `along` cells.
  void quad(Vec a, Vec b, Vec c, Vec d, int across = 1, int along = 1);
  void add(const Shape& other, Vec offset = {});
};

// Round the origin.
Shape box(Vec size, int cells = 1);
Shape sphere(double radius, int around, int down);
// Of revolution about y: (radius, height) points from bottom to top.
Shape lathe(const std::vector<std::array<double, 2>>& profile, int around);
Shape torus(double ring_radius, double tube_radius, int around, int across);  // about z
// A cylinder without ends.
Shape rod(Vec from, Vec to, double radius, int around);

// In the plane z, facing +z.
Shape stroke(double x0, double y0, double x1, double y1, double width, double z = 0);
Shape ring(double x, double y, double inner, double outer, int around, double z = 0);  // inner 0: a disc
// Text of strokes: capitals and digits of a 4 x 6 grid scaled to `height`, its base line from (x, y) at an angle.
Shape text(const std::string& words, double x, double y, double height, double width, double angle_rad = 0);

// A quaternion x y z w.
json turn(Vec axis, double angle_rad);

class Gltf {
 public:
  // About the scene, for people who open the file.
  explicit Gltf(const std::string& about);
  int material(const std::string& name, json value);
  int unlit(const std::string& name, Vec colour);
  // Diffuse only: index of refraction 1 takes glTF's gloss away.
  int diffuse(const std::string& name, Vec colour);
  int metal(const std::string& name, Vec colour, double roughness);
  int lamp(const std::string& name, Vec radiance);
  int mesh(const std::string& name, const Shape& shape, int material);
  // Index of the node; `more` holds translation, rotation, scale ...
  int node(const std::string& name, int mesh, json more = json::object());
  int place(const std::string& name, const Shape& shape, int material, json more = json::object());
  // An 8-bit RGB or RGBA picture and a texture of it.
  int texture(int width, int height, const std::string& pixels, bool nearest, int wrap = 10497);
  void perspective(Vec eye, Vec target, double yfov_rad, json extras = json::object());
  void orthographic(double half_height, double half_width);
  void background(Vec radiance);
  void light(const std::string& name, json light, json node);
  // One animated property of one node.
  void animate(int node, const std::string& path, const std::vector<double>& times_s,
               const std::vector<double>& values, int components);
  void require(const std::string& extension);
  void save(const std::string& path) const;

 private:
  int push(const char* key, json value);
  int view(const std::string& bytes);
  int floats(const std::vector<double>& values, int components, bool bounds);
  json root_;
  std::string buffer_;
  std::map<std::string, int> views_;  // by what is in them
};

// Each writes files into a folder, with a slash at its end.
void make_flat_scenes(const std::string& folder);
void make_solid_scenes(const std::string& folder);
void make_room(const std::string& folder);

}  // namespace make_scenes
