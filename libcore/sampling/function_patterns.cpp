// SPDX-License-Identifier: Apache-2.0
// Functions that repeat: stripes, squares, discs.
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/sampling/areas.hpp>
#include <triad/sampling/function_base.hpp>

namespace triad {
namespace {

struct Point {
  double u, v;
};

// The integral along the segment of triangle_wave(u) w(v) dv, w a square wave if `crossed` and 1 if not: exact, as
// the integrand is linear between whole numbers of u and v. By Green's theorem the sum over a polygon's sides is the
// integral of square_wave(u) w(v) over the polygon.
double along(Point from, Point to, bool crossed) {
  const double du = to.u - from.u, dv = to.v - from.v;
  if (dv == 0) return 0;
  const auto first_beyond = [](double t, double step) { return step > 0 ? std::floor(t) + 1 : std::ceil(t) - 1; };
  double next_u = first_beyond(from.u, du), next_v = first_beyond(from.v, dv);
  double sum = 0, t = 0, wave = triangle_wave(from.u);
  while (t < 1) {
    const double at_u = du != 0 ? (next_u - from.u) / du : 1, at_v = crossed ? (next_v - from.v) / dv : 1;
    const double end = std::max(t, std::min({at_u, at_v, 1.}));
    const double wave_end = triangle_wave(from.u + end * du);
    const double sign = crossed ? square_wave(from.v + .5 * (t + end) * dv) : 1;
    sum += sign * .5 * (wave + wave_end) * (end - t) * dv;
    if (at_u <= end) next_u += du > 0 ? 1 : -1;
    if (at_v <= end) next_v += dv > 0 ? 1 : -1;
    t = end;
    wave = wave_end;
  }
  return sum;
}

// The mean over a box of square_wave(u / cell) times square_wave(v / cell), or of the first alone.
template <class Box>
double wave_mean(const Turned& turned, double shift_px, double cell_px, bool crossed, const Box& box) {
  const auto corner = [&](double x, double y) {
    return Point{(turned.u(x, y) - shift_px) / cell_px, turned.v(x, y) / cell_px};
  };
  const Point corners[4] = {corner(box.x0, box.y0), corner(box.x1, box.y0), corner(box.x1, box.y1),
                            corner(box.x0, box.y1)};
  double sum = 0;
  for (int i = 0; i < 4; ++i) sum += along(corners[i], corners[(i + 1) % 4], crossed);
  return sum / (box.area() / (cell_px * cell_px));
}

constexpr double kFinest_px = .01;  // of what repeats: a hundred times along a pixel, ten thousand times in it

const FunctionInfo kStripes{
    "stripes", "bright and dark stripes of the same width",
    "With a period of one pixel, as by default, all samples at the same place in each pixel see the same stripe: "
    "the picture is even for a strategy of one sample a pixel, and even for one that averages, but not the same.",
    with_tones({{"period", "pixels from one bright stripe to the next", 1e-4, 1e5, 1, true},
                angle_param(0),
                shift_param(),
                rows_param()})};

class Stripes final : public TonesOf<Stripes> {
 public:
  Stripes(const StrategyValues& values, const View& view)
      : TonesOf(values, view),
        turned_(view, values.at("angle")),
        cell_px_(.5 * length_px(values, "period", view)),
        shift_px_(length_px(values, "shift", view)) {}

 private:
  friend TonesOf;
  double tone(double x, double y) const { return square_wave((turned_.u(x, y) - shift_px_) / cell_px_) > 0; }
  double tone_in(const Box& box) const override {
    return .5 + .5 * wave_mean(turned_, shift_px_, cell_px_, false, box);
  }
  MaybeTone gaussian_tone(Axes centre, Axes sigma_px) const override {
    const double sigma = std::hypot(turned_.cosine * sigma_px.x, turned_.sine * sigma_px.y);
    return wave(centre, {.gaussian_sigma_px = sigma}, 1);
  }
  MaybeTone filter_tone(Axes centre, const SeparableFilter& f, Axes per_px) const override {
    return turned_.upright() ? MaybeTone(wave(centre, f, per_px.x)) : MaybeTone();
  }
  double wave(Axes centre, const SeparableFilter& f, double per_px) const {
    return .5 + .5 * filtered_square_wave((turned_.u(centre.x, centre.y) - shift_px_) / cell_px_,
                                          1 / (cell_px_ * per_px), f);
  }

  Turned turned_;
  double cell_px_, shift_px_;
};

const FunctionInfo kChecker{
    "checker", "a checkerboard",
    "Bright and dark squares about the picture's middle. Turned by an angle its edges meet the pixels in all ways; "
    "upright, it has an exact picture under every reconstruction filter.",
    with_tones({{"cell", "pixels along a square's side", 1e-4, 1e5, 3.7, true}, angle_param(0), rows_param()})};

class Checker final : public TonesOf<Checker> {
 public:
  Checker(const StrategyValues& values, const View& view)
      : TonesOf(values, view), turned_(view, values.at("angle")), cell_px_(length_px(values, "cell", view)) {}

