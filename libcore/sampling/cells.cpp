// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/random.hpp>
#include <triad/sampling/cell_shares.hpp>
#include <triad/sampling/pixel_batches.hpp>
#include <triad/sampling/point_strategy.hpp>

namespace triad {
namespace {

enum class Points { kSobol, kJitter, kRandom };
constexpr uint32_t kMostStrata = 4096;  // along a side of a pixel; finer ones would change no cell by a thousandth

const StrategyInfo kInfo{
    "cells",
    "spp samples in each display pixel, binned into its fine cells",
    "For displays whose subpixels are driven one by one: render with --cells of the display's layout, and give the "
    "picture to platt or another filter of that display. No more samples than ordinary antialiasing takes: spp in "
    "each pixel of the display, whatever the number of its cells. Each sample stands for the box of the pixel that "
    "it "
    "was drawn from (one of spp, by the elementary intervals of Sobol points, or one of n x n for jitter), and is "
    "shared by the cells that the box covers: a pixel's cells together have exactly the mean that the plain "
    "strategy would have given it, constant pictures stay constant, and places of light are kept to within a box. "
    "random points stand for the cell that they fall into. Cells without a sample take the mean of the nearest that "
    "have some. With one cell a pixel it is plain antialiasing.",
    {{"spp", "samples per display pixel; for points=jitter a square number", 1, 1 << 24, 16},
     choice_param("points", "where they lie in a pixel of the display", {"sobol", "jitter", "random"})}};

// Samples of equal boxes of a pixel, columns by rows.
struct Strata {
  uint32_t columns = 1, rows = 1;
};

Strata strata_for(Points points, uint32_t spp, const Cells& cells) {
  switch (points) {
    case Points::kJitter: {
      const auto n = std::min(kMostStrata, static_cast<uint32_t>(std::lround(std::sqrt(spp))));
      return {n, n};
    }
    case Points::kRandom: return {static_cast<uint32_t>(cells.x), static_cast<uint32_t>(cells.y)};
    case Points::kSobol: break;
  }
  // Any 2^a x 2^b boxes with a + b = log2 spp hold one point each. Where a side has one cell, boxes need not be
  // told apart along it; else they are to be of the cells' shape.
  const int bits = std::bit_width(spp) - 1;
  int across = cells.y == 1 ? bits : 0;
  if (cells.x > 1 && cells.y > 1)
    across = static_cast<int>(std::lround((bits + std::log2(static_cast<double>(cells.x) / cells.y)) / 2));
  across = std::clamp(across, 0, bits);
  return {std::min(kMostStrata, 1u << across), std::min(kMostStrata, 1u << (bits - across))};
}

// What the samples say of each cell of the film.
class Bins {
 public:
  Bins(const Film& film, const Cells& cells, const Strata& strata)
      : cells_(cells),
        width_(static_cast<size_t>(film.width())),
        across_(strata.columns, static_cast<uint32_t>(cells.x)),
        down_(strata.rows, static_cast<uint32_t>(cells.y)),
        sums_(film.pixels()) {}

  // A display pixel's samples, whose requests are given the cell of the film that each lies in.
  void add(int x, int y, std::span<SampleRequest> requests, std::span<const Sample> samples) {
    const int64_t left = int64_t{x} * cells_.x, top = int64_t{y} * cells_.y;
    const size_t corner = static_cast<size_t>(top) * width_ + static_cast<size_t>(left);
    for (size_t i = 0; i < requests.size(); ++i) {
      SampleRequest& request = requests[i];
      const double u = (request.x - static_cast<double>(left)) / cells_.x;
      const double v = (request.y - static_cast<double>(top)) / cells_.y;
      request.pixel_x = static_cast<int32_t>(left) + cell_of(u, cells_.x);
      request.pixel_y = static_cast<int32_t>(top) + cell_of(v, cells_.y);
      if (!samples[i].valid) continue;
      const auto& rgb = samples[i].rgb;
      for (const CellShares::Share& row : down_.of(v))
        for (const CellShares::Share& column : across_.of(u)) {
          Sum& sum = sums_[corner + row.cell * width_ + column.cell];
          const double weight = row.part * column.part;
          for (size_t c = 0; c < 3; ++c) sum.rgb[c] += weight * rgb[c];
          sum.weight += weight;
        }
    }
  }

