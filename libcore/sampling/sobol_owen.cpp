// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
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

namespace {

constexpr size_t kAtOnce = 64;
struct Places {
  std::array<double, kAtOnce> x, y;
};

// use(first, count, places) for each run of at most kAtOnce requests: in film pixels, or in [0, 1) of their own
// pixel.
template <bool kOnFilm, class Use>
void for_places(std::span<const SampleRequest> requests, const Use& use) {
  std::array<uint32_t, kAtOnce> index{}, seed_x{}, seed_y{};
  std::array<int32_t, kAtOnce> pixel_x{}, pixel_y{};
  Places places;
  for (size_t begin = 0; begin < requests.size(); begin += kAtOnce) {
    const size_t n = std::min(kAtOnce, requests.size() - begin);
    const auto some = requests.subspan(begin, n);
    for (size_t first = 0, past = 0; first < n; first = past) {  // runs of one pixel
      const SampleRequest& run = some[first];
      for (past = first + 1; past < n; ++past)
        if (some[past].pixel_x != run.pixel_x || some[past].pixel_y != run.pixel_y) break;
      const SobolOwenSeeds seeds(SampleRandom::pixel_key(run.pixel_x, run.pixel_y, run.seed));
      for (size_t i = first; i < past; ++i) {
        index[i] = run.index + static_cast<uint32_t>(i - first);
        if constexpr (kOnFilm) {
          pixel_x[i] = run.pixel_x;
          pixel_y[i] = run.pixel_y;
        }
        seed_x[i] = seeds.x;
        seed_y[i] = seeds.y;
      }
    }
    run_widest([&]() TRIAD_INLINE_BODY {
      for (size_t i = 0; i < kAtOnce; ++i) {
        const std::array<uint32_t, 2> point = sobol_owen_point(index[i], SobolOwenSeeds(seed_x[i], seed_y[i]));
        places.x[i] = (kOnFilm ? pixel_x[i] : 0) + point[0] * 0x1p-32;
        places.y[i] = (kOnFilm ? pixel_y[i] : 0) + point[1] * 0x1p-32;
      }
    });
    use(begin, n, places);
  }
}

}  // namespace

void place_sobol_owen(std::span<SampleRequest> requests) {
  for_places<true>(requests, [&](size_t begin, size_t n, const Places& places) {
    for (size_t i = 0; i < n; ++i) {
      requests[begin + i].x = places.x[i];
      requests[begin + i].y = places.y[i];
    }
  });
}

void sobol_owen_places(std::span<const SampleRequest> requests, std::span<double> x, std::span<double> y) {
  for_places<false>(requests, [&](size_t begin, size_t n, const Places& places) {
    std::copy_n(places.x.begin(), n, x.begin() + static_cast<ptrdiff_t>(begin));
    std::copy_n(places.y.begin(), n, y.begin() + static_cast<ptrdiff_t>(begin));
  });
}

const StrategyEntry& sobol_owen_strategy() {
  static const StrategyEntry entry = strategy_entry<SobolOwen>(kInfo);
  return entry;
}

}  // namespace triad
