// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numeric>
#include <triad/sampling/passes.hpp>
#include <triad/sampling/point_strategy.hpp>

namespace triad {
namespace {

constexpr uint32_t kSecondPass = 16;  // samples per pixel after the second pass

}  // namespace

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
  const uint32_t spp = samples_per_pixel();
  Passes passes(*this, source, options, 1 / std::sqrt(static_cast<float>(spp)),
                [this](std::span<SampleRequest> requests) { place(requests); });
  const auto next = [spp](uint32_t last) { return std::min(spp, std::max(last * 2, kSecondPass)); };
  for (uint32_t first = 0, last = 1; first < spp; first = last, last = next(last))
    if (!passes.run_all(first, last)) break;
  return passes.finish();
}

}  // namespace triad
