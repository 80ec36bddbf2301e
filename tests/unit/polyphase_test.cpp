// SPDX-License-Identifier: Apache-2.0
// An obvious triple loop in double judges every path of the polyphase filter that this machine runs.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/numeric/polyphase.hpp>
#include <utility>
#include <vector>

using triad::CpuPath;
using triad::FirKernel;
using triad::PolyphaseFir;

namespace {

using Kernels = std::array<FirKernel, 3>;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr int kWidths[] = {1, 2, 3, 7, 8, 15, 16, 17, 31, 383, 384, 385, 400, 3840};

std::vector<CpuPath> paths() {
  std::vector<CpuPath> result;
  for (const auto path : {CpuPath::kBaseline, CpuPath::kAvx2, CpuPath::kAvx512})
    if (triad::cpu_can_run(path)) result.push_back(path);
  return result;
}

// A row with exactly the cells that a filter may read, in a buffer of its own, so that a sanitizer sees any
// other read.
template <typename Real>
struct Row {
  int first_cell = 0, past_cell = 0;
  std::vector<Real> values;

  Row(int cells, int first, int last, int n_pixels)
      : first_cell(first), past_cell(cells * (n_pixels - 1) + last + 1), values(3 * std::max(0, past_cell - first)) {}
  const Real* cell(int i) const { return values.data() + 3 * (static_cast<ptrdiff_t>(i) - first_cell); }
  Real& at(int i, int d) { return values[static_cast<size_t>(3 * (i - first_cell) + d)]; }
};

template <typename Real>
Row<Real> random_row(int cells, int first, int last, int n_pixels, unsigned seed) {
  Row<Real> row(cells, first, last, n_pixels);
  std::mt19937 random(seed);
  std::uniform_real_distribution<Real> uniform(-1, 1);
  for (Real& value : row.values) value = uniform(random);
  return row;
}

// Smooth, signed and decaying like an optimal filter's, with noise so that no symmetry hides a mistake.
Kernels random_kernels(int taps, int first_cell, int step, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Kernels kernels;
  for (int e = 0; e < 3; ++e) {
    auto& kernel = kernels[static_cast<size_t>(e)];
    kernel.first_cell = first_cell + e * step;
    for (int t = 0; t < taps; ++t)
      for (int d = 0; d < 3; ++d)
        kernel.coefficients.push_back((uniform(random) + (d == e ? 2 : 0)) / (1 + std::abs(t - taps / 2)));
  }
  return kernels;
}

double norm_1(const FirKernel& kernel) {
  double sum = 0;
  for (const double c : kernel.coefficients) sum += std::abs(c);
  return sum;
}

template <typename Real>
double reference(const FirKernel& kernel, int cells, const Row<Real>& row, int x) {
  double sum = 0;
  for (int t = 0; t < static_cast<int>(kernel.coefficients.size()) / 3; ++t)
    for (int d = 0; d < 3; ++d)
      sum += kernel.coefficients[static_cast<size_t>(3 * t + d)] *
             static_cast<double>(row.cell(cells * x + kernel.first_cell + t)[d]);
  return sum;
}

template <typename Real>
std::vector<Real> apply(const PolyphaseFir<Real>& fir, const Row<Real>& row, int n_pixels) {
  triad::PolyphaseScratch scratch;
  std::vector<Real> out(static_cast<size_t>(3 * n_pixels));
  fir.apply_row(row.cell(0), out.data(), n_pixels, scratch);
  return out;
}

// Largest error relative to max|in|·‖h‖₁, which bounds what the sum can be.
template <typename Real>
double worst_error(const Kernels& kernels, int cells, const Row<Real>& row, const std::vector<Real>& out) {
  double largest = 0;
  for (const Real value : row.values) largest = std::max(largest, std::abs(static_cast<double>(value)));
  double worst = 0;
  for (size_t i = 0; i < out.size(); ++i) {
    const FirKernel& kernel = kernels[i % 3];
    const double error = std::abs(out[i] - reference(kernel, cells, row, static_cast<int>(i / 3)));
    worst = std::max(worst, error / (largest * norm_1(kernel)));
  }
  return worst;
}

// NaNs are all alike: which one comes out is not promised.
bool same_bits(float a, float b) {
  return std::bit_cast<uint32_t>(a) == std::bit_cast<uint32_t>(b) || (std::isnan(a) && std::isnan(b));
}

void expect_same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) ASSERT_TRUE(same_bits(a[i], b[i])) << i << ": " << a[i] << ", " << b[i];
}

