// SPDX-License-Identifier: Apache-2.0
#include <triad/base/parallel.hpp>
#include <triad/sampling/lattice_strategy.hpp>

namespace triad {
namespace {

constexpr size_t kBlock = 512;  // pixels that a thread looks at at once
constexpr int kBand = 16;       // rows of pixels: enough for all threads, and little memory

CellRules with_values(CellRules rules, const StrategyValues& values) {
  rules.depth = static_cast<int>(values.at("depth"));
  rules.threshold = values.at("threshold");
  return rules;
}

}  // namespace

std::vector<StrategyParam> lattice_params() {
  return {{"depth", "how often a pixel may be divided: at most (2^depth + 1)^2 samples in it", 0, 8, 3},
          pov_threshold_param(),
          pov_gamma_param()};
}

std::vector<StrategyParam> lattice_line_params() {
  std::vector<StrategyParam> params = lattice_params();
  params.push_back(
      choice_param("order",
                   "fixpoint: all pixels look at all samples found so far until none is added; scanline: "
                   "each looks once, in reading order, at those of the pixels before it",
                   {"fixpoint", "scanline"}));
  return params;
}

LatticeStrategy::LatticeStrategy(const StrategyInfo& info, const StrategyValues& values, CellRules rules, Order order)
    : StrategyBase(info, values), rules_(with_values(rules, values)), order_(order) {}

uint64_t LatticeStrategy::most_samples(int width, int height) const {
  const auto w = static_cast<uint64_t>(width), h = static_cast<uint64_t>(height);
  const uint64_t side = uint64_t{1} << rules_.depth;
  const uint64_t centres = rules_.with_centre && rules_.depth == 0 ? w * h : 0;
  return (w * side + 1) * (h * side + 1) + centres;
}

class LatticeStrategy::Render {
 public:
  Render(const LatticeStrategy& strategy, const Source& source, const RenderOptions& options)
      : rules_(strategy.rules_),
        taker_(strategy, source, options),
        lattice_(taker_, std::max(1, rules_.depth), rules_.with_centre, strategy.value("gamma")),
        width_(static_cast<size_t>(lattice_.width())),
        colours_(taker_.film().pixels()) {
    if (options.planes.reasons) taker_.result().reasons.assign(2, std::vector<float>(colours_.size()));
  }

  RenderResult run(Order order) {
    const bool all = lattice_.ask_corners();
    taker_.end_pass();
    // Ended here, the film's means are the picture.
    if (!all) return taker_.finish();
    list_divided();
    if (order == Order::kReading)
      in_reading_order();
    else if (rules_.along_lines)
      until_none_is_added(std::move(divided_));
    else
      in_bands();
    taker_.end_pass();
    taker_.result().colour = std::move(colours_);
    return taker_.finish();
  }

 private:
  int x_of(size_t pixel) const { return static_cast<int>(pixel % width_); }
  int y_of(size_t pixel) const { return static_cast<int>(pixel / width_); }

  void put(size_t pixel, PixelCells& cells) {
    colours_[pixel] = cells.colour();
    std::vector<std::vector<float>>& reasons = taker_.result().reasons;
    if (reasons.empty()) return;
    reasons[0][pixel] = static_cast<float>(cells.depth());
    reasons[1][pixel] = static_cast<float>(cells.points());
  }

  // body(cells, first, past) over [0, count).
  template <class Body>
  void in_blocks(size_t count, const Body& body) const {
    parallel_for(static_cast<int64_t>((count + kBlock - 1) / kBlock), [&](int64_t block) {
      PixelCells cells(lattice_, rules_);
      const size_t first = static_cast<size_t>(block) * kBlock;
      body(cells, first, std::min(count, first + kBlock));
    });
  }

  // The picture as it is without division, and those pixels that are to be divided.
  void list_divided() {
    std::vector<uint8_t> divides(colours_.size());
    in_blocks(colours_.size(), [&](PixelCells& cells, size_t first, size_t past) {
      for (size_t p = first; p < past; ++p) {
        divides[p] = cells.divides(x_of(p), y_of(p));
        put(p, cells);
      }
    });
    for (size_t p = 0; p < divides.size(); ++p)
      if (divides[p]) divided_.push_back(p);
    expect(divided_.size());
  }

