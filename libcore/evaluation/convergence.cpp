// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <triad/base/error.hpp>
#include <triad/evaluation/convergence.hpp>
#include <triad/evaluation/study_statistics.hpp>

namespace triad {
namespace {

constexpr double kTwoSided = .975;  // of 95 %
// Two measurements do not scatter less than the arithmetic that made them.
constexpr double kLeastScatter = 1e-9;

struct Logs {
  std::vector<double> cost, error;
};

Logs logarithms(const std::vector<CostedError>& points) {
  Logs logs;
  for (const CostedError& point : points) {
    if (!(point.cost > 0 && point.error > 0 && std::isfinite(point.cost) && std::isfinite(point.error)))
      throw_internal("a cost or an error that has no logarithm");
    logs.cost.push_back(std::log(point.cost));
    logs.error.push_back(std::log(point.error));
  }
  return logs;
}

// The best fit of log(b + exp(c - a x)) for one b, by damped Gauss-Newton steps over c and, if it is free, a.
class Profile {
 public:
  Profile(Logs logs, std::optional<double> rate) : logs_(std::move(logs)), free_(!rate), rate_(rate.value_or(1)) {
    centre_ = mean_of(logs_.cost);
    for (double& x : logs_.cost) x -= centre_;
    log_variance_ = mean_of(logs_.error) + rate_ * mean_of(logs_.cost);
  }

  double squares(double b) {
    double best = sum(b, log_variance_, rate_);
    double damping = 1e-6;
    for (int step = 0; step < kMostSteps && damping < kGivenUp; ++step) {
      const auto [dc, da] = direction(b, damping);
      const double c = log_variance_ + dc, a = std::clamp(rate_ + da, kLeastRate, kMostRate);
      const double tried = sum(b, c, free_ ? a : rate_);
      if (!(tried < best)) {
        damping = std::max(damping, 1e-6) * 10;
        continue;
      }
      const bool done = best - tried <= 1e-14 * best;
      log_variance_ = c;
      if (free_) rate_ = a;
      best = tried;
      damping /= 10;
      if (done) break;
    }
    return best;
  }

  double rate() const { return rate_; }
  double variance() const { return std::exp(log_variance_ + rate_ * centre_); }

 private:
  static constexpr int kMostSteps = 60;
  static constexpr double kGivenUp = 1e12, kLeastRate = .01, kMostRate = 6;

  double sum(double b, double c, double a) const {
    double total = 0;
    for (size_t i = 0; i < logs_.cost.size(); ++i) {
      const double r = logs_.error[i] - std::log(b + std::exp(c - a * logs_.cost[i]));
      total += r * r;
    }
    return total;
  }

  std::pair<double, double> direction(double b, double damping) const {
    double cc = 0, ca = 0, aa = 0, rc = 0, ra = 0;
    for (size_t i = 0; i < logs_.cost.size(); ++i) {
      const double falling = std::exp(log_variance_ - rate_ * logs_.cost[i]), model = b + falling;
      const double r = logs_.error[i] - std::log(model), by_c = falling / model, by_a = -logs_.cost[i] * by_c;
      cc += by_c * by_c;
      ca += by_c * by_a;
      aa += by_a * by_a;
      rc += r * by_c;
      ra += r * by_a;
    }
    constexpr double kTiny = 1e-300;
    const double c = cc * (1 + damping) + kTiny;
    // Long steps of a logarithm would leave the range in which the model says anything.
    const auto bounded = [](double v) { return std::clamp(v, -3., 3.); };
    if (!free_) return {bounded(rc / c), 0};
    const double a = aa * (1 + damping) + kTiny, det = c * a - ca * ca;
    if (!(det > 0)) return {bounded(rc / c), 0};
    return {bounded((rc * a - ra * ca) / det), bounded((ra * c - rc * ca) / det)};
  }

