// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/cell_estimates.hpp>
#include <triad/sampling/cell_passes.hpp>
#include <triad/sampling/cell_sums.hpp>
#include <triad/sampling/strategy_base.hpp>

namespace triad {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const StrategyInfo kInfo{
    "cells",
    "spp samples in each display pixel, binned into its fine cells",
    "For displays whose subpixels are driven one by one: render with --cells of the display's layout, and give the "
    "picture to platt or another filter of that display. No more samples than ordinary antialiasing takes: spp in "
    "each pixel of the display, whatever the number of its cells. A cell is the mean of the samples that fall into "
    "it. "
    "Points are drawn from boxes of the pixel (one of spp, by the elementary intervals of Sobol points, or the cells "
    "of "
    "jitter's grid), and the boxes are laid so that each cell has whole ones, as many as its neighbours or one more: "
    "no cell is left to chance, and within cells nothing is biased. Cells without a sample, where there are more "
    "cells than "
    "boxes or points are random, take the mean of the nearest that have some. With one cell a pixel it is plain "
    "antialiasing. An estimated error is that of the cells, and unknown until each has samples in both halves.\n"
    "With a threshold, pixels begin with least samples, and double them up to spp while the error that an eye would "
    "see "
    "of their noise, or of a neighbour's, is above it: the difference between the means of two halves of the "
    "samples, in "
    "luminance, red-green and blue-yellow, each by how much of a pixel's noise in it gets through at ppd. .01 is a "
    "hundredth of white. What the first samples miss stays missed.",
    {{"spp", "samples per display pixel", 1, 1 << 24, 16},
     PixelPoints::param(),
     {"threshold", "error seen of a pixel's noise at which it goes on; 0: spp everywhere", 0, kInfinity, 0, true},
     {"least", "samples in each pixel with a threshold", 2, 1 << 24, 8},
     {"ppd", "pixels of the display in a degree of the view, for the threshold", 1, 10000, 40, true}}};

class CellsStrategy final : public StrategyBase {
 public:
  explicit CellsStrategy(const StrategyValues& values)
      : StrategyBase(kInfo, values),
        spp_(whole("spp")),
        points_(static_cast<PixelPoints::Kind>(whole("points")), spp_),
        threshold_(value("threshold")),
        least_(whole("least")) {}
  bool estimates_error() const override { return points_.halves_are_alike(); }
  uint64_t most_samples(int width, int height) const override {
    return uint64_t{spp_} * static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    const Cells cells = options.cells;
    if (source.width() % cells.x != 0 || source.height() % cells.y != 0)
      throw_usage("the strategy 'cells' needs whole display pixels: a film of " + std::to_string(source.width()) +
                  "x" + std::to_string(source.height()) + " has none of " + std::to_string(cells.x) + "x" +
                  std::to_string(cells.y) + " cells");
    RenderOptions with_halves = options;
    with_halves.planes.error = options.planes.error || threshold_ > 0;
    SampleTaker taker(*this, source, with_halves, film_for_cells(cells, spp_));
    const int width = source.width() / cells.x, height = source.height() / cells.y;
    const uint64_t samples = most_samples(width, height);
    taker.expect(static_cast<double>(samples));
    const CellPoints points(points_, cells);
    CellPasses passes(taker, points, width, height,
                      std::sqrt(static_cast<float>(cells.x * cells.y) / static_cast<float>(spp_)));
    const auto go_on = [&](PassRecord& pass) {
      if (options.until_rmse <= 0) return true;
      pass.rmse = taker.film().estimated_rmse();
      taker.result().reached = pass.rmse <= options.until_rmse;
      return !taker.result().reached;
    };
    if (threshold_ > 0) {
      take_where_seen(taker, passes, cells, go_on);
    } else {
      passes.take_in_turn(spp_, go_on);
    }
    const bool all_have_samples = taker.samples() == samples && taker.result().dropped == 0 && points.fill_all();
    if (!all_have_samples) taker.result().colour = filled_means(taker.film(), cells);
    return taker.finish();
  }

 private:
  // A barrier after each pass, so that who goes on depends on no order.
  void take_where_seen(SampleTaker& taker, CellPasses& passes, const Cells& cells,
                       const std::function<bool(PassRecord&)>& go_on) const {
    const NoiseSeen seen(value("ppd"));
    const auto width = static_cast<size_t>(taker.film().width() / cells.x),
               height = static_cast<size_t>(taker.film().height() / cells.y);
    std::vector<size_t> pixels;  // that go on, in tiles; all have as many samples
    for (uint32_t first = 0, past = least_; first < spp_; first = past, past = std::min(spp_, 2 * past)) {
      const bool whole = first == 0 ? passes.take(first, past) : passes.take(first, past, pixels);
      PassRecord& pass = taker.end_pass();
      if (!whole || !go_on(pass)) return;
      if (first == 0) pixels = passes.pixels_in_tiles();
      std::vector<uint8_t> unsure(width * height);
      parallel_for(static_cast<int64_t>(pixels.size()), [&](int64_t i) {
        const size_t p = pixels[static_cast<size_t>(i)];
        unsure[p] = !(seen(estimated_error(taker.film(), cells, static_cast<int>(p % width),
                                           static_cast<int>(p / width))) <= threshold_);
      });
      std::erase_if(pixels, [&](size_t p) {
        const size_t x = p % width, y = p / width;
        for (size_t v = y - (y > 0); v <= std::min(y + 1, height - 1); ++v)
          for (size_t u = x - (x > 0); u <= std::min(x + 1, width - 1); ++u)
            if (unsure[v * width + u]) return false;
        return true;
      });
      if (pixels.empty()) return;
      taker.expect(static_cast<double>(taker.samples() + pixels.size() * (spp_ - past)));
    }
  }

  uint32_t spp_;
  PixelPoints points_;
  double threshold_;
  uint32_t least_;
};

}  // namespace

const StrategyEntry& cells_strategy() {
  static const StrategyEntry entry{
      kInfo, [](const StrategyValues& values, const std::string& option) -> std::unique_ptr<Strategy> {
        const double spp = values.at("spp");
        if (values.at("threshold") > 0 &&
            !PixelPoints(static_cast<PixelPoints::Kind>(values.at("points")), 1).halves_are_alike())
          throw_usage(option +
                      ": cells:threshold compares two halves of the points, of which jitter has none that are "
                      "spread alike; take points=sobol or random");
        if (values.at("threshold") > 0 && values.at("least") > spp)
          throw_usage(option + ": cells:least=" + strategy_value(kInfo.params[3], values.at("least")) +
                      " is above spp=" + strategy_value(kInfo.params[0], spp) +
                      "; give a least of at most spp, or more spp");
        return std::make_unique<CellsStrategy>(values);
      }};
  return entry;
}

}  // namespace triad
