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

}  // namespace

void place_sobol_owen(std::span<SampleRequest> requests) {
  constexpr size_t kAtOnce = 64;
  std::array<uint32_t, kAtOnce> index{}, seed_x{}, seed_y{};
  std::array<int32_t, kAtOnce> pixel_x{}, pixel_y{};
  std::array<double, kAtOnce> x, y;
  for (; !requests.empty(); requests = requests.subspan(std::min(kAtOnce, requests.size()))) {
    const size_t n = std::min(kAtOnce, requests.size());
    for (size_t first = 0, past = 0; first < n; first = past) {  // runs of one pixel
      const SampleRequest& run = requests[first];
      for (past = first + 1; past < n; ++past)
        if (requests[past].pixel_x != run.pixel_x || requests[past].pixel_y != run.pixel_y) break;
      const SobolOwenSeeds seeds(SampleRandom::pixel_key(run.pixel_x, run.pixel_y, run.seed));
      for (size_t i = first; i < past; ++i) {
        index[i] = run.index + static_cast<uint32_t>(i - first);
        pixel_x[i] = run.pixel_x;
        pixel_y[i] = run.pixel_y;
        seed_x[i] = seeds.x;
        seed_y[i] = seeds.y;
      }
    }
    run_widest([&]() TRIAD_INLINE_BODY {
      for (size_t i = 0; i < kAtOnce; ++i) {
        const std::array<uint32_t, 2> point = sobol_owen_point(index[i], SobolOwenSeeds(seed_x[i], seed_y[i]));
        x[i] = pixel_x[i] + point[0] * 0x1p-32;
        y[i] = pixel_y[i] + point[1] * 0x1p-32;
      }
    });
    for (size_t i = 0; i < n; ++i) {
      requests[i].x = x[i];
      requests[i].y = y[i];
    }
  }
}

const StrategyEntry& sobol_owen_strategy() {
  static const StrategyEntry entry = strategy_entry<SobolOwen>(kInfo);
  return entry;
}

}  // namespace triad