class PolyphasePath : public testing::TestWithParam<CpuPath> {};

std::string path_name(const testing::TestParamInfo<CpuPath>& info) { return triad::cpu_path_name(info.param); }

}  // namespace

INSTANTIATE_TEST_SUITE_P(Paths, PolyphasePath, testing::ValuesIn(paths()), path_name);

TEST_P(PolyphasePath, AgreesWithTheObviousSum) {
  for (const int taps : {1, 2, 3, 31, 63, 200}) {
    const Kernels kernels = random_kernels(taps, -taps / 2, 1, static_cast<unsigned>(taps));
    const PolyphaseFir<float> fir(3, kernels, GetParam());
    EXPECT_EQ(fir.first_cell(), -taps / 2);
    EXPECT_EQ(fir.last_cell(), -taps / 2 + taps + 1);
    for (const int n : kWidths) {
      const auto row = random_row<float>(3, fir.first_cell(), fir.last_cell(), n, 7);
      EXPECT_LT(worst_error(kernels, 3, row, apply(fir, row, n)), 1e-6) << taps << " taps, " << n << " pixels";
    }
  }
}

TEST_P(PolyphasePath, AnyCellsPerPixelAndAnyOffsets) {
  for (int cells = 1; cells <= 8; ++cells) {
    for (const auto& [first, step] : {std::pair{-5, 1}, {-40, 17}, {3, 0}, {12, -9}}) {
      const Kernels kernels = random_kernels(11, first, step, static_cast<unsigned>(cells));
      const PolyphaseFir<float> fir(cells, kernels, GetParam());
      for (const int n : {1, 2, 9, 40, 387}) {
        const auto row = random_row<float>(cells, fir.first_cell(), fir.last_cell(), n, 3);
        EXPECT_LT(worst_error(kernels, cells, row, apply(fir, row, n)), 1e-6)
            << cells << " cells from " << first << " + " << step << "e, " << n << " pixels";
      }
    }
  }
}

TEST_P(PolyphasePath, KernelsOfDifferentLengthsAndWithZeros) {
  Kernels kernels = random_kernels(9, -4, 1, 5);
  kernels[1].coefficients.clear();
  kernels[2].coefficients.resize(3);
  for (size_t i = 0; i < kernels[0].coefficients.size(); ++i)
    if (i % 3 != 0) kernels[0].coefficients[i] = 0;  // its own channel alone
  const PolyphaseFir<float> fir(3, kernels, GetParam());
  EXPECT_EQ(fir.first_cell(), -4);
  EXPECT_EQ(fir.last_cell(), 4);
  const auto row = random_row<float>(3, -4, 4, 100, 1);
  const auto out = apply(fir, row, 100);
  for (int x = 0; x < 100; ++x)
    for (int e = 0; e < 3; ++e)
      EXPECT_NEAR(out[static_cast<size_t>(3 * x + e)], reference(kernels[static_cast<size_t>(e)], 3, row, x), 1e-6);
}

TEST_P(PolyphasePath, NoKernelNoInput) {
  const PolyphaseFir<float> fir(3, {}, GetParam());
  EXPECT_EQ(fir.first_cell(), 0);
  EXPECT_EQ(fir.last_cell(), -1);
  triad::PolyphaseScratch scratch;
  std::vector<float> out(30, 5);
  fir.apply_row(nullptr, out.data(), 10, scratch);
  EXPECT_EQ(out, std::vector<float>(30, 0));
}

