// SPDX-License-Identifier: Apache-2.0
// Errors relative to the reference. A Formula has an Info, its kEps, and
// static double of(double test, double reference, double eps): the error of one channel.
#pragma once

#include "compared_pictures.hpp"

#include <triad/numeric/trimmed_mean.hpp>

namespace relative_error {

namespace tp = triad_plugin;
namespace cp = compared_pictures;

inline constexpr auto kInputs = tp::list(tp::Input{"test", "the picture to judge", "rgb"},
                                         tp::Input{"reference", "what it should be", "rgb"}, cp::kMask);

template <class Stage>
constexpr auto eps_param(double eps) {
  return tp::number<&Stage::eps>("eps", "what keeps the error of dark pixels finite",
                                 {.def = eps, .min = 0, .flags = TRIAD_PARAM_MIN_EXCLUDED});
}

inline void plan_map(tp::PlanCall& call) {
  cp::require_same_size(call);
  call.out.channels = 1;
  call.plan.threads = TRIAD_REENTRANT;
}

// values[i] = the mean over the channels of pixel x + i.
template <class Formula>
void errors(const tp::StripCall& call, int x, int y, size_t count, double eps, double* values) {
  const float *test = call.in(0).at(x, y), *reference = call.in(1).at(x, y);
  for (size_t i = 0; i < count; ++i, test += 3, reference += 3) {
    double sum = 0;
    for (int c = 0; c < 3; ++c)
      sum += Formula::of(static_cast<double>(test[c]), static_cast<double>(reference[c]), eps);
    values[i] = sum / 3;
  }
}

// The mean over the pixels.
template <class Formula>
struct Mean {
  static constexpr tp::Info info = Formula::info;
  double eps;

  static constexpr auto params() { return tp::list(eps_param<Mean>(Formula::kEps)); }
  static constexpr auto inputs() { return kInputs; }
  static constexpr auto scores() { return tp::list(tp::Score{"mean", "mean over all pixels", nullptr, -1}); }
  using State = triad::WeightedMean;

  void plan(tp::PlanCall& call) { plan_map(call); }
  void strip(tp::StripCall& call, State& state) const {
    cp::for_blocks(call, 2, [&](int x, int y, size_t count, const float* weights) {
      double values[cp::kBlock_px];
      errors<Formula>(call, x, y, count, eps, values);
      state.add(values, weights, count);
      if (call.has_out()) cp::write_map(call, x, y, values, count);
    });
  }
  void merge(int, State& into, const State& from) const { into.merge(from); }
  void end_pass(tp::EndCall& call, const State& all) { call.scores[0] = cp::mean_of(all); }
};

// Also the mean without the largest values: what it would be without a few fireflies.
template <class Formula>
struct TrimmedMean {
  static constexpr tp::Info info = Formula::info;
  double eps, trim;

  static constexpr auto params() {
    return tp::list(eps_param<TrimmedMean>(Formula::kEps),
                    tp::number<&TrimmedMean::trim>(
                        "trim", "how many of the pixels trimmed leaves out; 0 reads the pictures once",
                        {.def = .1, .min = 0, .max = 100, .unit = "%", .flags = TRIAD_PARAM_MAX_EXCLUDED}));
  }
  static constexpr auto inputs() { return kInputs; }
  static constexpr auto scores() {
    return tp::list(tp::Score{"mean", "mean over all pixels", nullptr, -1},
                    tp::Score{"trimmed", "mean without the largest values", nullptr, -1});
  }
  struct State {
    triad::WeightedMean mean;
    triad::TrimmedSums trimmed;
  };

  void plan(tp::PlanCall& call) {
    plan_map(call);
    call.plan.passes = trim > 0 ? 2 : 1;
  }
  void strip(tp::StripCall& call, State& state) const {
    cp::for_blocks(call, 2, [&](int x, int y, size_t count, const float* weights) {
      double values[cp::kBlock_px];
      errors<Formula>(call, x, y, count, eps, values);
      if (call.pass == 0) state.mean.add(values, weights, count);
      if (call.pass == 0 && trim > 0) state.trimmed.add_first(values, weights, count);
      if (call.pass == 1) state.trimmed.add_second(values, weights, count, limit_);
      if (call.has_out()) cp::write_map(call, x, y, values, count);
    });
  }
  void merge(int, State& into, const State& from) const {
    into.mean.merge(from.mean);
    if (trim > 0) into.trimmed.merge(from.trimmed);
  }
  void end_pass(tp::EndCall& call, const State& all) {
    if (call.pass == 0) {
      mean_ = cp::mean_of(all.mean);
      if (trim > 0) limit_ = all.trimmed.limit(trim / 100);
    }
    if (call.scores.empty()) return;
    call.scores[0] = mean_;
    call.scores[1] = trim > 0 ? all.trimmed.mean(limit_) : mean_;
  }

 private:
  double mean_ = 0;
  triad::TrimLimit limit_;
};

}  // namespace relative_error
