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

namespace {

using namespace triad;

constexpr int kThreads = 2, kWidth = 400, kHeight = 225, kRounds = 21;
constexpr Cells kCells{3, 1};

// Seconds of the processor, summed over this process's threads: they leave out what other programs take.
double now_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double render_s(const Strategy& strategy, const Source& source, const Cells& cells) {
  RenderOptions options;
  options.cells = cells;
  const double start = now_s();
  benchmark::DoNotOptimize(strategy.render(source, options));
  return now_s() - start;
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
