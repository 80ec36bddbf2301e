// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <string>
#include <triad/display/emission.hpp>
#include <vector>

#include "seeing_parameters.hpp"

namespace {

namespace tp = triad_plugin;
namespace sp = seeing_parameters;

// Which cells an output pixel covers, and by how much: weights sum to 1.
struct Cover {
  int first = 0;
  std::vector<double> weights;
};

// Pixel i of `scale` within a display pixel of `cells` cells.
Cover cover(int i, int scale, int cells) {
  Cover out;
  // In units of 1 / scale of a cell, so that borders are whole numbers.
  const int begin = i * cells, end = begin + cells;
  out.first = begin / scale;
  for (int k = out.first; k * scale < end; ++k)
    out.weights.push_back(static_cast<double>(std::min(end, (k + 1) * scale) - std::max(begin, k * scale)) / cells);
  return out;
}

struct Panel {
  static constexpr tp::Info info{
      "panel", "1.0", "Draws each pixel as the panel's emitters, much enlarged",
      "What a magnifying glass on the display shows: each pixel becomes scale x scale pixels with the emitters where "
      "the "
      "layout has them, each in its own colour and as bright as its drive. With scale a multiple of the layout's "
      "cells (3 for stripes, 2 for qd-oled), emitters have sharp edges; else their borders are mixed by area.\n"
      "An emitter is as many times brighter than its pixel as it is smaller. gain=1 keeps that true light: the mean "
      "over a pixel is the light of the pixel, and values go beyond 1, which a file of 8 bits clips. gain=0 divides "
      "by the brightest that a cell of the layout gets, so that nothing in [0, 1] is clipped; the report says the "
      "gain.\nlines draws dark lines between emitters, below and to the right of each. Pixels beyond the picture are "
      "dark. Values outside [0, 1] are clamped first, as a panel does."};
  std::string layout;
  int scale, lines;
  double gain;
  std::vector<double> origin;

  static constexpr double kOrigin[] = {0, 0};
  static constexpr auto params() {
    return tp::list(
        tp::text<&Panel::layout>("layout", sp::kLayoutDoc, {.def = "auto"}),
        tp::integer<&Panel::scale>("scale", "pixels that a pixel becomes, each way",
                                   {.def = 12, .min = 1, .max = 256, .unit = "px"}),
        tp::number<&Panel::gain>("gain", "what light is multiplied by; 0 makes the brightest emitter 1",
                                 {.def = 0, .min = 0, .max = 1000}),
        tp::integer<&Panel::lines>("lines", "width of dark lines between emitters; less than scale",
                                   {.def = 0, .min = 0, .max = 255, .unit = "px"}),
        tp::numbers<&Panel::origin>("origin", "the picture's place on a panel that repeats after several pixels",
                                    {.def = kOrigin, .max_count = 2, .unit = "px"}));
  }
  static constexpr auto inputs() {
    return tp::list(tp::Input{"image", "a picture for the display", "rgb", "linear"});
  }

  void create(tp::Call&) {
    display_parameters::check_origin(origin);
    if (lines >= scale)
      throw tp::Error(TRIAD_E_PARAM, "lines=" + std::to_string(lines) +
                                         " leaves nothing of pixels drawn at scale=" + std::to_string(scale) +
                                         "; at most " + std::to_string(scale - 1) + " is possible");
  }

