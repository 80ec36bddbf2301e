// SPDX-License-Identifier: Apache-2.0
// What the colour differences of CIELAB share. A Formula has an Info and
// static void of(const LabBlock& test, const LabBlock& reference, size_t count, double* delta_e).
#pragma once

#include "compared_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <triad/colour/delta_e.hpp>

namespace colour_difference {

namespace tp = triad_plugin;
namespace cp = compared_pictures;

inline constexpr auto kInputs = tp::list(tp::Input{"test", "the picture to judge", "rgb", "linear"},
                                         tp::Input{"reference", "what it should be", "rgb", "linear"}, cp::kMask);
inline constexpr tp::Score kMeanScore{"mean", "mean colour difference", "dE", -1};

inline std::array<double, 9> to_xyz(const triad_image& image) {
  std::array<double, 9> matrix;
  std::copy_n(image.rgb_to_xyz, 9, matrix.begin());
  return matrix;
}

// In plan: refuses pictures that do not mean the same by white.
inline void require_same_white(const tp::PlanCall& call) {
  const auto white = [&](int input, int i) {
    const double* row = &call.in(input).rgb_to_xyz[3 * i];
    return row[0] + row[1] + row[2];
  };
  for (int i = 0; i < 3; ++i)
    if (!(std::abs(white(0, i) - white(1, i)) < 1e-3) || !(white(0, i) > 0))
      throw tp::Error(
          TRIAD_E_INPUT,
          "test and reference have different white points; bring them to one colour space first, as triad run "
          "--to SPACE -o FILE does");
}

template <class Formula>
struct ColourDifference {
  static constexpr tp::Info info = Formula::info;
  static constexpr auto inputs() { return kInputs; }
  static constexpr auto scores() { return tp::list(kMeanScore); }
  using State = triad::WeightedMean;

  void plan(tp::PlanCall& call) {
    cp::require_same_size(call);
    require_same_white(call);
    test_.emplace(to_xyz(call.in(0)));
    reference_.emplace(to_xyz(call.in(1)));
    call.out.channels = 1;
    call.plan.threads = TRIAD_REENTRANT;
  }
  void strip(tp::StripCall& call, State& state) const {
    cp::for_blocks(call, 2, [&](int x, int y, size_t count, const float* weights) {
      static_assert(cp::kBlock_px <= triad::kLabBlock);
      triad::LabBlock test, reference;
      alignas(64) double delta_e[cp::kBlock_px];
      test_->convert(call.in(0).at(x, y), count, test);
      reference_->convert(call.in(1).at(x, y), count, reference);
      Formula::of(test, reference, count, delta_e);
      state.add(delta_e, weights, count);
      if (call.has_out()) cp::write_map(call, x, y, delta_e, count);
    });
  }
  void merge(int, State& into, const State& from) const { into.merge(from); }
  void end_pass(tp::EndCall& call, const State& all) { call.scores[0] = cp::mean_of(all); }

 private:
  std::optional<triad::RgbToLab> test_, reference_;
};

}  // namespace colour_difference
