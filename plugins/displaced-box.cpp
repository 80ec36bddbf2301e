// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <string>
#include <triad/display/displaced_box.hpp>
#include <triad/display/torus.hpp>
#include <vector>

#include "driven_panel.hpp"

namespace {

namespace tp = triad_plugin;

enum class Displayed { kClip, kUnbounded };

struct Box {
  static constexpr tp::Info info{
      "displaced-box", "1.1", "Averages a pixel's size around each subpixel",
      "The red of a pixel is the mean red of the render over a pixel's width and height around the place where that "
      "pixel's red subpixel lies, and so on: cheap, within the range of the render, constant colours exact. It is "
      "where "
      "platt starts. Where a panel derives its white from the other three (rwbg), all are taken around the pixel's "
      "middle. Channels that drive nothing (pentile-rgbg) are 0."};
  std::string layout;
  triad::Edge edge;
  Displayed range;
  std::vector<double> origin;

  static constexpr auto params() {
    return tp::list(tp::text<&Box::layout>("layout", seeing_parameters::kLayoutDoc, {.def = "auto"}),
                    tp::choice<&Box::edge, "mirror", "wrap">("edge", "what lies beyond the borders"),
                    tp::choice<&Box::range, "clip", "unbounded">(
                        "range", "whether the render is clamped to [0, 1] first, as an ideal panel would"),
                    tp::numbers<&Box::origin>("origin", display_parameters::kOriginDoc,
                                              {.def = display_parameters::kOrigin, .max_count = 2, .unit = "px"}));
  }
  static constexpr auto inputs() { return tp::list(tp::Input{"image", "a wide render", "rgb", "linear"}); }

  void create(tp::Call&) { display_parameters::check_origin(origin); }

  void plan(tp::PlanCall& call) {
    panel_ = driven_panel::plan_for(call, layout);
    box_ = std::make_unique<triad::DisplacedBox>(panel_);
    order_ = std::make_unique<triad::DriveOrder>(panel_);
    const auto phase = seeing_parameters::origin_on(call, origin, panel_);
    phase_x_ = phase.x_px;
    phase_y_ = phase.y_px;
    tiles_ = (call.out.width + phase_x_ + panel_.tile_x - 1) / panel_.tile_x;
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.edge = edge == triad::Edge::kMirror ? TRIAD_EDGE_MIRROR : TRIAD_EDGE_WRAP;
  }

  void need(int, triad_rect out, tp::Needs& needs) const {
    const int first = first_cell_row(tile_row(out.y0)), last = first_cell_row(tile_row(out.y1 - 1));
    const int start = -phase_x_ * panel_.cells_x;
    needs[0] = {start - box_->left(), first - box_->above(),
                start + (tiles_ - 1) * panel_.tile_x * panel_.cells_x + box_->right(), last + box_->below()};
  }

  void strip(tp::StripCall& call) const {
    const auto in = call.in(0);
    const auto out = call.out();
    const ptrdiff_t floats = in.row_floats();
    const bool clip = range == Displayed::kClip;
    const auto clamped = call.scratch<float>(clip ? static_cast<size_t>(floats * in.height()) : 0);
    if (clip)
      for (int y = in.r.y0; y < in.r.y1; ++y) {
        const float* from = in.row(y);
        float* to = clamped.data() + (y - in.r.y0) * floats;
        for (ptrdiff_t i = 0; i < floats; ++i) to[i] = from[i] < 0 ? 0 : from[i] > 1 ? 1 : from[i];
      }
    const auto cell_row = [&](int y) { return clip ? clamped.data() + (y - in.r.y0) * floats : in.row(y); };

    std::vector<const float*> rows(static_cast<size_t>(box_->above() + box_->below()));
    std::vector<float> drives(panel_.emitters.size() * static_cast<size_t>(tiles_));
    std::vector<float> pixels(3 * static_cast<size_t>(tiles_) * panel_.tile_x);
    for (int tile = tile_row(call.r.y0); tile <= tile_row(call.r.y1 - 1); ++tile) {
      for (size_t k = 0; k < rows.size(); ++k)
        rows[k] = cell_row(first_cell_row(tile) - box_->above() + static_cast<int>(k)) + 3 * box_->left();
      box_->tiles(rows.data(), tiles_, drives.data(), tiles_);
      for (int p = 0; p < panel_.tile_y; ++p) {
        const int y = tile * panel_.tile_y - phase_y_ + p;
        if (y < call.r.y0 || y >= call.r.y1) continue;
        order_->pixels(drives.data(), tiles_, tiles_, p, pixels.data());
        std::copy_n(pixels.data() + 3 * static_cast<ptrdiff_t>(phase_x_ + call.r.x0), out.row_floats(), out.row(y));
      }
    }
  }

 private:
  int tile_row(int y) const { return (y + phase_y_) / panel_.tile_y; }
  int first_cell_row(int tile) const { return (tile * panel_.tile_y - phase_y_) * panel_.cells_y; }

  triad::Layout panel_;
  std::unique_ptr<triad::DisplacedBox> box_;
  std::unique_ptr<triad::DriveOrder> order_;
  int phase_x_ = 0, phase_y_ = 0, tiles_ = 0;
};

}  // namespace

TRIAD_PLUGIN("displaced-box", Box)
