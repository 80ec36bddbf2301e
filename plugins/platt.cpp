// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <string>
#include <triad/display/constrained.hpp>
#include <vector>

#include "driven_panel.hpp"
#include "platt_engines.hpp"

namespace {

namespace tp = triad_plugin;
using platt_engines::Engine;

// Copies with values outside [0, 1] clamped; returns how many were. What is not a number stays.
int64_t clamp_into(const float* from, int64_t count, float* to) {
  int64_t outside = 0;
  for (int64_t i = 0; i < count; ++i) {
    const float v = from[i], clamped = v < 0 ? 0 : v > 1 ? 1 : v;
    to[i] = clamped;
    outside += clamped != v;
  }
  return outside;
}

int64_t outside(const float* values, int64_t count) {
  int64_t found = 0;
  for (int64_t i = 0; i < count; ++i) found += values[i] < 0 || values[i] > 1;
  return found;
}

enum class EngineChoice { kAuto, kFft, kFir };
enum class FlatField { kExact, kFree };
enum class Displayed { kConstrained, kClip, kUnbounded };
enum class Mode { kAuto, kRows, kPlane };
enum class Precision { kFloat, kDouble };

// The best displayable drives of a strip of rows, or of the whole picture.
class Optimum {
 public:
  virtual ~Optimum() = default;
  virtual triad::SolveResult rows(tp::StripCall& call) = 0;
};

template <class Real>
class RowOptimum : public Optimum {
 public:
  explicit RowOptimum(triad::RowSolver<Real> solver) : solver_(std::move(solver)) {}
  triad::SolveResult rows(tp::StripCall& call) override {
    const auto in = call.in(0);
    const auto out = call.out();
    auto work = pool_.take();
    if (!work) work = std::make_unique<Workspace>(solver_);
    triad::SolveResult sum;
    for (int y = call.r.y0; y < call.r.y1; ++y) {
      const auto row = solver_.solve(in.row(y), out.row(y), *work);
      if (y == call.r.y0) {
        sum = row;
      } else {
        sum.add(row);
      }
    }
    pool_.give(std::move(work));
    return sum;
  }

 private:
  using Workspace = typename triad::RowSolver<Real>::Workspace;
  triad::RowSolver<Real> solver_;
  platt_engines::Pool<Workspace> pool_;
};

template <class Real>
class PlaneOptimum : public Optimum {
 public:
  explicit PlaneOptimum(triad::PlaneSolver<Real> solver) : solver_(std::move(solver)) {}
  triad::SolveResult rows(tp::StripCall& call) override {
    const auto in = call.in(0);
    const auto out = call.out();
    constexpr std::align_val_t kLine{64};
    const std::unique_ptr<void, void (*)(void*)> workspace(::operator new(solver_.workspace_bytes(), kLine),
                                                           [](void* p) { ::operator delete(p, kLine); });
    const auto stride = [](const auto& view) {
      return view.height() > 1 ? view.row(view.r.y0 + 1) - view.row(view.r.y0) : 0;
    };
    return solver_.solve(in.row(in.r.y0), stride(in), out.row(out.r.y0), stride(out), workspace.get(),
                         [&](double done) { call.progress(done); });
  }

 private:
  triad::PlaneSolver<Real> solver_;
};

struct Platt {
  static constexpr tp::Info info{
      "platt", "1.2", "Drives the subpixels so that the error an eye sees is least",
      "From a wide render, the drives of a panel's subpixels whose light differs least from the render, weighed by "
      "how "
      "finely an eye sees each frequency of luminance, red-green and blue-yellow (Platt 2000, \"Optimal Filtering "
      "for "
      "Patterned Displays\").\n"
      "range=constrained finds the best drives within [0, 1], what a panel can show, by iteration; it reports the "
      "gap: "
      "the error is at most that part of the displaced box's above the least possible. It stops at tolerance or "
      "after "
      "iterations; 15 do for a preview.\n"
      "range=unbounded is the linear filter; with lambda=0, flat-field=free and edge=wrap the published optimum. "
      "That "
      "asks for drives far outside [0, 1], and range=clip, which clips it, is worse than a plain average at small "
      "lambda. engine=fft filters whole rows exactly; engine=fir convolves with as many cells as taps says and "
      "reports which share of the kernel that leaves out (truncation), taps=0 taking as many as leave out at most "
      "0.001; engine=auto takes whichever needs fewer operations.\n"
      "mode=rows takes rows one by one and streams; mode=plane takes the whole picture at once, for panels whose "
      "rows do not stand alone. auto is rows where the layout allows it.\n"
      "The render is clamped to [0, 1] first, as an ideal panel would, unless range=unbounded."};
  std::string layout;
  triad::Csf csf;
  double ppd, lambda, luminance;
  FlatField flat_field;
  triad::ChannelGains channels;
  triad::Edge edge;
  EngineChoice engine;
  int taps;
  Displayed range;
  Mode mode;
  int iterations;
  double tolerance;
  Precision precision;
  std::vector<double> origin;

