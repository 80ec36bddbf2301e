// SPDX-License-Identifier: Apache-2.0
// What POV-Ray's method 2 and its descendants have in common: pixels that are divided, samples that they share.
#pragma once

#include <triad/sampling/lattice_cells.hpp>

namespace triad {

class LatticeStrategy : public StrategyBase {
 public:
  enum class Order {
    kFixpoint,  // all pixels together, again and again until no sample is added
    kReading    // each pixel once, as far as it goes with what those before it have found
  };
  LatticeStrategy(const StrategyInfo& info, const StrategyValues& values, CellRules rules,
                  Order order = Order::kFixpoint);

  bool estimates_error() const override { return false; }
  // How often a pixel was divided, and how many samples its colour is made of, those that it shares included.
  std::vector<std::string> reason_channels() const override { return {"reason.depth", "reason.points"}; }
  uint64_t most_samples(int width, int height) const override;
  RenderResult render(const Source& source, const RenderOptions& options) const override;

 private:
  class Render;
  const CellRules rules_;
  const Order order_;
};

// depth, threshold, gamma.
std::vector<StrategyParam> lattice_params();
// The same and order, whose words are Order's by its values.
std::vector<StrategyParam> lattice_line_params();
// What every such strategy's documentation ends with.
inline constexpr const char* kLatticeDoc =
    " Corners are shared, by cells and by pixels: each sample is taken once in the whole picture, and a picture "
    "without differences takes (width + 1) x (height + 1). The sample count of a pixel is of those that lie in it, "
    "its "
    "left and upper border included. The map of reasons says how often a pixel was divided, and how many samples its "
    "colour is made of, those on all its borders included. A sample that is not valid differs from nothing and is "
    "left out of means. Noise differs too, so that a path tracer's picture takes most of the samples there are.";

}  // namespace triad
