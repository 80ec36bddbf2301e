// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <triad/numeric/widest.hpp>
#include <triad/sampling/hot_avx512.hpp>
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
  Passes::Points points() const override { return place_sobol_owen; }

 private:
  uint32_t spp_;
};

constexpr size_t kMany = 16;

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
  if (first <= SobolStarts::kCount - kLanes) {
    const uint32_t *const start_x = &kSobolStarts.x[first], *const start_y = &kSobolStarts.y[first];
    for (uint32_t i = 0; i < kLanes; ++i) {
      x[i] = place_in(pixel_x, reverse_bits(owen_scramble_rest(start_x[i], seeds.x)));
      y[i] = place_in(pixel_y, reverse_bits(owen_scramble_rest(start_y[i], seeds.y)));
    }
  } else {
    for (uint32_t i = 0; i < kLanes; ++i) {
      const std::array<uint32_t, 2> point = sobol_owen_point(first + i, seeds);
      x[i] = place_in(pixel_x, point[0]);
      y[i] = place_in(pixel_y, point[1]);
    }
  }
  for (size_t i = 0; i < count; ++i) put(i, x[i], y[i]);
}

// The same of up to kLanes samples of one index that are each of another pixel.
template <uint32_t kLanes, bool kOnFilm, class Put>
TRIAD_INLINE_BODY inline void place_pixels(std::span<const SampleRequest> requests, const Put& put) {
  std::array<int32_t, kLanes> pixel_x, pixel_y;
  for (size_t i = 0; i < kLanes; ++i) {
    const SampleRequest& request = requests[std::min(i, requests.size() - 1)];
    pixel_x[i] = request.pixel_x;
    pixel_y[i] = request.pixel_y;
  }
  const std::array<uint32_t, 2> plain = sobol_point_reversed(requests[0].index);
  const uint32_t start_x = owen_scramble_start(plain[0]), start_y = owen_scramble_start(plain[1]);
  const uint64_t seed = requests[0].seed;
  std::array<double, kLanes> x, y;
  for (uint32_t i = 0; i < kLanes; ++i) {
    const SobolOwenSeeds seeds(SampleRandom::pixel_key(pixel_x[i], pixel_y[i], seed));
    x[i] = place_in(kOnFilm ? pixel_x[i] : 0, reverse_bits(owen_scramble_rest(start_x, seeds.x)));
    y[i] = place_in(kOnFilm ? pixel_y[i] : 0, reverse_bits(owen_scramble_rest(start_y, seeds.y)));
  }
  for (size_t i = 0; i < requests.size(); ++i) put(i, x[i], y[i]);
}

constexpr auto kNoneAtOnce = [](const SampleRequest&, SobolOwenSeeds, size_t) { return false; };

// put(i, x, y) for each request; or else put_many(first, seeds, i), which may say false, for kMany from there on of
// the pixel of request `first`. With each > 0 there are so many of every pixel; or else it is looked for.
template <bool kOnFilm, class Put, class PutMany>
TRIAD_INLINE_BODY inline void place_runs(std::span<const SampleRequest> requests, size_t each, const Put& put,
                                         const PutMany& put_many) {
  constexpr size_t kFew = 4;
  for (size_t begin = 0, past = 0; begin < requests.size(); begin = past) {
    const SampleRequest& first = requests[begin];
    past = begin + std::max<size_t>(each, 1);
    if (each == 0)  // the run of the first one's pixel
      while (past < requests.size() && same_pixel(requests[past], first)) ++past;
    if (past == begin + 1) {  // alone, as are perhaps those after it
      while (past < requests.size() && past - begin < kMany && requests[past].index == first.index &&
             !(each != 1 && past + 1 < requests.size() && same_pixel(requests[past], requests[past + 1])))
        ++past;
      place_pixels<kMany, kOnFilm>(requests.subspan(begin, past - begin),
                                   [&](size_t i, double x, double y) TRIAD_INLINE_BODY { put(begin + i, x, y); });
      continue;
    }
    const SobolOwenSeeds seeds(SampleRandom::pixel_key(first.pixel_x, first.pixel_y, first.seed));
    const int32_t x0 = kOnFilm ? first.pixel_x : 0, y0 = kOnFilm ? first.pixel_y : 0;
    for (size_t at = begin; at < past;) {
      const size_t left = past - at, most = left > kFew ? kMany : kFew, count = std::min(left, most);
      if (count == kMany && put_many(first, seeds, at)) {
        at += kMany;
        continue;
      }
      const uint32_t index = first.index + static_cast<uint32_t>(at - begin);
      const auto put_here = [&](size_t i, double x, double y) TRIAD_INLINE_BODY { put(at + i, x, y); };
      if (most == kMany)
        place_lanes<kMany>(seeds, index, x0, y0, count, put_here);
      else
        place_lanes<kFew>(seeds, index, x0, y0, count, put_here);
      at += count;
    }
  }
}

}  // namespace

void place_sobol_owen(std::span<SampleRequest> requests, size_t each) {
  const auto put = [&](size_t i, double x, double y) TRIAD_INLINE_BODY {
    requests[i].x = x;
    requests[i].y = y;
  };
#if defined(__x86_64__)
  static const bool wide = default_cpu_path() == CpuPath::kAvx512;
  if (wide) {
    bool all_by_hand = each % kMany == 0;  // which say all
    for (size_t i = 0; each > 0 && all_by_hand && i < requests.size(); i += each)
      all_by_hand = requests[i].index + each <= SobolStarts::kCount;
    if (!all_by_hand) say_all(requests, each);
    const auto put_many = [&](const SampleRequest& first, SobolOwenSeeds seeds, size_t i) TRIAD_INLINE_BODY {
      const uint32_t index = first.index + static_cast<uint32_t>(&requests[i] - &first);
      if (index > SobolStarts::kCount - kMany) return false;
      avx512::place_sixteen(&kSobolStarts.x[index], &kSobolStarts.y[index], seeds.x, seeds.y, first, &requests[i]);
      return true;
    };
    return run_avx512([&]() TRIAD_INLINE_BODY { place_runs<true>(requests, each, put, put_many); });
  }
#endif
  if (each > 1) say_all(requests, each);
  run_widest([&]() TRIAD_INLINE_BODY { place_runs<true>(requests, each, put, kNoneAtOnce); });
}

void sobol_owen_places(std::span<const SampleRequest> requests, std::span<double> x, std::span<double> y) {
  run_widest([&]() TRIAD_INLINE_BODY {
    const auto put = [&](size_t i, double place_x, double place_y) TRIAD_INLINE_BODY {
      x[i] = place_x;
      y[i] = place_y;
    };
    place_runs<false>(requests, 0, put, kNoneAtOnce);
  });
}

const StrategyEntry& sobol_owen_strategy() {
  static const StrategyEntry entry = strategy_entry<SobolOwen>(kInfo);
  return entry;
}

}  // namespace triad
