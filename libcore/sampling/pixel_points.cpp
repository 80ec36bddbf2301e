// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <triad/base/random.hpp>
#include <triad/sampling/pixel_points.hpp>
#include <triad/sampling/point_strategy.hpp>

namespace triad {
namespace {

// The two numbers of a sample in [0, 1), multiples of 2^-32.
std::array<double, 2> two_numbers(const SampleRequest& r) {
  const uint64_t bits = SampleRandom(r.pixel_x, r.pixel_y, r.index, r.seed).u64(0);
  return {static_cast<double>(bits >> 32) * 0x1p-32, static_cast<double>(bits & 0xffffffffu) * 0x1p-32};
}

}  // namespace

std::vector<uint32_t> scattered_cells(uint32_t nx, uint32_t ny) {
  const uint64_t cells = uint64_t{nx} * ny, stride = spread_stride(cells);
  std::vector<uint32_t> order(cells);
  for (uint64_t index = 0, cell = 0; index < cells; ++index, cell = (cell + stride) % cells)
    order[index] = static_cast<uint32_t>(cell);
  return order;
}

StrategyParam PixelPoints::param() {
  return choice_param("points",
                      "how they lie: scrambled Sobol points; independent; or one in each cell of a grid of spp cells",
                      {"sobol", "random", "jitter"});
}

PixelPoints::PixelPoints(Kind kind, uint32_t spp) : kind_(kind), spp_(spp) {
  if (kind != Kind::kJitter) return;
  nx_ = static_cast<uint32_t>(std::sqrt(static_cast<double>(spp)));
  while (spp % nx_ != 0) --nx_;
  ny_ = spp / nx_;
  cells_ = scattered_cells(nx_, ny_);
}

template <class Put>
void PixelPoints::each_place(std::span<const SampleRequest> requests, const Put& put) const {
  for (size_t i = 0; i < requests.size(); ++i) {
    const auto [u, v] = two_numbers(requests[i]);
    const uint32_t cell = kind_ == Kind::kJitter ? cells_[requests[i].index] : 0;
    put(i, (cell % nx_ + u) / nx_, (cell / nx_ + v) / ny_);
  }
}

void PixelPoints::place(std::span<SampleRequest> requests) const {
  if (kind_ == Kind::kSobol) return place_sobol_owen(requests);
  each_place(requests, [&](size_t i, double x, double y) {
    requests[i].x = requests[i].pixel_x + x;
    requests[i].y = requests[i].pixel_y + y;
  });
}

void PixelPoints::places(std::span<const SampleRequest> requests, std::span<double> x, std::span<double> y) const {
  if (kind_ == Kind::kSobol) return sobol_owen_places(requests, x, y);
  each_place(requests, [&](size_t i, double place_x, double place_y) {
    x[i] = place_x;
    y[i] = place_y;
  });
}

}  // namespace triad
