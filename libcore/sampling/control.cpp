// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <triad/sampling/point_strategy.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "control",
    "One sample at the centre of each pixel",
    "The picture without antialiasing, which the others are measured against. With more spp, all "
    "of them at the centre, the noise of lamps and lenses is averaged away, and edges stay as "
    "jagged as they are.",
    {{"spp", "samples at the centre", 1, 1 << 24, 1}}};

class Control final : public PointStrategy {
 public:
  explicit Control(const StrategyValues& values) : PointStrategy(kInfo, values) {}
  bool estimates_error() const override { return false; }

 protected:
  uint32_t samples_per_pixel() const override { return whole("spp"); }
  float footprint_px() const override { return 1; }  // of the pixel, however often
  Passes::Points points() const override { return Passes::Pattern(centre_); }

 private:
  std::array<std::array<double, 2>, 1> centre_{{{.5, .5}}};
};

}  // namespace

const StrategyEntry& control_strategy() {
  static const StrategyEntry entry = strategy_entry<Control>(kInfo);
  return entry;
}

}  // namespace triad
