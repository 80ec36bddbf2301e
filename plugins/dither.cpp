// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <string>
#include <triad/display/dither.hpp>
#include <vector>

#include "seeing_parameters.hpp"

namespace {

namespace tp = triad_plugin;
namespace sp = seeing_parameters;

enum class Stored { kSrgb, kLinear };

struct DitherFilter {
  static constexpr tp::Info info{
      "dither", "1.0", "Rounds to the codes of a file so that an eye sees the least of it",
      "For the end of a chain whose picture is stored in few bits, as in platt dither -o out.png. Every value "
      "becomes "
      "one of the two codes around it; values that are codes already stay.\n"
      "mode=perceptual chooses, drive after drive, the code with which the panel's light, as an eye at ppd pixels "
      "per "
      "degree sees it, differs least from that of the picture; later passes revise the choices in the light of the "
      "others. mode=ordered goes up or down by an 8 x 8 pattern, mode=none to the nearest code as a file would. "
      "Judge it by the metric display on the stored file.\n"
      "levels says what the codes stand for: those of PNG and JPEG follow the sRGB curve. Write with --depth 16 for "
      "bits above 8. Looks at the whole picture; about 36 bytes of memory a pixel."};
  std::string layout;
  triad::Dither mode;
  int bits, passes, radius;
  Stored stored;
  triad::Csf csf;
  double ppd, luminance;
  triad::ChannelGains channels;
  std::vector<double> origin;

  static constexpr double kOrigin[] = {0, 0};
  static constexpr auto params() {
    return tp::list(
        tp::text<&DitherFilter::layout>("layout", sp::kLayoutDoc, {.def = "auto"}),
        tp::choice<&DitherFilter::mode, "none", "ordered", "perceptual">("mode", "how codes are chosen",
                                                                         {.def = "perceptual"}),
        tp::integer<&DitherFilter::bits>("bits", "of a stored value",
                                         {.def = 8, .min = 1, .max = 16, .unit = "bits"}),
        tp::choice<&DitherFilter::stored, "srgb", "linear">("levels", "what the codes stand for"),
        tp::number<&DitherFilter::ppd>("ppd", "pixels per degree of visual angle; 40 is 96 dpi at 60 cm",
                                       {.def = 40, .min = 1, .max = 10000, .unit = "ppd"}),
        tp::choice<&DitherFilter::csf, "scielab", "kolpatzik-bouman">("csf", "how finely an eye sees"),
        tp::choice<&DitherFilter::channels, "gains", "raw">(
            "channels", "gains makes the three opponent channels comparably visible; raw leaves them as they are"),
        tp::integer<&DitherFilter::passes>("passes", "over the picture: the first decides, the others revise",
                                           {.def = 3, .min = 1, .max = 16}),
        tp::integer<&DitherFilter::radius>("radius",
                                           "how far a drive's light is followed; 0 is .15 degrees, 3 to 10 px",
                                           {.def = 0, .min = 0, .max = 16, .unit = "px"}),
        tp::number<&DitherFilter::luminance>("luminance", "mean luminance of the display, for csf=kolpatzik-bouman",
                                             {.def = 11, .min = .01, .max = 1e6, .unit = "cd/m2"}),
        tp::numbers<&DitherFilter::origin>("origin",
                                           "the picture's place on a panel that repeats after several pixels",
                                           {.def = kOrigin, .max_count = 2, .unit = "px"}));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"image", "a picture for the display", "rgb", "linear"});
  }

  void create(tp::Call&) { display_parameters::check_origin(origin); }

  void plan(tp::PlanCall& call) {
    const triad_image& in = call.in(0);
    if (in.cells_x != 1 || in.cells_y != 1)
      throw tp::Error(TRIAD_E_INPUT, "the picture has " + sp::cells_text(in.cells_x, in.cells_y) +
                                         " cells a pixel; a picture for the display has one");
    const triad::Layout panel = sp::choose_panel(layout, {call.get_meta(0, sp::kLayoutKey)});
    const auto at = sp::origin_on(call, origin, panel);
    triad::Observer observer;
    std::copy_n(in.rgb_to_xyz, 9, observer.rgb_to_xyz.begin());
    observer.ppd = ppd;
    observer.csf = csf;
    observer.gains = channels;
    observer.luminance_nits = luminance;
    dither_ = display_parameters::in_library([&] {
      return std::make_unique<triad::PanelDither>(
          panel, observer, at.x_px, at.y_px,
          stored == Stored::kSrgb ? triad::srgb_levels(bits) : triad::linear_levels(bits),
          triad::DitherOptions{mode, passes, radius});
    });
    width_ = in.width;
    height_ = in.height;
    call.plan.nonfinite = TRIAD_NONFINITE_ZERO;
    call.plan.strip_rows = -1;
    call.work_bytes(dither_->work_bytes(width_, height_));
  }

  void need(int, triad_rect, tp::Needs& needs) const { needs[0] = {0, 0, width_, height_}; }

  void strip(tp::StripCall& call) const {
    const auto out = call.out();
    dither_->apply(sp::rows_from(call.in(0), 0), width_, height_, out.row(0),
                   out.height() > 1 ? out.row(1) - out.row(0) : out.row_floats());
  }

 private:
  int width_ = 0, height_ = 0;
  std::unique_ptr<triad::PanelDither> dither_;
};

}  // namespace

TRIAD_PLUGIN("dither", DitherFilter)
