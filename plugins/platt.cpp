// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <mutex>
#include <string>
#include <triad/display/row_filter.hpp>
#include <triad/numeric/polyphase.hpp>
#include <vector>

#include "display_parameters.hpp"

namespace {

namespace tp = triad_plugin;

// Working memory that threads take and give back, so that a strip of one row costs no allocation.
template <class T>
class Pool {
 public:
  std::unique_ptr<T> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return nullptr;
    std::unique_ptr<T> out = std::move(free_.back());
    free_.pop_back();
    return out;
  }
  void give(std::unique_ptr<T> item) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(item));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
};

// Turns cells into drives. Pixel 0 reads the cells first_cell() .. last_cell(), unless whole_rows().
class Engine {
 public:
  virtual ~Engine() = default;
  virtual bool whole_rows() const = 0;
  virtual int first_cell() const = 0;
  virtual int last_cell() const = 0;
  // cells: the cell 0 of pixel x0, or of the row for whole_rows(). Writes pixels x0 .. x1 - 1.
  virtual void row(const float* cells, int x0, int x1, float* out) = 0;
};

template <class Real>
class FftEngine : public Engine {
 public:
  FftEngine(const triad::FilterDesign& design, int width_px, triad::Edge edge) : filter_(design, width_px, edge) {}
  bool whole_rows() const override { return true; }
  int first_cell() const override { return 0; }
  int last_cell() const override { return 0; }
  void row(const float* cells, int x0, int x1, float* out) override {
    auto work = pool_.take();
    if (!work) work = std::make_unique<Work>(filter_);
    filter_.apply(cells, work->drives.data(), work->workspace);
    std::copy(work->drives.data() + 3 * static_cast<ptrdiff_t>(x0),
              work->drives.data() + 3 * static_cast<ptrdiff_t>(x1), out);
    pool_.give(std::move(work));
  }

 private:
  struct Work {
    explicit Work(const triad::RowFilter<Real>& filter)
        : workspace(filter), drives(3 * static_cast<size_t>(filter.width_px())) {}
    typename triad::RowFilter<Real>::Workspace workspace;
    std::vector<float> drives;
  };
  triad::RowFilter<Real> filter_;
  Pool<Work> pool_;
};

template <class Real>
class FirEngine : public Engine {
 public:
  FirEngine(int cells, const std::array<triad::FirKernel, 3>& kernels) : filter_(cells, kernels) {}
  bool whole_rows() const override { return false; }
  int first_cell() const override { return filter_.first_cell(); }
  int last_cell() const override { return filter_.last_cell(); }
  void row(const float* cells, int x0, int x1, float* out) override {
    auto work = pool_.take();
    if (!work) work = std::make_unique<Work>();
    const int pixels = x1 - x0;
    if constexpr (std::is_same_v<Real, float>) {
      filter_.apply_row(cells, out, pixels, work->scratch);
    } else {
      const ptrdiff_t first = 3 * static_cast<ptrdiff_t>(first_cell());
      const ptrdiff_t end = 3 * (static_cast<ptrdiff_t>(filter_.cells()) * (pixels - 1) + last_cell() + 1);
      work->in.assign(cells + first, cells + end);
      work->out.resize(3 * static_cast<size_t>(pixels));
      filter_.apply_row(work->in.data() - first, work->out.data(), pixels, work->scratch);
      for (const double value : work->out) *out++ = static_cast<float>(value);
    }
    pool_.give(std::move(work));
  }

 private:
  struct Work {
    triad::PolyphaseScratch scratch;
    std::vector<double> in, out;
  };
  triad::PolyphaseFir<Real> filter_;
  Pool<Work> pool_;
};

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

enum class EngineChoice { kAuto, kFft, kFir };
enum class FlatField { kExact, kFree };
enum class Clipping { kClip, kUnbounded };
enum class Precision { kFloat, kDouble };

struct Platt {
  static constexpr tp::Info info{
      "platt", "1.0", "Drives the subpixels so that the error an eye sees is least",
      "The linear filter of Platt (2000), \"Optimal Filtering for Patterned Displays\": from a wide render, the "
      "drives "
      "of a panel's stripes whose light differs least from the render, weighed by how finely an eye sees each "
      "frequency of luminance, red-green and blue-yellow. With lambda=0, flat-field=free, edge=wrap and "
      "range=unbounded it is the published optimum; that asks for drives far outside [0, 1], and clipped it is worse "
      "than a plain average, which is why lambda pulls it towards the displaced box by default.\n"
      "engine=fft filters whole rows exactly. engine=fir convolves with as many cells as taps says; the report says "
      "which share of the kernel that leaves out (truncation). taps=0 takes as many as leave out at most 0.001. "
      "engine=auto takes whichever needs fewer operations; the choice depends on the parameters and the width only.\n"
      "range=clip clamps the render to [0, 1] before filtering, as an ideal panel would, and the drives after it."};
  std::string layout;
  triad::Csf csf;
  double ppd, lambda, luminance;
  FlatField flat_field;
  triad::ChannelGains channels;
  triad::Edge edge;
  EngineChoice engine;
  int taps;
  Clipping range;
  Precision precision;
  std::vector<double> origin;

