// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/random.hpp>
#include <triad/colour/colour.hpp>
#include <triad/display/vision.hpp>
#include <triad/numeric/widest.hpp>
#include <triad/sampling/cell_estimates.hpp>
#include <triad/sampling/pixel_batches.hpp>
#include <triad/sampling/point_strategy.hpp>

namespace triad {
namespace {

enum class Points { kSobol, kJitter, kRandom };
constexpr size_t kMostCells = 64 * 64;  // of a display pixel, as parse_cells() allows
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr uint32_t kMostStrata = 4096;  // along a side of a pixel; finer ones would change no cell by a thousandth

const StrategyInfo kInfo{
    "cells",
    "spp samples in each display pixel, binned into its fine cells",
    "For displays whose subpixels are driven one by one: render with --cells of the display's layout, and give the "
    "picture to platt or another filter of that display. No more samples than ordinary antialiasing takes: spp in "
    "each pixel of the display, whatever the number of its cells. A cell is the mean of the samples that fall into "
    "it. "
    "Points are drawn from boxes of the pixel (one of spp, by the elementary intervals of Sobol points, or n x n for "
    "jitter), and the boxes are laid so that each cell has whole ones, as many as its neighbours or one more: no "
    "cell "
    "is left to chance, and within cells nothing is biased. Cells without a sample, where there are more cells than "
    "boxes or points are random, take the mean of the nearest that have some. With one cell a pixel it is plain "
    "antialiasing.\n"
    "With a threshold, pixels begin with least samples, and double them up to spp while the error that an eye would "
    "see "
    "of their noise, or of a neighbour's, is above it: the difference between the means of two halves of the "
    "samples, in "
    "luminance, red-green and blue-yellow, each by how much of a pixel's noise in it gets through at ppd. .01 is a "
    "hundredth of white. What the first samples miss stays missed.",
    {{"spp", "samples per display pixel; for points=jitter a square number", 1, 1 << 24, 16},
     choice_param("points", "where they lie in a pixel of the display", {"sobol", "jitter", "random"}),
     {"threshold", "error seen of a pixel's noise at which it goes on; 0: spp everywhere", 0, kInfinity, 0, true},
     {"least", "samples in each pixel with a threshold", 2, 1 << 24, 8},
     {"ppd", "pixels of the display in a degree of the view, for the threshold", 1, 10000, 40, true}}};

// Equal boxes of the square that the points are made in, columns by rows.
struct Strata {
  uint32_t columns = 1, rows = 1;
};

Strata strata_for(Points points, uint32_t spp, const Cells& cells) {
  switch (points) {
    case Points::kJitter: {
      const auto n = std::min(kMostStrata, static_cast<uint32_t>(std::lround(std::sqrt(spp))));
      return {n, n};
    }
    case Points::kRandom: return {};
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

// One side of a display pixel: takes the side of the square that the points are made in, cut into strata, to cells.
// Each cell is given as many whole strata as its neighbours, or one more, and so has its samples, however they are
// scrambled; within a cell points keep their density. With fewer strata than cells nothing is moved.
class Side {
 public:
  Side(uint32_t strata, int cells) {
    const auto n = static_cast<uint32_t>(cells);
    if (strata < n) {
      cells_ = {{0, static_cast<double>(n)}};
      return;
    }
    for (uint32_t cell = 0; cell < n; ++cell) {
      const uint32_t first = (cell * strata + n / 2) / n, past = ((cell + 1) * strata + n / 2) / n;
      cells_.push_back({static_cast<double>(first) / strata, static_cast<double>(strata) / (past - first)});
    }
  }

  // From places in [0, 1) to cells from the pixel's edge.
  TRIAD_INLINE_BODY void move(std::span<double> places) const {
    if (cells_.size() == 1 && cells_[0].scale == 1) return;
    constexpr size_t kAtOnce = 64;
    for (size_t begin = 0; begin < places.size(); begin += kAtOnce) {
      const auto some = places.subspan(begin, std::min(kAtOnce, places.size() - begin));
      std::array<double, kAtOnce> cell, start, scale;
      cell.fill(0);
      start.fill(0);
      scale.fill(cells_[0].scale);
      for (size_t c = 1; c < cells_.size(); ++c) {
        const double from = cells_[c].start, by = cells_[c].scale, number = static_cast<double>(c);
        for (size_t i = 0; i < some.size(); ++i) {
          const bool past = some[i] >= from;
          cell[i] = past ? number : cell[i];
          start[i] = past ? from : start[i];
          scale[i] = past ? by : scale[i];
        }
      }
      for (size_t i = 0; i < some.size(); ++i) some[i] = cell[i] + (some[i] - start[i]) * scale[i];
    }
  }

 private:
  struct Cell {
    double start, scale;  // its first place, and cells by which a place moves it
  };
  std::vector<Cell> cells_;
};

// How much an eye sees of errors of pixels that are independent of each other, along a row.
class NoiseSeen {
 public:
  explicit NoiseSeen(double ppd) {
    Observer observer;
    observer.rgb_to_xyz = rec709_to_xyz();
    observer.ppd = ppd;
    to_opponent_ = opponent_matrix(observer);
    // Of white noise, the mean over frequencies below half a cycle a pixel of the squared transfer.
    constexpr int kSteps = 256;
    for (int c = 0; c < kOpponentChannels; ++c)
      for (int i = 0; i < kSteps; ++i) {
        const double transfer = mtf(observer, c, (i + .5) / kSteps * ppd / 2);
        passed_[static_cast<size_t>(c)] += transfer * transfer / kSteps;
      }
  }

  // The root of the energy that is left of an error in red, green and blue; white is 1.
  double operator()(const std::array<double, 3>& rgb) const {
    double energy = 0;
    for (size_t c = 0; c < kOpponentChannels; ++c) {
      const double error =
          to_opponent_[3 * c] * rgb[0] + to_opponent_[3 * c + 1] * rgb[1] + to_opponent_[3 * c + 2] * rgb[2];
      energy += passed_[c] * error * error;
    }
    return std::sqrt(energy);
  }

 private:
  std::array<double, 9> to_opponent_{};
  std::array<double, kOpponentChannels> passed_{};
};

// Samples counted by cell; then, for each, its place where all are ordered by cells.
class ManyCells {
 public:
  explicit ManyCells(size_t cells) : cells_(cells) { std::fill_n(next_.begin(), cells + 1, 0); }
  void add(size_t cell) { ++next_[cell + 1]; }
  void to_places() {
    for (size_t c = 1; c < cells_; ++c) next_[c] += next_[c - 1];
  }
  size_t next(size_t cell) { return next_[cell]++; }

 private:
  size_t cells_;
  std::array<uint32_t, kMostCells + 1> next_;
};
// The same in the four parts of one number, which no sample has to wait for until it is stored.
class FewCells {
 public:
  static constexpr size_t kMost = 4;
  explicit FewCells(size_t) {}
  void add(size_t cell) { next_ += uint64_t{1} << 16 * cell; }
  void to_places() { next_ *= 0x0001000100010000u; }  // each part the sum of those below
  size_t next(size_t cell) {
    const size_t place = next_ >> 16 * cell & 0xffff;
    add(cell);
    return place;
  }

 private:
  uint64_t next_ = 0;
};
static_assert(kMostTogether <= 0xffff);

class CellsStrategy final : public StrategyBase {
 public:
  explicit CellsStrategy(const StrategyValues& values)
      : StrategyBase(kInfo, values),
        spp_(whole("spp")),
        points_(static_cast<Points>(whole("points"))),
        threshold_(value("threshold")),
        least_(whole("least")) {
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
    RenderOptions with_halves = options;
    with_halves.planes.error = options.planes.error || threshold_ > 0;
    SampleTaker taker(*this, source, with_halves);
    const uint64_t samples = most_samples(source.width() / cells.x, source.height() / cells.y);
    taker.expect(static_cast<double>(samples));
    const Strata strata = strata_for(points_, spp_, cells);
    const Side across(strata.columns, cells.x), down(strata.rows, cells.y);
    PixelWork work{source.width() / cells.x, source.height() / cells.y,
                   std::sqrt(static_cast<float>(cells.x * cells.y) / static_cast<float>(spp_))};
    const int32_t last_x = source.width() - 1, last_y = source.height() - 1;
    const auto into_cells = [last_x, last_y](std::span<SampleRequest> requests) {
      for (SampleRequest& request : requests) {
        request.pixel_x = std::min(static_cast<int32_t>(request.x), last_x);
        request.pixel_y = std::min(static_cast<int32_t>(request.y), last_y);
      }
    };
    work.take = [&](const PixelBatch& batch) {
      place(batch, across, down, cells);
      return taker.add_renamed(batch.spare, batch.samples, into_cells);
    };
    const auto go_on = [&](PassRecord& pass) {
      if (options.until_rmse <= 0) return true;
      pass.rmse = estimated_rmse(taker.film(), cells);
      taker.result().reached = pass.rmse <= options.until_rmse;
      return !taker.result().reached;
    };
    if (threshold_ > 0) {
      take_where_seen(taker, work, cells, go_on);
    } else {
      take_in_passes(taker, work, spp_, 1, go_on);
    }
    PassRecord& last = taker.result().passes.back();
    if (taker.film().planes().error && !taker.stopped()) last.rmse = estimated_rmse(taker.film(), cells);
    const bool all_have_samples = taker.samples() == samples && taker.result().dropped == 0 &&
                                  strata.columns >= static_cast<uint32_t>(cells.x) &&
                                  strata.rows >= static_cast<uint32_t>(cells.y);
    if (!all_have_samples) taker.result().colour = filled_means(taker.film(), cells);
    return taker.finish();
  }

 private:
  // A barrier after each pass, so that who goes on depends on no order.
  void take_where_seen(SampleTaker& taker, PixelWork& work, const Cells& cells,
                       const std::function<bool(PassRecord&)>& go_on) const {
    const NoiseSeen seen(value("ppd"));
    const auto width = static_cast<size_t>(work.width), height = static_cast<size_t>(work.height);
    std::vector<size_t> pixels;  // that go on, in tiles; all have as many samples
    for (uint32_t first = 0, past = least_; first < spp_; first = past, past = std::min(spp_, 2 * past)) {
      work.only = first > 0 ? &pixels : nullptr;
      const bool whole = take_pixels(taker, work, first, past);
      PassRecord& pass = taker.end_pass();
      if (!whole || !go_on(pass)) return;
      if (first == 0) pixels = pixels_in_tiles(taker, work);
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

  // The points of the strategy of that name in a display pixel, in [0, 1).
  void points(std::span<const SampleRequest> requests, std::span<double> x, std::span<double> y) const {
    if (points_ == Points::kSobol) {
      sobol_owen_places(requests, x, y);
      return;
    }
    for (size_t i = 0; i < requests.size(); ++i) {
      const SampleRequest& request = requests[i];
      const SampleRandom random(request.pixel_x, request.pixel_y, request.index, request.seed);
      x[i] = random.u32(0) * 0x1p-32;
      y[i] = random.u32(1) * 0x1p-32;
      if (points_ == Points::kJitter) {
        const auto box = static_cast<uint32_t>(request.index * stride_ % spp_);
        x[i] = (x[i] + box % side_) / side_;
        y[i] = (y[i] + box / side_) / side_;
      }
    }
  }

  // Puts the requests into `spare`, with their places on the film, each pixel's by cells: what a cell's samples have
  // in common the source and the film need to find but once. Their random numbers stay those of the display pixel.
  void place(const PixelBatch& batch, const Side& across, const Side& down, const Cells& cells) const {
    std::array<double, kMostTogether> x, y;
    const size_t n = batch.requests.size();
    points(batch.requests, x, y);
    run_widest([&]() TRIAD_INLINE_BODY {
      across.move(std::span(x).first(n));
      down.move(std::span(y).first(n));
    });
    if (static_cast<size_t>(cells.x * cells.y) <= FewCells::kMost) {
      order<FewCells>(batch, x, y, cells);
    } else {
      order<ManyCells>(batch, x, y, cells);
    }
  }

  template <class Counts>
  static void order(const PixelBatch& batch, std::span<const double> x, std::span<const double> y,
                    const Cells& cells) {
    std::array<uint16_t, kMostTogether> cell;
    for (size_t first = 0; first < batch.requests.size(); first += batch.per_pixel) {
      const size_t past = first + batch.per_pixel;
      Counts counts(static_cast<size_t>(cells.x * cells.y));
      for (size_t i = first; i < past; ++i) {
        cell[i] = static_cast<uint16_t>(static_cast<int>(y[i]) * cells.x + static_cast<int>(x[i]));
        counts.add(cell[i]);
      }
      counts.to_places();
      for (size_t i = first; i < past; ++i) {
        SampleRequest& request = batch.spare[first + counts.next(cell[i])] = batch.requests[i];
        request.x = static_cast<double>(request.pixel_x) * cells.x + x[i];
        request.y = static_cast<double>(request.pixel_y) * cells.y + y[i];
      }
    }
  }

  uint32_t spp_;
  Points points_;
  double threshold_;
  uint32_t least_;
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
        if (values.at("threshold") > 0 && values.at("least") > spp)
          throw_usage(option + ": cells:least=" + strategy_value(kInfo.params[3], values.at("least")) +
                      " is above spp=" + strategy_value(kInfo.params[0], spp) +
                      "; give a least of at most spp, or more spp");
        return std::make_unique<CellsStrategy>(values);
      }};
  return entry;
}

}  // namespace triad
