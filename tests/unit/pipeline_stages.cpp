// SPDX-License-Identifier: Apache-2.0
// Stages for the tests of the pipeline, one for each way a stage can ask for its input.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <triad/abi/triad_plugin.hpp>

namespace {
using namespace triad_plugin;

constexpr auto kImage = list(Input{"image", "the picture", "*"});

// A needs what lies at the other end: not monotone.
struct Flip {
  static constexpr Info info{"flip", "1.0", "Upside down"};
  static constexpr auto inputs() { return kImage; }
  int height = 0;
  void plan(PlanCall& call) {
    height = call.in(0).height;
    call.plan.threads = TRIAD_REENTRANT;
  }
  void need(int, triad_rect out, Needs& needs) const {
    needs[0] = {out.x0, height - out.y1, out.x1, height - out.y0};
  }
  void strip(StripCall& call) const {
    for (int y = call.r.y0; y < call.r.y1; ++y)
      std::copy_n(call.in(0).row(height - 1 - y), call.out().row_floats(), call.out().row(y));
  }
};

// A halo on all sides, with every edge mode.
struct Cross {
  static constexpr Info info{"cross", "1.0", "A pixel plus its neighbours at a distance"};
  static constexpr auto inputs() { return kImage; }
  int radius, edge;
  static constexpr auto params() {
    return list(integer<&Cross::radius>("radius", "distance", {.def = 1, .min = 0, .max = 1000}),
                choice<&Cross::edge, "clamp", "mirror", "wrap", "zero">("edge", "beyond the picture"));
  }
  void plan(PlanCall& call) {
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.edge = edge;
  }
  void need(int, triad_rect out, Needs& needs) const { needs[0] = grown(out, radius, radius); }
  void strip(StripCall& call) const {
    const auto in = call.in(0);
    for (int y = call.r.y0; y < call.r.y1; ++y)
      for (int x = call.r.x0; x < call.r.x1; ++x)
        for (int c = 0; c < in.channels; ++c)
          call.out().at(x, y)[c] = in.at(x, y)[c] + 2 * in.at(x - radius, y)[c] + 3 * in.at(x + radius, y)[c] +
                                   5 * in.at(x, y - radius)[c] + 7 * in.at(x, y + radius)[c] +
                                   11 * in.at(x + radius, y + radius)[c];
  }
};

// Two passes: the largest value first.
struct Normalise {
  static constexpr Info info{"normalise", "1.0", "Divides by the largest value"};
  static constexpr auto inputs() { return kImage; }
  struct State {
    float largest;
  };
  float largest = 0;
  void plan(PlanCall& call) {
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.passes = 2;
  }
  void strip(StripCall& call, State& state) const {
    for (int y = call.r.y0; y < call.r.y1; ++y)
      for (int i = 0; i < call.in(0).row_floats(); ++i) {
        if (call.pass == 0)
          state.largest = std::max(state.largest, call.in(0).row(y)[i]);
        else
          call.out().row(y)[i] = call.in(0).row(y)[i] / largest;
      }
  }
  void merge(int, State& into, const State& from) const { into.largest = std::max(into.largest, from.largest); }
  void end_pass(EndCall& call, const State& state) {
    if (call.pass == 0) largest = state.largest;
  }
};

// Needs ascending strips, each once: carries a running sum down the picture.
struct Running {
  static constexpr Info info{"running", "1.0", "Sum of the first column's first channel so far"};
  static constexpr auto inputs() { return kImage; }
  float sum = 0;
  int next = 0;
  void plan(PlanCall&) {}
  void strip(StripCall& call) {
    if (call.r.y0 != next) throw Error(TRIAD_E_INTERNAL, "strips out of order");
    for (int y = call.r.y0; y < call.r.y1; ++y) {
      sum += *call.in(0).row(y);
      std::fill_n(call.out().row(y), call.out().row_floats(), sum);
    }
    next = call.r.y1;
  }
};

// The whole picture in one call.
struct Mean {
  static constexpr Info info{"mean", "1.0", "The mean, everywhere"};
  static constexpr auto inputs() { return kImage; }
  int width = 0, height = 0;
  int64_t work;
  static constexpr auto params() {
    return list(integer<&Mean::work>("work", "bytes to ask the memory plan for", {.def = 0, .min = 0}));
  }
  void plan(PlanCall& call) {
    call.plan.strip_rows = -1;
    call.work_bytes(static_cast<uint64_t>(work));
    width = call.in(0).width;
    height = call.in(0).height;
  }
  void need(int, triad_rect, Needs& needs) const { needs[0] = {0, 0, width, height}; }
  void strip(StripCall& call) const {
    double sum = 0;
    for (int y = 0; y < height; ++y)
      for (int i = 0; i < call.in(0).row_floats(); ++i) sum += call.in(0).row(y)[i];
    const auto mean = static_cast<float>(sum / (static_cast<double>(height) * call.in(0).row_floats()));
    for (int y = 0; y < height; ++y) std::fill_n(call.out().row(y), call.out().row_floats(), mean);
  }
};

// Strips of exactly five rows, whose first row shows in all of them.
struct Fives {
  static constexpr Info info{"fives", "1.0", "Adds the number of the strip of five"};
  static constexpr auto inputs() { return kImage; }
  void plan(PlanCall& call) {
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.strip_rows = 5;
  }
  void strip(StripCall& call) const {
    if (call.r.y0 % 5 || call.r.y1 - call.r.y0 > 5) throw Error(TRIAD_E_INTERNAL, "not a strip of five");
    for (int y = call.r.y0; y < call.r.y1; ++y)
      for (int i = 0; i < call.out().row_floats(); ++i)
        call.out().row(y)[i] = call.in(0).row(y)[i] + static_cast<float>(call.r.y0 / 5);
  }
};

// Reads colour only, and spreads what is not finite over rows: asks the host to remove it.
struct RowMean {
  static constexpr Info info{"row-mean", "1.0", "Mean of each row, in thirds of the width"};
  static constexpr auto inputs() { return list(Input{"image", "the picture", "rgb", "linear"}); }
  int width = 0;
  void plan(PlanCall& call) {
    width = call.in(0).width;
    call.out.width = width / 3;
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.nonfinite = TRIAD_NONFINITE_ZERO;
  }
  void need(int, triad_rect out, Needs& needs) const { needs[0] = {0, out.y0, width, out.y1}; }
  void strip(StripCall& call) const {
    for (int y = call.r.y0; y < call.r.y1; ++y)
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int x = 0; x < width; ++x) sum += call.in(0).at(x, y)[c];
        for (int x = 0; x < call.out().width(); ++x) call.out().at(x, y)[c] = static_cast<float>(sum / width);
      }
  }
};

