// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/display/filter_design.hpp>
#include <triad/display/internal/tile_equations.hpp>
#include <triad/numeric/least_squares.hpp>

namespace triad {
namespace {

using Complex = std::complex<double>;

// Plain products: std::complex's own call a function that looks for infinities.
Complex times(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

// The equations of tile frequency m, solved for the difference to the displaced box. That form needs no
// right side for the regulariser, and gives the box itself where nothing determines the drives.
class TileFrequency {
 public:
  explicit TileFrequency(const TileEquations& equations)
      : k_(equations),
        solver_(3, 3 * equations.aliases_x()),
        box_(3 * static_cast<size_t>(equations.aliases_x())),
        rhs_(3 * static_cast<size_t>(equations.aliases_x())) {
    for (int e = 0; e < 3; ++e) window_[e] = displaced_box(equations.layout(), e);
  }

  // H[emitter][alias][rgb] of this frequency.
  WeightedLeastSquares::Result solve(int m, const FilterOptions& options, Complex* H) {
    const int S = k_.aliases_x(), T = k_.tiles_x();
    const int64_t N = k_.cells_x();
    for (int e = 0; e < 3; ++e)
      for (int j = 0; j < S; ++j) {
        Complex sum = 0;
        for (size_t i = 0; i < window_[e].weights.size(); ++i)
          sum += window_[e].weights[i] *
                 std::conj(turned(window_[e].first_cell + static_cast<int>(i), m + static_cast<int64_t>(T) * j, N));
        box_[static_cast<size_t>(e * S + j)] = sum / static_cast<double>(S);
      }

    solver_.clear();
    for (int j = 0; j < S; ++j) {
      const int n = m + T * j;
      double keep, transfer, re[3], im[3];
      k_.keep(m, 1, 0, j, 0, &keep);
      k_.light(n, 1, 0, re, im, 1);
      for (int c = 0; c < 3; ++c) {
        Complex p[3];
        for (int e = 0; e < 3; ++e) p[e] = k_.weight(c, e) * Complex(re[e], im[e]);
        std::fill(rhs_.begin(), rhs_.end(), 0.0);
        for (int d = 0; d < 3; ++d) rhs_[static_cast<size_t>(3 * j + d)] += k_.opponent()[3 * c + d] / S;
        for (int e = 0; e < 3; ++e) {
          const int d = k_.layout().emitters[e].channel;
          for (int i = 0; i < S; ++i)
            rhs_[static_cast<size_t>(3 * i + d)] -= keep * times(p[e], box_[static_cast<size_t>(e * S + i)]);
        }
        k_.transfer(c, n, 1, 0, &transfer);
        solver_.add(transfer, p, rhs_.data());
      }
    }
    std::fill(rhs_.begin(), rhs_.end(), 0.0);
    for (int e = 0; e < 3; ++e) {
      Complex unit[3] = {0, 0, 0};
      unit[e] = 1;
      if (options.lambda > 0) solver_.add(options.lambda * std::sqrt(k_.regulariser(e)), unit, rhs_.data());
    }
    const auto result = solver_.solve(H);
    for (int e = 0; e < 3; ++e)
      for (int j = 0; j < S; ++j)
        H[(e * S + j) * 3 + k_.layout().emitters[e].channel] += box_[static_cast<size_t>(e * S + j)];
    return result;
  }

 private:
  const TileEquations& k_;
  WeightedLeastSquares solver_;
  BoxWindow window_[3];
  std::vector<Complex> box_;  // [emitter][alias]: the displaced box's transfer function over S
  std::vector<Complex> rhs_;  // [alias][rgb]
};

}  // namespace

FilterDesign::FilterDesign(const Layout& layout, const Observer& observer, int tiles, const FilterOptions& options)
    : layout_(layout), tiles_(tiles), exact_flat_fields_(options.exact_flat_fields) {
  require_rows(layout);
  const TileEquations equations(layout_, observer, options, tiles, 1);
  TileFrequency frequency(equations);
  const size_t stride = 9 * static_cast<size_t>(aliases());
  transfer_.resize((static_cast<size_t>(tiles) / 2 + 1) * stride);
  for (int m = 0; m <= tiles / 2; ++m) {
    const auto result = frequency.solve(m, options, transfer_.data() + static_cast<size_t>(m) * stride);
    condition_ = std::max(condition_, result.condition);
    fallback_frequencies_ += result.rank < 3;
  }
}

}  // namespace triad
