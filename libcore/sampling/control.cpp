// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/point_strategy.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{"control",
                         "One sample at the centre of each pixel",
                         "The picture without antialiasing, which the others are measured against.",
                         {}};

class Control final : public PointStrategy {
 public:
  explicit Control(const StrategyValues& values) : PointStrategy(kInfo, values) {}
  bool estimates_error() const override { return false; }

 protected:
  uint32_t samples_per_pixel() const override { return 1; }
  void place(std::span<SampleRequest> requests) const override {
    for (SampleRequest& request : requests) {
      request.x = request.pixel_x + .5;
      request.y = request.pixel_y + .5;
    }
  }
};

}  // namespace

const StrategyEntry& control_strategy() {
  static const StrategyEntry entry = strategy_entry<Control>(kInfo);
  return entry;
}

}  // namespace triad
