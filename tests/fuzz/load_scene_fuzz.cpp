// SPDX-License-Identifier: Apache-2.0
// libFuzzer over load_gltf and what follows it: any bytes are a scene or one Error of one line; a scene is as the ray
// tracer relies on it (indices in range, numbers finite), and can be built and looked at. Pictures and a buffer that
// the bytes may name lie beside them; gltf_mutator.cpp changes them.
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <raytracer/gltf_loader.hpp>
#include <raytracer/scene_source.hpp>
#include <triad/base/error.hpp>

#include "scene_files.hpp"

namespace {

using namespace triad::raytracer;

void require(bool ok) {
  if (!ok) std::abort();
}

bool is_finite(const Float3& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

void check(const Scene& scene, const TextureUse& use) {
  require(use.texture < static_cast<int>(scene.textures.size()));
  require(use.texcoord == 0 || use.texcoord == 1);
}

void check(const Scene& scene) {
  require(!scene.meshes.empty() && !scene.cameras.empty());
  require(scene.camera >= 0 && static_cast<size_t>(scene.camera) < scene.cameras.size());
  for (const Mesh& mesh : scene.meshes) {
    require(mesh.material >= 0 && static_cast<size_t>(mesh.material) < scene.materials.size());
    require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
    require(mesh.normals.empty() || mesh.motion_normals.size() == mesh.motion_positions.size());
    for (const auto& uv : mesh.texcoords) require(uv.empty() || uv.size() == mesh.positions.size());
    for (const auto& triangle : mesh.indices)
      for (const uint32_t i : triangle) require(i < mesh.positions.size());
    for (const Float3& p : mesh.positions) require(is_finite(p));
    for (const auto& positions : mesh.motion_positions) {
      require(positions.size() == mesh.positions.size());
      for (const Float3& p : positions) require(is_finite(p));
    }
  }
  for (const Material& material : scene.materials)
    for (const TextureUse* use : {&material.base_color_texture, &material.metallic_roughness_texture,
                                  &material.emission_texture, &material.transmission_texture})
      check(scene, *use);
  for (const Texture& texture : scene.textures)
    require(texture.texels.size() == static_cast<size_t>(texture.width) * texture.height * texture.channels);
  for (const Camera& camera : scene.cameras) require(!camera.poses.empty());
  require(scene.environment.texture < static_cast<int>(scene.textures.size()));
}

// A few paths through each of 8 x 6 pixels.
void draw(Scene scene) {
  constexpr uint64_t kMostTriangles = 20000;  // so that each try stays quick
  constexpr int kWidth = 8, kHeight = 6;
  if (scene.triangle_count() > kMostTriangles) return;
  SourceOptions options;
  options.width = kWidth;
  options.height = kHeight;
  options.max_depth = 4;
  const auto source = make_scene_source(std::make_shared<const Scene>(std::move(scene)), options);
  std::vector<triad::SampleRequest> requests;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) requests.push_back({x + .5, y + .5, 1, x, y, 0, 7});
  std::vector<triad::Sample> samples(requests.size());
  source->eval(requests, samples);
  for (const triad::Sample& sample : samples)
    for (const float v : sample.rgb) require(std::isfinite(v));
}

std::string make_folder() {
  const std::string folder =
      std::filesystem::temp_directory_path().string() + "/triad-fuzz-" + std::to_string(getpid());
  std::filesystem::create_directories(folder);
  scene_files::put(folder);
  return folder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string path = make_folder() + "/a.gltf";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    Scene scene = load_gltf(path);
    check(scene);
    draw(std::move(scene));
  } catch (const triad::Error& error) {
    // A defect of our own says kInternal: that is as bad as a crash.
    require(error.kind() != triad::ErrorKind::kInternal);
    require(std::string(error.what()).find('\n') == std::string::npos);
  }
  return 0;
}
