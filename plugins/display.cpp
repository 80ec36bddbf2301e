// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <triad/base/text.hpp>
#include <triad/display/display_error.hpp>
#include <vector>

#include "seeing_parameters.hpp"

namespace {

namespace tp = triad_plugin;
namespace sp = seeing_parameters;

enum class Mode { kAuto, kRows, kPlane };

// Delta E of a small luminance error at white: the norm of CIELAB's gradient there in units of linear light.
constexpr double kDeltaEPerRmse = 53;

struct Display {
  static constexpr tp::Info info{
      "display", "1.1", "The error that an eye sees on a display's subpixels, against a wide render",
      "The light of the panel's emitters, driven by the test picture, is compared with the wide render of as many "
      "cells a pixel as the layout has, after both passed an eye's contrast sensitivity in luminance, red-green and "
      "blue-yellow. rmse is the root of the mean square over pixels, in linear light with white at 1. Scores of "
      "different csf, ppd, channels, modes or layouts do not compare. The map is each pixel's root mean square.\n"
      "mode=rows takes each row for itself (Platt 2000) and streams; mode=plane looks at the whole picture, which "
      "takes about 60 bytes of memory a cell, with edge=wrap about half. They agree on pictures that are constant in "
      "y. auto is rows for panels of vertical stripes, plane for any other.\n"
      "A reference of the test's own size is taken for a picture on the same panel: the error is the difference that "
      "an eye sees between the two, and ratio, over a pixel average that the reference itself is, is infinite unless "
      "they look alike.\n"
      "ratio is rmse over that of the pixel average, conventional antialiasing without a limit of samples. fringe is "
      "the share of the error (of its square) in the two colour channels. delta-e and delta-e-p95 are the mean and "
      "the 95th percentile over pixels of S-CIELAB, the panel's light against the render's; in mode=rows each row "
      "counts as a picture that is constant in y.\n"
      "border leaves pixels out of the pooling, at both ends of each row and, in the plane, column: there, what is "
      "imagined beyond the edge shows; auto is a fifth of a degree. mode=rows, border=0, edge=wrap, range=unbounded "
      "is the published measure."};
  std::string layout, border;
  triad::Csf csf;
  double ppd, luminance;
  triad::ChannelGains channels;
  triad::Edge edge;
  triad::Range range;
  Mode mode;
  std::vector<double> origin;

  static constexpr double kOrigin[] = {0, 0};
  static constexpr auto params() {
    return tp::list(
        tp::text<&Display::layout>("layout", sp::kLayoutDoc, {.def = "auto"}),
        tp::choice<&Display::csf, "scielab", "kolpatzik-bouman">("csf", "how finely an eye sees"),
        tp::number<&Display::ppd>("ppd", "pixels per degree of visual angle; 40 is 96 dpi at 60 cm",
                                  {.def = 40, .min = 1, .max = 10000, .unit = "ppd"}),
        tp::choice<&Display::channels, "gains", "raw">(
            "channels", "gains makes the three opponent channels comparably visible; raw leaves them as they are"),
        tp::choice<&Display::edge, "mirror", "wrap">("edge", "what lies beyond the picture"),
        tp::text<&Display::border>("border", "pixels left out along the edges, a whole number or auto",
                                   {.def = "auto"}),
        tp::choice<&Display::range, "clip", "unbounded">("range",
                                                         "whether test and reference are first clamped to [0, 1]"),
        tp::choice<&Display::mode, "auto", "rows", "plane">("mode", "each row for itself, or the whole picture"),
        tp::number<&Display::luminance>("luminance", "mean luminance of the display, for csf=kolpatzik-bouman",
                                        {.def = 11, .min = .01, .max = 1e6, .unit = "cd/m2"}),
        tp::numbers<&Display::origin>("origin", "the picture's place on a panel that repeats after several pixels",
                                      {.def = kOrigin, .max_count = 2, .unit = "px"}));
  }
  static constexpr auto inputs() {
    return tp::list(
        tp::Input{"test", "what the display is given", "rgb", "linear"},
        tp::Input{"reference", "the wide render that it should show, or a picture of its own size", "rgb", "linear"},
        tp::Input{"mask", "weights of the pixels", "mask", nullptr, TRIAD_INPUT_OPTIONAL});
  }
  static constexpr auto scores() {
    return tp::list(
        tp::Score{"rmse", "root of the mean squared visible error", nullptr, -1},
        tp::Score{"ratio", "rmse over that of the pixel average", nullptr, -1, TRIAD_SCORE_MAY_BE_INFINITE},
        tp::Score{"fringe", "share of the squared error that is colour", nullptr, -1},
        tp::Score{"delta-e", "mean S-CIELAB difference", "dE", -1},
        tp::Score{"delta-e-p95", "S-CIELAB difference that 95% of the pixels stay below", "dE", -1});
  }

  struct State {
    triad::DisplayTotals shown, average;
    triad::DeltaTotals delta_e;
  };

