// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numeric>
#include <triad/sampling/point_strategy.hpp>

namespace triad {

float PointStrategy::footprint_px() const { return 1 / std::sqrt(static_cast<float>(samples_per_pixel())); }

uint64_t PointStrategy::most_samples(int width, int height) const {
  return uint64_t{samples_per_pixel()} * static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
}

uint64_t spread_stride(uint64_t count) {
  constexpr double kGoldenSection = .6180339887498949;
  uint64_t stride =
      std::max<uint64_t>(1, static_cast<uint64_t>(std::llround(static_cast<double>(count) * kGoldenSection)));
  while (std::gcd(stride, count) != 1) ++stride;
  return stride;
}

RenderResult PointStrategy::render(const Source& source, const RenderOptions& options) const {
  Passes passes(*this, source, options, footprint_px(), points());
  passes.run_all_in_turn(samples_per_pixel());
  return passes.finish();
}

}  // namespace triad
