// SPDX-License-Identifier: Apache-2.0
// What pooling costs for each value of a map, beside copying the map. Processor time, of all threads.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <triad/numeric/pooling.hpp>
#include <vector>

using namespace triad;

namespace {

constexpr int kWidth = 4096, kHeight = 4096, kStripRows = 64;
constexpr size_t kValues = size_t{kWidth} * kHeight;

enum Kind { kErrors, kConstant, kAnything };

const std::vector<float>& map_of(int kind) {
  static std::vector<float> maps[3];
  std::vector<float>& map = maps[kind];
  if (!map.empty()) return map;
  map.resize(kValues);
  std::mt19937 random(1);
  std::normal_distribution<float> normal(0, .1f);
  std::uniform_real_distribution<float> exponent(-100, 100);
  for (float& value : map)
    value = kind == kErrors ? std::abs(normal(random)) : kind == kConstant ? .25f : std::exp2(exponent(random));
  return map;
}

void per_value(benchmark::State& state) {
  state.counters["ns/value"] =
      benchmark::Counter(static_cast<double>(kValues) * 1e-9,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

// Strip by strip into the same place, as a strip that stays in the cache is copied.
void copy(benchmark::State& state) {
  const std::vector<float>& map = map_of(kErrors);
  std::vector<float> to(size_t{kWidth} * kStripRows);
  for (auto _ : state)
    for (size_t at = 0; at < kValues; at += to.size()) {
      std::memcpy(to.data(), &map[at], to.size() * sizeof(float));
      benchmark::DoNotOptimize(to.data());
      benchmark::ClobberMemory();
    }
  per_value(state);
}

void pool(benchmark::State& state, int kind, bool weighted, uint64_t keep_bytes, bool finish) {
  const std::vector<float>& map = map_of(kind);
  const std::vector<float> weights(kWidth, .5f);
  for (auto _ : state) {
    Pooling pooling(weighted, keep_bytes, kValues);
    for (int y0 = 0; y0 < kHeight; y0 += kStripRows) {
      auto block = pooling.take(size_t{kWidth} * kStripRows);
      for (int y = y0; y < y0 + kStripRows; ++y)
        block->add_row(&map[static_cast<size_t>(y) * kWidth], weighted ? weights.data() : nullptr, kWidth, 1, 0, y);
      pooling.add(std::move(block));
    }
    if (finish) benchmark::DoNotOptimize(pooling.finish());
  }
  per_value(state);
}

constexpr uint64_t kInMemory = uint64_t{1} << 30;

}  // namespace

BENCHMARK(copy)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(pool, first_look_errors, kErrors, false, kInMemory, false)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(pool, errors, kErrors, false, kInMemory, true)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(pool, errors_spilled, kErrors, false, 0, true)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(pool, errors_weighted, kErrors, true, kInMemory, true)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(pool, constant, kConstant, false, kInMemory, true)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(pool, all_exponents, kAnything, false, kInMemory, true)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();

BENCHMARK_MAIN();
