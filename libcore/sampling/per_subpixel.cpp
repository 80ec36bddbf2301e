// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <triad/base/parallel.hpp>
#include <triad/sampling/pixel_batches.hpp>
#include <triad/sampling/strategy_base.hpp>
#include <triad/sampling/subpixels.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "per-subpixel",
    "a sample for each of a pixel's three subpixels",
    "Red is the red of a sample at the centre of the left third of the pixel, green of the middle, blue of the right "
    "third: the picture for a display of red, green and blue stripes in which each subpixel has the light of the "
    "place where it lies. Three samples a pixel; edges are sharp, and fringed with colour, as nothing is averaged. "
    "More of spp are more samples at the same three places, and take away noise of light only.",
    {{"spp", "samples at each of the three places", 1, 1 << 22, 1}}};

class PerSubpixel final : public StrategyBase {
 public:
  explicit PerSubpixel(const StrategyValues& values) : StrategyBase(kInfo, values), spp_(whole("spp")) {}
  // Three places that are always the same ones say nothing about what lies between them.
  bool estimates_error() const override { return false; }
  uint64_t most_samples(int width, int height) const override {
    return uint64_t{kSubpixels} * spp_ * static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    require_whole_pixels(info(), options);
    SampleTaker taker(*this, source, options);
    SubpixelSums sums(source.width(), source.height());
    PixelWork work{source.width(), source.height(), 1 / std::sqrt(static_cast<float>(kSubpixels * spp_))};
    work.take = [&](const PixelBatch& batch) {
      return sums.take(taker, batch, [](const SampleRequest& r) { return static_cast<int>(r.index % kSubpixels); });
    };
    take_in_passes(taker, work, spp_, kSubpixels);
    auto& colour = taker.result().colour;
    colour.resize(taker.film().pixels());
    parallel_for(source.height(), [&](int64_t y) {
      const auto means = sums.means(static_cast<int>(y));
      for (int x = 0; x < source.width(); ++x)
        for (size_t s = 0; s < kSubpixels; ++s)
          colour[taker.film().pixel(x, static_cast<int>(y))][s] = means[static_cast<size_t>(x) * kSubpixels + s][s];
    });
    return taker.finish();
  }

 private:
  uint32_t spp_;
};

}  // namespace

const StrategyEntry& per_subpixel_strategy() {
  static const StrategyEntry entry = strategy_entry<PerSubpixel>(kInfo);
  return entry;
}

}  // namespace triad
