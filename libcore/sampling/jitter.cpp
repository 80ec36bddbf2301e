// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/pixel_points.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "jitter",
    "One random point in each of n x n cells of a pixel",
    "Uniform in its cell. At an edge the error falls with the samples to the power of 3/4, where "
    "that of random points falls with their root. What a cell adds to the error shows in no "
    "other sample, so the error is not estimated.",
    {{"n", "cells along each side of a pixel", 1, 1024, 4}}};

class Jitter final : public PixelPointsStrategy {
 public:
  explicit Jitter(const StrategyValues& values)
      : PixelPointsStrategy(
            kInfo, values,
            PixelPoints(PixelPoints::Kind::kJitter, static_cast<uint32_t>(values.at("n") * values.at("n")))) {}
};

}  // namespace

const StrategyEntry& jitter_strategy() {
  static const StrategyEntry entry = strategy_entry<Jitter>(kInfo);
  return entry;
}

}  // namespace triad
