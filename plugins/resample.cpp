// SPDX-License-Identifier: Apache-2.0
#include <triad/abi/triad_plugin.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <triad/sampling/reconstruction.hpp>
#include <vector>

namespace {

namespace tp = triad_plugin;

// One axis: which pixels of the input make a pixel of the output, and with what weights, which sum to 1.
class Axis {
 public:
  Axis(triad::ReconstructionKernel kernel, double scale, int in, int out)
      : step_px_(static_cast<double>(in) / out), filter_(kernel, scale * std::max(1., step_px_)) {}

  struct Range {
    int first, past;
  };
  struct Taps {
    int first = 0;
    std::vector<double> weights;
    int past() const { return first + static_cast<int>(weights.size()); }
  };
  // That reach() says for any pixel, at most.
  double most_taps() const { return std::floor(2 * filter_.radius_px()) + 2; }
  // The pixels that one of the output may need. Both ends rise with it, so that a strip's first and last say all.
  Range reach(int out) const {
    const double centre = (out + .5) * step_px_, radius = filter_.radius_px();
    const auto nearest = static_cast<int>(std::floor(centre));
    return {std::min(nearest, static_cast<int>(std::ceil(centre - radius - .5))),
            std::max(nearest, static_cast<int>(std::floor(centre + radius - .5))) + 1};
  }
  Taps taps(int out) const {
    const double centre = (out + .5) * step_px_;
    const Range range = reach(out);
    Taps taps{range.first, {}};
    double sum = 0, absolute = 0;
    for (int i = range.first; i < range.past; ++i) {
      double weight = filter_.value(i + .5 - centre);
      if (std::abs(weight) < kNone) weight = 0;
      taps.weights.push_back(weight);
      sum += weight;
      absolute += std::abs(weight);
    }
    // A filter narrower than the distance between pixels may miss them, or see little but its negative parts.
    if (std::abs(sum) <= kCancelled * absolute) return {static_cast<int>(std::floor(centre)), {1}};
    for (double& weight : taps.weights) weight /= sum;
    return taps;
  }

 private:
  static constexpr double kNone = 1e-14;         // of a peak near 1: what rounding leaves where a filter is 0
  static constexpr double kCancelled = 1. / 16;  // as splat has it
  double step_px_;                               // input pixels for one of the output
  triad::ReconstructionFilter filter_;
};

// The taps of all columns. There are as many as the result is wide, and so they are made when the first strip is, and
// not while a plan is made that may never be carried out.
class Columns {
 public:
  explicit Columns(int count) : count_(count) {}
  // Bytes of all of them.
  double bytes(const Axis& across) const {
    return count_ * (sizeof(Axis::Taps) + across.most_taps() * sizeof(double));
  }
  // By any thread.
  const std::vector<Axis::Taps>& taps(const Axis& across) {
    std::call_once(once_, [&] {
      taps_.reserve(static_cast<size_t>(count_));
      for (int x = 0; x < count_; ++x) taps_.push_back(across.taps(x));
    });
    return taps_;
  }

 private:
  int count_;
  std::once_flag once_;
  std::vector<Axis::Taps> taps_;
};

struct Resample {
  static constexpr tp::Info info{
      "resample", "1.0", "Changes the size of a picture, with a reconstruction filter",
      "Each pixel is the weighted mean of the pixels under the filter about its centre, in linear light; where the "
      "picture gets smaller, the filter widens with it. Every channel is treated alike (colour is associated with "
      "alpha, so alpha needs no special treatment). mitchell is a compromise; lanczos3 is the sharpest and rings at "
      "edges, gaussian and blackman-harris are soft and never ring, tent is linear interpolation, box repeats pixels "
      "or averages blocks. Values that are not finite are replaced by 0, as they would spread.\n"
      "factor applies to both sides; width and height say them instead, and one alone keeps the shape. In a wide "
      "render "
      "cells=keep leaves each display pixel its cells, so that width and height are multiples of them; cells=one "
      "makes "
      "a standard picture."};
  enum class Edge { kMirror, kWrap, kClamp };
  enum class Cells { kKeep, kOne };

  double factor, scale;
  int width, height;
  triad::ReconstructionKernel filter;
  Edge edge;
  Cells cells;

  static constexpr auto params() {
    return tp::list(
        tp::number<&Resample::factor>("factor", "size of the result over that of the picture",
                                      {.def = 1, .min = 0, .flags = TRIAD_PARAM_MIN_EXCLUDED}),
        tp::integer<&Resample::width>("width", "of the result; 0 follows from the height or from factor",
                                      {.min = 0, .unit = "px"}),
        tp::integer<&Resample::height>("height", "of the result; 0 follows from the width or from factor",
                                       {.min = 0, .unit = "px"}),
        tp::choice<&Resample::filter, "box", "box2", "tent", "gaussian", "mitchell", "lanczos2", "lanczos3",
                   "blackman-harris">("filter", "the reconstruction filter", {.def = "mitchell"}),
        tp::number<&Resample::scale>("scale", "of the filter: 2 makes it twice as wide",
                                     {.def = 1, .min = .125, .max = 8}),
        tp::choice<&Resample::edge, "mirror", "wrap", "clamp">("edge", "what lies beyond the picture"),
        tp::choice<&Resample::cells, "keep", "one">("cells", "what becomes of the cells of a display pixel"));
  }
  static constexpr auto inputs() { return tp::list(tp::Input{"image", "the picture", "*", "linear"}); }

