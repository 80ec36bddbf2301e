// SPDX-License-Identifier: Apache-2.0
#include <triad/abi/triad_plugin.hpp>

#include <algorithm>
#include <string>

namespace {

namespace tp = triad_plugin;

// Cells per display pixel after `factor` of them became one; refuses what would leave a fraction.
int cells_after(int cells, int factor, const char* name) {
  if (cells % factor == 0) return cells / factor;
  if (factor % cells == 0) return 1;
  throw tp::Error(TRIAD_E_PARAM,
                  std::string(name) + "=" + std::to_string(factor) + " cuts through the " + std::to_string(cells) +
                      " cells of a display pixel; use a divisor or a multiple of " + std::to_string(cells));
}

struct Box {
  static constexpr tp::Info info{
      "box", "1.0", "Averages blocks of x by y pixels into one",
      "Every channel is averaged in linear light (colour is associated with alpha, so alpha needs no special "
      "treatment). Where the picture is not a multiple of the block, the last column or row of blocks averages the "
      "pixels that are there. The cells of a wide render are used up: 3x1 cells and x=3 give a standard picture."};
  int x, y;

  static constexpr auto params() {
    return tp::list(tp::integer<&Box::x>("x", "width of a block", {.def = 1, .min = 1, .max = 4096, .unit = "px"}),
                    tp::integer<&Box::y>("y", "height of a block", {.def = 1, .min = 1, .max = 4096, .unit = "px"}));
  }
  static constexpr auto inputs() { return tp::list(tp::Input{"image", "the picture", "*", "linear"}); }

  void plan(tp::PlanCall& call) {
    const triad_image& in = call.in(0);
    width_ = in.width;
    height_ = in.height;
    call.out.width = (in.width - 1) / x + 1;
    call.out.height = (in.height - 1) / y + 1;
    call.out.cells_x = cells_after(in.cells_x, x, "x");
    call.out.cells_y = cells_after(in.cells_y, y, "y");
    call.out.pixel_aspect = in.pixel_aspect * x / y;
    call.plan.threads = TRIAD_REENTRANT;
  }

  void need(int, triad_rect out, tp::Needs& needs) const {
    needs[0] = {out.x0 * x, out.y0 * y, end(out.x1, x, width_), end(out.y1, y, height_)};
  }

  void strip(tp::StripCall& call) const {
    const auto in = call.in(0);
    const auto out = call.out();
    const auto sums = call.scratch<double>(static_cast<size_t>(out.row_floats()));
    for (int oy = call.r.y0; oy < call.r.y1; ++oy) {
      const int y0 = oy * y, y1 = end(oy + 1, y, height_);
      std::fill(sums.begin(), sums.end(), 0.0);
      for (int iy = y0; iy < y1; ++iy) add_row(in, iy, call.r, sums.data());
      float* to = out.row(oy);
      for (int ox = call.r.x0, i = 0; ox < call.r.x1; ++ox) {
        const double count = static_cast<double>(end(ox + 1, x, width_) - ox * x) * (y1 - y0);
        for (int c = 0; c < in.channels; ++c, ++i) to[i] = static_cast<float>(sums[static_cast<size_t>(i)] / count);
      }
    }
  }

 private:
  static int end(int blocks, int factor, int size) {
    return static_cast<int>(std::min<int64_t>(int64_t{blocks} * factor, size));
  }
  void add_row(const tp::View<const float>& in, int iy, triad_rect r, double* sums) const {
    for (int ox = r.x0; ox < r.x1; ++ox, sums += in.channels) {
      const float* from = in.at(ox * x, iy);
      for (int ix = ox * x, last = end(ox + 1, x, width_); ix < last; ++ix, from += in.channels)
        for (int c = 0; c < in.channels; ++c) sums[c] += static_cast<double>(from[c]);
    }
  }
  int width_ = 0, height_ = 0;
};

}  // namespace

TRIAD_PLUGIN("box", Box)
