// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstring>
#include <numbers>
#include <random>
#include <thread>
#include <triad/base/error.hpp>
#include <triad/numeric/aligned.hpp>
#include <triad/numeric/fft.hpp>
#include <triad/numeric/least_squares.hpp>
#include <triad/numeric/sum.hpp>
#include <vector>

using triad::AlignedBuffer;
using triad::NeumaierSum;

namespace {

constexpr double kPi = std::numbers::pi;

template <class Real>
AlignedBuffer<Real> noise(size_t n) {
  std::mt19937 bits(7);
  AlignedBuffer<Real> out(n);
  for (Real& value : out) value = static_cast<Real>(static_cast<double>(bits()) / 2147483648.0 - 1);
  return out;
}

template <class Real>
void check_transforms(size_t n, double tolerance) {
  const auto values = noise<Real>(n);
  const triad::RealFft<Real> fft(n);
  const triad::CosineTransform<Real> cosine(n);
  AlignedBuffer<std::complex<Real>> spectrum(fft.spectrum_size());
  AlignedBuffer<Real> cosines(n), back(n);
  fft.forward(values.data(), spectrum.data());
  cosine.forward(values.data(), cosines.data());
  const double bound = tolerance * std::sqrt(static_cast<double>(n));
  for (size_t k = 0; k <= n / 2; ++k) {
    std::complex<long double> sum = 0;
    for (size_t j = 0; j < n; ++j)
      sum += static_cast<long double>(values[j]) *
             std::polar(1.0L, -2 * std::numbers::pi_v<long double> * static_cast<long double>(j * k % n) / n);
    EXPECT_NEAR(spectrum[k].real(), static_cast<double>(sum.real()), bound) << n << ' ' << k;
    EXPECT_NEAR(spectrum[k].imag(), static_cast<double>(sum.imag()), bound) << n << ' ' << k;
  }
  for (size_t k = 0; k < n; ++k) {
    long double sum = 0;
    for (size_t j = 0; j < n; ++j)
      sum +=
          2 * static_cast<long double>(values[j]) *
          std::cos(std::numbers::pi_v<long double> * static_cast<long double>((2 * j + 1) * k % (4 * n)) / (2 * n));
    EXPECT_NEAR(cosines[k], static_cast<double>(sum), 2 * bound) << n << ' ' << k;
  }
  fft.inverse(spectrum.data(), back.data());
  for (size_t j = 0; j < n; ++j)
    EXPECT_NEAR(back[j] / static_cast<Real>(n), values[j], tolerance * 4) << n << ' ' << j;
  cosine.inverse(cosines.data(), back.data());
  for (size_t j = 0; j < n; ++j)
    EXPECT_NEAR(back[j] / static_cast<Real>(2 * n), values[j], tolerance * 4) << n << ' ' << j;
}

}  // namespace

TEST(Fft, MatchesTheSumsOfItsDefinition) {
  for (const size_t n : {1u, 2u, 3u, 4u, 5u, 7u, 12u, 97u, 128u, 300u, 331u}) {
    check_transforms<double>(n, 2e-15);
    check_transforms<float>(n, 1e-6);
  }
}

TEST(Fft, CosinesAreTheSpectrumOfTheMirroredRow) {
  for (const size_t n : {1u, 6u, 9u, 50u}) {
    const auto values = noise<double>(n);
    AlignedBuffer<double> mirrored(2 * n), cosines(n);
    for (size_t j = 0; j < n; ++j) mirrored[j] = mirrored[2 * n - 1 - j] = values[j];
    AlignedBuffer<std::complex<double>> spectrum(n + 1);
    triad::RealFft<double>(2 * n).forward(mirrored.data(), spectrum.data());
    triad::CosineTransform<double>(n).forward(values.data(), cosines.data());
    for (size_t k = 0; k < n; ++k)
      EXPECT_LT(std::abs(spectrum[k] -
                         std::polar(1., kPi * static_cast<double>(k) / (2. * static_cast<double>(n))) * cosines[k]),
                1e-13);
    EXPECT_LT(std::abs(spectrum[n]), 1e-13);
  }
}

TEST(Fft, GivesTheSameBitsOnAllThreads) {
  constexpr size_t kLength = 1200;
  const auto values = noise<float>(kLength);
  std::vector<AlignedBuffer<std::complex<float>>> results;
  for (int i = 0; i < 8; ++i) results.emplace_back(kLength / 2 + 1);
  std::vector<std::thread> threads;
  for (auto& result : results)
    threads.emplace_back([&] { triad::RealFft<float>(kLength).forward(values.data(), result.data()); });
  for (auto& thread : threads) thread.join();
  for (const auto& result : results)
    EXPECT_EQ(0, std::memcmp(result.data(), results[0].data(), result.size() * sizeof(std::complex<float>)));
}

