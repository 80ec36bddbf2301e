// SPDX-License-Identifier: Apache-2.0
// The scenes that come with Triad: each loads without a warning, is what its name says, and is, byte for byte,
// what its generator writes.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <raytracer/gltf_loader.hpp>
#include <raytracer/scene_source.hpp>

#include "picture_files.hpp"

using namespace triad::raytracer;
using picture_files::bytes_of;

namespace {

const std::string kScenes = TRIAD_SOURCE_DIR "/data/scenes/";

struct Bundled {
  const char* name;
  uint64_t triangles_from, triangles_to;
};
const Bundled kBundled[] = {{"checker-horizon", 2, 1000},
                            {"cornell", 30, 40},
                            {"depth-of-field", 10000, 99999},
                            {"glass", 10000, 99999},
                            {"high-contrast-1", 200, 999},
                            {"high-contrast-2", 1000, 9999},
                            {"high-contrast-3", 200, 999},
                            {"high-contrast-4", 1000, 19999},
                            {"mirror", 10000, 99999},
                            {"motion", 10000, 99999},
                            {"room", 90000, 110000},
                            {"text", 1000, 9999},
                            {"texture", 10, 999},
                            {"thin-lines", 100, 999}};

Scene load(const std::string& name) { return load_gltf(kScenes + name + ".gltf"); }

TEST(BundledScenes, LoadWithoutAWarning) {
  for (const Bundled& bundled : kBundled) {
    const std::string path = kScenes + bundled.name + ".gltf";
    EXPECT_LT(std::filesystem::file_size(path), 2u << 20) << bundled.name;
    const Scene scene = load_gltf(path);
    EXPECT_THAT(scene.warnings, testing::IsEmpty()) << bundled.name;
    EXPECT_GE(scene.triangle_count(), bundled.triangles_from) << bundled.name;
    EXPECT_LE(scene.triangle_count(), bundled.triangles_to) << bundled.name;
    EXPECT_EQ(scene.cameras.size(), 1u) << bundled.name;
    for (const Mesh& mesh : scene.meshes)
      for (size_t i = 0; i < mesh.normals.size(); ++i) {
        const Float3& n = mesh.normals[i];
        ASSERT_NEAR(n.x * n.x + n.y * n.y + n.z * n.z, 1, 1e-5) << bundled.name << ", " << mesh.name;
      }
  }
}

// Normals and the turn of the triangles agree, so that nothing is inside out.
TEST(BundledScenes, TrianglesFaceTheWayOfTheirNormals) {
  for (const Bundled& bundled : kBundled) {
    const Scene scene = load(bundled.name);
    for (const Mesh& mesh : scene.meshes) {
      if (mesh.normals.empty()) continue;
      for (const auto& t : mesh.indices) {
        const Float3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        const double u[3] = {b.x - a.x, b.y - a.y, b.z - a.z}, v[3] = {c.x - a.x, c.y - a.y, c.z - a.z};
        const double g[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        double n[3] = {};
        for (const uint32_t i : t) {
          n[0] += mesh.normals[i].x;
          n[1] += mesh.normals[i].y;
          n[2] += mesh.normals[i].z;
        }
        ASSERT_GT(g[0] * n[0] + g[1] * n[1] + g[2] * n[2], 0) << bundled.name << ", " << mesh.name;
      }
    }
  }
}

TEST(BundledScenes, HoldWhatTheyAreFor) {
  const auto any = [](const auto& list, const auto& condition) {
    return std::any_of(list.begin(), list.end(), condition);
  };
  EXPECT_TRUE(any(load("motion").meshes, [](const Mesh& mesh) { return mesh.moves(); }));
  EXPECT_GT(load("depth-of-field").cameras[0].aperture_radius_m, 0);
  EXPECT_TRUE(any(load("glass").materials, [](const Material& m) { return m.transmission == 1; }));
  EXPECT_TRUE(any(load("mirror").materials, [](const Material& m) { return m.metallic == 1 && m.roughness == 0; }));
  EXPECT_TRUE(any(load("texture").materials, [](const Material& m) { return m.alpha_mode == AlphaMode::kMask; }));
  EXPECT_TRUE(any(load("checker-horizon").materials, [](const Material& m) { return m.base_color_texture.nearest; }));
  for (const char* name : {"high-contrast-1", "high-contrast-2", "high-contrast-3", "text", "thin-lines"}) {
    const Scene scene = load(name);
    EXPECT_TRUE(scene.cameras[0].orthographic) << name;
    EXPECT_TRUE(scene.environment.black()) << name;
    EXPECT_FALSE(any(scene.materials, [](const Material& m) { return !m.unlit; })) << name;
  }
  // The lamp of the box: 0.25 m2 of radiance 15, facing down.
  const Scene cornell = load("cornell");
  const auto lamp = std::find_if(cornell.meshes.begin(), cornell.meshes.end(),
                                 [](const Mesh& mesh) { return mesh.name == "lamp"; });
  ASSERT_NE(lamp, cornell.meshes.end());
  EXPECT_EQ(cornell.materials[static_cast<size_t>(lamp->material)].emission, (Float3{15, 15, 15}));
  EXPECT_EQ(lamp->normals[0], (Float3{0, -1, 0}));
}

TEST(BundledScenes, AreWhatTheGeneratorWrites) {
  const picture_files::Folder folder;
  ASSERT_EQ(std::system(("'" TRIAD_MAKE_SCENES "' '" + std::string(folder.path()) + "'").c_str()), 0);
  EXPECT_EQ(folder.file_count(), std::size(kBundled));
  for (const Bundled& bundled : kBundled) {
    const std::string file = std::string(bundled.name) + ".gltf";
    EXPECT_TRUE(bytes_of(folder / file) == bytes_of(kScenes + file)) << file;
  }
}

// A kernel for the scene's effects and the kernel with everything in it draw the same bits, and count no ray
// for what is not there.
TEST(BundledScenes, SpecialisedKernelsDrawTheSameBits) {
  for (const Bundled& bundled : kBundled) {
    const auto scene = std::make_shared<const Scene>(load(bundled.name));
    SourceOptions options;
    options.width = 64;
    options.height = 36;
    const auto specialised = make_scene_source(scene, options);
    options.specialise = false;
    const auto everything = make_scene_source(scene, options);
    std::vector<triad::SampleRequest> requests;
    for (int y = 0; y < options.height; ++y)
      for (int x = 0; x < options.width; ++x)
        for (uint32_t index = 0; index < 2; ++index)
          requests.push_back({x + .25 + .5 * index, y + .5, 1, x, y, index, 7});
    std::vector<triad::Sample> a(requests.size()), b(requests.size());
    specialised->eval(requests, a);
    everything->eval(requests, b);
    double light = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i].rgb, b[i].rgb) << bundled.name << ", sample " << i;
      light += a[i].rgb[1];
    }
    EXPECT_GT(light, 0) << bundled.name;
    const EffectSet effects = specialised->effects();
    const auto none_without = [&](Effect effect, RayKind kind) {
      EXPECT_TRUE(effects.has(effect) || specialised->rays(kind) == 0) << bundled.name << ", " << ray_kind_name(kind);
    };
    none_without(Effect::kMirror, RayKind::kMirror);
    none_without(Effect::kRefraction, RayKind::kRefraction);
    none_without(Effect::kGlossy, RayKind::kGlossy);
    none_without(Effect::kIndirectDiffuse, RayKind::kDiffuse);
  }
}

}  // namespace
