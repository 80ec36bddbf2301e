// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/lattice_strategy.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "pov4", "As pov3, with fewer samples for a division, and lines followed from pixel to pixel",
    std::string(
        "A cell that is divided takes a sample at its centre, and one in the middle of an edge only where an end of "
        "the edge differs from the centre or from the other end; else the middle is the mean of the ends. Along an "
        "edge, all samples on it count, whichever pixel they were taken for: a line that passes between the corners "
        "of a pixel is found as soon as a neighbour has found it. What no corner and no neighbour meets stays "
        "missed, "
        "and very thin lines slip through between the samples of the neighbours too: with depth=3, lines of .3 "
        "pixels "
        "are whole, and of lines of .1 pixels little is left. order=scanline, which is what was first described, "
        "leaves gaps in lines that rise to the right.") +
        kLatticeDoc,
    lattice_line_params()};

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
