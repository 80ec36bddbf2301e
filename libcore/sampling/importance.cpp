// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/filtered_points.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "importance", "points drawn from a reconstruction filter, for each pixel on its own",
    "Filter importance sampling (Ernst, Stamminger, Greiner, 2006): spp places about the pixel's centre with a "
    "density "
    "of |filter|; the pixel is (integral of |f| / integral of f)^2 times their mean, each with the sign of the "
    "filter "
    "there. Noise is white: no sample counts in two pixels. With a filter that has negative values (mitchell, "
    "lanczos2, "
    "lanczos3), even a constant gets noise, as dividing by the sum of the signs instead would make fireflies worse. "
    "For light that is noisy itself; at edges, splat is smoother for the same samples.",
    FilteredPoints::params()};

class Importance final : public FilteredPoints {
 public:
  explicit Importance(const StrategyValues& values) : FilteredPoints(kInfo, values) {}
  bool estimates_error() const override { return points().halves_are_alike(); }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    const auto place = [this](std::span<SampleRequest> requests, size_t each) {
      if (each > 0) say_all(requests, each);
      points().place(requests);
      for (SampleRequest& r : requests) {
        r.x = r.pixel_x + .5 + filter().place(r.x - r.pixel_x);
        r.y = r.pixel_y + .5 + filter().place(r.y - r.pixel_y);
      }
    };
    SampleTaker::Weigh weigh;
    if (filter().is_signed()) {
      const double ratio = filter().absolute_integral() / filter().integral();
      weigh = [this, factor = static_cast<float>(ratio * ratio)](std::span<const SampleRequest> requests,
                                                                 std::span<Sample> samples) {
        for (size_t i = 0; i < requests.size(); ++i)
          for (float& v : samples[i].rgb) v *= is_negative(requests[i]) ? -factor : factor;
      };
    }
    Passes passes(*this, source, options, footprint_px(), place, weigh);
    passes.run_all_in_turn(spp());
    return passes.finish();
  }

 private:
  bool is_negative(const SampleRequest& r) const {
    return (table()(r.x - r.pixel_x - .5) < 0) != (table()(r.y - r.pixel_y - .5) < 0);
  }
};

}  // namespace

const StrategyEntry& importance_strategy() {
  static const StrategyEntry entry = strategy_entry<Importance>(kInfo);
  return entry;
}

}  // namespace triad
