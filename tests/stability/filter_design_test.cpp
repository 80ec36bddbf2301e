// SPDX-License-Identifier: Apache-2.0
// Where the filter's design is hard: weights that span sixteen orders of magnitude, and rings of every length.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <triad/display/filter_design.hpp>
#include <triad/display/row_filter.hpp>
#include <vector>

#include "display_reference.hpp"
#include "stability_table.hpp"

using triad::Edge;
using triad::FilterDesign;
namespace stability = triad::stability;
namespace reference = triad::reference;

namespace {

triad::Layout layout(const char* name = "rgb") {
  return triad::load_layout(std::string(TRIAD_SOURCE_DIR "/data/layouts/") + name + ".toml");
}

__extension__ typedef __float128 Quad;  // 113 bits of mantissa, 34 digits

struct QuadComplex {
  Quad re = 0, im = 0;
  QuadComplex operator+(QuadComplex o) const { return {re + o.re, im + o.im}; }
  QuadComplex operator-(QuadComplex o) const { return {re - o.re, im - o.im}; }
  QuadComplex operator*(QuadComplex o) const { return {re * o.re - im * o.im, re * o.im + im * o.re}; }
  QuadComplex conj() const { return {re, -im}; }
  Quad norm2() const { return re * re + im * im; }
};

Quad square_root(Quad x) {
  Quad root = std::sqrt(static_cast<long double>(x));
  for (int i = 0; i < 2; ++i) root = (root + x / root) / 2;
  return root;
}

constexpr int kRows = 9, kUnknowns = 3, kSides = 9;

// The equations of tile frequency m of red-green-blue stripes: for alias j and channel c the weighted light of
// the three emitters, and for each alias and colour of the target the right side. From the definition, with
// phases to 64 bits.
struct System {
  QuadComplex matrix[kRows][kUnknowns], sides[kRows][kSides];

  System(const triad::Observer& eye, int tiles, int m) {
    const auto C = triad::opponent_matrix(eye);
    const int N = 3 * tiles;
    for (int j = 0; j < 3; ++j)
      for (int c = 0; c < 3; ++c) {
        const int n = m + tiles * j, row = 3 * j + c;
        const double weight = triad::mtf(eye, c, static_cast<double>(std::min(n, N - n)) / N * 3 * eye.ppd);
        for (int e = 0; e < 3; ++e) {
          const auto phase = std::polar(1.0L, -2 * reference::kWidePi * (static_cast<long>(e) * n % N) / N);
          const Quad light = static_cast<Quad>(weight) * C[3 * c + e];
          matrix[row][e] = {light * phase.real(), light * phase.imag()};
          sides[row][3 * j + e] = {static_cast<Quad>(weight) * C[3 * c + e] / 3, 0};
        }
      }
  }

  // Least squares by modified Gram-Schmidt in 34 digits: the rows' scaling costs 16 of them at most.
  std::vector<std::complex<double>> solve_in_34_digits() const {
    System s = *this;
    QuadComplex R[kUnknowns][kUnknowns], y[kUnknowns][kSides];
    for (int k = 0; k < kUnknowns; ++k) {
      Quad norm2 = 0;
      for (auto& row : s.matrix) norm2 += row[k].norm2();
      const Quad norm = square_root(norm2);
      R[k][k] = {norm, 0};
      for (auto& row : s.matrix) row[k] = {row[k].re / norm, row[k].im / norm};
      for (int i = k + 1; i < kUnknowns; ++i) {
        for (auto& row : s.matrix) R[k][i] = R[k][i] + row[k].conj() * row[i];
        for (auto& row : s.matrix) row[i] = row[i] - row[k] * R[k][i];
      }
      for (int i = 0; i < kSides; ++i) {
        for (int r = 0; r < kRows; ++r) y[k][i] = y[k][i] + s.matrix[r][k].conj() * s.sides[r][i];
        for (int r = 0; r < kRows; ++r) s.sides[r][i] = s.sides[r][i] - s.matrix[r][k] * y[k][i];
      }
    }
    std::vector<std::complex<double>> out(kUnknowns * kSides);
    for (int i = 0; i < kSides; ++i)
      for (int k = kUnknowns; k-- > 0;) {
        for (int q = k + 1; q < kUnknowns; ++q) y[k][i] = y[k][i] - R[k][q] * y[q][i];
        y[k][i] = {y[k][i].re / R[k][k].re, y[k][i].im / R[k][k].re};
        out[static_cast<size_t>(k * kSides + i)] = {static_cast<double>(y[k][i].re), static_cast<double>(y[k][i].im)};
      }
    return out;
  }

