// SPDX-License-Identifier: Apache-2.0
// Functions of one or two straight edges, and of none.
#include <triad/sampling/areas.hpp>
#include <triad/sampling/function_base.hpp>

namespace triad {
namespace {

// What lies left of the line u = edge.
class Edge {
 public:
  Edge(const Turned& turned, double edge) : turned_(turned), edge_(edge) {}
  bool covers(double x, double y) const { return turned_.u(x, y) < edge_; }
  template <class Box>
  double share(const Box& box) const {
    return half_plane_share(box.x1 - box.x0, box.y1 - box.y0, turned_.cosine, turned_.sine,
                            edge_ - turned_.u(box.x0, box.y0));
  }
  // Phi(d / sigma) for the distance d, with the Gaussian's sigma across the edge.
  template <class Axes>
  double gaussian(Axes centre, Axes sigma_px) const {
    const double sigma = std::hypot(turned_.cosine * sigma_px.x, turned_.sine * sigma_px.y);
    return cumulative_at({.gaussian_sigma_px = sigma}, edge_ - turned_.u(centre.x, centre.y));
  }
  // Of an upright edge.
  template <class Axes>
  double filtered(Axes centre, const SeparableFilter& filter, double per_px) const {
    return cumulative_at(filter, (edge_ - turned_.u(centre.x, centre.y)) * per_px);
  }

 private:
  Turned turned_;
  double edge_;
};

const FunctionInfo kFlat{"flat",
                         "the same light everywhere",
                         "What no strategy may change, and what the cheapest should spend least on.",
                         {{"level", "its light", 0, 1e4, .5, true}}};

std::unique_ptr<Source> make_flat(const StrategyValues& values, const View& view, const std::string&) {
  const auto level = static_cast<float>(values.at("level"));
  return std::make_unique<RampSource>(view.width_px, view.height_px, Rgb{level, level, level}, Rgb{}, Rgb{},
                                      view.cells);
}

const FunctionInfo kRamp{
    "ramp",
    "light that grows evenly to the right, and blue downwards",
    "From 0 at the left to 1 at the right in red and green, from 0 at the top to 1 at the bottom "
    "in blue. Adaptive strategies find nothing to do inside it; every regular grid is exact.",
    {}};

std::unique_ptr<Source> make_ramp(const StrategyValues&, const View& view, const std::string&) {
  const float across = 1 / static_cast<float>(view.width_px), down = 1 / static_cast<float>(view.height_px);
  return std::make_unique<RampSource>(view.width_px, view.height_px, Rgb{}, Rgb{across, across, 0}, Rgb{0, 0, down},
                                      view.cells);
}

const FunctionInfo kHalfPlane{
    "half-plane", "one straight, infinitely sharp edge",
    "Bright to the left of a line through the picture's middle, dark to the right. Its exact picture is the area of "
    "each pixel's bright part; under a Gaussian the normal distribution of the distance.",
    with_tones({angle_param(20), shift_param(), rows_param()})};

class HalfPlane final : public TonesOf<HalfPlane> {
 public:
  HalfPlane(const StrategyValues& values, const View& view)
      : TonesOf(values, view),
        upright_(values.at("angle") == 0),
        edge_(Turned(view, values.at("angle")), length_px(values, "shift", view)) {}

 private:
  friend TonesOf;
  double tone(double x, double y) const { return edge_.covers(x, y); }
  double tone_in(const Box& box) const override { return edge_.share(box); }
  MaybeTone gaussian_tone(Axes centre, Axes sigma_px) const override { return edge_.gaussian(centre, sigma_px); }
  MaybeTone filter_tone(Axes centre, const SeparableFilter& f, Axes per_px) const override {
    return upright_ ? MaybeTone(edge_.filtered(centre, f, per_px.x)) : MaybeTone();
  }

  bool upright_;
  Edge edge_;
};

const FunctionInfo kThinLine{
    "thin-line", "a bright line, thinner than a pixel if you like",
    "It runs through the picture's middle from edge to edge. A line of width w adds w times its length of light; "
    "adaptive strategies that look at too few places lose parts of it.",
    with_tones({{"width", "pixels", 1e-6, 1e5, .3, true}, angle_param(20), shift_param(), rows_param()})};

class ThinLine final : public TonesOf<ThinLine> {
 public:
  ThinLine(const StrategyValues& values, const View& view)
      : TonesOf(values, view),
        upright_(values.at("angle") == 0),
        left_(side(values, view, -.5)),
        right_(side(values, view, .5)) {}

 private:
  friend TonesOf;
  static Edge side(const StrategyValues& values, const View& view, double sign) {
    return {Turned(view, values.at("angle")),
            length_px(values, "shift", view) + sign * length_px(values, "width", view)};
  }
  double tone(double x, double y) const { return right_.covers(x, y) && !left_.covers(x, y); }
  double tone_in(const Box& box) const override { return right_.share(box) - left_.share(box); }
  MaybeTone gaussian_tone(Axes centre, Axes sigma_px) const override {
    return right_.gaussian(centre, sigma_px) - left_.gaussian(centre, sigma_px);
  }
  MaybeTone filter_tone(Axes centre, const SeparableFilter& f, Axes per_px) const override {
    if (!upright_) return {};
    return right_.filtered(centre, f, per_px.x) - left_.filtered(centre, f, per_px.x);
  }

  bool upright_;
  Edge left_, right_;
};

}  // namespace

const FunctionEntry& flat_function() {
  static const FunctionEntry entry{kFlat, make_flat};
  return entry;
}

const FunctionEntry& ramp_function() {
  static const FunctionEntry entry{kRamp, make_ramp};
  return entry;
}

const FunctionEntry& half_plane_function() {
  static const FunctionEntry entry = function_entry<HalfPlane>(kHalfPlane);
  return entry;
}

const FunctionEntry& thin_line_function() {
  static const FunctionEntry entry = function_entry<ThinLine>(kThinLine);
  return entry;
}

}  // namespace triad
