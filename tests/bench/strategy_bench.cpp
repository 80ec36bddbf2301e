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

#include "raytracer/gltf_loader.hpp"
#include "raytracer/scene_source.hpp"

namespace {

using namespace triad;

constexpr int kThreads = 2, kWidth = 640, kHeight = 360;

int64_t processor_ns(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

// What asking for a thread's time costs: the kernel keeps that clock, and two calls a batch are 5% of what is
// measured.
double clock_ns() {
  constexpr int kCalls = 20000;
  const int64_t start = processor_ns(CLOCK_THREAD_CPUTIME_ID);
  for (int i = 0; i < kCalls; ++i) benchmark::DoNotOptimize(processor_ns(CLOCK_THREAD_CPUTIME_ID));
  return static_cast<double>(processor_ns(CLOCK_THREAD_CPUTIME_ID) - start) / kCalls;
}

// Adds up the processor time that threads spend in another source.
class TimedSource final : public Source {
 public:
  explicit TimedSource(const Source& source) : source_(source) {}
  int width() const override { return source_.width(); }
  int height() const override { return source_.height(); }
  SourceAbilities abilities() const override { return source_.abilities(); }
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const override {
    const int64_t start = processor_ns(CLOCK_THREAD_CPUTIME_ID);
    source_.eval(requests, samples);
    ns += processor_ns(CLOCK_THREAD_CPUTIME_ID) - start;
    ++batches;
  }
  mutable std::atomic<int64_t> ns{0}, batches{0};

 private:
  const Source& source_;
};

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
  const double each_clock_ns = clock_ns();  // of two a batch, half is inside
  for (auto unused : state) {
    (void)unused;
    const TimedSource timed(*source);
    const int64_t start = processor_ns(CLOCK_PROCESS_CPUTIME_ID);
    benchmark::DoNotOptimize(strategy->render(timed, {}).samples);
    const double clocks = each_clock_ns * static_cast<double>(timed.batches.load());
    const double whole = static_cast<double>(processor_ns(CLOCK_PROCESS_CPUTIME_ID) - start) - 2 * clocks;
    const double inside = static_cast<double>(timed.ns.load()) - clocks;
    shares.push_back((whole - inside) / inside);
    state.SetIterationTime(1e-9 * whole);
  }
  const auto middle = shares.begin() + static_cast<ptrdiff_t>(shares.size() / 2);
  std::nth_element(shares.begin(), middle, shares.end());
  state.counters["added_to_source"] = *middle;
}

}  // namespace

int main(int argc, char** argv) {
  for (const char* strategy : {"control", "grid:n=4", "grid:n=8", "sobol-owen:spp=16", "sobol-owen:spp=64"})
    benchmark::RegisterBenchmark((std::string("strategy/room/") + strategy).c_str(), added, strategy)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->MinTime(1);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