  Eigen::MatrixXcd matrix_in_double() const {
    Eigen::MatrixXcd out(kRows, kUnknowns);
    for (int r = 0; r < kRows; ++r)
      for (int k = 0; k < kUnknowns; ++k)
        out(r, k) = {static_cast<double>(matrix[r][k].re), static_cast<double>(matrix[r][k].im)};
    return out;
  }
  Eigen::MatrixXcd sides_in_double() const {
    Eigen::MatrixXcd out(kRows, kSides);
    for (int r = 0; r < kRows; ++r)
      for (int k = 0; k < kSides; ++k)
        out(r, k) = {static_cast<double>(sides[r][k].re), static_cast<double>(sides[r][k].im)};
    return out;
  }
};

// Largest error of the solution over the largest value of the right one.
double error_of(const Eigen::MatrixXcd& solution, const std::vector<std::complex<double>>& right) {
  double worst = 0, largest = 0;
  for (int k = 0; k < kUnknowns; ++k)
    for (int i = 0; i < kSides; ++i) {
      const auto expected = right[static_cast<size_t>(k * kSides + i)];
      const double difference = std::abs(solution(k, i) - expected);
      worst = difference <= worst ? worst : difference;
      largest = std::max(largest, std::abs(expected));
    }
  return worst / largest;
}

}  // namespace

TEST(FilterDesignStability, SortedPivotedQrWhereOthersFail) {
  constexpr int kTiles = 64;
  struct Row {
    double normal = 0, plain = 0, design = 0;
  };
  std::vector<Row> table;
  const double ppds[] = {40, 67, 80, 100, 120};
  for (const double ppd : ppds) {
    const auto eye = reference::observer(ppd);
    const FilterDesign design(layout(), eye, kTiles, {.lambda = 0, .exact_flat_fields = false});
    Row row;
    for (int m = 0; m <= kTiles / 2; ++m) {
      const System system(eye, kTiles, m);
      const auto right = system.solve_in_34_digits();
      const Eigen::MatrixXcd A = system.matrix_in_double(), b = system.sides_in_double();
      const Eigen::MatrixXcd normal = A.adjoint() * A, normal_side = A.adjoint() * b;
      row.normal = std::max(row.normal, error_of(normal.fullPivLu().solve(normal_side), right));
      row.plain = std::max(row.plain, error_of(A.householderQr().solve(b), right));
      Eigen::MatrixXcd got(kUnknowns, kSides);
      for (int e = 0; e < kUnknowns; ++e)
        for (int i = 0; i < kSides; ++i) got(e, i) = design.transfer(m, e, i / 3, i % 3);
      row.design = std::max(row.design, error_of(got, right));
    }
    const auto what = fmt::format("{} ppd, lambda 0 (condition {:.0e}; normal equations {:.0e}, plain QR {:.0e})",
                                  ppd, design.condition(), row.normal, row.plain);
    stability::at_most("filter design", what, row.design, 1e-13);
    table.push_back(row);
  }
  // The others are not merely less good.
  stability::naive_fails("filter design", "67 ppd: by normal equations", table[1].normal, 1e-11);
  stability::naive_fails("filter design", "120 ppd: by normal equations", table[4].normal, .1);
  stability::naive_fails("filter design", "120 ppd: by plain QR", table[4].plain, 1e-8);
}

TEST(FilterDesignStability, FiniteAndFlatForEveryRing) {
  double most_off = 0, worst_condition = 1;
  uint64_t designs = 0, not_finite = 0;
  for (const int width : {1, 2, 4, 7, 400, 3840, 100003})
    for (const double ppd : {5., 20., 67., 120., 250., 500., 700., 1000.})
      for (const double lambda : {0., 1e-8, .01, 1.}) {
        if (width > 1000 && (ppd == 20 || ppd == 120 || ppd == 700 || lambda == 1e-8)) continue;  // time
        if (width > 10000 && lambda == 1) continue;
        for (const auto csf : {triad::Csf::kScielab, triad::Csf::kKolpatzikBouman}) {
          if (width > 1000 && csf == triad::Csf::kKolpatzikBouman) continue;
          const auto what =
              std::to_string(width) + " px, " + std::to_string(ppd) + " ppd, lambda " + std::to_string(lambda);
          const FilterDesign design(layout(), reference::observer(ppd, csf), width, {.lambda = lambda});
          EXPECT_GE(design.condition(), 1) << what;
          worst_condition = std::max(worst_condition, design.condition());
          ++designs;
          double largest = 0;
          for (int m = 0; m <= width / 2; ++m)
            for (int i = 0; i < 27; ++i) {
              const double size = std::abs(design.transfer(m, i / 9, i / 3 % 3, i % 3));
              largest = size <= largest ? largest : size;
            }
          not_finite += !std::isfinite(largest) || !std::isfinite(design.condition());

          const triad::RowFilter<double> filter(design, width, Edge::kWrap);
          triad::RowFilter<double>::Workspace workspace(filter);
          const double colour[] = {1, .3, .8};
          std::vector<double> cells(static_cast<size_t>(width) * 9), drives(static_cast<size_t>(width) * 3);
          for (size_t i = 0; i < cells.size(); ++i) cells[i] = colour[i % 3];
          filter.apply(cells.data(), drives.data(), workspace);
          double off = 0;
          for (size_t i = 0; i < drives.size(); ++i) {
            const double difference = std::abs(drives[i] - colour[i % 3]);
            off = difference <= off ? off : difference;
          }
          EXPECT_LT(off, 1e-12) << what << ", largest transfer " << largest;
          most_off = off <= most_off ? most_off : off;
        }
      }
  stability::never("filter design", "1 ... 100003 pixels, 5 ... 1000 ppd, lambda 0 ... 1: not finite", not_finite,
                   designs);
  stability::at_most("filter design",
                     fmt::format("the same, flat fields: error; largest condition {:.1e}", worst_condition), most_off,
                     1e-12);
}

