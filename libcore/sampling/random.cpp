// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/pixel_points.hpp>
#include <triad/sampling/point_strategy.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{"random",
                         "spp independent points in each pixel",
                         "Uniform and independent: the plainest antialiasing, whose error falls with the root of spp "
                         "everywhere. What the theory of noise is about; sobol-owen costs the same and errs less.",
                         {{"spp", "samples per pixel", 1, 1 << 24, 16}}};

class Random final : public PointStrategy {
 public:
  explicit Random(const StrategyValues& values)
      : PointStrategy(kInfo, values), points_(PixelPoints::Kind::kRandom, whole("spp")) {}
  bool estimates_error() const override { return true; }

 protected:
  uint32_t samples_per_pixel() const override { return points_.samples_per_pixel(); }
  void place(std::span<SampleRequest> requests) const override { points_.place(requests); }

 private:
  PixelPoints points_;
};

}  // namespace

const StrategyEntry& random_strategy() {
  static const StrategyEntry entry = strategy_entry<Random>(kInfo);
  return entry;
}

}  // namespace triad
