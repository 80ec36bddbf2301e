// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <triad/sampling/filtered_points.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "uniform", "uniform points under a reconstruction filter, weighted by it, for each pixel on its own",
    "spp places in the square that the filter covers; the pixel is the mean of the samples, each weighted by the "
    "filter "
    "there. What is simplest where a filter cannot be drawn from, and the noisiest: most samples lie where the "
    "filter "
    "is "
    "small. divide=weights divides by the sum of the weights, so that a constant stays one; where they cancel, the "
    "sample nearest to the centre is taken. divide=integral divides by what that sum is in the mean: unbiased, but a "
    "constant gets noise. A variance that is asked for is that of the weighted samples, undivided. See splat and "
    "importance.",
    FilteredPoints::params({choice_param("divide", "by what the weighted sum is divided", {"weights", "integral"})})};

class Uniform final : public FilteredPoints {
 public:
  explicit Uniform(const StrategyValues& values) : FilteredPoints(kInfo, values), by_weights_(whole("divide") == 0) {}
  bool estimates_error() const override { return !by_weights_ && points().halves_are_alike(); }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    const double factor = std::pow(2 * filter().radius_px() / filter().integral(), 2);
    std::vector<SignedWeights> weights;
    const auto width = static_cast<size_t>(source.width());
    if (by_weights_) weights.resize(width * static_cast<size_t>(source.height()));
    const auto weigh = [&](std::span<const SampleRequest> requests, std::span<Sample> samples) {
      for (size_t i = 0; i < requests.size(); ++i) {
        const SampleRequest& r = requests[i];
        const double x = r.x - r.pixel_x - .5, y = r.y - r.pixel_y - .5, w = filter().value(x) * filter().value(y);
        if (by_weights_ && usable(samples[i]))
          weights[static_cast<size_t>(r.pixel_y) * width + static_cast<size_t>(r.pixel_x)].add(w, x, y,
                                                                                               samples[i].rgb);
        for (float& v : samples[i].rgb) v = static_cast<float>(v * factor * w);
      }
    };
    Passes passes(
        *this, source, options, footprint_px(),
        [this](auto requests, size_t each) {
          if (each > 0) say_all(requests, each);
          place(requests);
        },
        weigh);
    passes.run_all_in_turn(spp());
    RenderResult result = passes.finish();
    if (by_weights_) result.colour = divided(result.film, weights, factor);
    return result;
  }

 private:
  void place(std::span<SampleRequest> requests) const {
    points().place(requests);
    const double radius = filter().radius_px();
    for (SampleRequest& r : requests) {
      r.x = r.pixel_x + .5 + (2 * (r.x - r.pixel_x) - 1) * radius;
      r.y = r.pixel_y + .5 + (2 * (r.y - r.pixel_y) - 1) * radius;
    }
  }
  static std::vector<std::array<double, 3>> divided(const Film& film, const std::vector<SignedWeights>& weights,
                                                    double factor) {
    std::vector<std::array<double, 3>> colour(film.pixels());
    for (size_t p = 0; p < colour.size(); ++p) {
      const SignedWeights& w = weights[p];
      const std::array<double, 3> mean = film.mean(p);
      for (size_t c = 0; c < 3; ++c)
        colour[p][c] = w.cancel() ? w.nearest[c] : mean[c] * film.count(p) / (factor * w.sum);
    }
    return colour;
  }

  bool by_weights_;
};

}  // namespace

const StrategyEntry& uniform_strategy() {
  static const StrategyEntry entry = strategy_entry<Uniform>(kInfo);
  return entry;
}

}  // namespace triad
