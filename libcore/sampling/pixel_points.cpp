// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <numeric>
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
  const uint64_t cells = uint64_t{nx} * ny;
  uint64_t stride =
      std::max<uint64_t>(1, static_cast<uint64_t>(std::llround(static_cast<double>(cells) * .6180339887498949)));
  while (std::gcd(stride, cells) != 1) ++stride;
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

void PixelPoints::place(std::span<SampleRequest> requests) const {
  if (kind_ == Kind::kSobol) return place_sobol_owen(requests);
  for (SampleRequest& r : requests) {
    const auto [u, v] = two_numbers(r);
    const uint32_t cell = kind_ == Kind::kJitter ? cells_[r.index] : 0;
    r.x = r.pixel_x + (cell % nx_ + u) / nx_;
    r.y = r.pixel_y + (cell / nx_ + v) / ny_;
  }
}

}  // namespace triad
