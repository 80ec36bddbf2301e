// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstring>
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
  void place(std::span<SampleRequest> requests) const override {
    typedef int32_t TwoInts __attribute__((vector_size(8)));
    typedef double Two __attribute__((vector_size(16)));
    static_assert(offsetof(SampleRequest, pixel_y) == offsetof(SampleRequest, pixel_x) + sizeof(int32_t));
    static_assert(offsetof(SampleRequest, x) == 0 && offsetof(SampleRequest, y) == sizeof(double));
    for (SampleRequest& request : requests) {
      TwoInts pixel;
      std::memcpy(&pixel, &request.pixel_x, sizeof(pixel));
      const Two place = __builtin_convertvector(pixel, Two) + .5;
      std::memcpy(static_cast<void*>(&request), &place, sizeof(place));
    }
  }
};

}  // namespace

const StrategyEntry& control_strategy() {
  static const StrategyEntry entry = strategy_entry<Control>(kInfo);
  return entry;
}

}  // namespace triad
