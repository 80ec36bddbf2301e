// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>
#include <triad/numeric/fresnel.hpp>

namespace triad {
namespace {

using Complex = std::complex<double>;

Complex series(double z) {
  // The terms of the integral of exp(i x), x = pi t^2 / 2, one by one: z (i x)^n / (n! (2n + 1)).
  const Complex ix(0, .5 * std::numbers::pi * z * z);
  Complex power = z, sum = z;
  for (int n = 1; n < 60; ++n) {  // at z = 2 the 35th term is below 1e-17
    power *= ix / static_cast<double>(n);
    sum += power / (2. * n + 1);
  }
  return sum;
}

// sqrt(pi) exp(w^2) erfc(w) = 1 / (w + (1/2) / (w + (2/2) / (w + (3/2) / ...))), from the far end.
Complex scaled_erfc(Complex w) {
  constexpr int kTerms = 120;  // at z = 2, half as many do
  Complex tail = w;
  for (int n = kTerms; n >= 1; --n) tail = w + .5 * n / tail;
  return 1. / tail;
}

}  // namespace

std::complex<double> fresnel(double z) {
  constexpr double kSeriesEnd = 2;
  if (std::abs(z) <= kSeriesEnd) return series(z);
  const double size = std::abs(z);
  const Complex w = .5 * std::sqrt(std::numbers::pi) * Complex(size, -size);
  const double phase = .5 * std::numbers::pi * size * size;  // exp(-w^2) = exp(i phase)
  const Complex erfc = Complex(std::cos(phase), std::sin(phase)) * scaled_erfc(w) / std::sqrt(std::numbers::pi);
  const Complex value = Complex(.5, .5) * (1. - erfc);
  return z > 0 ? value : -value;
}

std::complex<double> mean_chirp(double a, double t0, double t1) {
  const double scale = std::sqrt(2 * a / std::numbers::pi);  // a t^2 = pi / 2 (scale t)^2
  return (fresnel(scale * t1) - fresnel(scale * t0)) / (scale * (t1 - t0));
}

}  // namespace triad
