// SPDX-License-Identifier: Apache-2.0
// The polyphase filter on a 4K picture from a wide render, in memory, against copying its input and its output
// once with the same threads. The two alternate, so that a busy machine slows both. Counters are medians over
// the iterations; the goal is fir_to_copy ≤ 3.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <string>
#include <triad/base/parallel.hpp>
#include <triad/numeric/polyphase.hpp>
#include <tuple>
#include <vector>

#include "measure.hpp"

namespace {

using triad::bench::median;

constexpr int kThreads = 2;
constexpr int kCells = 3;
constexpr int kTaps = 31;
constexpr int kRowsPerTask = 16;  // as strips of a chain would be

// Dense kernels, centred on the emitters of RGB stripes.
std::array<triad::FirKernel, 3> kernels() {
  std::array<triad::FirKernel, 3> result;
  for (int e = 0; e < 3; ++e) {
    result[static_cast<size_t>(e)].first_cell = e - kTaps / 2;
    for (int i = 0; i < 3 * kTaps; ++i)
      result[static_cast<size_t>(e)].coefficients.push_back(.3 * std::cos(.7 * i + e) / (1 + std::abs(i - 46)));
  }
  return result;
}

struct Picture {
  int width, height;
  size_t in_row, out_row;  // values
  int left;                // cells of padding on the left; as many on the right
  std::vector<float> in, out, copy;

  Picture(int w, int h) : width(w), height(h), left(kTaps) {
    in_row = 3 * static_cast<size_t>(kCells * width + 2 * left);
    out_row = 3 * static_cast<size_t>(width);
    in.resize(in_row * static_cast<size_t>(height));
    for (size_t i = 0; i < in.size(); ++i) in[i] = static_cast<float>(i * 2654435761u % 1024) / 1024;
    out.resize(out_row * static_cast<size_t>(height));
    copy.resize(in.size() + out.size());
  }

  template <typename Body>
  double seconds(const Body& rows) const {
    const auto start = std::chrono::steady_clock::now();
    triad::parallel_for((height + kRowsPerTask - 1) / kRowsPerTask, [&](int64_t task) {
      const auto first = static_cast<size_t>(task * kRowsPerTask);
      rows(first, std::min(first + kRowsPerTask, static_cast<size_t>(height)));
    });
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
};

void fir_and_copy(benchmark::State& state, triad::CpuPath path, int width, int height) {
  if (!triad::cpu_can_run(path)) return state.SkipWithError("this machine cannot run the path");
  triad::set_thread_limit(kThreads);
  Picture picture(width, height);
  const triad::PolyphaseFir<float> fir(kCells, kernels(), path);
  std::vector<double> fir_s, copy_s;
  for (auto unused : state) {
    (void)unused;
    fir_s.push_back(picture.seconds([&](size_t first, size_t past) {
      thread_local triad::PolyphaseScratch scratch;
      for (size_t y = first; y < past; ++y)
        fir.apply_row(picture.in.data() + y * picture.in_row + 3 * picture.left,
                      picture.out.data() + y * picture.out_row, width, scratch);
    }));
    copy_s.push_back(picture.seconds([&](size_t first, size_t past) {
      const size_t in_begin = first * picture.in_row, out_begin = first * picture.out_row;
      std::memcpy(picture.copy.data() + in_begin, picture.in.data() + in_begin,
                  (past - first) * picture.in_row * sizeof(float));
      std::memcpy(picture.copy.data() + picture.in.size() + out_begin, picture.out.data() + out_begin,
                  (past - first) * picture.out_row * sizeof(float));
    }));
    benchmark::DoNotOptimize(picture.copy.data());
    state.SetIterationTime(fir_s.back());
  }
  state.counters["fir_ms"] = 1e3 * median(fir_s);
  state.counters["copy_ms"] = 1e3 * median(copy_s);
  state.counters["fir_to_copy"] = median(fir_s) / median(copy_s);
}

}  // namespace

int main(int argc, char** argv) {
  for (const auto path : {triad::CpuPath::kAvx512, triad::CpuPath::kAvx2, triad::CpuPath::kBaseline}) {
    const std::string name = triad::cpu_path_name(path);
    for (const auto& [w, h, size] : {std::tuple{3840, 2160, "4k"}, std::tuple{400, 225, "400x225"}})
      benchmark::RegisterBenchmark(("fir/" + name + "/" + size).c_str(), fir_and_copy, path, w, h)
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond)
          ->MinTime(1);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
