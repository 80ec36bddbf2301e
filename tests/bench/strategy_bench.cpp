// SPDX-License-Identifier: Apache-2.0
// What strategies and the film add to the source's own work: processor seconds of a whole render outside the source,
// over those inside it, for the scene `room` without light, where a sample is as cheap as it gets. For an idle
// machine: inside, it is the time that passes.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <memory>
#include <triad/base/parallel.hpp>
#include <triad/sampling/strategy.hpp>
#include <vector>

#include "measure.hpp"
#include "raytracer/gltf_loader.hpp"
#include "raytracer/scene_source.hpp"

namespace {

using namespace triad;
using namespace triad::bench;

constexpr int kThreads = 2, kWidth = 1920, kHeight = 1080;

void added(benchmark::State& state, const char* strategy_text) {
  set_thread_limit(kThreads);
  const auto scene =
      std::make_shared<raytracer::Scene>(raytracer::load_gltf(TRIAD_SOURCE_DIR "/data/scenes/room.gltf"));
  for (raytracer::Material& material : scene->materials) material.unlit = true;  // shows its colour
  raytracer::SourceOptions options;
  options.width = kWidth;
  options.height = kHeight;
  options.effects = raytracer::EffectSet{};
  options.geometry = false;
  const auto source = raytracer::make_scene_source(scene, options);
  const auto strategy = make_strategy(strategy_text, "strategy_bench");
  std::vector<double> shares;
  for (auto unused : state) {
    (void)unused;
    const TimedSource timed(*source);
    const double start_s = processor_s();
    benchmark::DoNotOptimize(strategy->render(timed, {}).samples);
    const double whole = processor_s() - start_s - timed.clocks_s(), inside = timed.inside_s();
    shares.push_back((whole - inside) / inside);
    state.SetIterationTime(whole);
  }
  state.counters["added_to_source"] = median(shares);
}

}  // namespace

int main(int argc, char** argv) {
  for (const char* strategy : {"control", "grid:n=4", "grid:n=2", "sobol-owen:spp=16", "sobol-owen:spp=64"})
    benchmark::RegisterBenchmark((std::string("strategy/room/") + strategy).c_str(), added, strategy)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->MinTime(1);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
