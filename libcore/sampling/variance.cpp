// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/passes.hpp>
#include <triad/sampling/point_strategy.hpp>

namespace triad {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDarkest = 1e-4;  // added to a power of a pixel's light, as Cycles does
constexpr size_t kFewest = 16;     // pixels that a thread takes at once

const StrategyInfo kInfo{
    "variance",
    "scrambled Sobol points, more of them where a pixel's halves differ",
    "The points of sobol-owen: least in each pixel, then batch more (0: as many again) wherever the pixel or one of "
    "its eight neighbours is unsure, up to spp. A pixel is unsure unless |I - A| / (1e-4 + I^power) is below the "
    "threshold, with I its mean and A the mean of half of its samples, summed over red, green and blue. A power of "
    ".5 is what Cycles does, and about what eyes see; 0 asks for the same error in dark and in light, and so for the "
    "least rmse. For edges and shadows in quiet surroundings. A pixel none of whose samples can be used stops at "
    "least. What all the first samples miss stays missed, and as a pixel that has met "
    "something bright goes on while one that has not stops, means err on the dark side by a little: more of it for a "
    "larger threshold and a smaller least.",
    {{"threshold", "difference at which a pixel goes on; 0: spp everywhere", 0, kInfinity, .01, true},
     {"least", "samples in each pixel", 4, 1 << 24, 16},
     {"batch", "samples added to a pixel at once; 0 doubles them", 0, 1 << 24, 4},
     {"spp", "most samples in a pixel", 4, 1 << 24, 256},
     {"power", "of the light that differences are measured by", 0, 1, .5, true}}};

// Which pixels go on, and how far each has come.
class Unsure {
 public:
  Unsure(const Passes& passes, int tile_px, uint32_t taken, uint32_t most, double threshold, double power)
      : film_(passes.film()),
        tile_px_(tile_px),
        most_(most),
        threshold_(threshold),
        power_(power),
        taken_(film_.pixels(), taken),
        marked_(film_.pixels(), 1) {
    list();
  }

  const std::vector<size_t>& pixels() const { return pixels_; }
  uint32_t& taken(size_t pixel) { return taken_[pixel]; }
  double remaining() const {
    double sum = 0;
    for (const size_t p : pixels_) sum += most_ - taken_[p];
    return sum;
  }

  // To be called after each pass. Pixels that are not in the list are as they were, and need no second look.
  void update() {
    std::vector<uint8_t> unsure(pixels_.size());
    constexpr size_t kBlock = 1024;
    parallel_for(static_cast<int64_t>((pixels_.size() + kBlock - 1) / kBlock), [&](int64_t block) {
      const size_t first = static_cast<size_t>(block) * kBlock;
      for (size_t i = first; i < std::min(first + kBlock, pixels_.size()); ++i)
        unsure[i] = taken_[pixels_[i]] < most_ && !(difference(pixels_[i]) < threshold_);
    });
    for (size_t i = 0; i < pixels_.size(); ++i)
      if (unsure[i]) mark_around(pixels_[i]);
    list();
  }

 private:
  // Dammertz, Hanika, Keller, Lensch: A hierarchical automatic stopping condition for Monte Carlo global illumination
  // (WSCG 2010), section 2.1, as Cycles has it. Infinite until both halves have samples, but nothing where none can
  // be used: more of them would be lost, too.
  double difference(size_t pixel) const {
    if (film_.has_nothing(pixel)) return -1;
    const uint32_t half = film_.half_count(pixel);
    if (half == 0 || half == film_.count(pixel)) return kInfinity;
    const std::array<double, 3> all = film_.mean(pixel), part = film_.half_mean(pixel);
    double apart = 0, light = 0;
    for (int c = 0; c < 3; ++c) {
      apart += std::abs(all[c] - part[c]);
      light += all[c];
    }
    return apart / (kDarkest + std::pow(std::max(0., light), power_));
  }

  void mark_around(size_t pixel) {
    const auto width = static_cast<size_t>(film_.width()), height = static_cast<size_t>(film_.height());
    const size_t x = pixel % width, y = pixel / width;
    for (size_t v = y - (y > 0); v <= std::min(y + 1, height - 1); ++v)
      for (size_t u = x - (x > 0); u <= std::min(x + 1, width - 1); ++u) marked_[v * width + u] = 1;
  }

