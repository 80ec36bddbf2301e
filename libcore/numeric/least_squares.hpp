// SPDX-License-Identifier: Apache-2.0
// Small complex least squares whose equations weigh wildly different amounts.
#pragma once

#include <complex>
#include <vector>

namespace triad {

// Minimises sum_r weight_r^2 |coefficients_r x - right_side_r|^2 for several right sides at once, by
// Householder QR with the weighted rows sorted by size and the columns pivoted. That form is backward stable
// row by row (Powell and Reid 1969; Cox and Higham, "Stability of Householder QR factorization for weighted
// least squares problems", 1998): weights of 1 and 1e-15 in one system cost no accuracy, where normal
// equations and plain QR lose all of it (tests/stability/filter_design_test.cpp).
//
// Equations more than 1e-150 times smaller than the largest count as absent. Where the rest do not determine
// every unknown, the undetermined ones are zero.
//
// Holds its working memory, to be used again for many systems of one shape; not thread-safe.
class WeightedLeastSquares {
 public:
  WeightedLeastSquares(int unknowns, int right_sides);

  void clear() { rows_ = 0; }
  // Appends an equation. coefficients[unknowns], right_sides[right_sides]; weight >= 0.
  void add(double weight, const std::complex<double>* coefficients, const std::complex<double>* right_sides);

  struct Result {
    int rank = 0;
    // ||R|| ||R^-1|| in the Frobenius norm, of the weighted matrix: between the condition number and
    // `unknowns` times it. 0 unless the rank is full.
    double condition = 0;
  };
  // x[unknown * right_sides + right_side].
  Result solve(std::complex<double>* x);

 private:
  int unknowns_, right_sides_, columns_, rows_ = 0;
  std::vector<double> weights_;
  std::vector<double> raw_, work_;  // per row: the real parts of all columns, then the imaginary parts
  std::vector<double> norms_, project_;
  std::vector<std::complex<double>> inverse_column_;
  std::vector<int> order_, pivot_;
};

}  // namespace triad
