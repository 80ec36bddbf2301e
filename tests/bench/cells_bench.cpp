// SPDX-License-Identifier: Apache-2.0
// What it takes to bin samples into a display's cells: seconds of the strategy cells beside those of sobol-owen with
// as many samples per display pixel, of the same scene.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <raytracer/gltf_loader.hpp>
#include <raytracer/scene_source.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/strategy.hpp>
#include <vector>

#include "measure.hpp"

namespace {

using namespace triad;
using namespace triad::bench;

constexpr int kThreads = 2, kWidth = 400, kHeight = 225, kRounds = 21;
constexpr Cells kCells{3, 1};

double render_s(const Strategy& strategy, const Source& source, const Cells& cells) {
  RenderOptions options;
  options.cells = cells;
  const double start = processor_s();
  benchmark::DoNotOptimize(strategy.render(source, options));
  return processor_s() - start;
}

void cells_beside_plain(benchmark::State& state, const std::string& name) {
  set_thread_limit(kThreads);
  const auto scene = std::make_shared<const raytracer::Scene>(
      raytracer::load_gltf(TRIAD_SOURCE_DIR "/data/scenes/" + name + ".gltf"));
  raytracer::SourceOptions options;
  options.geometry = false;
  options.picture_aspect = static_cast<double>(kWidth) / kHeight;
  options.width = kWidth;
  options.height = kHeight;
  const auto plain = raytracer::make_scene_source(scene, options);
  options.width *= kCells.x;
  options.height *= kCells.y;
  const auto fine = raytracer::make_scene_source(scene, options);
  const std::string spp = ":spp=" + std::to_string(state.range(0));
  const auto sobol = make_strategy("sobol-owen" + spp, ""), cells = make_strategy("cells" + spp, "");
  std::vector<double> plain_s, cells_s, ratios;
  for (auto _ : state)
    for (int round = 0; round < kRounds; ++round) {
      plain_s.push_back(render_s(*sobol, *plain, {}));
      cells_s.push_back(render_s(*cells, *fine, kCells));
      ratios.push_back(cells_s.back() / plain_s.back());
    }
  state.counters["plain_ms"] = 1e3 * median(plain_s);
  state.counters["cells_ms"] = 1e3 * median(cells_s);
  state.counters["ratio"] = median(ratios);
}

#define TRIAD_SCENE(number)                                                               \
  BENCHMARK_CAPTURE(cells_beside_plain, high_contrast_##number, "high-contrast-" #number) \
      ->Arg(16)                                                                           \
      ->Arg(64)                                                                           \
      ->Iterations(1)                                                                     \
      ->Unit(benchmark::kMillisecond)
TRIAD_SCENE(1);
TRIAD_SCENE(2);
TRIAD_SCENE(3);
TRIAD_SCENE(4);

}  // namespace

BENCHMARK_MAIN();