TEST(FilterDesignStability, RegularisationAtHighPpdIsTheBoxBeyondWhatIsSeen) {
  // At 1000 ppd nothing of frequencies past a tenth of the pixels' is seen: the filter must be the box there.
  const int tiles = 100;
  const FilterDesign design(layout(), reference::observer(1000), tiles);
  double worst = 0;
  for (int m = 20; m <= tiles / 2; ++m)
    for (int e = 0; e < 3; ++e)
      for (int j = 0; j < 3; ++j)
        for (int d = 0; d < 3; ++d) {
          // (1 + 2 cos w) / 3 for a box of three cells, over three aliases, displaced to cell e.
          const double w = 2 * std::numbers::pi * (m + tiles * j) / (3 * tiles);
          const auto box = d == e ? std::polar((1 + 2 * std::cos(w)) / 9, w * e) : 0.;
          const double off = std::abs(design.transfer(m, e, j, d) - box);
          worst = off <= worst ? worst : off;
        }
  stability::at_most("filter design", "1000 ppd: distance from the box beyond what is seen", worst, 1e-12);
}

TEST(FilterDesignStability, PrimeAndHugeRowsMatchDirectSums) {
  double worst_double = 0, worst_single = 0;  // over the bound on what a row can come to
  for (const int width : {100003, 65536})
    for (const Edge edge : {Edge::kWrap, Edge::kMirror}) {
      const FilterDesign design(layout("bgr"), reference::observer(40), triad::ring_px(width, edge), {});
      const auto cells = reference::random_cells(3 * width, 1);
      const std::vector<float> single(cells.begin(), cells.end());
      std::vector<double> exact(static_cast<size_t>(width) * 3);
      std::vector<float> fast(exact.size());
      {
        const triad::RowFilter<double> filter(design, width, edge);
        triad::RowFilter<double>::Workspace workspace(filter);
        filter.apply(cells.data(), exact.data(), workspace);
      }
      {
        const triad::RowFilter<float> filter(design, width, edge);
        triad::RowFilter<float>::Workspace workspace(filter);
        filter.apply(single.data(), fast.data(), workspace);
      }
      const triad::ImpulseResponse response(design);
      const auto ring = reference::ring_of(cells, edge);
      const int N = static_cast<int>(ring.size()) / 3;
      const auto kernels = response.truncated(N);
      const double bound = response.l1_norm();
      for (const int x : {0, 1, 12345, width / 2, width - 1})
        for (int o = 0; o < 3; ++o) {
          long double sum = 0;
          for (int t = 0; t < N; ++t)
            for (int d = 0; d < 3; ++d) {
              const int k = ((3 * x + kernels[o].first_cell + t) % N + N) % N;
              sum += static_cast<long double>(kernels[o].coefficients[static_cast<size_t>(3 * t + d)]) *
                     ring[static_cast<size_t>(3 * k + d)];
            }
          const auto direct = static_cast<double>(sum);
          const size_t at = static_cast<size_t>(3 * x + o);
          const double in_double = std::abs(exact[at] - direct) / bound;
          const double in_single = std::abs(static_cast<double>(fast[at]) - direct) / bound;
          worst_double = in_double <= worst_double ? worst_double : in_double;
          worst_single = in_single <= worst_single ? worst_single : in_single;
        }
    }
  stability::at_most("applying", "rows of 100003 and 65536 pixels, FFT and direct sum: double", worst_double, 1e-10);
  stability::at_most("applying", "rows of 100003 and 65536 pixels, FFT and direct sum: float", worst_single, 1e-5);
}