 private:
  friend TonesOf;
  double tone(double x, double y) const {
    return square_wave(turned_.u(x, y) / cell_px_) != square_wave(turned_.v(x, y) / cell_px_);
  }
  double tone_in(const Box& box) const override { return .5 - .5 * wave_mean(turned_, 0, cell_px_, true, box); }
  MaybeTone gaussian_tone(Axes centre, Axes sigma_px) const override {
    return waves(centre, {.gaussian_sigma_px = sigma_px.x}, {.gaussian_sigma_px = sigma_px.y}, {1, 1});
  }
  MaybeTone filter_tone(Axes centre, const SeparableFilter& f, Axes per_px) const override {
    return waves(centre, f, f, per_px);
  }
  MaybeTone waves(Axes centre, const SeparableFilter& across, const SeparableFilter& down, Axes per_px) const {
    if (!turned_.upright()) return {};
    const auto wave = [&](double u, const SeparableFilter& f, double per) {
      return filtered_square_wave(u / cell_px_, 1 / (cell_px_ * per), f);
    };
    return .5 - .5 * wave(turned_.u(centre.x, centre.y), across, per_px.x) *
                    wave(turned_.v(centre.x, centre.y), down, per_px.y);
  }

  Turned turned_;
  double cell_px_;
};

const FunctionInfo kDiscs{
    "discs", "a grid of bright discs, smaller than a pixel if you like",
    "A disc in the middle of each square of a grid about the picture's middle. Its mean is pi r^2 / spacing^2, "
    "whether or not a strategy's samples happen to meet discs.",
    with_tones({{"radius", "pixels; at most half the spacing", 1e-6, 1e5, .3, true},
                {"spacing", "pixels from one disc's middle to the next", .02, 1e5, 4.3, true},
                rows_param()})};

class Discs final : public TonesOf<Discs> {
 public:
  Discs(const StrategyValues& values, const View& view)
      : TonesOf(values, view),
        turned_(view, 0),
        radius_(length_px(values, "radius", view)),
        spacing_(length_px(values, "spacing", view)) {}

 private:
  friend TonesOf;
  double tone(double x, double y) const {
    const double u = turned_.u(x, y) / spacing_, v = turned_.v(x, y) / spacing_;
    const double du = (u - std::floor(u) - .5) * spacing_, dv = (v - std::floor(v) - .5) * spacing_;
    return du * du + dv * dv < radius_ * radius_;
  }
  double tone_in(const Box& box) const override {
    // In radii of a disc, about the picture's middle.
    const double x0 = (box.x0 - turned_.x) / radius_, x1 = (box.x1 - turned_.x) / radius_;
    const double y0 = (box.y0 - turned_.y) / radius_, y1 = (box.y1 - turned_.y) / radius_;
    const double step = spacing_ / radius_;
    const auto first = [&](double edge) { return std::ceil((edge - 1) / step - .5); };
    const auto last = [&](double edge) { return std::floor((edge + 1) / step - .5); };
    const auto inside = [](double middle, double low, double high) {
      return middle - 1 >= low && middle + 1 <= high;
    };
    double area = 0;
    for (double j = first(y0); j <= last(y1); ++j)
      for (double i = first(x0); i <= last(x1); ++i) {
        const double x = (i + .5) * step, y = (j + .5) * step;
        area += inside(x, x0, x1) && inside(y, y0, y1) ? std::numbers::pi
                                                       : unit_disc_area(x0 - x, y0 - y, x1 - x, y1 - y);
      }
    return area / ((x1 - x0) * (y1 - y0));
  }

  Turned turned_;
  double radius_, spacing_;
};

std::unique_ptr<Source> make_discs(const StrategyValues& values, const View& view, const std::string& option) {
  if (values.at("radius") > .5 * values.at("spacing"))
    throw_usage(option + ": discs:radius=" + format_double(values.at("radius")) + " is more than half of spacing=" +
                format_double(values.at("spacing")) + ", so that discs overlap; take a smaller radius");
  require_length(kDiscs, values, "spacing", view, kFinest_px, option);
  return std::make_unique<Discs>(values, view);
}

std::unique_ptr<Source> make_stripes(const StrategyValues& values, const View& view, const std::string& option) {
  require_length(kStripes, values, "period", view, kFinest_px, option);
  return std::make_unique<Stripes>(values, view);
}

std::unique_ptr<Source> make_checker(const StrategyValues& values, const View& view, const std::string& option) {
  require_length(kChecker, values, "cell", view, kFinest_px, option);
  return std::make_unique<Checker>(values, view);
}

}  // namespace

const FunctionEntry& stripes_function() {
  static const FunctionEntry entry{kStripes, make_stripes};
  return entry;
}

const FunctionEntry& checker_function() {
  static const FunctionEntry entry{kChecker, make_checker};
  return entry;
}

const FunctionEntry& discs_function() {
  static const FunctionEntry entry{kDiscs, make_discs};
  return entry;
}

}  // namespace triad