  static constexpr double kTruncationTarget = 1e-3;  // of the kernel's absolute sum: below a step of 8 bits

  static constexpr auto params() {
    return tp::list(
        tp::text<&Platt::layout>("layout", seeing_parameters::kLayoutDoc, {.def = "auto"}),
        tp::choice<&Platt::csf, "scielab", "kolpatzik-bouman">("csf", "how finely an eye sees"),
        tp::number<&Platt::ppd>("ppd", "pixels per degree of visual angle; 40 is 96 dpi at 60 cm",
                                {.def = 40, .min = 1, .max = 10000, .unit = "ppd"}),
        tp::number<&Platt::lambda>("lambda", "share of the displaced box in what an eye can hardly see",
                                   {.def = .01, .min = 0, .max = 1}),
        tp::choice<&Platt::flat_field, "exact", "free">(
            "flat-field", "exact keeps constant colours constant; free is the plain optimum, which tints them"),
        tp::choice<&Platt::channels, "gains", "raw">(
            "channels", "gains makes the three opponent channels comparably visible; raw leaves them as they are"),
        tp::choice<&Platt::edge, "mirror", "wrap">("edge", "what lies beyond the ends of a row"),
        tp::choice<&Platt::range, "constrained", "clip", "unbounded">(
            "range", "the best drives within [0, 1], the linear filter clamped to it, or that filter as it is"),
        tp::choice<&Platt::mode, "auto", "rows", "plane">("mode", "whether rows are taken one by one"),
        tp::integer<&Platt::iterations>("iterations", "of range=constrained, at most; 0 is the displaced box",
                                        {.def = 40, .min = 0, .max = 100000}),
        tp::number<&Platt::tolerance>("tolerance", "the gap at which range=constrained stops; 0 runs all iterations",
                                      {.def = .01, .min = 0, .max = 1}),
        tp::choice<&Platt::engine, "auto", "fft", "fir">("engine", "how the linear filter is applied"),
        tp::integer<&Platt::taps>("taps", "cells of the convolution, an odd number; 0 chooses",
                                  {.def = 0, .min = 0, .max = 16777215, .unit = "cells"}),
        tp::choice<&Platt::precision, "float", "double">("precision",
                                                         "of the filtering; the design is always double"),
        tp::number<&Platt::luminance>("luminance", "mean luminance of the display, for csf=kolpatzik-bouman",
                                      {.def = 11, .min = .01, .max = 1e6, .unit = "cd/m2"}),
        tp::numbers<&Platt::origin>("origin", display_parameters::kOriginDoc,
                                    {.def = display_parameters::kOrigin, .max_count = 2, .unit = "px"}));
  }
  static constexpr auto inputs() { return tp::list(tp::Input{"image", "a wide render", "rgb", "linear"}); }

  struct State {
    int64_t clamped_inputs, clipped_outputs, rows;
    triad::SolveResult solved;
  };

  void create(tp::Call&) {
    display_parameters::check_origin(origin);
    if (taps > 0 && taps % 2 == 0)
      throw tp::Error(TRIAD_E_PARAM, "taps=" + std::to_string(taps) + " has no middle: " + std::to_string(taps - 1) +
                                         " or " + std::to_string(taps + 1) + " would do");
    if (range == Displayed::kConstrained && (engine != EngineChoice::kAuto || taps != 0))
      throw tp::Error(TRIAD_E_PARAM, std::string(taps != 0 ? "taps" : "engine") +
                                         " is of the linear filter: it needs range=clip or range=unbounded");
  }

