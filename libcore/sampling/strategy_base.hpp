// SPDX-License-Identifier: Apache-2.0
// What all strategies have in common: their parameters, and the list that they are found in.
#pragma once

#include <triad/sampling/named_params.hpp>

namespace triad {

class StrategyBase : public Strategy {
 public:
  StrategyBase(const StrategyInfo& info, const StrategyValues& values) : info_(info), values_(values) {}

  const StrategyInfo& info() const override { return info_; }
  std::string text() const override;

 protected:
  double value(const std::string& name) const { return values_.at(name); }
  // Of a parameter that is a whole number, or a choice's place.
  uint32_t whole(const std::string& name) const { return static_cast<uint32_t>(values_.at(name)); }

 private:
  const StrategyInfo& info_;
  StrategyValues values_;
};

// One line per strategy in strategy.cpp's list.
struct StrategyEntry {
  const StrategyInfo& info;
  // Throws Error(kUsage) naming `option` for values that do not go together.
  std::unique_ptr<Strategy> (*make)(const StrategyValues& values, const std::string& option);
};
// The entry of a strategy whose values all go together.
template <class S>
StrategyEntry strategy_entry(const StrategyInfo& info) {
  return {info, [](const StrategyValues& values, const std::string&) -> std::unique_ptr<Strategy> {
            return std::make_unique<S>(values);
          }};
}

const StrategyEntry& control_strategy();
const StrategyEntry& grid_strategy();
const StrategyEntry& random_strategy();
const StrategyEntry& jitter_strategy();
const StrategyEntry& sobol_owen_strategy();
const StrategyEntry& quad_strategy();
const StrategyEntry& tri_strategy();
const StrategyEntry& uniform_strategy();
const StrategyEntry& splat_strategy();
const StrategyEntry& importance_strategy();
const StrategyEntry& pov1_strategy();
const StrategyEntry& pov2_strategy();
const StrategyEntry& pov3_strategy();
const StrategyEntry& pov4_strategy();
const StrategyEntry& pov5_strategy();
const StrategyEntry& pov_stochastic_strategy();
const StrategyEntry& variance_strategy();
const StrategyEntry& per_subpixel_strategy();
const StrategyEntry& random_subpixel_strategy();
const StrategyEntry& cells_strategy();
const StrategyEntry& exact_strategy();

}  // namespace triad