  void plan(tp::PlanCall& call) {
    const triad_image& in = call.in(0);
    triad_image& out = call.out;
    if (cells == Cells::kOne) out.cells_x = out.cells_y = 1;
    choose_size(in, out);
    // The pixel of a panel at which the picture began is none of the new ones.
    if (out.width != in.width || out.height != in.height) call.erase_meta("triad:origin");
    out.pixel_aspect = in.pixel_aspect * in.width / out.width * out.height / in.height;
    across_ = std::make_unique<const Axis>(filter, scale, in.width, out.width);
    down_ = std::make_unique<const Axis>(filter, scale, in.height, out.height);
    columns_ = std::make_unique<Columns>(out.width);
    const auto row = static_cast<size_t>(across_->reach(out.width - 1).past - across_->reach(0).first) *
                     static_cast<size_t>(in.channels);
    call.work_bytes(row * sizeof(double) + static_cast<size_t>(columns_->bytes(*across_)));
    call.plan.threads = TRIAD_REENTRANT;
    // One such value would spoil all that the filter reaches.
    call.plan.nonfinite = TRIAD_NONFINITE_ZERO;
    constexpr int kEdges[] = {TRIAD_EDGE_MIRROR, TRIAD_EDGE_WRAP, TRIAD_EDGE_CLAMP};
    call.plan.edge = kEdges[static_cast<size_t>(edge)];
  }

  void need(int, triad_rect out, tp::Needs& needs) const {
    needs[0] = {across_->reach(out.x0).first, down_->reach(out.y0).first, across_->reach(out.x1 - 1).past,
                down_->reach(out.y1 - 1).past};
  }

  void strip(tp::StripCall& call) const {
    const auto in = call.in(0);
    const auto out = call.out();
    const std::vector<Axis::Taps>& columns = columns_->taps(*across_);
    // First down, into a row of the input's width, then across: an output row depends on no other.
    const auto row = call.scratch<double>(static_cast<size_t>(in.row_floats()));
    for (int y = call.r.y0; y < call.r.y1; ++y) {
      const Axis::Taps down = down_->taps(y);
      std::fill(row.begin(), row.end(), 0.);
      for (int iy = down.first; iy < down.past(); ++iy) {
        const double weight = down.weights[static_cast<size_t>(iy - down.first)];
        const float* from = in.row(iy);
        if (weight != 0)
          for (size_t i = 0; i < row.size(); ++i) row[i] += weight * static_cast<double>(from[i]);
      }
      float* to = out.row(y);
      for (int x = call.r.x0; x < call.r.x1; ++x, to += in.channels) {
        const Axis::Taps& taps = columns[static_cast<size_t>(x)];
        const double* const from = row.data() + int64_t{taps.first - in.r.x0} * in.channels;
        for (int c = 0; c < in.channels; ++c) to[c] = static_cast<float>(mean(taps.weights, from + c, in.channels));
      }
    }
  }

 private:
  static double mean(const std::vector<double>& weights, const double* from, int stride) {
    double sum = 0;
    for (const double weight : weights) {
      if (weight != 0) sum += weight * *from;
      from += stride;
    }
    return sum;
  }

  void choose_size(const triad_image& in, triad_image& out) const {
    if (factor != 1 && (width > 0 || height > 0))
      throw tp::Error(TRIAD_E_PARAM, "factor and " + std::string(width > 0 ? "width" : "height") +
                                         " both say the size of the result; give one of them");
    const double across = static_cast<double>(in.width) / in.cells_x,
                 down = static_cast<double>(in.height) / in.cells_y;
    const double by_width = width / (across * out.cells_x), by_height = height / (down * out.cells_y);
    const double both = width > 0 ? by_width : height > 0 ? by_height : factor;
    out.width = side("width", width, across * both, out.cells_x);
    out.height = side("height", height, down * (height > 0 ? by_height : both), out.cells_y);
  }

  // given, or else the whole number nearest to `pixels` display pixels, in cells.
  static int side(const char* name, int given, double pixels, int cells_each) {
    if (given % cells_each != 0)
      throw tp::Error(TRIAD_E_PARAM, std::string(name) + "=" + std::to_string(given) +
                                         " cuts through a display pixel, which has " + std::to_string(cells_each) +
                                         " cells here; use a multiple of " + std::to_string(cells_each) +
                                         ", or cells=one");
    const double cells = std::max(1., std::round(pixels)) * cells_each;
    if (cells > INT32_MAX)
      throw tp::Error(TRIAD_E_PARAM, std::string("the result's ") + name + " would be above 2^31 - 1 pixels");
    return given > 0 ? given : static_cast<int>(cells);
  }

  std::unique_ptr<const Axis> across_, down_;
  std::unique_ptr<Columns> columns_;
};

}  // namespace

TRIAD_PLUGIN("resample", Resample)
