// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/display/filter_design.hpp>
#include <triad/numeric/least_squares.hpp>

namespace triad {
namespace {

constexpr int kMaxTiles = 1 << 27;      // keeps cells and products with cell offsets inside 32 bits
constexpr double kFlatWindow_px = 1.5;  // sigma of the window in which flat fields are protected
using Complex = std::complex<double>;

// exp(2 pi i k n / N) with the product reduced exactly, so that no accuracy is lost on long rows.
Complex unit_root(int64_t k, int64_t n, int64_t N) {
  int64_t r = k * n % N;
  if (r < 0) r += N;
  const double angle = 2 * std::numbers::pi * static_cast<double>(r) / static_cast<double>(N);
  return {std::cos(angle), std::sin(angle)};
}

// Plain products: std::complex's own call a function that looks for infinities.
Complex times(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

// Everything that does not depend on the frequency.
struct Constants {
  const Layout& layout;
  const Observer& observer;
  int S, T;
  std::array<double, 9> opponent;  // C, [channel][rgb]
  double emitter_opponent[3][3];   // C P_e, [emitter][channel]
  double regulariser[3];           // sqrt(D_e)
  BoxWindow box[3];

  Constants(const Layout& l, const Observer& o, int tiles)
      : layout(l), observer(o), S(l.cells_x), T(tiles), opponent(opponent_matrix(o)) {
    for (int e = 0; e < 3; ++e) {
      const Emitter& emitter = layout.emitters[e];
      double norm2 = 0, shares2 = 0;
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int d = 0; d < 3; ++d) sum += opponent[3 * c + d] * emitter.primary[d];
        emitter_opponent[e][c] = sum;
        norm2 += sum * sum;
      }
      for (const EmitterCell& cell : emitter.cells) shares2 += cell.share * cell.share;
      // D_e = G^2 / S * sum of share^2 * ||C P_e||^2, with G = S for tiles of one pixel.
      regulariser[e] = std::sqrt(S * shares2 * norm2);
      box[e] = displaced_box(layout, e);
    }
  }
};

// The equations of tile frequency m, solved for the difference to the displaced box. That form needs no
// right side for the regulariser, and gives the box itself where nothing determines the drives.
class TileFrequency {
 public:
  explicit TileFrequency(const Constants& constants)
      : k_(constants),
        solver_(3, 3 * constants.S),
        box_(3 * static_cast<size_t>(constants.S)),
        rhs_(3 * static_cast<size_t>(constants.S)) {}

  // H[emitter][alias][rgb] of this frequency.
  WeightedLeastSquares::Result solve(int m, const FilterOptions& options, Complex* H) {
    const int S = k_.S, T = k_.T;
    const int64_t N = static_cast<int64_t>(S) * T;
    const double window_phase = 2 * std::numbers::pi * kFlatWindow_px * m / T;
    const double window = std::exp(-.5 * window_phase * window_phase);

    for (int e = 0; e < 3; ++e)
      for (int j = 0; j < S; ++j) {
        Complex sum = 0;
        const BoxWindow& box = k_.box[e];
        for (size_t i = 0; i < box.weights.size(); ++i)
          sum += box.weights[i] * unit_root(box.first_cell + static_cast<int>(i), m + static_cast<int64_t>(T) * j, N);
        box_[static_cast<size_t>(e * S + j)] = sum / static_cast<double>(S);
      }

    solver_.clear();
    for (int j = 0; j < S; ++j) {
      const int64_t n = m + static_cast<int64_t>(T) * j;
      const int64_t folded = std::min(n, N - n);
      const double f_cpd = static_cast<double>(folded) / static_cast<double>(N) * S * k_.observer.ppd;
      // At half the tile frequency two aliases are equally low and share the name of baseband; real results
      // need that.
      const double baseband = 2 * folded < T ? 1 : 2 * folded == T ? .5 : 0;
      const double keep = options.exact_flat_fields ? 1 - window * (1 - baseband) : 1;
      Complex light[3];  // of each emitter at unit drive, before its colour
      for (int e = 0; e < 3; ++e) {
        light[e] = 0;
        for (const EmitterCell& cell : k_.layout.emitters[e].cells)
          light[e] += cell.share * std::conj(unit_root(cell.x, n, N));
      }
      for (int c = 0; c < 3; ++c) {
        Complex p[3];
        for (int e = 0; e < 3; ++e) p[e] = k_.emitter_opponent[e][c] * light[e];  // times G / S, which is 1
        std::fill(rhs_.begin(), rhs_.end(), 0.0);
        for (int d = 0; d < 3; ++d) rhs_[static_cast<size_t>(3 * j + d)] += k_.opponent[3 * c + d] / S;
        for (int e = 0; e < 3; ++e) {
          const int d = k_.layout.emitters[e].channel;
          for (int i = 0; i < S; ++i)
            rhs_[static_cast<size_t>(3 * i + d)] -= keep * times(p[e], box_[static_cast<size_t>(e * S + i)]);
        }
        solver_.add(mtf(k_.observer, c, f_cpd), p, rhs_.data());
      }
    }
    std::fill(rhs_.begin(), rhs_.end(), 0.0);
    for (int e = 0; e < 3; ++e) {
      Complex unit[3] = {0, 0, 0};
      unit[e] = 1;
      if (options.lambda > 0) solver_.add(options.lambda * k_.regulariser[e], unit, rhs_.data());
    }
    const auto result = solver_.solve(H);
    for (int e = 0; e < 3; ++e)
      for (int j = 0; j < S; ++j)
        H[(e * S + j) * 3 + k_.layout.emitters[e].channel] += box_[static_cast<size_t>(e * S + j)];
    return result;
  }

 private:
  const Constants& k_;
  WeightedLeastSquares solver_;
  std::vector<Complex> box_;  // [emitter][alias]: the displaced box's transfer function over S
  std::vector<Complex> rhs_;  // [alias][rgb]
};

}  // namespace

FilterDesign::FilterDesign(const Layout& layout, const Observer& observer, int tiles, const FilterOptions& options)
    : layout_(layout), tiles_(tiles), exact_flat_fields_(options.exact_flat_fields) {
  require_rows(layout);
  check_observer(observer);
  if (!(options.lambda >= 0 && options.lambda <= 1))
    throw_usage("lambda is " + format_double(options.lambda) + ": 0 to 1 are possible");
  if (tiles < 1 || tiles > kMaxTiles)
    throw_usage("a filter for a row of " + std::to_string(tiles) + " pixels: 1 to " + std::to_string(kMaxTiles) +
                " are possible");
  const Constants constants(layout_, observer, tiles);
  TileFrequency frequency(constants);
  const size_t stride = 9 * static_cast<size_t>(aliases());
  transfer_.resize((static_cast<size_t>(tiles) / 2 + 1) * stride);
  for (int m = 0; m <= tiles / 2; ++m) {
    const auto result = frequency.solve(m, options, transfer_.data() + static_cast<size_t>(m) * stride);
    condition_ = std::max(condition_, result.condition);
    fallback_frequencies_ += result.rank < 3;
  }
}

}  // namespace triad