  void plan(tp::PlanCall& call) {
    call.erase_meta(sp::kLayoutKey);  // what comes out is light, and no panel's drives
    call.erase_meta(sp::kOriginKey);
    const triad_image& in = call.in(0);
    const triad::Layout panel = sp::choose_panel(layout, {call.get_meta(0, sp::kLayoutKey)});
    if (in.cells_x != 1 || in.cells_y != 1)
      throw tp::Error(TRIAD_E_INPUT, "the picture has " + sp::cells_text(in.cells_x, in.cells_y) +
                                         " cells a pixel; a picture for the display has one");
    if (int64_t{scale} * std::max(in.width, in.height) > INT32_MAX)
      throw tp::Error(TRIAD_E_PARAM, "scale=" + std::to_string(scale) + " makes more than 2^31 pixels of a side of " +
                                         display_parameters::size_text(in));
    const auto at = sp::origin_on(call, origin, panel);
    emission_ = std::make_unique<triad::Emission>(panel, at.x_px, at.y_px);
    width_px_ = in.width;
    height_px_ = in.height;
    cells_x_ = panel.cells_x;
    cells_y_ = panel.cells_y;
    for (int i = 0; i < scale; ++i) {
      across_.push_back(cover(i, scale, panel.cells_x));
      down_.push_back(cover(i, scale, panel.cells_y));
    }
    applied_gain_ = gain > 0 ? gain : 1 / brightest(panel);
    if (lines > 0) draw_lines(panel, at);
    call.report("gain", applied_gain_);
    call.out.width = in.width * scale;
    call.out.height = in.height * scale;
    call.plan.threads = TRIAD_REENTRANT;
    call.plan.edge = TRIAD_EDGE_ZERO;
  }

  void need(int, triad_rect out, tp::Needs& needs) const {
    needs[0] = {0, out.y0 / scale - emission_->reach_up_px(), width_px_,
                (out.y1 - 1) / scale + 1 + emission_->reach_down_px()};
  }

  void strip(tp::StripCall& call) const {
    const auto in = call.in(0);
    const int first = std::max(in.r.y0, 0), last = std::min(in.r.y1, height_px_);
    const size_t row_floats = 3 * static_cast<size_t>(width_px_);
    const auto clamped = call.scratch<float>(row_floats * static_cast<size_t>(last - first));
    for (int y = first; y < last; ++y)
      std::transform(in.at(0, y), in.at(0, y) + row_floats, &clamped[static_cast<size_t>(y - first) * row_floats],
                     [](float v) { return std::clamp(v, 0.f, 1.f); });
    const triad::DriveRows<float> drives{
        clamped.data(), static_cast<ptrdiff_t>(row_floats), width_px_, height_px_, first, last};
    const size_t cell_floats = row_floats * static_cast<size_t>(cells_x_);
    const auto light = call.scratch<double>(cell_floats * static_cast<size_t>(cells_y_));
    const auto mixed = call.scratch<double>(cell_floats);
    int shown = -1;
    for (int y = call.r.y0; y < call.r.y1; ++y) {
      const int pixel_y = y / scale;
      if (pixel_y != shown)
        emission_->light(drives, triad::Beyond::kDark,
                         {0, pixel_y * cells_y_, width_px_ * cells_x_, (pixel_y + 1) * cells_y_}, light.data());
      shown = pixel_y;
      const Cover& rows = down_[static_cast<size_t>(y % scale)];
      std::fill(mixed.begin(), mixed.end(), 0.);
      for (size_t k = 0; k < rows.weights.size(); ++k) {
        const double* row = &light[(static_cast<size_t>(rows.first) + k) * cell_floats];
        for (size_t i = 0; i < cell_floats; ++i) mixed[i] += rows.weights[k] * row[i];
      }
      draw_row(mixed.data(), y, call.out().row(y));
    }
  }

 private:
  // The most light of a cell and channel where everything is fully on, at least 1.
  static double brightest(const triad::Layout& panel) {
    const int width = panel.tile_x, height = panel.tile_y;
    double most = 1;
    // Not all at once: what is derived as white takes the others' place.
    for (int on = 1; on < 8; ++on) {
      std::vector<float> drives;
      for (int i = 0; i < width * height; ++i)
        for (int d = 0; d < 3; ++d) drives.push_back(static_cast<float>(on >> d & 1));
      const int columns = width * panel.cells_x, rows = height * panel.cells_y;
      std::vector<double> light(3 * static_cast<size_t>(columns) * static_cast<size_t>(rows));
      triad::Emission(panel).light(triad::DriveRows<float>{drives.data(), 3 * width, width, height, 0, height},
                                   triad::Beyond::kWrap, {0, 0, columns, rows}, light.data());
      most = std::max(most, *std::max_element(light.begin(), light.end()));
    }
    return most;
  }

