// SPDX-License-Identifier: Apache-2.0
#include <triad/numeric/widest.hpp>
#include <triad/sampling/point_strategy.hpp>
#include <triad/sampling/sobol.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "sobol-owen",
    "spp scrambled Sobol points in each pixel",
    "The first spp points of the Sobol sequence, dimensions 0 and 1, with an Owen scrambling of its own for each "
    "pixel. "
    "Unbiased; with spp a power of two, each elementary interval of the pixel (a box of 2^-a by 2^-b with 2^(a+b) = "
    "spp) holds exactly one. The general choice.",
    {{"spp", "samples per pixel", 1, 1 << 24, 16}}};

class SobolOwen final : public PointStrategy {
 public:
  explicit SobolOwen(const StrategyValues& values)
      : PointStrategy(kInfo, values), spp_(static_cast<uint32_t>(values.at("spp"))) {}
  bool estimates_error() const override { return true; }

 protected:
  uint32_t samples_per_pixel() const override { return spp_; }
  void place(std::span<SampleRequest> requests) const override { place_sobol_owen(requests); }

 private:
  uint32_t spp_;
};

// pixel + fraction * 2^-32, rounded once, with one conversion of signed numbers: vectors have none of unsigned ones
// before AVX-512.
TRIAD_INLINE_BODY inline double place_in(int32_t pixel, uint32_t fraction) {
  return (pixel + .5) + static_cast<int32_t>(fraction ^ 0x80000000u) * 0x1p-32;
}

// Up to kLanes samples of one pixel, worked out side by side.
template <uint32_t kLanes>
TRIAD_INLINE_BODY inline void place_lanes(SobolOwenSeeds seeds, std::span<SampleRequest> run) {
  const uint32_t first = run.front().index;
  const int32_t pixel_x = run.front().pixel_x, pixel_y = run.front().pixel_y;
  std::array<double, kLanes> x, y;
  for (uint32_t i = 0; i < kLanes; ++i) {
    const std::array<uint32_t, 2> point = sobol_owen_point(first + i, seeds);
    x[i] = place_in(pixel_x, point[0]);
    y[i] = place_in(pixel_y, point[1]);
  }
  for (size_t i = 0; i < run.size(); ++i) {
    run[i].x = x[i];
    run[i].y = y[i];
  }
}

TRIAD_INLINE_BODY inline void place_runs(std::span<SampleRequest> requests) {
  constexpr size_t kMany = 16, kFew = 4;
  while (!requests.empty()) {
    const SampleRequest& first = requests.front();
    size_t n = 1;  // in the run of the first one's pixel
    while (n < requests.size() && requests[n].pixel_x == first.pixel_x && requests[n].pixel_y == first.pixel_y) ++n;
    const SobolOwenSeeds seeds(SampleRandom::pixel_key(first.pixel_x, first.pixel_y, first.seed));
    for (size_t done = 0; done < n;) {
      const size_t left = n - done;
      if (left > kFew)
        place_lanes<kMany>(seeds, requests.subspan(done, std::min(kMany, left)));
      else
        place_lanes<kFew>(seeds, requests.subspan(done, left));
      done += std::min(left, left > kFew ? kMany : kFew);
    }
    requests = requests.subspan(n);
  }
}

}  // namespace

void place_sobol_owen(std::span<SampleRequest> requests) {
  run_widest([&]() TRIAD_INLINE_BODY { place_runs(requests); });
}

const StrategyEntry& sobol_owen_strategy() {
  static const StrategyEntry entry = strategy_entry<SobolOwen>(kInfo);
  return entry;
}

}  // namespace triad
