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

  // All of this in single precision and in that order, too: what the weights lack of a sum of 0 shows in flat areas.
  float sum = 0, dg_positive = 0, dg_negative = 0, ddg_positive = 0, ddg_negative = 0;
  for (int k = -edge_radius; k <= edge_radius; ++k) {
    const auto x = static_cast<float>(k);
    const float g = std::exp(-(x * x) / (2.f * deviation_px * deviation_px)), dg = -x * g;
    const float ddg = (x * x / (deviation_px * deviation_px) - 1.f) * g;
    sum += g;
    (dg > 0 ? dg_positive : dg_negative) += std::abs(dg);
    (ddg > 0 ? ddg_positive : ddg_negative) += std::abs(ddg);
    gaussian.push_back(g);
    first_derivative.push_back(dg);
    second_derivative.push_back(ddg);
  }
  for (float& w : gaussian) w /= sum;
  for (float& w : first_derivative) w /= w > 0 ? dg_positive : dg_negative;
  for (float& w : second_derivative) w /= w > 0 ? ddg_positive : ddg_negative;
}

int FlipFilters::reach_px() const {
  return static_cast<int>(std::max(blue_yellow_wide.size() - 1, gaussian.size() / 2));
}

}  // namespace triad