  static constexpr double kOrigin[] = {0, 0};
  static constexpr double kTruncationTarget = 1e-3;  // of the kernel's absolute sum: below a step of 8 bits

  static constexpr auto params() {
    return tp::list(
        tp::text<&Platt::layout>("layout", "how the subpixels lie: rgb, bgr or the path of a layout's TOML file",
                                 {.def = "rgb"}),
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
        tp::choice<&Platt::engine, "auto", "fft", "fir">("engine", "how the filter is applied"),
        tp::integer<&Platt::taps>("taps", "cells of the convolution, an odd number; 0 chooses",
                                  {.def = 0, .min = 0, .max = 16777215, .unit = "cells"}),
        tp::choice<&Platt::range, "clip", "unbounded">("range", "whether render and drives are clamped to [0, 1]"),
        tp::choice<&Platt::precision, "float", "double">("precision",
                                                         "of the filtering; the design is always double"),
        tp::number<&Platt::luminance>("luminance", "mean luminance of the display, for csf=kolpatzik-bouman",
                                      {.def = 11, .min = .01, .max = 1e6, .unit = "cd/m2"}),
        tp::numbers<&Platt::origin>("origin", "the picture's place on the panel; all are alike for stripes",
                                    {.def = kOrigin, .max_count = 2, .unit = "px"}));
  }
  static constexpr auto inputs() { return tp::list(tp::Input{"image", "a wide render", "rgb", "linear"}); }

  struct State {
    int64_t clamped_inputs, clipped_outputs;
  };

  void create(tp::Call&) {
    display_parameters::check_origin(origin);
    if (taps > 0 && taps % 2 == 0)
      throw tp::Error(TRIAD_E_PARAM, "taps=" + std::to_string(taps) + " has no middle: " + std::to_string(taps - 1) +
                                         " or " + std::to_string(taps + 1) + " would do");
    panel_ = display_parameters::stripes(layout);
  }

  void plan(tp::PlanCall& call) {
    const triad_image& in = call.in(0);
    display_parameters::narrow(in, panel_, call.out);
    width_cells_ = in.width;
    triad::Observer observer;
    std::copy_n(in.rgb_to_xyz, 9, observer.rgb_to_xyz.begin());
    observer.ppd = ppd;
    observer.csf = csf;
    observer.gains = channels;
    observer.luminance_nits = luminance;
    display_parameters::in_library([&] { design(call, observer, call.out.width); });
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.edge = edge == triad::Edge::kMirror ? TRIAD_EDGE_MIRROR : TRIAD_EDGE_WRAP;
    // With either engine: one such value would spoil a row, or as many pixels as the kernel is long.
    call.plan.nonfinite = TRIAD_NONFINITE_ZERO;
  }

  void need(int, triad_rect out, tp::Needs& needs) const {
    const int cells = panel_.cells_x;
    needs[0] = engine_->whole_rows() ? triad_rect{0, out.y0, width_cells_, out.y1}
                                     : triad_rect{out.x0 * cells + engine_->first_cell(), out.y0,
                                                  (out.x1 - 1) * cells + engine_->last_cell() + 1, out.y1};
  }

  void strip(tp::StripCall& call, State& state) const {
    const auto in = call.in(0);
    const auto out = call.out();
    const int cells = panel_.cells_x;
    const bool clip = range == Clipping::kClip;
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
  }

  void end_pass(tp::EndCall& call, const State& state) {
    if (range != Clipping::kClip) return;
    call.report("clamped-inputs", static_cast<double>(state.clamped_inputs));
    call.report("clipped-outputs", static_cast<double>(state.clipped_outputs));
  }

 private:
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
          engine_ = std::make_unique<FirEngine<float>>(panel_.cells_x, kernels);
        } else {
          engine_ = std::make_unique<FirEngine<double>>(panel_.cells_x, kernels);
        }
        call.report("taps", count);
        call.report("truncation", response.truncation_error(count));
        return;
      }
    }
    if (precision == Precision::kFloat) {
      engine_ = std::make_unique<FftEngine<float>>(filter, width_px, edge);
    } else {
      engine_ = std::make_unique<FftEngine<double>>(filter, width_px, edge);
    }
  }

  triad::Layout panel_;
  int width_cells_ = 0;
  std::unique_ptr<Engine> engine_;
};

}  // namespace

TRIAD_PLUGIN("platt", Platt)
