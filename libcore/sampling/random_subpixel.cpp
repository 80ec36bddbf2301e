// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <triad/base/parallel.hpp>
#include <triad/base/random.hpp>
#include <triad/colour/colour.hpp>
#include <triad/display/row_filter.hpp>
#include <triad/sampling/pixel_batches.hpp>
#include <triad/sampling/strategy_base.hpp>
#include <triad/sampling/subpixels.hpp>

namespace triad {
namespace {

enum class Mode { kLatin, kIid };

const StrategyInfo kInfo{
    "random-subpixel",
    "each frame one subpixel of each pixel, through the optimal filter",
    "Each frame takes one sample a pixel, at the centre of a subpixel drawn at random, and what the subpixels of a "
    "display of red, green and blue stripes are to show is filtered from the samples of the whole row by the optimal "
    "linear filter of Platt (2000), as platt:range=unbounded,edge=wrap applies it to a wide render. As a subpixel is "
    "drawn with a probability of one third, each sample weighs three times (a weight of Monte Carlo; it has nothing "
    "to do with the three that a stripe is brighter than its pixel by). mode=latin has every pixel visit its three "
    "subpixels in a random order every three frames: after any multiple of three frames the picture is that of the "
    "full filter over a wide render with frames / 3 samples a cell, for a third of its samples in each frame. "
    "mode=iid "
    "draws anew in each frame: right in the mean, with noise that falls with the root of the frames. Values lie "
    "outside 0 .. 1 beside edges.",
    {{"frames", "samples in each pixel; latin is best with a multiple of 3", 1, 1 << 24, 15},
     choice_param("mode", "how subpixels are drawn", {"latin", "iid"}),
     {"lambda", "share of the displaced box in what an eye can hardly see", 0, 1, .01, true},
     {"ppd", "pixels of the display in a degree of the view", 1, 10000, 40, true},
     choice_param("flat-field", "exact keeps constant colours constant; free is the optimum of 2000",
                  {"exact", "free"})}};

class RandomSubpixel final : public StrategyBase {
 public:
  explicit RandomSubpixel(const StrategyValues& values)
      : StrategyBase(kInfo, values), frames_(whole("frames")), mode_(static_cast<Mode>(whole("mode"))) {}
  // A pixel's samples are of three places, and what they become is spread over its row.
  bool estimates_error() const override { return false; }
  uint64_t most_samples(int width, int height) const override {
    return uint64_t{frames_} * static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    require_whole_pixels(info(), options);
    Observer observer;
    observer.rgb_to_xyz = rec709_to_xyz();
    observer.ppd = value("ppd");
    const FilterDesign design(load_layout("rgb"), observer, ring_px(source.width(), Edge::kWrap),
                              {.lambda = value("lambda"), .exact_flat_fields = whole("flat-field") == 0});
    const RowFilter<double> filter(design, source.width(), Edge::kWrap);
    SampleTaker taker(*this, source, options);
    SubpixelSums sums(source.width(), source.height());
    PixelWork work{source.width(), source.height(), std::sqrt(1.f / kSubpixels)};
    work.take = [&](const PixelBatch& batch) {
      return sums.take(taker, batch, [this](const SampleRequest& r) { return subpixel(r); });
    };
    // Frames by threes, and what is left over.
    const uint32_t whole_rounds = frames_ / kSubpixels * kSubpixels;
    take_in_passes(taker, work, frames_ / kSubpixels, kSubpixels);
    if (whole_rounds < frames_ && !taker.stopped()) {
      take_pixels(taker, work, whole_rounds, frames_);
      taker.end_pass();
    }
    taker.result().colour = filtered(sums, filter, source.height());
    return taker.finish();
  }

 private:
  // The one that the pixel samples in frame number `index`.
  int subpixel(const SampleRequest& request) const {
    const auto below = [](uint32_t bits, uint32_t count) {
      return static_cast<size_t>(uint64_t{bits} * count >> 32);
    };
    if (mode_ == Mode::kIid) {
      const SampleRandom random(request.pixel_x, request.pixel_y, request.index, request.seed);
      return static_cast<int>(below(random.u32(0), kSubpixels));
    }
    static constexpr int kOrders[6][kSubpixels] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    const uint32_t round = request.index / kSubpixels;
    const SampleRandom random(request.pixel_x, request.pixel_y, round, request.seed);
    return kOrders[below(random.u32(1), 6)][request.index % kSubpixels];
  }

  // As the filter is linear, the frames go through it together: each pixel's subpixels with three times the share of
  // its samples that they had. A sample that is not valid counts as those that are.
  static std::vector<std::array<double, 3>> filtered(const SubpixelSums& sums, const RowFilter<double>& filter,
                                                     int height) {
    const int width = filter.width_px();
    std::vector<std::array<double, 3>> colour(static_cast<size_t>(width) * static_cast<size_t>(height));
    parallel_for(height, [&](int64_t y64) {
      const int y = static_cast<int>(y64);
      RowFilter<double>::Workspace workspace(filter);
      std::vector<double> wide;
      const auto means = sums.means(y);
      wide.reserve(static_cast<size_t>(width) * kSubpixels * 3);
      for (int x = 0; x < width; ++x) {
        double asked = 0;
        for (int s = 0; s < kSubpixels; ++s) asked += sums.asked(x, y, s);
        for (int s = 0; s < kSubpixels; ++s) {
          const double weight = asked > 0 ? kSubpixels * sums.asked(x, y, s) / asked : 1;
          for (const double light : means[static_cast<size_t>(x * kSubpixels + s)]) wide.push_back(weight * light);
        }
      }
      filter.apply(wide.data(), colour[static_cast<size_t>(y) * static_cast<size_t>(width)].data(), workspace);
    });
    return colour;
  }

  uint32_t frames_;
  Mode mode_;
};

}  // namespace

const StrategyEntry& random_subpixel_strategy() {
  static const StrategyEntry entry = strategy_entry<RandomSubpixel>(kInfo);
  return entry;
}

}  // namespace triad