  // The cells' means. Where nothing fell, the mean of the nearest that have something, in squares of display pixels
  // of two to either side at most; 0 if there is none.
  std::vector<std::array<double, 3>> means() const {
    std::vector<std::array<double, 3>> all(sums_.size());
    const auto height = static_cast<int64_t>(sums_.size() / width_);
    parallel_for(height, [&](int64_t y) {
      for (int64_t x = 0; x < static_cast<int64_t>(width_); ++x) {
        Sum sum = at(x, y);
        const int side = std::max(cells_.x, cells_.y);
        for (int reach = 1; sum.weight <= 0 && reach <= 2 * side; ++reach)
          sum = around(x, y, int64_t{reach} * cells_.x / side, int64_t{reach} * cells_.y / side);
        if (sum.weight > 0)
          for (size_t c = 0; c < 3; ++c) all[index(x, y)][c] = sum.rgb[c] / sum.weight;
      }
    });
    return all;
  }

 private:
  struct Sum {
    std::array<double, 3> rgb{};
    double weight = 0;
  };
  static int32_t cell_of(double place, int cells) { return std::min(static_cast<int32_t>(place * cells), cells - 1); }
  size_t index(int64_t x, int64_t y) const { return static_cast<size_t>(y) * width_ + static_cast<size_t>(x); }
  const Sum& at(int64_t x, int64_t y) const { return sums_[index(x, y)]; }
  Sum around(int64_t x, int64_t y, int64_t reach_x, int64_t reach_y) const {
    const auto width = static_cast<int64_t>(width_), height = static_cast<int64_t>(sums_.size() / width_);
    Sum sum;
    for (int64_t v = std::max<int64_t>(0, y - reach_y); v <= std::min(height - 1, y + reach_y); ++v)
      for (int64_t u = std::max<int64_t>(0, x - reach_x); u <= std::min(width - 1, x + reach_x); ++u) {
        for (size_t c = 0; c < 3; ++c) sum.rgb[c] += at(u, v).rgb[c];
        sum.weight += at(u, v).weight;
      }
    return sum;
  }

