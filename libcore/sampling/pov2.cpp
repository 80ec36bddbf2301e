// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/lattice_strategy.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "pov2", "POV-Ray's method 2: pixels are divided into four where their corners differ",
    std::string(
        "Samples at the corners of each pixel. Where any two of the four differ by the threshold or more, the pixel "
        "is divided into four cells with samples at their corners, and each of these again, up to depth times; a "
        "cell that is not divided is the mean of its corners. As POV-Ray 3.6 does; POV-Ray 3.7 divides once less at "
        "the same depth, and shares samples within a pixel only. Takes samples where there is something to see, but "
        "misses what lies between the corners, and thin lines with it.") +
        kLatticeDoc,
    lattice_params()};

class Pov2 final : public LatticeStrategy {
 public:
  explicit Pov2(const StrategyValues& values) : LatticeStrategy(kInfo, values, {}) {}
};

}  // namespace

const StrategyEntry& pov2_strategy() {
  static const StrategyEntry entry = strategy_entry<Pov2>(kInfo);
  return entry;
}

}  // namespace triad