// A metric in two passes that looks one row beyond its strips: the mean, then the variance of the difference.
struct Variance {
  static constexpr Info info{"variance", "1.0", "Variance of the vertical differences"};
  static constexpr auto inputs() {
    return list(Input{"test", "a", "*"}, Input{"reference", "b", "*"}, Input{"mask", "weights", "mask", nullptr, 1});
  }
  static constexpr auto scores() {
    return list(Score{"mean", "mean", nullptr, 0}, Score{"variance", "variance", nullptr, -1},
                Score{"strips", "strips merged in order", nullptr, 0});
  }
  struct State {
    double sum, weight;
    int32_t strips, last_y;
  };
  static constexpr auto params() {
    return list(integer<&Variance::rows>("rows", "of a strip, 0 for any", {.def = 0, .min = 0, .max = 100000}));
  }
  int rows;
  double mean = 0;
  void plan(PlanCall& call) {
    call.out.channels = 1;
    call.plan.passes = 2;
    call.plan.strip_rows = rows;
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.edge = TRIAD_EDGE_CLAMP;
  }
  void need(int, triad_rect out, Needs& needs) const { needs[0] = needs[1] = grown(out, 0, 1); }
  void strip(StripCall& call, State& state) const {
    for (int y = call.r.y0; y < call.r.y1; ++y)
      for (int x = call.r.x0; x < call.r.x1; ++x) {
        const double weight = call.has(2) ? *call.in(2).at(x, y) : 1;
        const double d = static_cast<double>(*call.in(0).at(x, y + 1)) - *call.in(1).at(x, y - 1);
        state.sum += weight * (call.pass == 0 ? d : (d - mean) * (d - mean));
        state.weight += weight;
        if (call.has_out()) *call.out().at(x, y) = static_cast<float>(d);
      }
    state.strips = 1;
    state.last_y = call.r.y0;
  }
  void merge(int, State& into, const State& from) const {
    if (into.strips && from.last_y <= into.last_y) throw Error(TRIAD_E_INTERNAL, "merged out of order");
    into.sum += from.sum;
    into.weight += from.weight;
    into.strips += from.strips;
    into.last_y = from.last_y;
  }
  void end_pass(EndCall& call, const State& state) {
    if (call.pass == 0) {
      mean = state.sum / state.weight;
      return;
    }
    call.scores[0] = mean;
    call.scores[1] = state.sum / state.weight;
    call.scores[2] = state.strips;
  }
};

// Takes the variance of the test picture's pixels; its map is that, where it is to be pooled.
struct Spread {
  static constexpr Info info{"spread", "1.0", "Mean variance"};
  static constexpr auto inputs() {
    return list(Input{"test", "a", "rgb"}, Input{"reference", "b", "rgb"},
                Input{"variance", "of the test picture", "variance.*", nullptr, 0},
                Input{"mask", "weights", "mask", nullptr, TRIAD_INPUT_OPTIONAL});
  }
  static constexpr auto scores() {
    return list(Score{"psnr", "no mean of the map", "dB", 1, TRIAD_SCORE_MAY_BE_INFINITE},
                Score{"mean", "mean", nullptr, 1});
  }
  static constexpr auto params() {
    return list(
        integer<&Spread::border>("border", "pixels not pooled, -1 for all", {.def = 0, .min = -1, .max = 100}),
        integer<&Spread::nan_row>("nan", "row with a not-a-number", {.def = -1, .min = -1, .max = 1000}));
  }
  struct State {
    double sum, count;
  };
  int border, nan_row;
  void plan(PlanCall& call) {
    call.out.channels = 3;
    call.plan.threads = TRIAD_REENTRANT;
    const int width = call.in(0).width, height = call.in(0).height;
    if (border < 0) call.pool({});
    if (border > 0) call.pool({border, border, width - border, height - border});
  }
  void strip(StripCall& call, State& state) const {
    for (int y = call.r.y0; y < call.r.y1; ++y)
      for (int i = 0; i < 3 * (call.r.x1 - call.r.x0); ++i) {
        state.sum += call.in(2).row(y)[i];
        state.count += 1;
        if (call.has_out()) call.out().row(y)[i] = y == nan_row ? std::nanf("") : call.in(2).row(y)[i];
      }
  }
  void merge(int, State& into, const State& from) const {
    into.sum += from.sum;
    into.count += from.count;
  }
  void end_pass(EndCall& call, const State& state) {
    call.scores[0] = HUGE_VAL;
    call.scores[1] = state.sum / state.count;
  }
};

}  // namespace
TRIAD_PLUGIN("pipeline-stages", Flip, Cross, Normalise, Running, Mean, Fives, RowMean, Variance, Spread)
