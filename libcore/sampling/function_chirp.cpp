// SPDX-License-Identifier: Apache-2.0
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/sampling/function_base.hpp>

namespace triad {
namespace {

const FunctionInfo kInfo{
    "chirp", "bright and dark bands that get finer towards the top",
    "Infinitely sharp bands that fan out from the picture's middle downwards; their frequency grows from the bottom "
    "to "
    "the top, by the same factor on each row. A strategy shows its filtered edges below, its aliasing in the middle "
    "and its noise above, where grey is right.",
    with_tones({{"bottom", "bright bands in a picture height at the bottom", .01, 1e6, 4, true},
                {"top", "the same at the top; not less than at the bottom", .01, 1e6, 400, true}})};

// With x and the height t above the bottom in picture heights, the tone is the sign of square_wave(u), u =
// 2 bottom exp(growth t) x.
class Chirp final : public TonesOf<Chirp> {
 public:
  Chirp(const StrategyValues& values, const View& view)
      : TonesOf(values, view),
        halves_(2 * values.at("bottom")),
        growth_(std::log(values.at("top") / values.at("bottom"))) {}

 private:
  friend TonesOf;
  double x_of(double x) const { return (x - .5 * width_px()) / height_px(); }
  double t_of(double y) const { return 1 - y / height_px(); }

  double tone(double x, double y) const { return square_wave(halves_ * std::exp(growth_ * t_of(y)) * x_of(x)) > 0; }
  double tone_in(const Box& box) const override {
    const double x0 = x_of(box.x0), x1 = x_of(box.x1), t0 = t_of(box.y1), t1 = t_of(box.y0);
    return .5 + .5 * (left_of(x1, t0, t1) - left_of(x0, t0, t1)) / ((x1 - x0) * (t1 - t0));
  }

  // The integral of square_wave(u) over x from 0 and t from t0 to t1. Over x it is triangle_wave(u) / (du/dx), and
  // with n = floor(u) that is x - n / (du/dx), or for odd n (n + 1) / (du/dx) - x, with a known integral over t up to
  // where u is n + 1.
  double left_of(double x, double t0, double t1) const {
    const double reach = std::abs(x);
    const auto frequency = [&](double t) { return halves_ * std::exp(growth_ * t); };
    double sum = 0;
    for (double t = t0, n = std::floor(reach * frequency(t0)); t < t1; ++n) {
      double end = t1;
      if (reach > 0 && growth_ > 0) end = std::clamp(std::log((n + 1) / (halves_ * reach)) / growth_, t, t1);
      const double inverse =  // the integral of 1 / frequency
          growth_ > 0 ? -std::expm1(-growth_ * (end - t)) / (growth_ * frequency(t)) : (end - t) / halves_;
      const bool odd = std::fmod(n, 2) != 0;
      sum += odd ? (n + 1) * inverse - reach * (end - t) : reach * (end - t) - n * inverse;
      t = end;
    }
    return sum;
  }

  double halves_, growth_;
};

std::unique_ptr<Source> make_chirp(const StrategyValues& values, const View& view, const std::string& option) {
  if (values.at("top") < values.at("bottom"))
    throw_usage(option + ": chirp:top=" + format_double(values.at("top")) + " is less than bottom=" +
                format_double(values.at("bottom")) + "; bands become finer towards the top");
  // Its integral goes from one edge of a band to the next: a pixel of a low, wide picture would have billions.
  constexpr double kMostBands = 2e6;  // from the middle of the uppermost row to its end
  if (.5 * values.at("top") * view.width_px / view.height_px > kMostBands)
    throw_usage(option + ": chirp:top=" + format_double(values.at("top")) + " has more than " +
                format_double(kMostBands) + " bright bands on either side in a picture of " +
                std::to_string(view.width_px) + "x" + std::to_string(view.height_px) +
                "; take a smaller top, or a picture that is less wide");
  return std::make_unique<Chirp>(values, view);
}

}  // namespace

const FunctionEntry& chirp_function() {
  static const FunctionEntry entry{kInfo, make_chirp};
  return entry;
}

}  // namespace triad
