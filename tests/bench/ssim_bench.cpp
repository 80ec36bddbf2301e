// SPDX-License-Identifier: Apache-2.0
// Structural similarity of two RGB pictures in memory, at one scale and at five, with and without a map, and PU21 of
// both, against copying both pictures once with the same threads. They alternate, so that a busy machine slows all.
// Counters are medians over the iterations.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <triad/base/parallel.hpp>
#include <triad/evaluation/ms_ssim.hpp>
#include <triad/evaluation/pu21.hpp>
#include <vector>

#include "measure.hpp"

namespace {

using triad::bench::median;

constexpr int kThreads = 2, kPad = triad::kSsimRadius_px;

struct Pictures {
  int width, height;
  ptrdiff_t stride;
  std::vector<float> test, reference, copy, map;

  Pictures(int w, int h) : width(w), height(h), stride(ptrdiff_t{w + 2 * kPad} * 3) {
    const size_t size = static_cast<size_t>(stride) * (h + 2 * kPad);
    for (size_t i = 0; i < size; ++i) {
      reference.push_back(static_cast<float>(i * 2654435761u % 1024) / 1024);
      test.push_back(.9f * reference.back() + static_cast<float>(i * 2246822519u % 1024) / 10240);
    }
    copy.resize(2 * size);
    map.resize(static_cast<size_t>(w) * h);
  }
  triad::SsimSamples<float> at(const std::vector<float>& picture, int y) const {
    return {picture.data() + (y + kPad) * stride + 3 * kPad, stride};
  }
  double seconds(int rows, const std::function<void(int y0, int y1)>& body) const {
    const auto start = std::chrono::steady_clock::now();
    triad::parallel_for((height + rows - 1) / rows, [&](int64_t strip) {
      const int y0 = static_cast<int>(strip) * rows;
      body(y0, std::min(height, y0 + rows));
    });
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
};

void similarity_and_copy(benchmark::State& state, int width, int height) {
  triad::set_thread_limit(kThreads);
  Pictures p(width, height);
  std::vector<double> one_s, five_s, map_s, pu_s, copy_s;
  const auto five = [&](bool map) {
    return p.seconds(128, [&](int y0, int y1) {
      triad::MsSsimTotals totals{};
      triad::add_ms_ssim(p.at(p.test, y0), p.at(p.reference, y0), {width, height, y0, y1, 3, nullptr, 0}, 1, totals,
                         map ? &p.map[static_cast<size_t>(y0) * width] : nullptr, width);
      benchmark::DoNotOptimize(totals);
    });
  };
  for (auto unused : state) {
    (void)unused;
    one_s.push_back(p.seconds(64, [&](int y0, int y1) {
      triad::SsimTotals totals{};
      triad::local_ssim(p.at(p.test, y0), p.at(p.reference, y0), {0, y0, width, y1, 3}, 1,
                        [&](int x, int y, int pixels, const double* ssim, const double* structure) {
                          totals.add(x, y, pixels, width, height, 3, nullptr, ssim, structure);
                        });
      benchmark::DoNotOptimize(totals);
    }));
    five_s.push_back(five(false));
    map_s.push_back(five(true));
    pu_s.push_back(p.seconds(64, [&](int y0, int y1) {
      std::vector<double> row(static_cast<size_t>(3) * width);
      for (int y = y0; y < y1; ++y)
        for (const auto* picture : {&p.test, &p.reference}) {
          std::copy_n(p.at(*picture, y).first, row.size(), row.begin());
          triad::pu21(row.data(), row.size());
          benchmark::DoNotOptimize(row.data());
        }
    }));
    copy_s.push_back(p.seconds(64, [&](int y0, int y1) {
      const auto bytes = static_cast<size_t>((y1 - y0) * p.stride) * sizeof(float);
      const auto from = static_cast<size_t>(y0 * p.stride);
      std::memcpy(&p.copy[from], &p.test[from], bytes);
      std::memcpy(&p.copy[p.copy.size() / 2 + from], &p.reference[from], bytes);
    }));
  }
  const double copy = median(copy_s);
  state.counters["copy_ms"] = 1e3 * copy;
  state.counters["ssim_ms"] = 1e3 * median(one_s);
  state.counters["ssim_to_copy"] = median(one_s) / copy;
  state.counters["ms_ssim_to_copy"] = median(five_s) / copy;
  state.counters["ms_ssim_map_to_copy"] = median(map_s) / copy;
  state.counters["pu21_to_copy"] = median(pu_s) / copy;
}

}  // namespace

BENCHMARK_CAPTURE(similarity_and_copy, 1920x1080, 1920, 1080)->Unit(benchmark::kMillisecond)->MinTime(2);
BENCHMARK_CAPTURE(similarity_and_copy, 3840x2160, 3840, 2160)->Unit(benchmark::kMillisecond)->MinTime(2);
BENCHMARK_MAIN();
