// SPDX-License-Identifier: Apache-2.0
#include <complex>
#include <triad/numeric/fresnel.hpp>
#include <triad/sampling/function_base.hpp>

namespace triad {
namespace {

using Complex = std::complex<double>;

const FunctionInfo kInfo{
    "zone-plate", "rings that get finer outwards, every frequency in every direction",
    "1/2 + 1/2 cos(a r^2) about the picture's middle. Its frequency grows evenly with the distance, to 4 rings / s "
    "cycles a pixel at the nearest edge, s being the smaller of width and height: with the default it passes half a "
    "cycle there, beyond which a picture can only alias or be grey, if s is below 480. Its exact picture is made of "
    "Fresnel integrals.",
    with_tones({{"rings", "from the middle to the nearest edge", .01, 1e6, 60, true}})};

class ZonePlate final : public TonesOf<ZonePlate> {
 public:
  ZonePlate(const StrategyValues& values, const View& view)
      : TonesOf(values, view), middle_x_(.5 * view.width_px), middle_y_(.5 * view.height_px) {
    const double edge = std::min(middle_x_, middle_y_);
    a_ = 2 * std::numbers::pi * values.at("rings") / (edge * edge);
  }

 private:
  friend TonesOf;
  double tone(double x, double y) const {
    const double dx = x - middle_x_, dy = y - middle_y_;
    return .5 + .5 * std::cos(a_ * (dx * dx + dy * dy));
  }
  double tone_in(const Box& box) const override {
    return .5 + .5 * (mean_chirp(a_, box.x0 - middle_x_, box.x1 - middle_x_) *
                      mean_chirp(a_, box.y0 - middle_y_, box.y1 - middle_y_))
                         .real();
  }
  MaybeTone gaussian_tone(Axes centre, Axes sigma_px) const override {
    // The mean of exp(i a t^2) for t normally distributed about t0: q^-1/2 exp(i a t0^2 / q), q = 1 - 2 i a sigma^2.
    const auto axis = [&](double t0, double sigma) {
      const Complex q(1, -2 * a_ * sigma * sigma);
      return std::exp(Complex(0, a_ * t0 * t0) / q) / std::sqrt(q);
    };
    return .5 + .5 * (axis(centre.x - middle_x_, sigma_px.x) * axis(centre.y - middle_y_, sigma_px.y)).real();
  }

  double middle_x_, middle_y_, a_;
};

}  // namespace

const FunctionEntry& zone_plate_function() {
  static const FunctionEntry entry = function_entry<ZonePlate>(kInfo);
  return entry;
}

}  // namespace triad
