// SPDX-License-Identifier: Apache-2.0
// How an error falls with samples or seconds: its rate, what of it stays, and who reaches the same error sooner.
//
// Everything is fitted to logarithms, on which the error of a Monte Carlo picture scatters alike at any number of
// samples. All intervals are of 95 % and rest on Student's t: measurements independent, their scatter unknown and
// about normal on that scale. All functions are pure.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace triad {

// NaN where it is not known.
struct Interval {
  double value = std::numeric_limits<double>::quiet_NaN();
  double low = std::numeric_limits<double>::quiet_NaN(), high = std::numeric_limits<double>::quiet_NaN();
};

struct CostedError {
  double cost = 0;   // samples per pixel, or seconds; above 0
  double error = 0;  // above 0
};

// error = factor cost^slope, by least squares on the logarithms of both.
struct PowerLaw {
  size_t count = 0;
  Interval slope;                 // -1 for a squared error, -1/2 for its root, of independent samples
  double intercept = 0;           // log(error) at cost 1
  double scatter = 0;             // standard deviation of log(error) around the line, count - 2 degrees of freedom
  double centre = 0, spread = 0;  // mean of log(cost), and the sum of squares around it

  double error_at(double cost) const;
  double cost_at(double error) const;
};
// At least three points, at two or more costs; anything that is not finite or not above 0 is Error(kInternal).
PowerLaw fit_power_law(const std::vector<CostedError>& points);

// A point that the others do not expect: its residual, divided by the standard deviation that the others alone give
// it (externally studentized: Cook and Weisberg, Residuals and Influence in Regression, 1982, section 2.2), exceeds
// what Student's t has in one of 100 series (Bonferroni's correction for `count` points).
struct Outlier {
  size_t point = 0;
  double expected_cost = 0;  // at which the line through the others has its error
};
// A cost in words, for sentences that say "about": whole numbers from 1 to a million, else two digits; "inf", "nan".
std::string rough_cost(double cost);
// The most extreme one. Needs five points; none for fewer.
std::optional<Outlier> find_outlier(const std::vector<CostedError>& points);

// Squared error = floor + variance cost^-rate: what falls with more samples, the variance, and what does not, the
// squared bias and the reference's own noise.
struct ErrorFloor {
  // 0 or above. The interval is that of the profile likelihood: all floors whose best fit leaves no more than
  // (1 + t^2 / freedom) times the least sum of squares. low is 0 where the error may well fall for ever.
  Interval floor;
  double variance = 0, rate = 0;
  double scatter = 0;  // as in PowerLaw
  bool found() const { return floor.low > 0; }
};
// Nonlinear least squares of log(error). The rate is the given one, 1 for independent samples, or fitted too where
// there is none; that takes four points, three otherwise, at as many costs or nearly (else the floor's interval
// begins at 0). `error` of the points is a squared one.
ErrorFloor fit_floor(const std::vector<CostedError>& points, std::optional<double> rate);

// Of values above 0: the geometric mean with its interval, which is NaN for fewer than two.
Interval geometric_mean(const std::vector<double>& values);

// The errors that both series reach, from the larger of both least ones to the smaller of both largest.
std::optional<std::pair<double, double>> common_errors(const std::vector<CostedError>& a,
                                                       const std::vector<CostedError>& b);

// What `b` costs over what `a` costs, both by their lines at the same error: how many times a is as fast. The
// interval is of the difference of two inverse regressions (delta method), with the degrees of freedom of Welch and
// Satterthwaite. NaN where a line does not fall.
Interval cost_ratio(const PowerLaw& a, const PowerLaw& b, double error);

}  // namespace triad
