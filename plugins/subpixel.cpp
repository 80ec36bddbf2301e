// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "driven_panel.hpp"

namespace {

namespace tp = triad_plugin;

struct Subpixel {
  static constexpr tp::Info info{
      "subpixel", "1.1", "Takes each subpixel's colour from the place where it lies",
      "The red of a pixel comes from the cell of the wide render that the display's red stripe covers, and so on: "
      "sharp, and full of coloured fringes. Nothing is averaged, so values are taken as they are stored."};
  std::string layout;
  std::vector<double> origin;

  static constexpr double kOrigin[] = {0, 0};
  static constexpr auto params() {
    return tp::list(
        tp::text<&Subpixel::layout>("layout",
                                    "how the subpixels lie: rgb, bgr or the path of a layout's TOML file; auto takes "
                                    "the one that the picture names, else rgb",
                                    {.def = "auto"}),
        tp::numbers<&Subpixel::origin>("origin", "the picture's place on the panel; all are alike for stripes",
                                       {.def = kOrigin, .max_count = 2, .unit = "px"}));
  }
  static constexpr auto inputs() { return tp::list(tp::Input{"image", "a wide render", "rgb"}); }

  void create(tp::Call&) { display_parameters::check_origin(origin); }

  void plan(tp::PlanCall& call) {
    const triad::Layout panel = driven_panel::plan_for(call, layout);
    display_parameters::in_library([&] { triad::require_rows(panel); });
    for (int c = 0; c < 3; ++c) {
      const triad::Emitter& emitter = panel.emitters[panel.emitter_of(c)];
      if (emitter.cells.size() != 1)
        throw tp::Error(TRIAD_E_PARAM, "layout " + panel.name + " has subpixels of several cells; its " +
                                           emitter.name + " must lie in one to be taken from there");
      cell_[c] = emitter.cells[0].x;
    }
    cells_ = panel.cells_x;
    call.plan.threads = TRIAD_REENTRANT;
  }

  void need(int, triad_rect out, tp::Needs& needs) const {
    needs[0] = {out.x0 * cells_, out.y0, out.x1 * cells_, out.y1};
  }

  void strip(tp::StripCall& call) const {
    const auto in = call.in(0);
    const auto out = call.out();
    for (int y = call.r.y0; y < call.r.y1; ++y) {
      const float* from = in.at(call.r.x0 * cells_, y);
      float* to = out.row(y);
      for (int x = call.r.x0; x < call.r.x1; ++x, from += 3 * cells_, to += 3)
        for (int c = 0; c < 3; ++c) to[c] = from[3 * cell_[c] + c];
    }
  }

 private:
  int cells_ = 3, cell_[3] = {0, 1, 2};
};

}  // namespace

TRIAD_PLUGIN("subpixel", Subpixel)
