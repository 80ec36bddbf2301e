// SPDX-License-Identifier: Apache-2.0
// A million triangles from a .glb: seconds to load and to build, beside Embree's own build of the same triangles, and
// the bytes that each triangle takes.
#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "../unit/gltf_files.hpp"
#include "measure.hpp"
#include "raytracer/geometry.hpp"
#include "raytracer/gltf_loader.hpp"

namespace {

using triad::bench::median;

using namespace triad::raytracer;
using gltf_files::json;

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// A hilly square of 2 * 1000 * 500 triangles.
std::string save_hills(const std::filesystem::path& path) {
  constexpr uint32_t kColumns = 1000, kRows = 500;
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  for (uint32_t y = 0; y <= kRows; ++y)
    for (uint32_t x = 0; x <= kColumns; ++x) {
      const float u = static_cast<float>(x) * 2e-3f, v = static_cast<float>(y) * 4e-3f;
      positions.insert(positions.end(), {u, .1f * std::sin(9 * u) * std::cos(7 * v), v});
      if (x == kColumns || y == kRows) continue;
      const uint32_t a = y * (kColumns + 1) + x, b = a + kColumns + 1;
      indices.insert(indices.end(), {a, b, a + 1, a + 1, b, b + 1});
    }
  gltf_files::Gltf gltf;
  const json primitive{{"attributes", {{"POSITION", gltf.accessor(positions, 3)}}},
                       {"indices", gltf.accessor(indices, 1)}};
  gltf.push("meshes", {{"primitives", {primitive}}});
  gltf.node({{"mesh", 0}});
  return gltf.save(path.string());
}

// Embree's own: shared vertices, no caps; the flags are those of Geometry.
double bare_build_s(const Mesh& mesh) {
  RTCDevice device = rtcNewDevice(nullptr);
  const double start = now_s();
  RTCScene tree = rtcNewScene(device);
  rtcSetSceneFlags(tree, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Float3),
                                          mesh.positions.size());
  std::copy(mesh.positions.begin(), mesh.positions.end(), static_cast<Float3*>(corners));
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0,
                             sizeof(mesh.indices[0]), mesh.indices.size());
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(tree, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(tree);
  const double seconds = now_s() - start;
  rtcReleaseScene(tree);
  rtcReleaseDevice(device);
  return seconds;
}

void million_triangles(benchmark::State& state) {
  const auto path = std::filesystem::temp_directory_path() / "triad_load_scene_bench.glb";
  save_hills(path);
  std::vector<double> load_s, build_s, bare_s;
  double scene_bytes = 0, tree_bytes = 0, triangles = 1;
  for (auto unused : state) {
    (void)unused;
    const double start = now_s();
    const Scene scene = load_gltf(path.string());
    const double loaded = now_s();
    const Geometry geometry(scene, {}, {});
    const double built = now_s();
    load_s.push_back(loaded - start);
    build_s.push_back(built - loaded);
    bare_s.push_back(bare_build_s(scene.meshes[0]));
    triangles = static_cast<double>(scene.triangle_count());
    tree_bytes = static_cast<double>(geometry.memory_bytes());
    scene_bytes = static_cast<double>(scene.meshes[0].positions.size() * sizeof(Float3) +
                                      scene.meshes[0].indices.size() * sizeof(scene.meshes[0].indices[0]));
    state.SetIterationTime(built - start);
  }
  std::filesystem::remove(path);
  state.counters["triangles"] = triangles;
  state.counters["load_s"] = median(load_s);
  state.counters["build_s"] = median(build_s);
  state.counters["build_over_bare_embree"] = median(build_s) / median(bare_s);
  state.counters["tree_bytes_per_triangle"] = tree_bytes / triangles;
  state.counters["scene_bytes_per_triangle"] = scene_bytes / triangles;
}

BENCHMARK(million_triangles)->UseManualTime()->Unit(benchmark::kSecond)->Iterations(5);

}  // namespace

BENCHMARK_MAIN();
