// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <string>
#include <triad/display/eye.hpp>
#include <vector>

#include "seeing_parameters.hpp"

namespace {

namespace tp = triad_plugin;
namespace sp = seeing_parameters;

struct EyeFilter {
  static constexpr tp::Info info{
      "eye", "1.0", "What an observer at a distance sees of a picture on a panel",
      "A picture for the display is shown through the layout's emitters; a wide picture, with the layout's cells a "
      "pixel, is taken as the light itself. Then luminance, red-green and blue-yellow each lose the detail that an "
      "eye "
      "loses at ppd pixels per degree, and the result is linear light again, to be looked at from near. Flat colours "
      "stay what they are. Values may lie a little outside [0, 1], where colour is blurred more than lightness.\n"
      "grid=pixels gives a pixel for each pixel of the display, the mean of its cells, for people; grid=cells keeps "
      "the fine grid.\n"
      "space=neutral counts as colour what differs from the grey of the same luminance, so that greys stay grey. "
      "space=opponent takes the channels of the metric display as they are, in which white is a little coloured and "
      "black and white edges get tinted halos; with it and grid=cells, a view of the wide render and one of what a "
      "filter made of it differ by what the metric measures.\n"
      "Looks at the whole picture: about 60 bytes of memory a cell, half with edge=wrap."};
  std::string layout;
  triad::Csf csf;
  double ppd, luminance;
  triad::Edge edge;
  triad::EyeGrid grid;
  triad::EyeSpace space;
  triad::Range range;
  std::vector<double> origin;

  static constexpr double kOrigin[] = {0, 0};
  static constexpr auto params() {
    return tp::list(
        tp::text<&EyeFilter::layout>("layout", sp::kLayoutDoc, {.def = "auto"}),
        tp::number<&EyeFilter::ppd>("ppd", "pixels per degree of visual angle; 40 is 96 dpi at 60 cm",
                                    {.def = 40, .min = 1, .max = 10000, .unit = "ppd"}),
        tp::choice<&EyeFilter::csf, "scielab", "kolpatzik-bouman">("csf", "how finely an eye sees"),
        tp::choice<&EyeFilter::grid, "pixels", "cells">("grid", "what a pixel of the result stands for"),
        tp::choice<&EyeFilter::space, "neutral", "opponent">("space", "what counts as colour"),
        tp::choice<&EyeFilter::edge, "mirror", "wrap">("edge", "what lies beyond the picture"),
        tp::choice<&EyeFilter::range, "clip", "unbounded">("range", "whether values are first clamped to [0, 1]"),
        tp::number<&EyeFilter::luminance>("luminance", "mean luminance of the display, for csf=kolpatzik-bouman",
                                          {.def = 11, .min = .01, .max = 1e6, .unit = "cd/m2"}),
        tp::numbers<&EyeFilter::origin>("origin", "the picture's place on a panel that repeats after several pixels",
                                        {.def = kOrigin, .max_count = 2, .unit = "px"}));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"image", "a picture for the display, or a wide one", "rgb", "linear"});
  }

  void create(tp::Call&) { display_parameters::check_origin(origin); }

  void plan(tp::PlanCall& call) {
    call.erase_meta(sp::kLayoutKey);  // what comes out is light, and no panel's drives
    call.erase_meta(sp::kOriginKey);
    const triad_image& in = call.in(0);
    const triad::Layout panel = sp::choose_panel(layout, {call.get_meta(0, sp::kLayoutKey)});
    wide_ = in.cells_x == panel.cells_x && in.cells_y == panel.cells_y;
    const std::string needed = sp::cells_text(panel.cells_x, panel.cells_y);
    if (!wide_ && (in.cells_x != 1 || in.cells_y != 1))
      throw tp::Error(TRIAD_E_INPUT, "the picture has " + sp::cells_text(in.cells_x, in.cells_y) +
                                         " cells a pixel; for layout " + panel.name + " it must have one, or " +
                                         needed);
    if (wide_ && (in.width % panel.cells_x != 0 || in.height % panel.cells_y != 0))
      throw tp::Error(TRIAD_E_INPUT, "the picture of " + display_parameters::size_text(in) +
                                         " is no whole number of pixels of " + needed + " cells");
    const triad::PanelTorus::Shape shape{wide_ ? in.width / panel.cells_x : in.width,
                                         wide_ ? in.height / panel.cells_y : in.height,
                                         sp::origin_on(call, origin, panel).x_px,
                                         sp::origin_on(call, origin, panel).y_px,
                                         edge,
                                         false};
    triad::Observer observer;
    std::copy_n(in.rgb_to_xyz, 9, observer.rgb_to_xyz.begin());
    observer.ppd = ppd;
    observer.csf = csf;
    observer.luminance_nits = luminance;
    eye_ = display_parameters::in_library(
        [&] { return std::make_unique<triad::Eye>(panel, observer, shape, grid, space); });
    const bool cells = grid == triad::EyeGrid::kCells;
    call.out.width = eye_->width();
    call.out.height = eye_->height();
    call.out.cells_x = cells ? panel.cells_x : 1;
    call.out.cells_y = cells ? panel.cells_y : 1;
    call.out.pixel_aspect = in.pixel_aspect * in.cells_x / in.cells_y * call.out.cells_y / call.out.cells_x;
    width_ = in.width;
    height_ = in.height;
    call.plan.nonfinite = TRIAD_NONFINITE_ZERO;
    call.plan.strip_rows = -1;
    call.work_bytes(eye_->work_bytes() + (range == triad::Range::kClip && !wide_ ? 3 * sizeof(float) * pixels() : 0));
  }

  void need(int, triad_rect, tp::Needs& needs) const { needs[0] = {0, 0, width_, height_}; }

  void strip(tp::StripCall& call) const {
    const triad::PictureView in = sp::rows_from(call.in(0), 0);
    const auto out = call.out();
    const triad::PanelTorus& torus = eye_->torus();
    const ptrdiff_t stride = out.height() > 1 ? out.row(1) - out.row(0) : out.row_floats();
    if (wide_) return eye_->look(torus.target(in, range), out.row(0), stride);
    if (range == triad::Range::kUnbounded) return eye_->look(torus.panel(in), out.row(0), stride);
    std::vector<float> clamped(3 * pixels());
    const ptrdiff_t row = 3 * static_cast<ptrdiff_t>(width_);
    for (int y = 0; y < height_; ++y)
      std::transform(in.row(y), in.row(y) + row, clamped.data() + y * row,
                     [](float v) { return std::clamp(v, 0.f, 1.f); });
    eye_->look(torus.panel({clamped.data(), row}), out.row(0), stride);
  }

 private:
  size_t pixels() const { return static_cast<size_t>(width_) * static_cast<size_t>(height_); }

  bool wide_ = false;
  int width_ = 0, height_ = 0;
  std::unique_ptr<triad::Eye> eye_;
};

}  // namespace

TRIAD_PLUGIN("eye", EyeFilter)
