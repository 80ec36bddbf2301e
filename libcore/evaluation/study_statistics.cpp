// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/evaluation/study_statistics.hpp>

namespace triad {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// The continued fraction of the incomplete beta function I_x(a, b), by Lentz's algorithm (Applied Optics 15, 1976);
// converges quickly for x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;  // in place of a zero divisor
  constexpr int kMostTerms = 10000;
  const auto guarded = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1, d = 1 / guarded(1 - (a + b) * x / (a + 1)), value = d;
  for (int m = 1; m <= kMostTerms; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / guarded(1 + even * d);
    c = guarded(1 + even / c);
    value *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / guarded(1 + odd * d);
    c = guarded(1 + odd / c);
    value *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return value;
}

// x and 1 - x are both given, as the difference would lose the digits of a small one.
double incomplete_beta(double a, double b, double x, double rest) {
  if (x <= 0) return 0;
  if (rest <= 0) return 1;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log(rest));
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, rest) / b;
}

// The sum of squared deviations over n - 1.
double variance_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return sum / static_cast<double>(values.size() - 1);
}

bool all_same(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [&](double v) { return v == values[0]; });
}

}  // namespace

double student_cumulative(double t, double freedom) {
  if (!(freedom > 0)) throw_internal("Student's t needs more than 0 degrees of freedom");
  if (std::isnan(t)) return kNan;
  if (std::isinf(t)) return t > 0 ? 1 : 0;
  const double x = freedom / (freedom + t * t), rest = t * t / (freedom + t * t);
  const double tail = incomplete_beta(freedom / 2, .5, x, rest) / 2;
  return t > 0 ? 1 - tail : tail;
}

double student_quantile(double p, double freedom) {
  if (!(p > 0 && p < 1)) throw_internal("a quantile is asked for between 0 and 1");
  if (p > .5) return -student_quantile(1 - p, freedom);
  if (p == .5) return 0;
  double low = -1, high = 0;
  while (student_cumulative(low, freedom) > p) low *= 2;
  for (double middle = low / 2; middle > low && middle < high; middle = low + (high - low) / 2)
    (student_cumulative(middle, freedom) > p ? high : low) = middle;
  return high;
}

double mean_of(const std::vector<double>& values) {
  if (values.empty()) return kNan;
  if (all_same(values)) return values[0];  // infinite ones, too
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double half_width_95(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  if (n < 2) return kNan;
  if (all_same(values)) return 0;
  return student_quantile(.975, n - 1) * std::sqrt(variance_of(values) / n);
}

LessThanTest test_less(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() < 2 || b.size() < 2) return {kNan, kNan, kNan};
  const auto n_a = static_cast<double>(a.size()), n_b = static_cast<double>(b.size());
  const double difference = mean_of(a) - mean_of(b);
  const double error_a = variance_of(a) / n_a, error_b = variance_of(b) / n_b, error = error_a + error_b;
  if (error == 0) {
    const double t = difference == 0 ? 0 : std::copysign(std::numeric_limits<double>::infinity(), difference);
    return {t, n_a + n_b - 2, t == 0 ? .5 : t < 0 ? 0. : 1.};
  }
  const double freedom = error * error / (error_a * error_a / (n_a - 1) + error_b * error_b / (n_b - 1));
  const double t = difference / std::sqrt(error);
  return {t, freedom, student_cumulative(t, freedom)};
}

}  // namespace triad
