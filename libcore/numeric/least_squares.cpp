// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numeric>
#include <triad/numeric/least_squares.hpp>

namespace triad {
namespace {

// Below this share of the largest row, squares of entries leave the range of a double.
constexpr double kNegligible = 1e-150;

}  // namespace

WeightedLeastSquares::WeightedLeastSquares(int unknowns, int right_sides)
    : unknowns_(unknowns),
      right_sides_(right_sides),
      columns_(unknowns + right_sides),
      project_(2 * static_cast<size_t>(columns_)),
      pivot_(static_cast<size_t>(unknowns)) {}

void WeightedLeastSquares::add(double weight, const std::complex<double>* coefficients,
                               const std::complex<double>* right_sides) {
  const size_t stride = 2 * static_cast<size_t>(columns_);
  const size_t row = static_cast<size_t>(rows_++);
  if (raw_.size() < (row + 1) * stride) {
    raw_.resize((row + 1) * stride);
    work_.resize((row + 1) * stride);
    weights_.resize(row + 1);
    norms_.resize(row + 1);
    order_.resize(row + 1);
  }
  weights_[row] = weight;
  double* re = raw_.data() + row * stride;
  double* im = re + columns_;
  double largest = 0;
  for (int k = 0; k < columns_; ++k) {
    const std::complex<double> value = k < unknowns_ ? coefficients[k] : right_sides[k - unknowns_];
    re[k] = value.real();
    im[k] = value.imag();
    if (k < unknowns_) largest = std::max({largest, std::abs(re[k]), std::abs(im[k])});
  }
  norms_[row] = weight * largest;
}

WeightedLeastSquares::Result WeightedLeastSquares::solve(std::complex<double>* x) {
  const size_t stride = 2 * static_cast<size_t>(columns_);
  std::fill_n(x, static_cast<size_t>(unknowns_ * right_sides_), 0.0);
  const double largest = rows_ ? *std::max_element(norms_.begin(), norms_.begin() + rows_) : 0;
  if (!(largest > 0)) return {};

  std::iota(order_.begin(), order_.begin() + rows_, 0);
  std::stable_sort(order_.begin(), order_.begin() + rows_, [&](int a, int b) { return norms_[a] > norms_[b]; });
  int rows = 0;
  for (; rows < rows_ && norms_[order_[rows]] > kNegligible * largest; ++rows) {
    const double scale = weights_[order_[rows]] / largest;
    const double* from = raw_.data() + static_cast<size_t>(order_[rows]) * stride;
    double* to = work_.data() + static_cast<size_t>(rows) * stride;
    for (size_t k = 0; k < stride; ++k) to[k] = from[k] * scale;
  }
  const auto re = [&](int r, int c) -> double& { return work_[static_cast<size_t>(r) * stride + c]; };
  const auto im = [&](int r, int c) -> double& { return work_[static_cast<size_t>(r) * stride + columns_ + c]; };

  std::iota(pivot_.begin(), pivot_.end(), 0);
  int rank = 0;
  double first_diagonal = 0;
  for (; rank < std::min(rows, unknowns_); ++rank) {
    const int k = rank;
    // Norms are computed afresh: updating them is what makes pivoting go wrong when columns nearly cancel.
    int best = k;
    double best_norm2 = -1;
    for (int c = k; c < unknowns_; ++c) {
      double norm2 = 0;
      for (int r = k; r < rows; ++r) norm2 += re(r, c) * re(r, c) + im(r, c) * im(r, c);
      if (norm2 > best_norm2) best = c, best_norm2 = norm2;
    }
    const double norm = std::sqrt(best_norm2);
    if (k == 0) first_diagonal = norm;
    if (!(norm > kNegligible * first_diagonal)) break;
    if (best != k) {
      std::swap(pivot_[k], pivot_[best]);
      for (int r = 0; r < rows; ++r) {
        std::swap(re(r, k), re(r, best));
        std::swap(im(r, k), im(r, best));
      }
    }
    // v = x + phase(x0) ||x|| e1: adding, never subtracting, is part of what makes rows independent.
    const double head = std::hypot(re(k, k), im(k, k));
    const double phase_re = head > 0 ? re(k, k) / head : 1, phase_im = head > 0 ? im(k, k) / head : 0;
    const double v0_re = re(k, k) + phase_re * norm, v0_im = im(k, k) + phase_im * norm;
    re(k, k) = v0_re;
    im(k, k) = v0_im;
    const double beta = 1 / (norm * (norm + head));  // 2 / ||v||^2
    // project = beta v^H A, then A -= v project, over the remaining columns and all right sides.
    double* project_re = project_.data();
    double* project_im = project_re + columns_;
    std::fill(project_.begin(), project_.end(), 0.0);
    for (int r = k; r < rows; ++r) {
      const double v_re = re(r, k), v_im = im(r, k);
      const double* a_re = &re(r, 0);
      const double* a_im = &im(r, 0);
      for (int c = k + 1; c < columns_; ++c) {
        project_re[c] += v_re * a_re[c] + v_im * a_im[c];
        project_im[c] += v_re * a_im[c] - v_im * a_re[c];
      }
    }
    for (int c = k + 1; c < columns_; ++c) {
      project_re[c] *= beta;
      project_im[c] *= beta;
    }
    for (int r = k; r < rows; ++r) {
      const double v_re = re(r, k), v_im = im(r, k);
      double* a_re = &re(r, 0);
      double* a_im = &im(r, 0);
      for (int c = k + 1; c < columns_; ++c) {
        a_re[c] -= v_re * project_re[c] - v_im * project_im[c];
        a_im[c] -= v_re * project_im[c] + v_im * project_re[c];
      }
    }
    re(k, k) = -phase_re * norm;
    im(k, k) = -phase_im * norm;
  }

  // Back substitution. Columns past the rank stay zero.
  const auto divided = [&](double a_re, double a_im, int k) {
    const double d_re = re(k, k), d_im = im(k, k), size = std::hypot(d_re, d_im);
    const double u_re = d_re / size, u_im = d_im / size;
    return std::complex<double>((a_re * u_re + a_im * u_im) / size, (a_im * u_re - a_re * u_im) / size);
  };
  for (int k = rank - 1; k >= 0; --k) {
    std::complex<double>* target = x + static_cast<size_t>(pivot_[k]) * right_sides_;
    for (int s = 0; s < right_sides_; ++s) {
      double sum_re = re(k, unknowns_ + s), sum_im = im(k, unknowns_ + s);
      for (int c = k + 1; c < rank; ++c) {
        const std::complex<double> known = x[static_cast<size_t>(pivot_[c]) * right_sides_ + s];
        sum_re -= re(k, c) * known.real() - im(k, c) * known.imag();
        sum_im -= re(k, c) * known.imag() + im(k, c) * known.real();
      }
      target[s] = divided(sum_re, sum_im, k);
    }
  }

  Result result;
  result.rank = rank;
  if (rank == unknowns_) {
    // ||R^-1||: column by column of the inverse of the triangle.
    double norm2 = 0, inverse2 = 0;
    std::vector<std::complex<double>>& column = inverse_column_;
    column.resize(static_cast<size_t>(unknowns_));
    for (int c = 0; c < unknowns_; ++c) {
      for (int r = 0; r <= c; ++r) norm2 += re(r, c) * re(r, c) + im(r, c) * im(r, c);
      for (int r = c; r >= 0; --r) {
        double sum_re = r == c ? 1 : 0, sum_im = 0;
        for (int q = r + 1; q <= c; ++q) {
          sum_re -= re(r, q) * column[q].real() - im(r, q) * column[q].imag();
          sum_im -= re(r, q) * column[q].imag() + im(r, q) * column[q].real();
        }
        column[r] = divided(sum_re, sum_im, r);
        inverse2 += std::norm(column[r]);
      }
    }
    result.condition = std::sqrt(norm2) * std::sqrt(inverse2);
  }
  return result;
}

}  // namespace triad
