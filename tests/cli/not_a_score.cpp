// SPDX-License-Identifier: Apache-2.0
// A metric with a defect: its score is not a number.
#include <cmath>
#include <triad/abi/triad_plugin.hpp>

namespace {

namespace tp = triad_plugin;

struct NotAScore {
  static constexpr tp::Info info{"not-a-score", "1.0", "Scores NaN", "For the tests of the command line."};
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "any picture", "rgb"}, tp::Input{"reference", "any picture", "rgb"});
  }
  static constexpr auto scores() { return tp::list(tp::Score{"score", "not a number", nullptr, -1}); }
  struct State {
    int64_t strips;
  };
  void plan(tp::PlanCall& call) { call.out.channels = 0; }
  void strip(tp::StripCall&, State& state) const { ++state.strips; }
  void merge(int, State& into, const State& from) const { into.strips += from.strips; }
  void end_pass(tp::EndCall& call, const State&) { call.scores[0] = std::nan(""); }
};

}  // namespace

TRIAD_PLUGIN("not-a-score", NotAScore)
