// SPDX-License-Identifier: Apache-2.0
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
      : PointStrategy(kInfo, values), n_(static_cast<uint32_t>(values.at("n"))), places_(places_for(n_)) {}
  bool estimates_error() const override { return false; }

 protected:
  uint32_t samples_per_pixel() const override { return n_ * n_; }
  void place(std::span<SampleRequest> requests) const override {
    for (SampleRequest& request : requests) {
      const Place& place = places_[request.index];
      request.x = request.pixel_x + place.x;
      request.y = request.pixel_y + place.y;
    }
  }

 private:
  struct Place {
    double x, y;
  };
  static std::vector<Place> places_for(uint32_t n) {
    const uint64_t cells = uint64_t{n} * n;
    const uint64_t stride = spread_stride(cells);
    std::vector<Place> places(cells);
    for (uint64_t index = 0, cell = 0; index < cells; ++index, cell = (cell + stride) % cells)
      places[index] = {(static_cast<double>(cell % n) + .5) / n, (static_cast<double>(cell / n) + .5) / n};
    return places;
  }

  uint32_t n_;
  std::vector<Place> places_;
};

}  // namespace

const StrategyEntry& grid_strategy() {
  static const StrategyEntry entry = strategy_entry<Grid>(kInfo);
  return entry;
}

}  // namespace triad