  void draw_row(const double* cells, int y, float* to) const {
    const char* dark = dark_.empty() ? nullptr : dark_row(y);
    for (int x = 0; x < width_px_; ++x, cells += 3 * cells_x_)
      for (int i = 0; i < scale; ++i, to += 3) {
        const Cover& columns = across_[static_cast<size_t>(i)];
        const bool line = dark && dark[x % tile_x_ * scale + i];
        for (int d = 0; d < 3; ++d) {
          double sum = 0;
          for (size_t k = 0; k < columns.weights.size(); ++k)
            sum += columns.weights[k] * cells[3 * (static_cast<size_t>(columns.first) + k) + static_cast<size_t>(d)];
          to[d] = line ? 0 : static_cast<float>(applied_gain_ * sum);
        }
      }
  }

  const char* dark_row(int y) const {
    const size_t row = static_cast<size_t>(y / scale % tile_y_ * scale + y % scale);
    return dark_.data() + row * static_cast<size_t>(tile_x_ * scale);
  }

  // Marks, over one tile as the picture sees it, the pixels within `lines` above or left of another emitter's.
  void draw_lines(const triad::Layout& panel, const sp::Origin& at) {
    tile_x_ = panel.tile_x;
    tile_y_ = panel.tile_y;
    const int columns = tile_x_ * cells_x_, rows = tile_y_ * cells_y_;
    const auto modulo = [](int a, int n) { return (a % n + n) % n; };
    // Whose each cell is: the emitter, and in which tile its pixel lies, for cells may reach into the next one.
    std::vector<int> owner(static_cast<size_t>(columns * rows), -1);
    for (size_t e = 0; e < panel.emitters.size(); ++e)
      for (const triad::EmitterCell& cell : panel.emitters[e].cells)
        owner[static_cast<size_t>(modulo(cell.y, rows) * columns + modulo(cell.x, columns))] =
            static_cast<int>(e * 16) +
            (cell.x < 0          ? 1
             : cell.x >= columns ? 2
                                 : 0) +
            4 * (cell.y < 0       ? 1
                 : cell.y >= rows ? 2
                                  : 0);
    const int width = tile_x_ * scale, height = tile_y_ * scale;
    // The owner of an output pixel's middle, and of which tile of the panel that one is.
    struct Place {
      int owner, tile_x, tile_y;
      bool operator==(const Place&) const = default;
    };
    const auto place = [&](int x, int y) {
      const int cx = (2 * x + 1) * cells_x_ / (2 * scale) + at.x_px * cells_x_;
      const int cy = (2 * y + 1) * cells_y_ / (2 * scale) + at.y_px * cells_y_;
      const int id = owner[static_cast<size_t>(cy % rows * columns + cx % columns)];
      const int left = id < 0 ? 0 : id % 4, up = id < 0 ? 0 : id / 4 % 4;
      return Place{id < 0 ? id : id / 16, cx / columns + (left == 1) - (left == 2),
                   cy / rows + (up == 1) - (up == 2)};
    };
    dark_ = std::vector<char>(static_cast<size_t>(width * height));
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int i = 1; i <= lines; ++i)
          if (!(place(x, y) == place(x + i, y)) || !(place(x, y) == place(x, y + i)))
            dark_[static_cast<size_t>(y * width + x)] = 1;
  }

  int width_px_ = 0, height_px_ = 0, cells_x_ = 1, cells_y_ = 1, tile_x_ = 1, tile_y_ = 1;
  double applied_gain_ = 1;
  std::vector<Cover> across_, down_;
  std::vector<char> dark_;
  std::unique_ptr<triad::Emission> emission_;
};

}  // namespace

TRIAD_PLUGIN("panel", Panel)
