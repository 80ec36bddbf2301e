// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/lattice_strategy.hpp>

namespace triad {
namespace {

std::vector<StrategyParam> params() {
  std::vector<StrategyParam> params = lattice_params();
  params.push_back(lattice_order_param());
  return params;
}

const StrategyInfo kInfo{
    "pov4", "As pov3, with fewer samples for a division, and lines followed from pixel to pixel",
    std::string(
        "A cell that is divided takes a sample at its centre, and one in the middle of an edge only where an end of "
        "the edge differs from the centre or from the other end; else the middle is the mean of the ends. Along an "
        "edge, all samples on it count, whichever pixel they were taken for: a line that passes between the corners "
        "of "
        "a pixel is found as soon as a neighbour has found it. What no corner and no neighbour meets stays missed: "
        "lines of .3 pixels are whole, lines of .1 pixels are not. order=scanline is quicker to "
        "describe and finds lines that go down; order=fixpoint finds them in all directions.") +
        kLatticeDoc,
    params()};

class Pov4 final : public LatticeStrategy {
 public:
  explicit Pov4(const StrategyValues& values)
      : LatticeStrategy(kInfo, values, {.by_area = true, .along_lines = true},
                        values.at("order") == 0 ? Order::kFixpoint : Order::kReading) {}
};

}  // namespace

const StrategyEntry& pov4_strategy() {
  static const StrategyEntry entry = strategy_entry<Pov4>(kInfo);
  return entry;
}

}  // namespace triad
