// SPDX-License-Identifier: Apache-2.0
// The metrics that compare pixel by pixel, over pictures in memory in strips as the host cuts them, against copying
// both pictures once with the same threads. The two alternate, so that a busy machine slows both. Counters are
// medians over the iterations.
//
//   metrics_bench FOLDER-WITH-PLUGINS [--benchmark_filter=...]
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <string>
#include <triad/base/parallel.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/stage_exercise.hpp>
#include <tuple>
#include <vector>

#include "measure.hpp"

namespace {

using triad::bench::median;

constexpr int kThreads = 2;
constexpr int kStripRows = 64;  // the host's

template <class Body>
double seconds(const Body& body) {
  const auto start = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// One comparison, as the host makes it: strips on all threads, merged in order.
std::vector<double> compare(triad::StageInstance& stage, const triad::StageInstance::Plan& plan,
                            const triad::SyntheticPicture& test, const triad::SyntheticPicture& reference) {
  const int height = test.image.height, rows = plan.plan.strip_rows < 0 ? height : kStripRows,
            strips = (height + rows - 1) / rows;
  std::vector<double> scores;
  for (int pass = 0; pass < plan.plan.passes; ++pass) {
    std::vector<std::vector<std::byte>> states(static_cast<size_t>(strips));
    triad::parallel_for(strips, [&](int64_t k) {
      const int y0 = static_cast<int>(k) * rows;
      const triad_rect r{0, y0, test.image.width, std::min(height, y0 + rows)};
      const auto view = [&](const triad::SyntheticPicture& p) {
        const int64_t row = int64_t{3} * p.image.width;
        return triad_strip{sizeof(triad_strip), 3, r, const_cast<float*>(p.pixels.data()) + y0 * row,
                           row * static_cast<int64_t>(sizeof(float))};
      };
      const triad_strip a = view(test), b = view(reference);
      auto& state = states[static_cast<size_t>(k)];
      state.resize(plan.plan.state_bytes);
      stage.strip(pass, r, {&a, &b, nullptr}, nullptr, state.data());
    });
    std::vector<std::byte> total(plan.plan.state_bytes);
    for (const auto& state : states) stage.merge(pass, total.data(), state.data());
    scores = stage.end_pass(pass, total.data());
  }
  return scores;
}

void metric_and_copy(benchmark::State& state, triad::PluginHost& host, const std::string& id, int width, int height) {
  triad::set_thread_limit(kThreads);
  const auto test = triad::synthetic_picture(width, height, 3, {}, 1),
             reference = triad::synthetic_picture(width, height, 3, {}, 2);
  triad::StageInstance stage(host.find(id), {});
  const auto plan = stage.plan({&test.image, &reference.image, nullptr}, {nullptr, nullptr, nullptr});
  std::vector<float> copy(test.pixels.size());
  std::vector<double> metric_s, copy_s;
  for (auto unused : state) {
    (void)unused;
    metric_s.push_back(seconds([&] { benchmark::DoNotOptimize(compare(stage, plan, test, reference)); }));
    copy_s.push_back(seconds([&] {
      const size_t row = 3 * static_cast<size_t>(width);
      triad::parallel_for(height, [&](int64_t y) {
        const size_t at = static_cast<size_t>(y) * row;
        std::memcpy(&copy[at], &test.pixels[at], row * sizeof(float));
        std::memcpy(&copy[at], &reference.pixels[at], row * sizeof(float));
      });
      benchmark::DoNotOptimize(copy.data());
    }));
    state.SetIterationTime(metric_s.back());
  }
  state.counters["metric_ms"] = 1e3 * median(metric_s);
  state.counters["ns_per_px"] = 1e9 * median(metric_s) / width / height;
  state.counters["copy_ms"] = 1e3 * median(copy_s);
  state.counters["to_copy"] = median(metric_s) / median(copy_s);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  triad::PluginHost host({argc > 1 ? argv[1] : TRIAD_PLUGINS});
  for (const char* id : {"error", "relmse-tev", "mape", "smape", "cie76", "ciede2000", "s-cielab"})
    for (const auto& [w, h, size] : {std::tuple{1920, 1080, "hd"}, std::tuple{3840, 2160, "4k"}})
      if (id != std::string("s-cielab") || w == 1920)
        benchmark::RegisterBenchmark((std::string(id) + "/" + size).c_str(), metric_and_copy, std::ref(host), id, w,
                                     h)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond)
            ->MinTime(1);
  benchmark::RunSpecifiedBenchmarks();
}
