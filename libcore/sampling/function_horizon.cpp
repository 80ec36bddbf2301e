// SPDX-License-Identifier: Apache-2.0
#include <triad/base/error.hpp>
#include <triad/sampling/function_base.hpp>

namespace triad {
namespace {

constexpr double kFocal = 1.2;     // focal length in picture heights: 45 degrees from top to bottom
constexpr double kFarthest = 1e5;  // rows of squares; what lies beyond is grey

const FunctionInfo kInfo{
    "horizon", "a checkerboard that goes to the horizon",
    "A floor of squares seen through a lens of 45 degrees, under an even sky. Towards the horizon squares become "
    "ever "
    "smaller than a pixel; what should be seen there is the grey half-way between bright and dark, and with the "
    "usual "
    "sky of that grey all else that is seen is aliasing or noise. From the hundred-thousandth row of squares on the "
    "floor is grey.",
    with_tones({{"cell", "a square's width at the picture's bottom, in shares of its height", 1e-3, 10, .15, true},
                {"horizon", "where it lies, in shares of the height from the top", -1, .99, .3, true},
                {"sky", "tone of the sky: 0 as the dark squares, 1 as the bright ones", 0, 1, .5, true}})};

// With x and depth eta below the horizon in picture heights, the floor's coordinates in squares are across x / eta
// and away / eta.
class Horizon final : public TonesOf<Horizon> {
 public:
  Horizon(const StrategyValues& values, const View& view)
      : TonesOf(values, view),
        horizon_(values.at("horizon")),
        sky_(values.at("sky")),
        across_((1 - horizon_) / values.at("cell")),
        away_(kFocal * across_) {}

 private:
  friend TonesOf;
  double x_of(double x) const { return (x - .5 * width_px()) / height_px(); }
  double depth_of(double y) const { return y / height_px() - horizon_; }

  double tone(double x, double y) const {
    const double depth = depth_of(y);
    if (depth <= 0) return sky_;
    const double row = away_ / depth;
    if (row > kFarthest) return .5;
    return square_wave(across_ * x_of(x) / depth) != square_wave(row);
  }

  double tone_in(const Box& box) const override {
    const double x0 = x_of(box.x0), x1 = x_of(box.x1), top = depth_of(box.y0), bottom = depth_of(box.y1);
    const double far = away_ / kFarthest;
    double tone = sky_ * std::max(0., std::min(bottom, 0.) - top);
    tone += .5 * std::max(0., bottom - std::max(top, 0.));
    if (bottom > far) tone -= .5 * wave_integral(x0, x1, std::max(top, far), bottom) / (x1 - x0);
    return tone / (bottom - top);
  }

  // The integral of square_wave(u) square_wave(v). Across the columns it is
  //   f(eta) = eta / across (triangle_wave(across x1 / eta) - triangle_wave(across x0 / eta)),
  // which is linear in eta between those eta at which one of the triangles has a corner; and the rows' sign changes
  // where away / eta is whole. So the trapezoidal rule between all of these is exact.
  double wave_integral(double x0, double x1, double far, double near) const {
    struct Crossings {
      double factor, n;  // at eta = factor / n, with n from here up
      double next() const { return factor / n; }
    };
    const auto crossings = [&](double factor) { return Crossings{factor, std::floor(factor / near) + 1}; };
    Crossings left = crossings(across_ * std::abs(x0)), right = crossings(across_ * std::abs(x1));
    Crossings rows = crossings(away_);
    const auto f = [&](double eta) {
      return eta / across_ * (triangle_wave(across_ * x1 / eta) - triangle_wave(across_ * x0 / eta));
    };
    double sum = 0, eta = near, value = f(near), sign = square_wave(rows.n - 1);
    while (eta > far) {
      const double next_left = left.next(), next_right = right.next(), next_row = rows.next();
      const double end = std::min(eta, std::max({next_left, next_right, next_row, far}));
      const double value_end = f(end);
      sum += sign * .5 * (value + value_end) * (eta - end);
      if (next_left >= end) ++left.n;
      if (next_right >= end) ++right.n;
      if (next_row >= end) {
        ++rows.n;
        sign = -sign;
      }
      eta = end;
      value = value_end;
    }
    return sum;
  }

  double horizon_, sky_, across_, away_;
};

std::unique_ptr<Source> make_horizon(const StrategyValues& values, const View& view, const std::string& option) {
  // Its integral goes from one square's border to the next, of which a pixel at the horizon has kFarthest times its
  // distance from the middle in picture heights.
  constexpr int kWidest = 100;  // picture heights
  if (view.width_px > int64_t{kWidest} * view.height_px)
    throw_usage(option + ": horizon in a picture of " + std::to_string(view.width_px) + "x" +
                std::to_string(view.height_px) + ", more than " + std::to_string(kWidest) +
                " times as wide as high, has too many squares in a pixel; take a picture that is less wide");
  return std::make_unique<Horizon>(values, view);
}

}  // namespace

const FunctionEntry& horizon_function() {
  static const FunctionEntry entry{kInfo, make_horizon};
  return entry;
}

}  // namespace triad
