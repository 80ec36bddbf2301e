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

// pixel + fraction * 2^-32, rounded once, with one conversion of signed numbers: vectors have none of unsigned ones
// before AVX-512.
TRIAD_INLINE_BODY inline double place_in(int32_t pixel, uint32_t fraction) {
  return (pixel + .5) + static_cast<int32_t>(fraction ^ 0x80000000u) * 0x1p-32;
}

// Up to kLanes samples of one pixel, worked out side by side: put(i, x, y) for each, in film pixels or, for a pixel
// 0, 0, within their own.
template <uint32_t kLanes, class Put>
TRIAD_INLINE_BODY inline void place_lanes(SobolOwenSeeds seeds, uint32_t first, int32_t pixel_x, int32_t pixel_y,
                                          size_t count, const Put& put) {
  std::array<double, kLanes> x, y;
  for (uint32_t i = 0; i < kLanes; ++i) {
    const std::array<uint32_t, 2> point = sobol_owen_point(first + i, seeds);
    x[i] = place_in(pixel_x, point[0]);
    y[i] = place_in(pixel_y, point[1]);
  }
  for (size_t i = 0; i < count; ++i) put(i, x[i], y[i]);
}

// put(i, x, y) for each request.
template <bool kOnFilm, class Put>
TRIAD_INLINE_BODY inline void place_runs(std::span<const SampleRequest> requests, const Put& put) {
  constexpr size_t kMany = 16, kFew = 4;
  for (size_t begin = 0, past = 0; begin < requests.size(); begin = past) {
    const SampleRequest& first = requests[begin];
    for (past = begin + 1; past < requests.size(); ++past)  // the run of the first one's pixel
      if (requests[past].pixel_x != first.pixel_x || requests[past].pixel_y != first.pixel_y) break;
    const SobolOwenSeeds seeds(SampleRandom::pixel_key(first.pixel_x, first.pixel_y, first.seed));
    const int32_t x0 = kOnFilm ? first.pixel_x : 0, y0 = kOnFilm ? first.pixel_y : 0;
    for (size_t at = begin; at < past;) {
      const size_t left = past - at, most = left > kFew ? kMany : kFew, count = std::min(left, most);
      const auto put_here = [&](size_t i, double x, double y) TRIAD_INLINE_BODY { put(at + i, x, y); };
      if (most == kMany)
        place_lanes<kMany>(seeds, requests[at].index, x0, y0, count, put_here);
      else
        place_lanes<kFew>(seeds, requests[at].index, x0, y0, count, put_here);
      at += count;
    }
  }
}

}  // namespace

void place_sobol_owen(std::span<SampleRequest> requests) {
  run_widest([&]() TRIAD_INLINE_BODY {
    place_runs<true>(requests, [&](size_t i, double x, double y) TRIAD_INLINE_BODY {
      requests[i].x = x;
      requests[i].y = y;
    });
  });
}

void sobol_owen_places(std::span<const SampleRequest> requests, std::span<double> x, std::span<double> y) {
  run_widest([&]() TRIAD_INLINE_BODY {
    place_runs<false>(requests, [&](size_t i, double place_x, double place_y) TRIAD_INLINE_BODY {
      x[i] = place_x;
      y[i] = place_y;
    });
  });
}

const StrategyEntry& sobol_owen_strategy() {
  static const StrategyEntry entry = strategy_entry<SobolOwen>(kInfo);
  return entry;
}

}  // namespace triad