  void create(tp::Call&) {
    display_parameters::check_origin(origin);
    if (border == "auto") return;
    const auto value = triad::parse_int(border);
    if (!value || *value < 0 || *value > 1 << 26)
      throw tp::Error(TRIAD_E_PARAM, "border is '" + border + "': auto or a whole number of pixels from 0 is needed");
    border_x_ = border_y_ = static_cast<int>(*value);
  }

  void plan(tp::PlanCall& call) {
    const triad_image &test = call.in(0), &reference = call.in(1);
    const triad::Layout panel =
        sp::choose_panel(layout, {call.get_meta(0, sp::kLayoutKey), call.get_meta(1, sp::kLayoutKey)});
    check_pictures(test, reference, panel);
    rows_ = mode == Mode::kRows || (mode == Mode::kAuto && panel.has_independent_rows());
    const auto shown_from = sp::origin_on(call, origin, panel);
    triad::Observer observer;
    std::copy_n(test.rgb_to_xyz, 9, observer.rgb_to_xyz.begin());
    observer.ppd = ppd;
    observer.csf = csf;
    observer.gains = channels;
    observer.luminance_nits = luminance;
    width_px_ = test.width;
    height_px_ = test.height;
    const bool same_panel = reference.width == test.width && reference.height == test.height;
    cells_x_ = same_panel ? 1 : panel.cells_x;
    cells_y_ = same_panel ? 1 : panel.cells_y;
    has_average_ = !same_panel;
    plan_border();
    const triad::PanelTorus::Shape shape{test.width, rows_ ? 1 : test.height, shown_from.x_px, shown_from.y_px, edge,
                                         rows_};
    measure_ = display_parameters::in_library([&] {
      using Target = triad::DisplayError::Target;
      return std::make_unique<triad::DisplayError>(panel, observer, shape, range,
                                                   same_panel ? Target::kDrives : Target::kCells);
    });
    call.report("border", border_x_);
    call.out.channels = 1;
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.nonfinite = TRIAD_NONFINITE_ZERO;
    if (!rows_) call.plan.strip_rows = -1;
    call.work_bytes(measure_->workspace_bytes() + measure_->perceived_workspace_bytes() +
                    static_cast<uint64_t>(width_px_) * static_cast<uint64_t>(shape.height_px) * Work::kBytesPerPixel);
  }

  void need(int, triad_rect out, tp::Needs& needs) const {
    needs[0] = {0, out.y0, width_px_, out.y1};
    needs[1] = {0, out.y0 * cells_y_, width_px_ * cells_x_, out.y1 * cells_y_};
  }

  void strip(tp::StripCall& call, State& state) const {
    Work work(*measure_);
    const int step = rows_ ? 1 : height_px_;
    for (int y = call.r.y0; y < call.r.y1; y += step) {
      judge(call, sp::rows_from(call.in(0), y), sp::rows_from(call.in(1), y * cells_y_), y, state, work);
    }
  }

  void merge(int, State& into, const State& from) const {
    into.shown.merge(from.shown);
    into.average.merge(from.average);
    into.delta_e.merge(from.delta_e);
  }

  void end_pass(tp::EndCall& call, const State& totals) {
    if (!(totals.shown.weight.value() > 0))
      throw tp::Error(TRIAD_E_INPUT, "every pixel is left out by the mask, the crop or the border");
    const double rmse = totals.shown.rmse(), average = totals.average.rmse();
    call.scores[0] = rmse;
    call.scores[1] = rmse == average ? 1 : rmse / average;
    call.scores[2] = totals.shown.share(1) + totals.shown.share(2);
    call.scores[3] = totals.delta_e.mean();
    call.scores[4] = totals.delta_e.percentile(.95);
    static constexpr const char* kShares[] = {"share-luminance", "share-red-green", "share-blue-yellow"};
    for (int c = 0; c < 3; ++c) call.report(kShares[c], totals.shown.share(c));
    call.report("pixel-average-rmse", average);
    call.report("rmse-as-delta-e", kDeltaEPerRmse * rmse);
    if (range != triad::Range::kClip) return;
    call.report("clamped-test-pixels", static_cast<double>(totals.shown.clamped_test_pixels));
    call.report("clamped-reference-cells", static_cast<double>(totals.shown.clamped_target_cells));
  }

 private:
  // What is found out of the rows that are measured together.
  struct Work {
    static constexpr size_t kBytesPerPixel = 7 * sizeof(double) + 3 * sizeof(float);
    explicit Work(const triad::DisplayError& measure)
        : error(measure),
          perceived(measure),
          energy(3 * pixels(measure)),
          average_energy(energy.size()),
          delta_e(pixels(measure)),
          average(energy.size()) {}
    static size_t pixels(const triad::DisplayError& m) {
      return static_cast<size_t>(m.width_px()) * static_cast<size_t>(m.height_px());
    }
    triad::DisplayError::Workspace error;
    triad::DisplayError::PerceivedWorkspace perceived;
    std::vector<double> energy, average_energy, delta_e;
    std::vector<float> average;
  };

