// SPDX-License-Identifier: Apache-2.0
#include <triad/abi/triad_plugin.hpp>

#include <algorithm>
#include <cstdio>
#include <string>
#include <tuple>

namespace {

namespace tp = triad_plugin;

struct Crop {
  static constexpr tp::Info info{
      "crop", "1.0", "Cuts out a rectangle",
      "x, y, w and h count the picture's own pixels from its upper left corner. The rectangle must lie inside the "
      "picture; in a wide render its borders must be borders of display pixels, so with 3x1 cells x and w are "
      "multiples of 3. w=0 and h=0 reach to the right and the lower border. On a picture that names its panel's "
      "layout, "
      "the panel's pixel at which it now begins is kept in triad:origin for the stages that follow."};
  int x, y, w, h;

  static constexpr auto params() {
    return tp::list(tp::integer<&Crop::x>("x", "left border", {.min = 0, .unit = "px"}),
                    tp::integer<&Crop::y>("y", "upper border", {.min = 0, .unit = "px"}),
                    tp::integer<&Crop::w>("w", "width; 0 reaches to the right border", {.min = 0, .unit = "px"}),
                    tp::integer<&Crop::h>("h", "height; 0 reaches to the lower border", {.min = 0, .unit = "px"}));
  }
  static constexpr auto inputs() { return tp::list(tp::Input{"image", "the picture", "*"}); }

  void plan(tp::PlanCall& call) {
    const triad_image& in = call.in(0);
    call.out.width = side("x", "w", x, w, in.width, in.cells_x, in);
    call.out.height = side("y", "h", y, h, in.height, in.cells_y, in);
    if (call.get_meta(0, "triad:layout")) keep_phase(call, x / in.cells_x, y / in.cells_y);
    call.plan.threads = TRIAD_REENTRANT;
  }

  void need(int, triad_rect out, tp::Needs& needs) const {
    needs[0] = {out.x0 + x, out.y0 + y, out.x1 + x, out.y1 + y};
  }

  void strip(tp::StripCall& call) const {
    const auto in = call.in(0);
    const auto out = call.out();
    for (int oy = call.r.y0; oy < call.r.y1; ++oy)
      std::copy_n(in.at(call.r.x0 + x, oy + y), out.row_floats(), out.row(oy));
  }

 private:
  // A panel may repeat after several pixels only: says at which of its pixels the picture now begins, counted from
  // where it began before, for the stages that ask.
  static void keep_phase(tp::PlanCall& call, int x_px, int y_px) {
    long before_x = 0, before_y = 0;
    if (const auto before = call.get_meta(0, "triad:origin"))
      std::sscanf(before->c_str(), "%ld,%ld", &before_x, &before_y);
    call.set_meta("triad:origin", std::to_string(before_x + x_px) + "," + std::to_string(before_y + y_px));
  }

  // The length of one side of the rectangle, checked.
  static int side(const char* from_name, const char* length_name, int from, int length, int size, int cells,
                  const triad_image& in) {
    const std::string picture = std::to_string(in.width) + "x" + std::to_string(in.height);
    if (from >= size || length > size - from)
      throw tp::Error(TRIAD_E_PARAM, std::string(from_name) + "=" + std::to_string(from) + "," + length_name + "=" +
                                         std::to_string(length) + " reaches beyond the picture of " + picture +
                                         " pixels");
    const int result = length ? length : size - from;
    for (const auto& [name, value, border] :
         {std::tuple{from_name, from, from}, std::tuple{length_name, result, from + result}})
      if (value % cells != 0 && border != size)
        throw tp::Error(TRIAD_E_PARAM, std::string(name) + "=" + std::to_string(value) +
                                           " cuts through a display pixel, which has " + std::to_string(cells) +
                                           " cells here; use a multiple of " + std::to_string(cells));
    return result;
  }
};

}  // namespace

TRIAD_PLUGIN("crop", Crop)