  void plan(tp::PlanCall& call) {
    const triad_image& in = call.in(0);
    panel_ = driven_panel::plan_for(call, layout);
    choose_mode();
    width_cells_ = in.width;
    triad::Observer observer;
    std::copy_n(in.rgb_to_xyz, 9, observer.rgb_to_xyz.begin());
    observer.ppd = ppd;
    observer.csf = csf;
    observer.gains = channels;
    observer.luminance_nits = luminance;
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.edge = edge == triad::Edge::kMirror ? TRIAD_EDGE_MIRROR : TRIAD_EDGE_WRAP;
    // Whatever the method: one such value would spoil a row, or as many pixels as the kernel is long.
    call.plan.nonfinite = TRIAD_NONFINITE_ZERO;
    display_parameters::in_library([&] {
      if (range == Displayed::kConstrained) {
        if (precision == Precision::kFloat) {
          prepare<float>(call, observer);
        } else {
          prepare<double>(call, observer);
        }
      } else if (plane_) {
        prepare<double>(call, observer);  // floats would not bear what an unbounded filter amplifies
      } else {
        design(call, observer, call.out.width);
      }
    });
  }

  void need(int, triad_rect out, tp::Needs& needs) const {
    const int cells = panel_.cells_x;
    if (!engine_) {  // whole rows, or the whole picture
      needs[0] = {0, out.y0 * panel_.cells_y, width_cells_, out.y1 * panel_.cells_y};
      return;
    }
    needs[0] = engine_->whole_rows() ? triad_rect{0, out.y0, width_cells_, out.y1}
                                     : triad_rect{out.x0 * cells + engine_->first_cell(), out.y0,
                                                  (out.x1 - 1) * cells + engine_->last_cell() + 1, out.y1};
  }

  void strip(tp::StripCall& call, State& state) const {
    const auto in = call.in(0);
    const auto out = call.out();
    const int cells = panel_.cells_x;
    if (!engine_) {
      for (int y = in.r.y0; y < in.r.y1; ++y) state.clamped_inputs += outside(in.row(y), in.row_floats());
      state.solved = optimum_->rows(call);
      if (range == Displayed::kClip)
        for (int y = out.r.y0; y < out.r.y1; ++y)
          state.clipped_outputs += clamp_into(out.row(y), out.row_floats(), out.row(y));
      state.rows = plane_ ? 1 : call.r.y1 - call.r.y0;
      return;
    }
    const bool clip = range == Displayed::kClip;
    const auto clamped = call.scratch<float>(clip ? static_cast<size_t>(in.row_floats()) : 0);
    // The cells of this strip's own pixels are counted, those that strips share are not.
    const int64_t own = 3 * int64_t{cells} * (call.r.x1 - call.r.x0);
    const int64_t before = 3 * (int64_t{cells} * call.r.x0 - in.r.x0), after = in.row_floats() - before - own;
    const int64_t start = engine_->whole_rows() ? 0 : before;
    for (int y = call.r.y0; y < call.r.y1; ++y) {
      const float* row = in.row(y);
      if (clip) {
        // A kernel all on one side leaves its own pixels' cells out: then there is nothing to count.
        const int64_t from = std::clamp<int64_t>(before, 0, in.row_floats());
        const int64_t to = std::clamp<int64_t>(in.row_floats() - after, from, in.row_floats());
        clamp_into(row, from, clamped.data());
        state.clamped_inputs += clamp_into(row + from, to - from, clamped.data() + from);
        clamp_into(row + to, in.row_floats() - to, clamped.data() + to);
        row = clamped.data();
      }
      float* drives = out.row(y);
      engine_->row(row + start, call.r.x0, call.r.x1, drives);
      if (clip) state.clipped_outputs += clamp_into(drives, out.row_floats(), drives);
    }
  }

  void merge(int, State& into, const State& from) const {
    into.clamped_inputs += from.clamped_inputs;
    into.clipped_outputs += from.clipped_outputs;
    if (into.rows == 0) into.solved.converged = true;  // zero bytes say it is not
    into.solved.add(from.solved);
    into.rows += from.rows;
  }

