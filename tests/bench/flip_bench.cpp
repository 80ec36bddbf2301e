// SPDX-License-Identifier: Apache-2.0
// FLIP in memory on two threads, as strips of 64 rows cut into pieces; codes for LDR, light at ten exposures for HDR.
// Beside it a copy of memory in the same run, in whose time for 10 GB on one core the authors' program takes .40 s
// (LDR) and 4.1 s (HDR) on two threads at 1920x1080, where that copy takes 1.0 s. Counters are the least of the
// iterations: wall_s, the processor's time of one of the two threads (cpu_s; what wall_s is on an idle machine), the
// copy's copy10GB_s, and how often cpu_s fits into the time of the authors' program on this machine (authors_to_this;
// pixels in proportion).
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <string>
#include <triad/base/parallel.hpp>
#include <triad/evaluation/flip.hpp>
#include <triad/numeric/aligned.hpp>
#include <tuple>
#include <vector>

#include "measure.hpp"

namespace {

using triad::bench::processor_s;

constexpr int kThreads = 2, kPiece_px = 384, kStripRows = 64;
constexpr double kAuthorsLdr = .40, kAuthorsHdr = 4.1;  // in copies of 10 GB, at 1920x1080

struct Pictures {
  int width, height, reach;
  int64_t row;
  std::vector<float> test, reference;

  Pictures(int w, int h, int r, float scale)
      : width(w), height(h), reach(r), row(3 * (int64_t{w} + 2 * r)), test(size(h)), reference(size(h)) {
    // A gradient with noise that differs.
    uint32_t x = 1;
    for (size_t i = 0; i < test.size(); ++i) {
      const auto noise = [&] {
        x = x * 1664525u + 1013904223u;
        return static_cast<float>(x >> 8) * 0x1p-24f;
      };
      const float base = static_cast<float>(i % static_cast<size_t>(row)) / static_cast<float>(row);
      reference[i] = scale * base * (.8f + .2f * noise());
      test[i] = scale * base * (.8f + .2f * noise());
    }
  }
  triad::FlipPicture at(const std::vector<float>& p, int x, int y) const {
    return {p.data() + (y + reach) * row + 3 * (x + reach), row};
  }

 private:
  size_t size(int h) const { return static_cast<size_t>(row) * static_cast<size_t>(h + 2 * reach); }
};

void evaluate(const triad::Flip& flip, const Pictures& p, const triad::FlipViewing& viewing) {
  const int columns = (p.width + kPiece_px - 1) / kPiece_px, strips = (p.height + kStripRows - 1) / kStripRows;
  triad::parallel_for(int64_t{columns} * strips, [&](int64_t i) {
    const int x = static_cast<int>(i % columns) * kPiece_px, y = static_cast<int>(i / columns) * kStripRows;
    const int width = std::min(kPiece_px, p.width - x), height = std::min(kStripRows, p.height - y);
    thread_local triad::AlignedBuffer<float> work, errors;
    const size_t floats = flip.work_floats(kPiece_px, kStripRows);
    if (work.size() < floats) work = triad::AlignedBuffer<float>(floats);
    const size_t results = static_cast<size_t>(triad::Flip::row_floats(kPiece_px)) * kStripRows;
    if (errors.size() < results) errors = triad::AlignedBuffer<float>(results);
    flip.evaluate(p.at(p.test, x, y), p.at(p.reference, x, y), width, height, viewing, errors.data(), nullptr,
                  work.data());
    benchmark::DoNotOptimize(errors.data());
  });
}

// Of 10 GB on one core, from a part of it.
double copy_s() {
  constexpr size_t kBytes = size_t{256} << 20;
  static std::vector<char> from(kBytes, 1), to(kBytes, 2);
  const double start = processor_s(CLOCK_THREAD_CPUTIME_ID);
  for (int i = 0; i < 4; ++i) {
    std::memcpy(to.data(), from.data(), kBytes);
    benchmark::DoNotOptimize(to.data());
  }
  return (processor_s(CLOCK_THREAD_CPUTIME_ID) - start) * 1e10 / (4. * kBytes);
}

void flip_and_copy(benchmark::State& state, int width, int height, int exposures) {
  triad::set_thread_limit(kThreads);
  const triad::Flip flip(67.020645);
  const Pictures pictures(width, height, flip.reach_px(), exposures > 0 ? 20.f : 1.f);
  triad::FlipViewing viewing{.srgb_codes = exposures == 0};
  for (int i = 0; i < exposures; ++i) viewing.exposures_stops.push_back(static_cast<float>(i - 6));
  double wall_s = HUGE_VAL, cpu_s = HUGE_VAL, copied_s = HUGE_VAL;
  for (auto unused : state) {
    (void)unused;
    const auto start = std::chrono::steady_clock::now();
    const double cpu = processor_s();
    evaluate(flip, pictures, viewing);
    cpu_s = std::min(cpu_s, (processor_s() - cpu) / kThreads);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    wall_s = std::min(wall_s, seconds);
    state.SetIterationTime(seconds);
    copied_s = std::min(copied_s, copy_s());
  }
  const double pixels = static_cast<double>(width) * height / (1920. * 1080);
  state.counters["wall_s"] = wall_s;
  state.counters["cpu_s"] = cpu_s;
  state.counters["copy10GB_s"] = copied_s;
  state.counters["authors_to_this"] = (exposures > 0 ? kAuthorsHdr : kAuthorsLdr) * pixels * copied_s / cpu_s;
}

}  // namespace

int main(int argc, char** argv) {
  for (const auto& [width, height, size] : {std::tuple{1920, 1080, "1920x1080"}, std::tuple{3840, 2160, "3840x2160"}})
    for (const auto& [exposures, name] : {std::pair{0, "ldr"}, std::pair{10, "hdr"}})
      benchmark::RegisterBenchmark((std::string(name) + "/" + size).c_str(), flip_and_copy, width, height, exposures)
          ->UseManualTime()
          ->Unit(benchmark::kSecond)
          ->Iterations(exposures > 0 ? 4 : 12);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
