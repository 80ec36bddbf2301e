// SPDX-License-Identifier: Apache-2.0
// What the ray tracer adds to bare ray queries: the scene `room` as its camera sees it, without light, rendered
// into a film, beside the same rays shot through Embree alone, in packets as wide, with the same threads, in the
// same order, in a tree built with the same flags.
#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <mutex>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/strategy.hpp>
#include <vector>

#include "measure.hpp"
#include "raytracer/camera.hpp"
#include "raytracer/gltf_loader.hpp"
#include "raytracer/scene_source.hpp"

namespace {

using namespace triad;
using namespace triad::bench;
using namespace triad::raytracer;

constexpr int kThreads = 2, kWidth = 640, kHeight = 360;

// Keeps the camera rays of every request, as packets in the order in which they were asked for.
template <class Packet, int K>
class Recorder final : public Source {
 public:
  explicit Recorder(const FilmCamera& camera) : camera_(camera) {}
  int width() const override { return kWidth; }
  int height() const override { return kHeight; }
  SourceAbilities abilities() const override { return {}; }
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const override {
    for (size_t first = 0; first < requests.size(); first += K) {
      Packet packet{};
      for (int i = 0; i < K; ++i) {
        const bool on = first + static_cast<size_t>(i) < requests.size();
        // A lane without a request holds an empty interval, which Embree passes over as an inactive one.
        const SampleRequest& request = requests[on ? first + static_cast<size_t>(i) : first];
        const Ray ray = camera_.ray(request.x, request.y, 0, 0, 0);
        packet.org_x[i] = ray.origin.x;
        packet.org_y[i] = ray.origin.y;
        packet.org_z[i] = ray.origin.z;
        packet.dir_x[i] = ray.direction.x;
        packet.dir_y[i] = ray.direction.y;
        packet.dir_z[i] = ray.direction.z;
        packet.tfar[i] = on ? ray.end : -1;
        packet.mask[i] = ~0u;
      }
      packets.push_back(packet);
    }
    std::fill(samples.begin(), samples.end(), Sample{});
  }

  mutable std::vector<Packet> packets;

 private:
  const FilmCamera& camera_;
};

RTCScene build(RTCDevice device, const Scene& scene) {
  RTCScene tree = rtcNewScene(device);
  rtcSetSceneFlags(tree, RTC_SCENE_FLAG_ROBUST);
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.indices.empty()) continue;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Float3),
                                            mesh.positions.size());
    std::copy(mesh.positions.begin(), mesh.positions.end(), static_cast<Float3*>(corners));
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices.data(), 0,
                               sizeof(mesh.indices[0]), mesh.indices.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(tree, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(tree);
  return tree;
}

struct Wide16 {
  using Ray = RTCRay16;
  using RayHit = RTCRayHit16;
  static constexpr int kWidth = 16;
  static void shoot(const int* valid, RTCScene tree, RTCIntersectContext* context, RayHit* packet) {
    rtcIntersect16(valid, tree, context, packet);
  }
};
struct Wide8 {
  using Ray = RTCRay8;
  using RayHit = RTCRayHit8;
  static constexpr int kWidth = 8;
  static void shoot(const int* valid, RTCScene tree, RTCIntersectContext* context, RayHit* packet) {
    rtcIntersect8(valid, tree, context, packet);
  }
};

// Seconds for all packets; `hits` counts the rays that met something, so that nothing is optimised away.
template <class Wide>
double bare_s(RTCScene tree, const std::vector<typename Wide::Ray>& packets, uint64_t& hits) {
  constexpr size_t kAtOnce = 128;
  std::mutex mutex;
  const double start = processor_s();
  parallel_for(static_cast<int64_t>((packets.size() + kAtOnce - 1) / kAtOnce), [&](int64_t task) {
    alignas(64) int valid[Wide::kWidth];
    std::fill(std::begin(valid), std::end(valid), -1);
    uint64_t met = 0;
    const size_t first = static_cast<size_t>(task) * kAtOnce, past = std::min(first + kAtOnce, packets.size());
    for (size_t p = first; p < past; ++p) {
      typename Wide::RayHit packet;
      packet.ray = packets[p];
      std::fill(std::begin(packet.hit.geomID), std::end(packet.hit.geomID), RTC_INVALID_GEOMETRY_ID);
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
      Wide::shoot(valid, tree, &context, &packet);
      for (const unsigned id : packet.hit.geomID) met += id != RTC_INVALID_GEOMETRY_ID;
    }
    const std::lock_guard lock(mutex);
    hits += met;
  });
  return processor_s() - start;
}

template <class Wide>
void visibility_wide(benchmark::State& state, RTCDevice device, const std::string& strategy_text) {
  set_thread_limit(kThreads);
  const auto scene = std::make_shared<Scene>(load_gltf(TRIAD_SOURCE_DIR "/data/scenes/room.gltf"));
  for (Material& material : scene->materials) material.unlit = true;  // shows its colour
  SourceOptions options;
  options.width = kWidth;
  options.height = kHeight;
  options.effects = EffectSet{};
  options.geometry = false;
  const auto source = make_scene_source(scene, options);
  const auto strategy = make_strategy(strategy_text, "visibility");
  const FilmCamera camera(scene->cameras[static_cast<size_t>(scene->camera)], options, EffectSet{});
  Recorder<typename Wide::Ray, Wide::kWidth> recorder(camera);
  set_thread_limit(1);
  strategy->render(recorder, {});
  set_thread_limit(kThreads);
  RTCScene tree = build(device, *scene);

  std::vector<double> ours_s, bare;
  uint64_t hits = 0, rays = 0;
  for (auto unused : state) {
    (void)unused;
    const double start = processor_s();
    const RenderResult result = strategy->render(*source, {});
    ours_s.push_back(processor_s() - start);
    rays = result.samples;
    bare.push_back(bare_s<Wide>(tree, recorder.packets, hits));
    state.SetIterationTime(ours_s.back());
  }
  rtcReleaseScene(tree);
  if (hits == 0) return state.SkipWithError("no ray met the room");
  state.counters["Mrays_per_core_s"] = static_cast<double>(rays) / median(ours_s) / 1e6;
  state.counters["bare_Mrays_per_core_s"] = static_cast<double>(rays) / median(bare) / 1e6;
  state.counters["share_of_bare"] = median(bare) / median(ours_s);
}

void visibility(benchmark::State& state, const std::string& strategy) {
  RTCDevice device = rtcNewDevice(nullptr);
  if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0)
    visibility_wide<Wide16>(state, device, strategy);
  else
    visibility_wide<Wide8>(state, device, strategy);
  rtcReleaseDevice(device);
}

}  // namespace

int main(int argc, char** argv) {
  for (const char* strategy : {"sobol-owen:spp=64", "sobol-owen:spp=16", "grid:n=8", "control"})
    benchmark::RegisterBenchmark((std::string("visibility/room/") + strategy).c_str(), visibility, strategy)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->MinTime(2);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
