// SPDX-License-Identifier: Apache-2.0
// A metric that knows the largest value of its map: the map is 1/2 everywhere, and could reach 2.
#include <algorithm>
#include <triad/abi/triad_plugin.hpp>

namespace {

namespace tp = triad_plugin;

struct BoundedMap {
  static constexpr tp::Info info{"bounded-map", "1.0", "A map of 1/2", "For the tests of the command line."};
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "any picture", "rgb"}, tp::Input{"reference", "any picture", "rgb"});
  }
  static constexpr auto scores() { return tp::list(tp::Score{"half", "1/2", nullptr, -1}); }
  struct State {
    int64_t strips;
  };
  void plan(tp::PlanCall& call) { call.out.channels = 1; }
  void strip(tp::StripCall& call, State& state) const {
    ++state.strips;
    if (!call.has_out()) return;
    const auto out = call.out();
    for (int y = call.r.y0; y < call.r.y1; ++y) std::fill_n(out.row(y), out.width(), .5f);
  }
  void merge(int, State& into, const State& from) const { into.strips += from.strips; }
  void end_pass(tp::EndCall& call, const State&) {
    call.scores[0] = .5;
    call.report("map-max", 2);
  }
};

}  // namespace

TRIAD_PLUGIN("bounded-map", BoundedMap)