  // The marked pixels that may go on, tile by tile so that neighbours are asked for together; takes the marks away.
  void list() {
    pixels_.clear();
    const int width = film_.width(), height = film_.height();
    for (int64_t y0 = 0; y0 < height; y0 += tile_px_)
      for (int64_t x0 = 0; x0 < width; x0 += tile_px_)
        for (int64_t y = y0; y < std::min<int64_t>(y0 + tile_px_, height); ++y)
          for (int64_t x = x0; x < std::min<int64_t>(x0 + tile_px_, width); ++x) {
            const size_t p = film_.pixel(static_cast<int>(x), static_cast<int>(y));
            if (marked_[p] && taken_[p] < most_) pixels_.push_back(p);
            marked_[p] = 0;
          }
  }

  const Film& film_;
  const int tile_px_;
  const uint32_t most_;
  const double threshold_, power_;
  std::vector<uint32_t> taken_;  // samples asked for, those that were dropped included
  std::vector<uint8_t> marked_;
  std::vector<size_t> pixels_;
};

class Variance final : public PointStrategy {
 public:
  explicit Variance(const StrategyValues& values)
      : PointStrategy(kInfo, values),
        threshold_(values.at("threshold")),
        least_(static_cast<uint32_t>(values.at("least"))),
        batch_(static_cast<uint32_t>(values.at("batch"))),
        spp_(static_cast<uint32_t>(values.at("spp"))),
        power_(values.at("power")) {}
  bool estimates_error() const override { return true; }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    RenderOptions with_halves = options;
    with_halves.planes.error = true;
    // The footprint of a pixel that goes all the way: one that sees too fine a texture then is unsure.
    Passes passes(*this, source, with_halves, 1 / std::sqrt(static_cast<float>(spp_)), points());
    // With many small passes, an error that nobody waits for would cost as much as they do.
    const bool estimate = options.until_rmse > 0;
    if (passes.run_all(0, 1, estimate) && passes.run_all(1, least_, estimate))
      go_on(passes, std::max(1, options.tile_px), estimate);
    return passes.finish();
  }

 protected:
  uint32_t samples_per_pixel() const override { return spp_; }
  Passes::Points points() const override { return place_sobol_owen; }

 private:
  // A barrier after each pass, so that who goes on depends on no order.
  void go_on(Passes& passes, int tile_px, bool estimate) const {
    const auto width = static_cast<size_t>(passes.film().width());
    Unsure unsure(passes, tile_px, least_, spp_, threshold_, power_);
    const size_t most_at_once = static_cast<size_t>(tile_px) * static_cast<size_t>(tile_px);
    for (;;) {
      unsure.update();
      const std::vector<size_t>& pixels = unsure.pixels();
      if (pixels.empty()) return;
      passes.expect(static_cast<double>(passes.samples()) + unsure.remaining());
      // So that there is work for every thread where few go on.
      const size_t at_once = std::min(most_at_once, std::max(kFewest, pixels.size() / 64));
      const auto fill = [&](int64_t group, Passes::Queue& queue) {
        const size_t first = static_cast<size_t>(group) * at_once;
        for (size_t i = first; i < std::min(first + at_once, pixels.size()); ++i) {
          const size_t p = pixels[i];
          uint32_t& taken = unsure.taken(p);
          const uint32_t past = taken + std::min(spp_ - taken, batch_ > 0 ? batch_ : taken);
          if (!queue.add(static_cast<int>(p % width), static_cast<int>(p / width), taken, past)) return;
          taken = past;
        }
      };
      if (!passes.run(static_cast<int64_t>((pixels.size() + at_once - 1) / at_once), fill, estimate)) return;
    }
  }

  double threshold_;
  uint32_t least_, batch_, spp_;
  double power_;
};

}  // namespace

const StrategyEntry& variance_strategy() {
  static const StrategyEntry entry{
      kInfo, [](const StrategyValues& values, const std::string& option) -> std::unique_ptr<Strategy> {
        if (values.at("least") > values.at("spp"))
          throw_usage(option + ": variance:least=" + strategy_value(kInfo.params[1], values.at("least")) +
                      " is above spp=" + strategy_value(kInfo.params[3], values.at("spp")) +
                      "; give a least of at most spp, or more spp");
        return std::make_unique<Variance>(values);
      }};
  return entry;
}

}  // namespace triad