  // Lines that are followed into other pixels may take more.
  void expect(size_t pixels) {
    const double side = lattice_.side() + 1;
    taker_.expect(static_cast<double>(taker_.samples()) + static_cast<double>(pixels) * side * side);
  }

  // What lies within pixels and between them is no concern of any others.
  void in_bands() {
    auto first = divided_.begin();
    for (int y = 0; y < lattice_.height(); y += kBand) {
      const int past_y = y + std::min(kBand, lattice_.height() - y);
      const auto past = std::lower_bound(first, divided_.end(), static_cast<size_t>(past_y) * width_);
      expect(static_cast<size_t>(divided_.end() - first));
      if (!until_none_is_added({first, past})) return;
      lattice_.forget_above(past_y);
      first = past;
    }
  }

  // Every pixel that may have changed is divided anew, on what samples there are: who is first makes no difference.
  // False: the render was stopped.
  bool until_none_is_added(std::vector<size_t> pixels) {
    std::vector<LatticePoint> points;
    while (!pixels.empty()) {
      std::vector<std::vector<LatticePoint>> wanted((pixels.size() + kBlock - 1) / kBlock);
      std::vector<uint8_t> waits(pixels.size());
      in_blocks(pixels.size(), [&](PixelCells& cells, size_t first, size_t past) {
        for (size_t i = first; i < past; ++i) {
          const size_t p = pixels[i];
          waits[i] = !cells.divide(x_of(p), y_of(p), wanted[first / kBlock]);
          put(p, cells);
        }
      });
      points.clear();
      for (const auto& part : wanted) points.insert(points.end(), part.begin(), part.end());
      size_t still = 0;
      for (size_t i = 0; i < pixels.size(); ++i)
        if (waits[i]) pixels[still++] = pixels[i];
      pixels.resize(still);
      if (pixels.empty()) break;
      if (!lattice_.ask(points)) return false;
      if (!rules_.along_lines) continue;
      add_touched(points, pixels);
      expect(pixels.size());
    }
    return true;
  }

  // The pixels on whose border these points are, to those that are divided anyway; by ascending number.
  void add_touched(const std::vector<LatticePoint>& points, std::vector<size_t>& pixels) const {
    const int bits = lattice_.bits(), mask = lattice_.side() - 1;
    for (const LatticePoint point : points) {
      const int x = point.x >> bits, y = point.y >> bits;
      const bool upper = (point.y & mask) == 0, left = (point.x & mask) == 0;
      if (!upper && !left) continue;
      const int other_x = x - left, other_y = y - upper;
      if (x < lattice_.width() && y < lattice_.height()) pixels.push_back(taker_.film().pixel(x, y));
      if (other_x >= 0 && other_y >= 0) pixels.push_back(taker_.film().pixel(other_x, other_y));
    }
    std::sort(pixels.begin(), pixels.end());
    pixels.erase(std::unique(pixels.begin(), pixels.end()), pixels.end());
  }

  // The pixels to the left and above have come to an end; what others do touches corners at most.
  void in_reading_order() {
    PixelCells cells(lattice_, rules_);
    std::vector<LatticePoint> points;
    size_t waiting = 0;
    const auto visit = [&](int x, int y) {
      const size_t p = taker_.film().pixel(x, y);
      // Those that do not divide by themselves do so by what was found on the two borders that others have been at.
      const bool touched = lattice_.on_upper_border(x, y) || lattice_.on_left_border(x, y);
      if (!touched && !std::binary_search(divided_.begin(), divided_.end(), p)) return true;
      const bool done = cells.divide(x, y, points);
      put(p, cells);
      waiting += !done;
      return done;
    };
    ReadingOrder order(lattice_.width(), lattice_.height(), 0);
    for (bool all = true; all;) {
      waiting = 0;
      points.clear();
      order.advance(visit);
      if (waiting == 0) break;
      all = lattice_.ask(points);
    }
  }

  const CellRules& rules_;
  SampleTaker taker_;
  Lattice lattice_;
  const size_t width_;
  std::vector<std::array<double, 3>> colours_;
  std::vector<size_t> divided_;  // by their corners alone; ascending
};

RenderResult LatticeStrategy::render(const Source& source, const RenderOptions& options) const {
  return Render(*this, source, options).run(order_);
}

}  // namespace triad
