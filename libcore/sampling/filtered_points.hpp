// SPDX-License-Identifier: Apache-2.0
// What strategies with a reconstruction filter have in common.
#pragma once

#include <array>
#include <limits>
#include <triad/sampling/passes.hpp>
#include <triad/sampling/pixel_points.hpp>
#include <triad/sampling/reconstruction.hpp>
#include <triad/sampling/strategy_base.hpp>

namespace triad {

// A strategy whose first parameters are filter, spp, points and scale.
class FilteredPoints : public StrategyBase {
 public:
  FilteredPoints(const StrategyInfo& info, const StrategyValues& values);
  uint64_t most_samples(int width, int height) const override;

  // Those four, and what else is given.
  static std::vector<StrategyParam> params(std::vector<StrategyParam> more = {});

 protected:
  const ReconstructionFilter& filter() const { return filter_; }
  const ReconstructionTable& table() const { return table_; }
  const PixelPoints& points() const { return points_; }
  uint32_t spp() const { return points_.samples_per_pixel(); }
  // So much of the film that the samples under a filter of radius 1/2 cover it once.
  float footprint_px() const;

 private:
  ReconstructionFilter filter_;
  ReconstructionTable table_;
  PixelPoints points_;
};

// The weights of a pixel, of either sign, and the sample to take instead of their mean where they cancel.
struct SignedWeights {
  // Weights that sum to less than this share of what their absolute values do say nothing: they would blow up noise
  // 16 times or more.
  static constexpr double kCancelled = 1. / 16;

  double sum = 0, absolute = 0;
  float nearest_px2 = std::numeric_limits<float>::infinity();  // squared distance from the centre
  std::array<float, 3> nearest{};                              // the colour there

  void add(double weight, double x_px, double y_px, const std::array<float, 3>& rgb) {
    sum += weight;
    absolute += weight < 0 ? -weight : weight;
    const auto px2 = static_cast<float>(x_px * x_px + y_px * y_px);
    if (px2 < nearest_px2) {
      nearest_px2 = px2;
      nearest = rgb;
    }
  }
  bool cancel() const { return (sum < 0 ? -sum : sum) <= kCancelled * absolute; }
};

}  // namespace triad
