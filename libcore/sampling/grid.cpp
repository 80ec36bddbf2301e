// SPDX-License-Identifier: Apache-2.0
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
      : PointStrategy(kInfo, values), n_(static_cast<uint32_t>(values.at("n"))), cells_(scattered_cells(n_, n_)) {}
  bool estimates_error() const override { return false; }

 protected:
  uint32_t samples_per_pixel() const override { return n_ * n_; }
  void place(std::span<SampleRequest> requests) const override {
    for (SampleRequest& request : requests) {
      const uint32_t cell = cells_[request.index];
      request.x = request.pixel_x + (cell % n_ + .5) / n_;
      request.y = request.pixel_y + (cell / n_ + .5) / n_;
    }
  }

 private:
  uint32_t n_;
  std::vector<uint32_t> cells_;  // by index, so that a render that is ended early has samples all over the pixel
};

}  // namespace

const StrategyEntry& grid_strategy() {
  static const StrategyEntry entry = strategy_entry<Grid>(kInfo);
  return entry;
}

}  // namespace triad
