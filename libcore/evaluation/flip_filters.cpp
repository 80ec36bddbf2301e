// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/flip_filters.hpp>

namespace triad {
namespace {

// Andersson et al. 2020, table 1.
struct Sensitivity {
  double a, b;
};
constexpr Sensitivity kAchromatic{1, .0047}, kRedGreen{1, .0053}, kBlueYellowWide{34.1, .04},
    kBlueYellowNarrow{13.5, .025};
constexpr float kWidest = .04f;
constexpr float kEdgeWidth_deg = .082f;

// Weights this far below the largest change nothing in single precision.
constexpr double kNegligible = 1e-9;

using Half = std::vector<double>;

double sum_of(const Half& half) {
  double sum = half[0];
  for (size_t k = 1; k < half.size(); ++k) sum += 2 * half[k];
  return sum;
}

// One factor of the two-dimensional Gaussian.
Half factor(const Sensitivity& s, int radius, double ppd) {
  Half half;
  for (int k = 0; k <= radius; ++k) {
    const double x_deg = k / ppd;
    half.push_back(std::sqrt(s.a * std::sqrt(std::numbers::pi / s.b)) *
                   std::exp(-std::numbers::pi * std::numbers::pi * x_deg * x_deg / s.b));
  }
  return half;
}

std::vector<float> scaled(const Half& half, double by) {
  std::vector<float> weights;
  for (const double w : half) weights.push_back(static_cast<float>(w * by));
  return weights;
}

std::vector<float> shortened(std::vector<float> weights) {
  while (weights.size() > 1 &&
         std::abs(static_cast<double>(weights.back())) < kNegligible * std::abs(static_cast<double>(weights.front())))
    weights.pop_back();
  return weights;
}

}  // namespace

FlipFilters::FlipFilters(double ppd) {
  if (!(ppd >= kLeast_ppd && ppd <= kMost_ppd))
    throw_usage("FLIP is defined for " + format_double(kLeast_ppd) + " to " + format_double(kMost_ppd) +
                " pixels per degree, not " + format_double(ppd));
  // In single precision, as in the authors' program: where a radius is nearly whole, the last bit decides it.
  const auto ppd_float = static_cast<float>(ppd);
  const auto pi_squared = static_cast<float>(std::numbers::pi * std::numbers::pi);
  const int sensitivity_radius =
      static_cast<int>(std::ceil(3.f * std::sqrt(kWidest / (2.f * pi_squared)) * ppd_float));
  const float deviation_px = .5f * kEdgeWidth_deg * ppd_float;
  const int edge_radius = static_cast<int>(std::ceil(3.f * deviation_px));

  const Half wide = factor(kBlueYellowWide, sensitivity_radius, ppd),
             narrow = factor(kBlueYellowNarrow, sensitivity_radius, ppd);
  const double volume = std::hypot(sum_of(wide), sum_of(narrow));
  blue_yellow_wide = scaled(wide, 1 / volume);
  blue_yellow_narrow = scaled(narrow, 1 / volume);
  const auto alone = [&](const Sensitivity& s) {
    const Half half = factor(s, sensitivity_radius, ppd);
    return shortened(scaled(half, 1 / sum_of(half)));
  };
  achromatic = alone(kAchromatic);
  red_green = alone(kRedGreen);

  Half g, dg, ddg;
  double dg_sum = 0, negative = 0, positive = 0;
  const double deviation = static_cast<double>(deviation_px);
  for (int k = 0; k <= edge_radius; ++k) {
    const double x = k / deviation, value = std::exp(-.5 * x * x), bend = (x * x - 1) * value;
    g.push_back(value);
    dg.push_back(k * value);
    ddg.push_back(bend);
    dg_sum += dg.back();
    (bend > 0 ? positive : negative) += (k == 0 ? 1 : 2) * std::abs(bend);
  }
  for (double& w : ddg) w /= w > 0 ? positive : negative;
  gaussian = scaled(g, 1 / sum_of(g));
  first_derivative = scaled(dg, 1 / dg_sum);
  second_derivative = scaled(ddg, 1);
}

int FlipFilters::reach_px() const { return static_cast<int>(std::max(blue_yellow_wide.size(), gaussian.size())) - 1; }

}  // namespace triad
