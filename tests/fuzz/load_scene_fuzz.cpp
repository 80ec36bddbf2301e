// SPDX-License-Identifier: Apache-2.0
// libFuzzer over load_gltf: any bytes are a scene or one Error of one line. Scenes are checked as the ray tracer
// relies on them: indices in range, numbers finite.
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <raytracer/gltf_loader.hpp>
#include <triad/base/error.hpp>

namespace {

void require(bool ok) {
  if (!ok) std::abort();
}

void check(const triad::raytracer::Scene& scene) {
  require(!scene.meshes.empty() && !scene.cameras.empty());
  for (const auto& mesh : scene.meshes) {
    require(mesh.material >= 0 && static_cast<size_t>(mesh.material) < scene.materials.size());
    require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
    require(mesh.normals.empty() || mesh.motion_normals.size() == mesh.motion_positions.size());
    for (const auto& triangle : mesh.indices)
      for (const uint32_t i : triangle) require(i < mesh.positions.size());
    for (const auto& p : mesh.positions) require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    for (const auto& positions : mesh.motion_positions) {
      require(positions.size() == mesh.positions.size());
      for (const auto& p : positions) require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    }
  }
  for (const auto& material : scene.materials)
    require(material.base_color_texture.texture < static_cast<int>(scene.textures.size()));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string folder =
      std::filesystem::temp_directory_path().string() + "/triad-fuzz-" + std::to_string(getpid());
  std::filesystem::create_directories(folder);
  const std::string path = folder + "/a.gltf";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    check(triad::raytracer::load_gltf(path));
  } catch (const triad::Error& error) {
    if (std::string(error.what()).find('\n') != std::string::npos) std::abort();
  }
  return 0;
}
