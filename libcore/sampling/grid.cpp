// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <triad/sampling/pixel_points.hpp>
#include <triad/sampling/point_strategy.hpp>
#include <vector>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "grid",
    "n x n samples on a regular grid in each pixel",
    "The mean of samples at ((i + 1/2) / n, (j + 1/2) / n). Exact where light changes linearly; edges "
    "near the horizontal or the vertical show n steps of grey at most.",
    {{"n", "samples along each side of a pixel", 1, 1024, 2}}};

class Grid final : public PointStrategy {
 public:
  explicit Grid(const StrategyValues& values)
      : PointStrategy(kInfo, values), n_(static_cast<uint32_t>(values.at("n"))) {
    for (const uint32_t cell : scattered_cells(n_, n_))
      places_.push_back({(cell % n_ + .5) / n_, (cell / n_ + .5) / n_});
  }
  bool estimates_error() const override { return false; }

 protected:
  uint32_t samples_per_pixel() const override { return n_ * n_; }
  Passes::Points points() const override { return Passes::Pattern(places_); }

 private:
  uint32_t n_;
  // In a pixel, by index, so that a render that is ended early has samples all over the pixel.
  std::vector<std::array<double, 2>> places_;
};

}  // namespace

const StrategyEntry& grid_strategy() {
  static const StrategyEntry entry = strategy_entry<Grid>(kInfo);
  return entry;
}

}  // namespace triad
