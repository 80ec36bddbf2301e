// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/pixel_points.hpp>
#include <triad/sampling/point_strategy.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "jitter",
    "One random point in each of n x n cells of a pixel",
    "Uniform in its cell. At an edge the error falls with the samples to the power of 3/4, where "
    "that of random points falls with their root. What a cell adds to the error shows in no "
    "other sample, so the error is not estimated.",
    {{"n", "cells along each side of a pixel", 1, 1024, 4}}};

class Jitter final : public PointStrategy {
 public:
  explicit Jitter(const StrategyValues& values)
      : PointStrategy(kInfo, values), points_(PixelPoints::Kind::kJitter, whole("n") * whole("n")) {}
  bool estimates_error() const override { return points_.halves_are_alike(); }

 protected:
  uint32_t samples_per_pixel() const override { return points_.samples_per_pixel(); }
  void place(std::span<SampleRequest> requests) const override { points_.place(requests); }

 private:
  PixelPoints points_;
};

}  // namespace

const StrategyEntry& jitter_strategy() {
  static const StrategyEntry entry = strategy_entry<Jitter>(kInfo);
  return entry;
}

}  // namespace triad
