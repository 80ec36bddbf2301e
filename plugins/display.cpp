// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <triad/base/text.hpp>
#include <triad/display/display_error.hpp>
#include <vector>

#include "display_parameters.hpp"

namespace {

namespace tp = triad_plugin;

enum class Mode { kRows };

struct Display {
  static constexpr tp::Info info{
      "display", "1.0", "The error that an eye sees on a display's subpixels, against a wide render",
      "The light of the panel's stripes, driven by the test picture, is compared with the wide render, three cells a "
      "pixel, after both passed an eye's contrast sensitivity in luminance, red-green and blue-yellow. rmse is the "
      "root of the mean square over pixels, rows taken one by one (Platt 2000), in linear light with white at 1. "
      "Scores of different csf, ppd or channels do not compare. The map is each pixel's root mean square.\n"
      "border leaves pixels out of the pooling at both ends of each row, where what is imagined beyond the edge "
      "shows; auto is a fifth of a degree. border=0, edge=wrap, range=unbounded is the published measure."};
  std::string layout, border;
  triad::Csf csf;
  double ppd, luminance;
  triad::ChannelGains channels;
  triad::Edge edge;
  triad::Range range;
  Mode mode;

  static constexpr auto params() {
    return tp::list(
        tp::text<&Display::layout>("layout", "how the subpixels lie: rgb, bgr or the path of a layout's TOML file",
                                   {.def = "rgb"}),
        tp::choice<&Display::csf, "scielab", "kolpatzik-bouman">("csf", "how finely an eye sees"),
        tp::number<&Display::ppd>("ppd", "pixels per degree of visual angle; 40 is 96 dpi at 60 cm",
                                  {.def = 40, .min = 1, .max = 10000, .unit = "ppd"}),
        tp::choice<&Display::channels, "gains", "raw">(
            "channels", "gains makes the three opponent channels comparably visible; raw leaves them as they are"),
        tp::choice<&Display::edge, "mirror", "wrap">("edge", "what lies beyond the ends of a row"),
        tp::text<&Display::border>("border", "pixels left out at each end of a row, a whole number or auto",
                                   {.def = "auto"}),
        tp::choice<&Display::range, "clip", "unbounded">("range",
                                                         "whether test and reference are first clamped to [0, 1]"),
        tp::choice<&Display::mode, "rows">("mode", "rows: each row for itself"),
        tp::number<&Display::luminance>("luminance", "mean luminance of the display, for csf=kolpatzik-bouman",
                                        {.def = 11, .min = .01, .max = 1e6, .unit = "cd/m2"}));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"test", "what the display is given", "rgb", "linear"},
                    tp::Input{"reference", "the wide render that it should show", "rgb", "linear"},
                    tp::Input{"mask", "weights of the pixels", "mask", nullptr, TRIAD_INPUT_OPTIONAL});
  }
  static constexpr auto scores() {
    return tp::list(tp::Score{"rmse", "root of the mean squared visible error", nullptr, -1});
  }

  using State = triad::DisplayTotals;

  void create(tp::Call&) {
    panel_ = display_parameters::stripes(layout);
    if (border == "auto") return;
    const auto value = triad::parse_int(border);
    if (!value || *value < 0 || *value > 1 << 26)
      throw tp::Error(TRIAD_E_PARAM, "border is '" + border + "': auto or a whole number of pixels from 0 is needed");
    border_px_ = static_cast<int>(*value);
  }

  void plan(tp::PlanCall& call) {
    const triad_image &test = call.in(0), &reference = call.in(1);
    if (int64_t{test.width} * panel_.cells_x != reference.width || test.height != reference.height)
      throw tp::Error(TRIAD_E_INPUT,
                      "the test picture is " + display_parameters::size_text(test) + " and the reference " +
                          display_parameters::size_text(reference) + "; the reference must be a wide render of " +
                          std::to_string(int64_t{test.width} * panel_.cells_x) + "x" + std::to_string(test.height));
    if (test.cells_x != 1 || test.cells_y != 1)
      throw tp::Error(TRIAD_E_INPUT, "the test picture has " + std::to_string(test.cells_x) + "x" +
                                         std::to_string(test.cells_y) +
                                         " cells a pixel; a picture for the display has one");
    for (int i = 0; i < 9; ++i)
      if (!(std::abs(test.rgb_to_xyz[i] - reference.rgb_to_xyz[i]) < 1e-4))
        throw tp::Error(TRIAD_E_INPUT, "test and reference have different primaries; bring them to one colour space");
    triad::Observer observer;
    std::copy_n(test.rgb_to_xyz, 9, observer.rgb_to_xyz.begin());
    observer.ppd = ppd;
    observer.csf = csf;
    observer.gains = channels;
    observer.luminance_nits = luminance;
    if (border == "auto") border_px_ = triad::automatic_border_px(ppd, test.width);
    if (2 * int64_t{border_px_} >= test.width)
      throw tp::Error(TRIAD_E_PARAM, "border=" + std::to_string(border_px_) + " leaves nothing of a width of " +
                                         std::to_string(test.width) + ": at most " +
                                         std::to_string((test.width - 1) / 2) + " is possible");
    width_px_ = test.width;
    measure_ = display_parameters::in_library(
        [&] { return std::make_unique<triad::DisplayError>(panel_, observer, width_px_, edge, range); });
    call.report("border", border_px_);
    call.out.channels = 1;
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.nonfinite = TRIAD_NONFINITE_ZERO;
  }

  void need(int, triad_rect out, tp::Needs& needs) const {
    needs[0] = {0, out.y0, width_px_, out.y1};
    needs[1] = {0, out.y0, width_px_ * panel_.cells_x, out.y1};
  }

  void strip(tp::StripCall& call, State& state) const {
    triad::DisplayError::Workspace workspace(*measure_);
    const auto energy = call.scratch<double>(3 * static_cast<size_t>(width_px_));
    const int x0 = std::max(call.r.x0, border_px_), x1 = std::min(call.r.x1, width_px_ - border_px_);
    for (int y = call.r.y0; y < call.r.y1; ++y) {
      const auto clamped = measure_->row(call.in(0).row(y), call.in(1).row(y), energy.data(), workspace);
      state.clamped_test_pixels += clamped.test_pixels;
      state.clamped_target_cells += clamped.target_cells;
      state.add_pixels(energy.data(), call.has(2) ? call.in(2).at(0, y) : nullptr, x0, x1);
      if (!call.has_out()) continue;
      float* to = call.out().row(y);
      for (int x = call.r.x0; x < call.r.x1; ++x) {
        const double* e = &energy[3 * static_cast<size_t>(x)];
        *to++ = static_cast<float>(std::sqrt(e[0] + e[1] + e[2]));
      }
    }
  }

  void merge(int, State& into, const State& from) const { into.merge(from); }

  void end_pass(tp::EndCall& call, const State& totals) {
    if (!(totals.weight.value() > 0))
      throw tp::Error(TRIAD_E_INPUT, "every pixel is left out by the mask, the crop or the border");
    call.scores[0] = totals.rmse();
    static constexpr const char* kShares[] = {"share-luminance", "share-red-green", "share-blue-yellow"};
    for (int c = 0; c < 3; ++c) call.report(kShares[c], totals.share(c));
    if (range != triad::Range::kClip) return;
    call.report("clamped-test-pixels", static_cast<double>(totals.clamped_test_pixels));
    call.report("clamped-reference-cells", static_cast<double>(totals.clamped_target_cells));
  }

 private:
  triad::Layout panel_;
  int border_px_ = 0, width_px_ = 0;
  std::unique_ptr<triad::DisplayError> measure_;
};

}  // namespace

TRIAD_PLUGIN("display", Display)
