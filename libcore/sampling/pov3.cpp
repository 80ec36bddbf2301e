// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/lattice_strategy.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "pov3", "As pov2, but stops where what still changes is too small to be seen",
    std::string(
        "Divides a pixel one level after the other. At each, only those cells go on whose corners differ by the "
        "threshold or more times the pixel's area over the area of all cells that go on, which is found by leaving "
        "out cells until none is left out any more: what is left can change the pixel by the threshold. So faint "
        "edges take few samples and strong ones as many as with pov2, never more.") +
        kLatticeDoc,
    lattice_params()};

class Pov3 final : public LatticeStrategy {
 public:
  explicit Pov3(const StrategyValues& values) : LatticeStrategy(kInfo, values, {.by_area = true}) {}
};

}  // namespace

const StrategyEntry& pov3_strategy() {
  static const StrategyEntry entry = strategy_entry<Pov3>(kInfo);
  return entry;
}

}  // namespace triad
