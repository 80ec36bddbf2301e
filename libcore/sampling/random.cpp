// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/pixel_points.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{"random",
                         "spp independent points in each pixel",
                         "Uniform and independent: the plainest antialiasing, whose error falls with the root of spp "
                         "everywhere. What the theory of noise is about; sobol-owen costs the same and errs less.",
                         {{"spp", "samples per pixel", 1, 1 << 24, 16}}};

class Random final : public PixelPointsStrategy {
 public:
  explicit Random(const StrategyValues& values)
      : PixelPointsStrategy(kInfo, values,
                            PixelPoints(PixelPoints::Kind::kRandom, static_cast<uint32_t>(values.at("spp")))) {}
};

}  // namespace

const StrategyEntry& random_strategy() {
  static const StrategyEntry entry = strategy_entry<Random>(kInfo);
  return entry;
}

}  // namespace triad