  void end_pass(tp::EndCall& call, const State& state) {
    if (range == Displayed::kUnbounded) return;
    call.report("clamped-inputs", static_cast<double>(state.clamped_inputs));
    if (range == Displayed::kClip) {
      call.report("clipped-outputs", static_cast<double>(state.clipped_outputs));
      return;
    }
    const triad::SolveResult& all = state.solved;
    const auto rows = static_cast<double>(std::max<int64_t>(1, state.rows));
    call.report("gap", all.gap());
    call.report("iterations", all.iterations);
    call.report("converged", all.converged);
    // As the metric display measures, lambda's share included, on the ring of the picture and its surroundings.
    call.report("rmse", std::sqrt(all.best / rows));
    call.report("rmse-displaced-box", std::sqrt(all.start / rows));
    if (!all.converged && tolerance > 0 && iterations > 0)
      call.warn("the gap is " + std::to_string(all.gap()) + " after " + std::to_string(all.iterations) +
                " iterations, above the tolerance of " + std::to_string(tolerance) + (plane_ ? "" : " in some rows") +
                "; more iterations would close it");
  }

 private:
  // Rows or plane, and whether the linear filter works on the panel.
  void choose_mode() {
    const bool rows_alone = panel_.has_independent_rows();
    if (mode == Mode::kRows && !rows_alone)
      throw tp::Error(TRIAD_E_PARAM,
                      "the rows of layout " + panel_.name + " do not stand alone: mode=plane solves it");
    plane_ = mode == Mode::kPlane || (mode == Mode::kAuto && !rows_alone);
    if (range == Displayed::kConstrained) return;
    if (plane_) {
      if (engine == EngineChoice::kFir || taps != 0)
        throw tp::Error(TRIAD_E_PARAM, "the linear filter in the plane has no taps: leave engine and taps out");
    } else if (!panel_.is_rows()) {
      throw tp::Error(
          TRIAD_E_PARAM,
          "the linear filter of range=clip and range=unbounded works on rows of vertical stripes, one per "
          "channel, as rgb or bgr; range=constrained works on " +
              panel_.name);
    }
  }

  template <class Real>
  void prepare(tp::PlanCall& call, const triad::Observer& observer) {
    const triad::SolveOptions options{{.lambda = lambda, .exact_flat_fields = flat_field == FlatField::kExact},
                                      iterations,
                                      tolerance,
                                      range == Displayed::kConstrained,
                                      range != Displayed::kUnbounded};
    const auto [x, y] = seeing_parameters::origin_on(call, origin, panel_);
    if (!plane_) {
      optimum_ = std::make_unique<RowOptimum<Real>>(
          triad::RowSolver<Real>(panel_, observer, call.out.width, x, edge, options));
      return;
    }
    triad::PlaneSolver<Real> solver(panel_, observer, call.out.width, call.out.height, x, y, edge, options);
    call.plan.strip_rows = -1;
    call.work_bytes(solver.workspace_bytes());
    optimum_ = std::make_unique<PlaneOptimum<Real>>(std::move(solver));
  }

  void design(tp::PlanCall& call, const triad::Observer& observer, int width_px) {
    const triad::FilterDesign filter(panel_, observer, triad::ring_px(width_px, edge),
                                     {.lambda = lambda, .exact_flat_fields = flat_field == FlatField::kExact});
    call.report("condition", filter.condition());
    if (filter.fallback_frequencies() > 0) call.report("fallback-frequencies", filter.fallback_frequencies());
    if (engine != EngineChoice::kFft) {
      const triad::ImpulseResponse response(filter);
      const int count = taps > 0 ? std::min(taps, filter.cells()) : response.taps_for(kTruncationTarget);
      if (engine == EngineChoice::kFir || triad::convolution_is_cheaper(count, width_px, panel_.cells_x, edge)) {
        const auto kernels = response.truncated(count);
        if (precision == Precision::kFloat) {
          engine_ = std::make_unique<platt_engines::FirEngine<float>>(panel_.cells_x, kernels);
        } else {
          engine_ = std::make_unique<platt_engines::FirEngine<double>>(panel_.cells_x, kernels);
        }
        call.report("taps", count);
        call.report("truncation", response.truncation_error(count));
        return;
      }
    }
    if (precision == Precision::kFloat) {
      engine_ = std::make_unique<platt_engines::FftEngine<float>>(filter, width_px, edge);
    } else {
      engine_ = std::make_unique<platt_engines::FftEngine<double>>(filter, width_px, edge);
    }
  }

  triad::Layout panel_;
  int width_cells_ = 0;
  bool plane_ = false;
  std::unique_ptr<Engine> engine_;    // of the linear filter
  std::unique_ptr<Optimum> optimum_;  // of range=constrained
};

}  // namespace

TRIAD_PLUGIN("platt", Platt)