TEST(Fft, RefusesWhatItCannotDo) {
  EXPECT_THROW(triad::RealFft<double>(0), triad::Error);
  EXPECT_THROW(triad::CosineTransform<float>(size_t{1} << 31), triad::Error);
  const triad::RealFft<double> fft(8);
  AlignedBuffer<double> values(16);
  AlignedBuffer<std::complex<double>> spectrum(5);
  EXPECT_THROW(fft.forward(values.data() + 1, spectrum.data()), triad::Error);
}

TEST(Sum, KeepsWhatPlainAdditionLoses) {
  NeumaierSum sum;
  for (const double x : {1e100, 1., -1e100}) sum.add(x);
  EXPECT_EQ(sum.value(), 1);

  // Alternating +-1e8 over a bias, in one go, and split into unequal parts.
  constexpr int kTerms = 2'000'000;
  constexpr double kBias = 0x1p-20;
  NeumaierSum all, merged, part;
  double plain = 0;
  for (int i = 0; i < kTerms; ++i) {
    const double x = (i % 2 ? -1e8 : 1e8) + kBias;
    all.add(x);
    part.add(x);
    plain += x;
    if (i % 777 == 0) {
      merged.merge(part);
      part = {};
    }
  }
  merged.merge(part);
  EXPECT_NEAR(all.value() / (kTerms * kBias), 1, 1e-12);
  EXPECT_NEAR(merged.value() / (kTerms * kBias), 1, 1e-12);

  NeumaierSum tenths;
  double plain_tenths = 0;
  for (int i = 0; i < 10'000'000; ++i) {
    tenths.add(.1);
    plain_tenths += .1;
  }
  // .1 is 3602879701896397 / 2^55.
  constexpr long double kTenth = 3602879701896397.0L / 36028797018963968.0L;
  EXPECT_NEAR(tenths.value(), static_cast<double>(1e7L * kTenth), 1e-9);
  EXPECT_GT(std::abs(plain_tenths - 1e6), 1e-5);  // why this class exists
}

TEST(Sum, PassesInfinitiesOn) {
  NeumaierSum sum;
  sum.add(1);
  sum.add(HUGE_VAL);
  sum.add(2);
  EXPECT_EQ(sum.value(), HUGE_VAL);
}

TEST(LeastSquares, SolvesAPublishedFit) {
  // Anscombe (1973), first data set: y = 3.00009 + .500091 x.
  const double x[] = {10, 8, 13, 9, 11, 14, 6, 4, 12, 7, 5};
  const double y[] = {8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68};
  triad::WeightedLeastSquares solver(2, 1);
  for (int i = 0; i < 11; ++i) {
    const std::complex<double> row[] = {1, x[i]}, rhs[] = {y[i]};
    solver.add(1, row, rhs);
  }
  std::complex<double> solution[2];
  EXPECT_EQ(solver.solve(solution).rank, 2);
  // 3 + 1/11000 and .5 + 1/11000, exactly, for these numbers.
  EXPECT_NEAR(solution[0].real(), 3 + 1 / 11000., 1e-13);
  EXPECT_NEAR(solution[1].real(), .5 + 1 / 11000., 1e-14);
}

TEST(LeastSquares, WeightsOf1And1eMinus20DoNotMix) {
  // Two heavy equations fix x + y = 3 and x + iy = 1 + 2i, a light one the rest: z = 5 - x = 4.
  for (const double light : {1e-3, 1e-20, 1e-100}) {
    triad::WeightedLeastSquares solver(3, 1);
    const std::complex<double> i(0, 1);
    const std::complex<double> rows[3][3] = {{1, 0, 1}, {1, i, 0}, {1, 1, 0}};
    const std::complex<double> rhs[] = {5., 1. + 2. * i, 3.};
    solver.add(light, rows[0], &rhs[0]);
    solver.add(1, rows[1], &rhs[1]);
    solver.add(1, rows[2], &rhs[2]);
    std::complex<double> x[3];
    const auto result = solver.solve(x);
    EXPECT_EQ(result.rank, 3);
    EXPECT_GT(result.condition, .5 / light);
    EXPECT_LT(std::abs(x[0] - 1.), 1e-14);
    EXPECT_LT(std::abs(x[1] - 2.), 1e-14);
    EXPECT_LT(std::abs(x[2] - 4.), 1e-14);
  }
}

TEST(LeastSquares, LeavesTheUndeterminedAtZero) {
  triad::WeightedLeastSquares solver(2, 1);
  const std::complex<double> row[] = {0, 2}, rhs[] = {6};
  solver.add(1e-300, row, rhs);
  std::complex<double> x[2];
  EXPECT_EQ(solver.solve(x).rank, 1);
  EXPECT_EQ(x[0], 0.);
  EXPECT_NEAR(x[1].real(), 3, 1e-15);
  solver.clear();
  solver.add(0, row, rhs);
  EXPECT_EQ(solver.solve(x).rank, 0);
  EXPECT_EQ(x[1], 0.);
}