// A long sum of equal terms is where plain float summation drifts: every addition rounds the same way.
TEST_P(PolyphasePath, EqualTermsDoNotDrift) {
  for (const double value : {.1, .3, 1. / 3, .7}) {
    Kernels kernels;
    for (auto& kernel : kernels) kernel.coefficients.assign(600, static_cast<float>(value));
    const PolyphaseFir<float> fir(3, kernels, GetParam());
    auto row = Row<float>(3, 0, 199, 20);
    std::fill(row.values.begin(), row.values.end(), .9f);
    EXPECT_LT(worst_error(kernels, 3, row, apply(fir, row, 20)), 1e-6) << value;
  }
}

TEST_P(PolyphasePath, SelectsOneSubpixelExactly) {
  Kernels kernels;
  for (int e = 0; e < 3; ++e) {
    kernels[static_cast<size_t>(e)].first_cell = e;
    kernels[static_cast<size_t>(e)].coefficients = {e == 0 ? 1. : 0., e == 1 ? 1. : 0., e == 2 ? 1. : 0.};
  }
  const PolyphaseFir<float> fir(3, kernels, GetParam());
  for (const int n : kWidths) {
    auto row = random_row<float>(3, 0, 2, n, 11);
    row.values[0] = std::numeric_limits<float>::denorm_min();
    row.values.back() = std::numeric_limits<float>::max();
    const auto out = apply(fir, row, n);
    for (int x = 0; x < n; ++x)
      for (int e = 0; e < 3; ++e) ASSERT_EQ(out[static_cast<size_t>(3 * x + e)], row.at(3 * x + e, e)) << n;
  }
}

TEST_P(PolyphasePath, APixelDoesNotDependOnWhereTheRowIsCut) {
  const int n = 1000;
  const PolyphaseFir<float> fir(3, random_kernels(31, -15, 1, 2), GetParam());
  const auto row = random_row<float>(3, fir.first_cell(), fir.last_cell(), n, 4);
  const auto whole = apply(fir, row, n);
  for (const int piece : {1, 3, 8, 17, 100, 384, 999}) {
    triad::PolyphaseScratch scratch;
    std::vector<float> out(static_cast<size_t>(3 * n));
    for (int x = 0; x < n; x += piece)
      fir.apply_row(row.cell(3 * x), out.data() + 3 * x, std::min(piece, n - x), scratch);
    expect_same_bits(out, whole);
  }
}

TEST_P(PolyphasePath, WritesNothingElse) {
  const PolyphaseFir<float> fir(3, random_kernels(5, -2, 1, 2), GetParam());
  for (const int n : kWidths) {
    const auto row = random_row<float>(3, fir.first_cell(), fir.last_cell(), n, 4);
    std::vector<float> out(static_cast<size_t>(3 * n + 40), 77);
    triad::PolyphaseScratch scratch;
    fir.apply_row(row.cell(0), out.data() + 20, n, scratch);
    for (size_t i = 0; i < 20; ++i) {
      ASSERT_EQ(out[i], 77);
      ASSERT_EQ(out[out.size() - 1 - i], 77);
    }
  }
}

TEST_P(PolyphasePath, OneScratchServesFiltersOfAnySize) {
  triad::PolyphaseScratch scratch;
  for (const int taps : {63, 1, 200, 31}) {
    const PolyphaseFir<float> fir(3, random_kernels(taps, 0, 1, 8), GetParam());
    auto row = random_row<float>(3, fir.first_cell(), fir.last_cell(), 50, 9);
    std::vector<float> out(150);
    fir.apply_row(row.cell(0), out.data(), 50, scratch);
    expect_same_bits(out, apply(fir, row, 50));
    std::fill(row.values.begin(), row.values.end(), std::nanf(""));  // what it leaves behind must not matter
    fir.apply_row(row.cell(0), out.data(), 50, scratch);
  }
}