  const Cells cells_;
  const size_t width_;
  const CellShares across_, down_;
  std::vector<Sum> sums_;
};

// As Film::estimated_rmse(), of the means of whole display pixels: single cells have too few samples for halves.
double estimated_rmse(const Film& film, const Cells& cells) {
  const int width = film.width() / cells.x, height = film.height() / cells.y;
  std::vector<NeumaierSum> rows(static_cast<size_t>(height));
  parallel_for(height, [&](int64_t y) {
    for (int x = 0; x < width; ++x) {
      double all = 0, half = 0;
      std::array<double, 3> light{}, half_light{};
      for (int v = 0; v < cells.y; ++v)
        for (int u = 0; u < cells.x; ++u) {
          const size_t p = film.pixel(x * cells.x + u, static_cast<int>(y) * cells.y + v);
          const double n = film.count(p), in_half = film.half_count(p);
          all += n;
          half += in_half;
          for (size_t c = 0; c < 3; ++c) {
            light[c] += n * film.mean(p)[c];
            half_light[c] += in_half * film.half_mean(p)[c];
          }
        }
      const double rest = all - half;
      for (size_t c = 0; c < 3; ++c) {
        const double apart = half_light[c] / half - (light[c] - half_light[c]) / rest;
        rows[static_cast<size_t>(y)].add(half > 0 && rest > 0 ? apart * apart * (half / all) * (rest / all)
                                                              : std::numeric_limits<double>::infinity());
      }
    }
  });
  NeumaierSum total;
  for (const NeumaierSum& row : rows) total.merge(row);
  return std::sqrt(total.value() / (3. * width * height));
}

class CellsStrategy final : public StrategyBase {
 public:
  explicit CellsStrategy(const StrategyValues& values)
      : StrategyBase(kInfo, values), spp_(whole("spp")), points_(static_cast<Points>(whole("points"))) {
    if (points_ == Points::kJitter) {
      side_ = static_cast<uint32_t>(std::lround(std::sqrt(spp_)));
      stride_ = spread_stride(spp_);
    }
  }
  bool estimates_error() const override { return true; }
  uint64_t most_samples(int width, int height) const override {
    return uint64_t{spp_} * static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    const Cells cells = options.cells;
    if (source.width() % cells.x != 0 || source.height() % cells.y != 0)
      throw_usage("the strategy 'cells' needs whole display pixels: a film of " + std::to_string(source.width()) +
                  "x" + std::to_string(source.height()) + " has none of " + std::to_string(cells.x) + "x" +
                  std::to_string(cells.y) + " cells");
    SampleTaker taker(*this, source, options);
    taker.expect(static_cast<double>(most_samples(source.width() / cells.x, source.height() / cells.y)));
    Bins bins(taker.film(), cells, strata_for(points_, spp_, cells));
    PixelBatches batches;
    batches.width = source.width() / cells.x;
    batches.height = source.height() / cells.y;
    batches.footprint_px = std::sqrt(static_cast<float>(cells.x * cells.y) / static_cast<float>(spp_));
    batches.place = [&](std::span<SampleRequest> requests) { place(requests, cells); };
    batches.use = [&](int x, int y, std::span<SampleRequest> requests, std::span<Sample> samples) {
      bins.add(x, y, requests, samples);
      taker.film().add(requests, samples);
    };
    batches.keep = false;
    take_in_passes(taker, batches, spp_, 1, [&](PassRecord& pass) {
      if (!taker.film().planes().error) return true;
      pass.rmse = estimated_rmse(taker.film(), cells);
      taker.result().reached = options.until_rmse > 0 && pass.rmse <= options.until_rmse;
      return !taker.result().reached;
    });
    taker.result().colour = bins.means();
    RenderResult result = taker.finish();
    // Requests name display pixels, whose samples have their random numbers in common.
    result.dropped_x *= result.dropped > 0 ? cells.x : 1;
    result.dropped_y *= result.dropped > 0 ? cells.y : 1;
    return result;
  }

 private:
  // As the strategy of that name would place them in the display pixel, in the film's pixels.
  void place(std::span<SampleRequest> requests, const Cells& cells) const {
    if (points_ == Points::kSobol) {
      place_sobol_owen(requests);
    } else {
      for (SampleRequest& request : requests) {
        const SampleRandom random(request.pixel_x, request.pixel_y, request.index, request.seed);
        double x = random.u32(0) * 0x1p-32, y = random.u32(1) * 0x1p-32;
        if (points_ == Points::kJitter) {
          const auto box = static_cast<uint32_t>(request.index * stride_ % spp_);
          x = (x + box % side_) / side_;
          y = (y + box / side_) / side_;
        }
        request.x = request.pixel_x + x;
        request.y = request.pixel_y + y;
      }
    }
    for (SampleRequest& request : requests) {
      request.x *= cells.x;
      request.y *= cells.y;
    }
  }

  uint32_t spp_;
  Points points_;
  uint32_t side_ = 1;
  uint64_t stride_ = 1;
};

}  // namespace

const StrategyEntry& cells_strategy() {
  static const StrategyEntry entry{
      kInfo, [](const StrategyValues& values, const std::string& option) -> std::unique_ptr<Strategy> {
        const double spp = values.at("spp"), side = std::round(std::sqrt(spp));
        if (static_cast<Points>(values.at("points")) == Points::kJitter && side * side != spp)
          throw_usage(option + ": cells:points=jitter puts n x n samples into a pixel, and spp=" +
                      strategy_value(kInfo.params[0], spp) + " is no square number; " +
                      strategy_value(kInfo.params[0], side * side) + " would do");
        return std::make_unique<CellsStrategy>(values);
      }};
  return entry;
}

}  // namespace triad
