// SPDX-License-Identifier: Apache-2.0
// What a few repeated measurements say: Student's t distribution, confidence intervals, a one-tailed test.
#pragma once

#include <vector>

namespace triad {

// The probability that Student's t with `freedom` degrees of freedom (above 0, not necessarily whole) is at most `t`.
// By the incomplete beta function, its continued fraction 8.17.22 of the NIST Digital Library of Mathematical
// Functions; to about 1e-13.
double student_cumulative(double t, double freedom);

// The t that it stays below with probability p in (0, 1): student_quantile(.975, 4) is 2.776.
double student_quantile(double p, double freedom);

double mean_of(const std::vector<double>& values);  // NaN for none
// Half the width of the interval around the mean that holds the expectation of independent, normal values with 95 %
// confidence: t(.975, n - 1) s / sqrt(n). 0 where all values are the same, NaN for fewer than two.
double half_width_95(const std::vector<double>& values);

// Welch's test (Biometrika 34, 1947) of whether `a` has the smaller expectation, the variances not taken to be alike.
struct LessThanTest {
  double t = 0;        // (mean a - mean b) / its standard error: negative where a is smaller
  double freedom = 0;  // by Welch and Satterthwaite
  double p = 0;        // the probability of such a t or a smaller one where a is no smaller than b
};
// NaN in all three for fewer than two values on either side. Values that are all the same on both sides have an
// infinite t (0 where they are equal) and p 0, 1/2 or 1.
LessThanTest test_less(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace triad
