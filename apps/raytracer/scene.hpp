// SPDX-License-Identifier: Apache-2.0
// What the ray tracer draws: plain data, filled by a loader or by hand, read by everyone else. Nothing in it
// changes after loading, so any number of threads may read it.
//
// World: right-handed, y up, metres, as in glTF 2.0. Light is linear RGB with the primaries of sRGB.
// Coordinates are relative to Scene::origin_m, so that float suffices for a scene that lies far away.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace triad::raytracer {

struct Float2 {
  float x = 0, y = 0;
  bool operator==(const Float2&) const = default;
};
struct Float3 {
  float x = 0, y = 0, z = 0;
  bool operator==(const Float3&) const = default;
};
struct Double3 {
  double x = 0, y = 0, z = 0;
  bool operator==(const Double3&) const = default;
};

enum class Wrap : uint8_t { kRepeat, kClamp, kMirror };

// A picture in memory, straight (not premultiplied) alpha, row 0 at the top, where v = 0.
// Colour pictures are decoded to linear light; data pictures (roughness ...) are as stored, 0 to 1.
struct Texture {
  std::string name;
  int width = 0, height = 0;
  int channels = 3;           // 3: RGB; 4: RGBA
  std::vector<float> texels;  // width * height * channels, interleaved
};

// One use of a texture: which, with which coordinates, and what happens past its edges.
struct TextureUse {
  int texture = -1;  // index into Scene::textures; -1: none, the factor alone counts
  int texcoord = 0;  // which set of the mesh: 0 or 1
  Wrap wrap_u = Wrap::kRepeat, wrap_v = Wrap::kRepeat;
  bool nearest = false;  // no interpolation between texels
  // u' = transform[0] u + transform[1] v + transform[2]; v' = transform[3] u + transform[4] v + transform[5]
  // (KHR_texture_transform: translation * rotation * scale).
  std::array<float, 6> transform{1, 0, 0, 0, 1, 0};
};

enum class AlphaMode : uint8_t {
  kOpaque,  // alpha is ignored
  kMask,    // opaque where alpha >= alpha_cutoff, else not there
  kBlend    // there with probability alpha
};

// glTF's metallic-roughness model (Khronos glTF 2.0, appendix B) with the extensions named. Every factor is
// multiplied by its texture where there is one.
struct Material {
  std::string name;
  Float3 base_color{1, 1, 1};
  float alpha = 1;         // texture: the alpha of base_color_texture
  float metallic = 1;      // 0 ... 1; texture: blue
  float roughness = 1;     // 0 ... 1, the square root of GGX's alpha; texture: green
  Float3 emission;         // radiance, with KHR_materials_emissive_strength multiplied in
  float ior = 1.5f;        // >= 1, or 0 for KHR_materials_ior's special value: all light is reflected
  float transmission = 0;  // 0 ... 1, KHR_materials_transmission; texture: red
  bool unlit = false;      // KHR_materials_unlit: shows base_color as it is, neither lights nor is lit
  bool double_sided = false;
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  float alpha_cutoff = .5f;
  TextureUse base_color_texture, metallic_roughness_texture, emission_texture, transmission_texture;

  bool emits() const { return emission.x > 0 || emission.y > 0 || emission.z > 0; }
};

// Triangles of one material. Vertices are in world space, the node's transform applied; triangles are
// counter-clockwise seen from the front.
struct Mesh {
  std::string name;
  std::vector<Float3> positions;
  std::vector<Float3> normals;                   // unit length; empty: flat shading with the triangles' own
  std::array<std::vector<Float2>, 2> texcoords;  // each empty, or one for each vertex
  std::vector<std::array<uint32_t, 3>> indices;  // each below positions.size()
  int material = 0;                              // index into Scene::materials
  uint32_t object_id = 0;                        // from 1, one for each node with a mesh; 0 is left for "nothing hit"
  // Motion: further sets of vertices, evenly spaced over the shutter's time after positions and normals, which
  // are at its opening; the last set is at its closing. Empty: at rest. motion_normals is empty where normals is.
  std::vector<std::vector<Float3>> motion_positions, motion_normals;

  bool moves() const { return !motion_positions.empty(); }
};

enum class LightKind : uint8_t { kPoint, kSpot, kDirectional };

// A light without size (KHR_lights_punctual). Lights with size are triangles of a material that emits.
struct Light {
  std::string name;
  LightKind kind = LightKind::kPoint;
  Float3 position_m;  // point and spot
  Float3 direction;   // spot and directional: the way the light travels, unit length
  Float3 intensity;   // colour times candela (point, spot: irradiance = intensity / distance^2) or lux
  float inner_cone_rad = 0, outer_cone_rad = 0.7853982f;  // half angles; spot: 0 <= inner < outer <= pi/2
};

// Where a camera stands: its axes are orthonormal; it looks along `forward`.
struct CameraPose {
  Double3 position_m;  // relative to Scene::origin_m
  Double3 right{1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};
  bool operator==(const CameraPose&) const = default;
};

struct Camera {
  std::string name;
  bool orthographic = false;
  double yfov_rad = 0.8;         // perspective: the vertical field of view, in (0, pi)
  double half_height_m = 1;      // orthographic: half of what is seen vertically
  double aspect_ratio = 0;       // width over height that the file suggests; 0: none. The picture's own wins
  double aperture_radius_m = 0;  // 0: a pinhole, all is sharp
  double focus_distance_m = 1;   // along `forward`, to the plane that is sharp
  double shutter_open_s = 0, shutter_close_s = 0;  // equal: no motion blur
  std::vector<CameraPose> poses{1};                // evenly spaced over the shutter's time, the first at its opening
};

// What rays meet that hit nothing.
struct Environment {
  Float3 radiance;   // constant, or the factor of the texture
  int texture = -1;  // index into Scene::textures, latitude-longitude: u = .5 + atan2(x, -z) / (2 pi),
                     // v = acos(y) / pi, so that the middle of the picture lies along -z
  bool black() const { return radiance == Float3{}; }
};

struct Scene {
  std::string file;                   // as it was given; "" for a scene made in memory
  Double3 origin_m;                   // add it to get the file's coordinates
  Float3 bounds_min_m, bounds_max_m;  // of all meshes over the shutter's time, relative to origin_m
  std::vector<Mesh> meshes;
  std::vector<Material> materials;
  std::vector<Texture> textures;
  std::vector<Light> lights;
  std::vector<Camera> cameras;  // at least one after loading
  int camera = 0;               // the one that was asked for; motion was sampled over its shutter's time
  Environment environment;
  std::vector<std::string> warnings;  // one line each, for the user; name the file

  uint64_t triangle_count() const {
    uint64_t count = 0;
    for (const Mesh& mesh : meshes) count += mesh.indices.size();
    return count;
  }
};

}  // namespace triad::raytracer