  // The rows from y0 on that are measured together.
  void judge(tp::StripCall& call, const triad::PictureView& test, const triad::PictureView& target, int y0,
             State& state, Work& work) const {
    const auto clamped = measure_->picture(test, target, work.energy.data(), work.error);
    state.shown.clamped_test_pixels += clamped.test_pixels;
    state.shown.clamped_target_cells += clamped.target_cells;
    call.progress(.25);
    if (has_average_) {
      measure_->pixel_average(target, work.average.data());
      measure_->picture({work.average.data(), 3 * static_cast<ptrdiff_t>(width_px_)}, target,
                        work.average_energy.data(), work.error);
    }
    call.progress(.5);
    measure_->delta_e(test, target, work.delta_e.data(), work.perceived);
    const int x0 = std::max(call.r.x0, border_x_), x1 = std::min(call.r.x1, width_px_ - border_x_);
    for (int i = 0; i < measure_->height_px(); ++i) {
      const int y = y0 + i;
      const size_t first = static_cast<size_t>(i) * static_cast<size_t>(width_px_);
      const double* energy = &work.energy[3 * first];
      if (y >= border_y_ && y < height_px_ - border_y_) {
        const float* mask = call.has(2) ? call.in(2).at(0, y) : nullptr;
        state.shown.add_pixels(energy, mask, x0, x1);
        state.average.add_pixels(&work.average_energy[3 * first], mask, x0, x1);
        for (int x = x0; x < x1; ++x)
          state.delta_e.add(work.delta_e[first + static_cast<size_t>(x)], mask ? static_cast<double>(mask[x]) : 1);
      }
      if (!call.has_out()) continue;
      float* to = call.out().row(y);
      for (int x = call.r.x0; x < call.r.x1; ++x) {
        const double* e = energy + 3 * static_cast<ptrdiff_t>(x);
        *to++ = static_cast<float>(std::sqrt(e[0] + e[1] + e[2]));
      }
    }
  }

  void check_pictures(const triad_image& test, const triad_image& reference, const triad::Layout& panel) const {
    const std::string needed = sp::cells_text(panel.cells_x, panel.cells_y);
    if (test.cells_x != 1 || test.cells_y != 1)
      throw tp::Error(TRIAD_E_INPUT, "the test picture has " + sp::cells_text(test.cells_x, test.cells_y) +
                                         " cells a pixel; a picture for the display has one");
    // One whose header says nothing of cells may be a wide render all the same: its size tells.
    if ((reference.cells_x != 1 || reference.cells_y != 1) &&
        (reference.cells_x != panel.cells_x || reference.cells_y != panel.cells_y))
      throw tp::Error(TRIAD_E_INPUT, "the reference has " + sp::cells_text(reference.cells_x, reference.cells_y) +
                                         " cells a pixel, and layout " + panel.name + " needs " + needed +
                                         "; render it with --cells " + panel.name + " or name its layout");
    if (reference.width == test.width && reference.height == test.height && reference.cells_x == 1 &&
        reference.cells_y == 1)
      return check_primaries(test, reference);
    const int64_t width = int64_t{test.width} * panel.cells_x, height = int64_t{test.height} * panel.cells_y;
    if (width != reference.width || height != reference.height)
      throw tp::Error(TRIAD_E_INPUT, "the test picture is " + display_parameters::size_text(test) +
                                         " and the reference " + display_parameters::size_text(reference) +
                                         "; for layout " + panel.name + " the reference must be a wide render of " +
                                         std::to_string(width) + "x" + std::to_string(height) +
                                         ", or a picture of the test's own size");
    check_primaries(test, reference);
  }

  static void check_primaries(const triad_image& test, const triad_image& reference) {
    for (int i = 0; i < 9; ++i)
      if (!(std::abs(test.rgb_to_xyz[i] - reference.rgb_to_xyz[i]) < 1e-4))
        throw tp::Error(TRIAD_E_INPUT, "test and reference have different primaries; bring them to one colour space");
  }

  void plan_border() {
    if (border == "auto") {
      border_x_ = triad::automatic_border_px(ppd, width_px_);
      border_y_ = triad::automatic_border_px(ppd, height_px_);
    }
    if (rows_) border_y_ = 0;
    const bool wide = 2 * int64_t{border_x_} >= width_px_;
    if (!wide && 2 * int64_t{border_y_} < height_px_) return;
    const int size = wide ? width_px_ : height_px_;
    throw tp::Error(TRIAD_E_PARAM, "border=" + border + " leaves nothing of a " + (wide ? "width" : "height") +
                                       " of " + std::to_string(size) + ": at most " + std::to_string((size - 1) / 2) +
                                       " is possible");
  }

  bool rows_ = true, has_average_ = true;
  int border_x_ = 0, border_y_ = 0, width_px_ = 0, height_px_ = 0, cells_x_ = 1, cells_y_ = 1;
  std::unique_ptr<triad::DisplayError> measure_;
};

}  // namespace

TRIAD_PLUGIN("display", Display)
