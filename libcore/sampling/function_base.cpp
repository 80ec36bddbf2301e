// SPDX-License-Identifier: Apache-2.0
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/sampling/function_base.hpp>

namespace triad {

void require_length(const FunctionInfo& info, const StrategyValues& values, const std::string& name, const View& view,
                    double least_px, const std::string& option) {
  if (length_px(values, name, view) >= least_px) return;
  throw_usage(option + ": " + info.name + " with " + name + "=" + format_double(values.at(name)) +
              " and rows=" + format_double(values.at("rows")) + " repeats within less than " +
              format_double(least_px) + " pixels of a picture of " + std::to_string(view.width_px) + "x" +
              std::to_string(view.height_px) + "; take a larger " + name);
}

double cumulative_at(const SeparableFilter& filter, double t_px) {
  if (filter.gaussian_sigma_px > 0) return .5 * std::erfc(-t_px / filter.gaussian_sigma_px / std::numbers::sqrt2);
  if (t_px <= -filter.radius_px) return 0;
  return t_px >= filter.radius_px ? 1 : filter.cumulative(t_px);
}

double filtered_square_wave(double u, double per_px, const SeparableFilter& filter) {
  constexpr double kGaussianEnd = 9;  // sigmas: 1e-19 of it lies beyond
  const double radius_px = filter.gaussian_sigma_px > 0 ? kGaussianEnd * filter.gaussian_sigma_px : filter.radius_px;
  double mean = 0, from_px = -radius_px, from = 0;
  double sign = square_wave(u - radius_px * per_px);
  for (double edge = std::floor(u - radius_px * per_px) + 1;; ++edge) {
    const double to_px = std::min(radius_px, std::max(from_px, (edge - u) / per_px));
    const double to = to_px < radius_px ? cumulative_at(filter, to_px) : 1;
    mean += sign * (to - from);
    if (to_px >= radius_px) return mean;
    sign = -sign;
    from_px = to_px;
    from = to;
  }
}

}  // namespace triad