// Exactly those outputs see an infinity or NaN whose kernel has a coefficient for it.
TEST_P(PolyphasePath, NonFiniteInputStaysWithinTheSupport) {
  const int taps = 7, n = 60;
  const Kernels kernels = random_kernels(taps, -3, 1, 6);
  const PolyphaseFir<float> fir(3, kernels, GetParam());
  const auto clean = random_row<float>(3, fir.first_cell(), fir.last_cell(), n, 12);
  const auto expected = apply(fir, clean, n);
  for (const float bad : {kInf, -kInf, std::nanf("")}) {
    for (int cell = clean.first_cell; cell < clean.past_cell; ++cell) {
      auto row = clean;
      row.at(cell, cell & 1) = bad;
      const auto out = apply(fir, row, n);
      for (int x = 0; x < n; ++x)
        for (int e = 0; e < 3; ++e) {
          const int tap = cell - 3 * x - kernels[static_cast<size_t>(e)].first_cell;
          const auto i = static_cast<size_t>(3 * x + e);
          if (tap >= 0 && tap < taps)
            ASSERT_FALSE(std::isfinite(out[i])) << cell << ' ' << x << ' ' << e;
          else
            ASSERT_TRUE(same_bits(out[i], expected[i])) << cell << ' ' << x << ' ' << e;
        }
    }
  }
}

TEST_P(PolyphasePath, ZeroCoefficientsIgnoreInfinity) {
  Kernels kernels;
  for (auto& kernel : kernels) kernel.coefficients = {.5, 0, 0, -0., 0, 1e-60, .25, 0, 0};
  const PolyphaseFir<float> fir(1, kernels, GetParam());
  auto row = random_row<float>(1, 0, 2, 40, 1);
  for (int cell = 0; cell < row.past_cell; ++cell)
    row.at(cell, 1) = row.at(cell, 2) = cell & 1 ? kInf : std::nanf("");
  const auto out = apply(fir, row, 40);
  for (int x = 0; x < 40; ++x)
    EXPECT_NEAR(out[static_cast<size_t>(3 * x)], .5 * row.at(x, 0) + .25 * row.at(x + 2, 0), 1e-7);
}

TEST_P(PolyphasePath, SmallestAndLargestValues) {
  const Kernels kernels = random_kernels(31, -15, 1, 13);
  const PolyphaseFir<float> fir(3, kernels, GetParam());
  for (const float scale : {1e-30f, 1e30f}) {
    auto row = random_row<float>(3, fir.first_cell(), fir.last_cell(), 50, 14);
    for (float& value : row.values) value *= scale;
    EXPECT_LT(worst_error(kernels, 3, row, apply(fir, row, 50)), 1e-6) << scale;
  }
  // ‖h‖₁ = .9: no sum of the largest floats overflows, not even on the way.
  Kernels contracting = kernels;
  for (FirKernel& kernel : contracting) {
    const double norm = norm_1(kernel);
    for (double& c : kernel.coefficients) c *= .9 / norm;
  }
  const PolyphaseFir<float> bounded(3, contracting, GetParam());
  auto largest = random_row<float>(3, fir.first_cell(), fir.last_cell(), 50, 15);
  for (float& value : largest.values) value = std::copysign(std::numeric_limits<float>::max(), value);
  EXPECT_LT(worst_error(contracting, 3, largest, apply(bounded, largest, 50)), 1e-6);
  // Denormals are kept: coefficients of ±1 and 2 make every sum exact.
  Kernels whole;
  for (auto& kernel : whole) kernel.coefficients = {1, -1, 2, 2, 1, -1};
  const PolyphaseFir<float> exact(3, whole, GetParam());
  Row<float> row(3, 0, 1, 50);
  for (size_t i = 0; i < row.values.size(); ++i)
    row.values[i] = static_cast<float>(i % 19 + 1) * std::numeric_limits<float>::denorm_min();
  const auto out = apply(exact, row, 50);
  for (int x = 0; x < 50; ++x) EXPECT_EQ(out[static_cast<size_t>(3 * x)], reference(whole[0], 3, row, x));
}