  Logs logs_;
  bool free_;
  double rate_, log_variance_ = 0, centre_ = 0;
};

double golden_section(const std::function<double(double)>& f, double low, double high) {
  constexpr double kRatio = .6180339887498949;
  double a = high - kRatio * (high - low), b = low + kRatio * (high - low), fa = f(a), fb = f(b);
  for (int i = 0; i < 60; ++i) {
    if (fa < fb) {
      high = b;
      b = a;
      fb = fa;
      a = high - kRatio * (high - low);
      fa = f(a);
    } else {
      low = a;
      a = b;
      fa = fb;
      b = low + kRatio * (high - low);
      fb = f(b);
    }
  }
  return (low + high) / 2;
}

// Where f crosses 0 between two places on either side of it.
double bisect(const std::function<double(double)>& f, double below, double above) {
  for (int i = 0; i < 60; ++i) {
    const double middle = (below + above) / 2;
    (f(middle) > 0 ? above : below) = middle;
  }
  return (below + above) / 2;
}

}  // namespace

double PowerLaw::error_at(double cost) const { return std::exp(intercept + slope.value * std::log(cost)); }
double PowerLaw::cost_at(double error) const { return std::exp((std::log(error) - intercept) / slope.value); }

PowerLaw fit_power_law(const std::vector<CostedError>& points) {
  if (points.size() < 3) throw_internal("a line with its scatter needs three points");
  const Logs logs = logarithms(points);
  PowerLaw law;
  law.count = points.size();
  law.centre = mean_of(logs.cost);
  const double middle = mean_of(logs.error);
  double product = 0, squares = 0;
  for (size_t i = 0; i < law.count; ++i) {
    law.spread += (logs.cost[i] - law.centre) * (logs.cost[i] - law.centre);
    product += (logs.cost[i] - law.centre) * (logs.error[i] - middle);
  }
  if (!(law.spread > 0)) throw_internal("a line needs two different costs");
  law.slope.value = product / law.spread;
  law.intercept = middle - law.slope.value * law.centre;
  for (size_t i = 0; i < law.count; ++i) {
    const double r = logs.error[i] - middle - law.slope.value * (logs.cost[i] - law.centre);
    squares += r * r;
  }
  const auto freedom = static_cast<double>(law.count - 2);
  law.scatter = std::sqrt(squares / freedom);
  const double half = student_quantile(kTwoSided, freedom) * law.scatter / std::sqrt(law.spread);
  law.slope.low = law.slope.value - half;
  law.slope.high = law.slope.value + half;
  return law;
}

std::optional<Outlier> find_outlier(const std::vector<CostedError>& points) {
  if (points.size() < 5) return std::nullopt;
  const auto n = static_cast<double>(points.size());
  std::optional<Outlier> found;
  double most = student_quantile(1 - .01 / (2 * n), n - 3);
  for (size_t i = 0; i < points.size(); ++i) {
    std::vector<CostedError> others = points;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    if (std::all_of(others.begin(), others.end(), [&](const CostedError& p) { return p.cost == others[0].cost; }))
      continue;
    const PowerLaw law = fit_power_law(others);
    const double x = std::log(points[i].cost) - law.centre;
    const double residual = std::log(points[i].error) - std::log(law.error_at(points[i].cost));
    const double deviation = std::max(law.scatter, kLeastScatter) * std::sqrt(1 + 1 / (n - 1) + x * x / law.spread);
    if (!(std::abs(residual) / deviation > most)) continue;
    most = std::abs(residual) / deviation;
    found = Outlier{i, law.cost_at(points[i].error)};
  }
  return found;
}

std::string rough_cost(double cost) {
  const bool whole = cost >= 1 && cost < 1e6;
  char text[32];
  std::snprintf(text, sizeof text, whole ? "%.0f" : "%.2g", cost);
  return text;
}

ErrorFloor fit_floor(const std::vector<CostedError>& points, std::optional<double> rate) {
  const size_t parameters = rate ? 2 : 3;
  if (points.size() <= parameters) throw_internal("a floor needs more points than it has parameters");
  const Logs logs = logarithms(points);
  const auto freedom = static_cast<double>(points.size() - parameters);
  const double least = std::exp(*std::min_element(logs.error.begin(), logs.error.end()));

  // Floors from 0 to many times the least error; the profile may be flat at either end. Each fit starts from the
  // last.
  Profile profile(logs, rate);
  const double without = profile.squares(0);
  constexpr double kLowest = -14, kHighest = 3, kStep = .125;  // logarithms, relative to `least`
  double best_log = kLowest, best = without;
  bool at_zero = true;
  Profile best_profile = profile;
  for (double u = kLowest; u <= kHighest; u += kStep) {
    const double squares = profile.squares(least * std::exp(u));
    if (squares < best) {
      best = squares;
      best_log = u;
      best_profile = profile;
      at_zero = false;
    }
  }
  const auto squares_at = [&](double u) {
    Profile one = best_profile;
    return one.squares(least * std::exp(u));
  };
  ErrorFloor result;
  Profile final = best_profile;
  result.floor.value = 0;
  if (!at_zero) {
    best_log = golden_section(squares_at, best_log - kStep, best_log + kStep);
    best = std::min(best, final.squares(least * std::exp(best_log)));
    result.floor.value = least * std::exp(best_log);
  }
  const auto n = static_cast<double>(points.size());
  const double counted = std::max(best, n * kLeastScatter * kLeastScatter);
  const double t = student_quantile(kTwoSided, freedom), most = best + counted * t * t / freedom;
  const auto excess = [&](double u) { return squares_at(u) - most; };
  const double from = at_zero ? kLowest : best_log;
  result.floor.low = 0;
  if (without > most && !at_zero) {
    // squares_at(kLowest) is that of no floor at all, but for a part in a million.
    result.floor.low =
        least * std::exp(excess(kLowest) > 0 ? bisect([&](double u) { return -excess(u); }, kLowest, from) : kLowest);
  }
  double above = from;
  while (above <= kHighest && !(excess(above) > 0)) above += kStep;
  result.floor.high =
      above > kHighest ? std::numeric_limits<double>::infinity() : least * std::exp(bisect(excess, from, above));
  result.variance = final.variance();
  result.rate = final.rate();
  result.scatter = std::sqrt(best / freedom);
  return result;
}

Interval geometric_mean(const std::vector<double>& values) {
  std::vector<double> logs;
  for (const double value : values) logs.push_back(std::log(value));
  const double mean = mean_of(logs), half = half_width_95(logs);
  return {std::exp(mean), std::exp(mean - half), std::exp(mean + half)};
}

std::optional<std::pair<double, double>> common_errors(const std::vector<CostedError>& a,
                                                       const std::vector<CostedError>& b) {
  const auto range = [](const std::vector<CostedError>& points) {
    const auto [low, high] = std::minmax_element(points.begin(), points.end(),
                                                 [](const auto& p, const auto& q) { return p.error < q.error; });
    return std::pair{low->error, high->error};
  };
  const auto of_a = range(a), of_b = range(b);
  const double low = std::max(of_a.first, of_b.first), high = std::min(of_a.second, of_b.second);
  if (!(low < high)) return std::nullopt;
  return std::pair{low, high};
}

Interval cost_ratio(const PowerLaw& a, const PowerLaw& b, double error) {
  if (!(a.slope.value < 0 && b.slope.value < 0)) return {};
  const auto variance = [&](const PowerLaw& law) {
    const double x = std::log(law.cost_at(error)) - law.centre;
    return law.scatter * law.scatter / (law.slope.value * law.slope.value) *
           (1 / static_cast<double>(law.count) + x * x / law.spread);
  };
  const double of_a = variance(a), of_b = variance(b), sum = of_a + of_b;
  const double log_ratio = std::log(b.cost_at(error)) - std::log(a.cost_at(error));
  if (sum == 0) return {std::exp(log_ratio), std::exp(log_ratio), std::exp(log_ratio)};
  const double freedom =
      sum * sum / (of_a * of_a / static_cast<double>(a.count - 2) + of_b * of_b / static_cast<double>(b.count - 2));
  const double half = student_quantile(kTwoSided, freedom) * std::sqrt(sum);
  return {std::exp(log_ratio), std::exp(log_ratio - half), std::exp(log_ratio + half)};
}

}  // namespace triad
