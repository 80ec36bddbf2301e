// SPDX-License-Identifier: Apache-2.0
#include <triad/abi/triad_plugin.hpp>

namespace {

namespace tp = triad_plugin;

struct Invert {
  static constexpr tp::Info info{"invert", "1.0", "Gives white minus the picture"};
  double white;

  static constexpr auto params() {
    return tp::list(tp::number<&Invert::white>("white", "the value that becomes black", {.def = 1}));
  }
  static constexpr auto inputs() { return tp::list(tp::Input{"image", "the picture", "rgb", "display"}); }
  void plan(tp::PlanCall& call) { call.plan.threads = TRIAD_REENTRANT; }
  void strip(tp::StripCall& call) const {
    for (int y = call.r.y0; y < call.r.y1; ++y)
      for (int i = 0; i < call.out().row_floats(); ++i)
        call.out().row(y)[i] = static_cast<float>(white - static_cast<double>(call.in(0).row(y)[i]));
  }
};

}  // namespace

TRIAD_PLUGIN("invert", Invert)