TEST(Polyphase, FusedPathsAgreeBitForBit) {
  if (!triad::cpu_can_run(CpuPath::kAvx512)) GTEST_SKIP() << "no AVX-512 here";
  for (const int cells : {1, 2, 3, 6}) {
    for (const int taps : {1, 3, 31, 200}) {
      Kernels kernels = random_kernels(taps, -taps / 3, 1, 21);
      for (size_t i = 0; i < kernels[1].coefficients.size(); i += 4) kernels[1].coefficients[i] = 0;
      const PolyphaseFir<float> narrow(cells, kernels, CpuPath::kAvx2), wide(cells, kernels, CpuPath::kAvx512);
      for (const int n : kWidths) {
        auto row = random_row<float>(cells, wide.first_cell(), wide.last_cell(), n, 22);
        for (size_t i = 0; i < row.values.size(); i += 97) row.values[i] *= 1e30f;
        for (size_t i = 50; i < row.values.size(); i += 101) row.values[i] *= 1e-42f;
        if (n > 100) row.at(100, 1) = kInf;
        expect_same_bits(apply(narrow, row, n), apply(wide, row, n));
      }
    }
  }
}

TEST_P(PolyphasePath, ThreadsShareAFilter) {
  const int n = 200, rows = 64;
  const PolyphaseFir<float> fir(3, random_kernels(31, -15, 1, 41), GetParam());
  std::vector<std::vector<float>> out(rows);
  const auto row = [&](int64_t y) {
    return random_row<float>(3, fir.first_cell(), fir.last_cell(), n, static_cast<unsigned>(y));
  };
  triad::parallel_for(rows, [&](int64_t y) {
    thread_local triad::PolyphaseScratch scratch;
    out[static_cast<size_t>(y)].resize(3 * n);
    fir.apply_row(row(y).cell(0), out[static_cast<size_t>(y)].data(), n, scratch);
  });
  for (int y = 0; y < rows; ++y) expect_same_bits(out[static_cast<size_t>(y)], apply(fir, row(y), n));
}

TEST(Polyphase, DoubleAgreesToFourteenDigits) {
  for (const int cells : {1, 3, 6}) {
    for (const int taps : {1, 31, 200}) {
      const Kernels kernels = random_kernels(taps, -taps / 2, 1, 31);
      const PolyphaseFir<double> fir(cells, kernels);
      for (const int n : {1, 2, 3, 17, 400}) {
        const auto row = random_row<double>(cells, fir.first_cell(), fir.last_cell(), n, 32);
        EXPECT_LT(worst_error(kernels, cells, row, apply(fir, row, n)), 1e-14);
      }
    }
  }
}

TEST(Polyphase, RefusesWhatItCannotDo) {
  const Kernels good = random_kernels(3, 0, 1, 1);
  for (const int cells : {-1, 0, 9}) EXPECT_THROW(PolyphaseFir<float>(cells, good), triad::Error);
  for (const double bad : {std::nan(""), static_cast<double>(kInf), 1e39}) {
    Kernels kernels = good;
    kernels[2].coefficients[4] = bad;
    EXPECT_THROW(PolyphaseFir<float>(3, kernels), triad::Error) << bad;
  }
  Kernels kernels = good;
  kernels[0].coefficients.push_back(1);
  EXPECT_THROW(PolyphaseFir<float>(3, kernels), triad::Error);
  kernels = good;
  kernels[0].first_cell = std::numeric_limits<int>::min();
  EXPECT_THROW(PolyphaseFir<float>(3, kernels), triad::Error);
}

TEST(Cpu, TheEnvironmentChoosesThePath) {
  const char* before = std::getenv("TRIAD_CPU");
  const std::string saved = before ? before : "";
  for (const auto path : paths()) {
    setenv("TRIAD_CPU", triad::cpu_path_name(path), 1);
    EXPECT_EQ(triad::default_cpu_path(), path);
  }
  setenv("TRIAD_CPU", "", 1);
  EXPECT_EQ(triad::default_cpu_path(), paths().back());
  setenv("TRIAD_CPU", "sse9", 1);
  try {
    triad::default_cpu_path();
    ADD_FAILURE() << "an unknown path was accepted";
  } catch (const triad::Error& error) {
    EXPECT_EQ(error.kind(), triad::ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find("TRIAD_CPU=sse9"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("baseline"), std::string::npos) << error.what();
  }
  if (before)
    setenv("TRIAD_CPU", saved.c_str(), 1);
  else
    unsetenv("TRIAD_CPU");
}
