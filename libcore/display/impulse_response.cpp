// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <triad/base/error.hpp>
#include <triad/display/filter_design.hpp>
#include <triad/numeric/aligned.hpp>
#include <triad/numeric/fft.hpp>
#include <triad/numeric/sum.hpp>

namespace triad {

ImpulseResponse::ImpulseResponse(const FilterDesign& design)
    : layout_(design.layout()),
      cells_(design.cells()),
      exact_flat_fields_(design.exact_flat_fields()),
      response_(9 * static_cast<size_t>(cells_)) {
  const int S = design.aliases(), T = design.tiles(), N = cells_;
  const RealFft<double> fft(static_cast<size_t>(N));
  AlignedBuffer<std::complex<double>> spectrum(fft.spectrum_size());
  AlignedBuffer<double> values(static_cast<size_t>(N));
  for (int o = 0; o < 3; ++o) {
    const int e = layout_.emitter_of(o);
    centre_cell_[o] = static_cast<int>(std::floor(layout_.emitters[e].centre_x()));
    for (int d = 0; d < 3; ++d) {
      // The drives are every S-th sample of the target correlated with h, so the transfer function of h is
      // S H, and h(k) = 1/N sum of S H(n) exp(-2 pi i k n / N).
      for (int n = 0; n <= N / 2; ++n) {
        const int j = n / T, m = n % T;
        const std::complex<double> H =
            2 * m <= T ? design.transfer(m, e, j, d) : std::conj(design.transfer(T - m, e, S - 1 - j, d));
        spectrum[static_cast<size_t>(n)] = std::conj(H) * (1.0 / T);
      }
      fft.inverse(spectrum.data(), values.data());
      std::copy(values.begin(), values.end(), response_.begin() + static_cast<ptrdiff_t>((o * 3 + d)) * N);
    }
  }
}

double ImpulseResponse::at(int output, int rgb, int cell) const {
  const int wrapped = ((cell % cells_) + cells_) % cells_;
  return response_[static_cast<size_t>(output * 3 + rgb) * cells_ + wrapped];
}

std::array<FirKernel, 3> ImpulseResponse::truncated(int taps) const {
  if (taps < 1 || taps > cells_)
    throw_usage("taps is " + std::to_string(taps) + ": a row of " + std::to_string(cells_) + " cells allows 1 to " +
                std::to_string(cells_));
  std::array<FirKernel, 3> kernels;
  for (int o = 0; o < 3; ++o) {
    FirKernel& kernel = kernels[o];
    kernel.first_cell = centre_cell_[o] - taps / 2;
    for (int t = 0; t < taps; ++t)
      for (int d = 0; d < 3; ++d) kernel.coefficients.push_back(at(o, d, kernel.first_cell + t));
    if (exact_flat_fields_) restore_flat_fields(kernel, o, taps);
  }
  return kernels;
}

void ImpulseResponse::restore_flat_fields(FirKernel& kernel, int output, int taps) const {
  const BoxWindow box = displaced_box(layout_, layout_.emitter_of(output));
  const auto for_each_inside = [&](const auto& body) {  // a kernel shorter than the box holds a part of it
    for (size_t i = 0; i < box.weights.size(); ++i) {
      const int t = box.first_cell + static_cast<int>(i) - kernel.first_cell;
      if (t >= 0 && t < taps) body(static_cast<size_t>(t), box.weights[i]);
    }
  };
  double inside = 0;
  for_each_inside([&](size_t, double weight) { inside += weight; });
  for (int d = 0; d < 3; ++d) {
    NeumaierSum sum;
    for (int t = 0; t < taps; ++t) sum.add(kernel.coefficients[static_cast<size_t>(t * 3 + d)]);
    const double missing = (output == d ? 1.0 : 0.0) - sum.value();
    for_each_inside([&](size_t t, double weight) { kernel.coefficients[3 * t + d] += missing * weight / inside; });
  }
}

double ImpulseResponse::truncation_error(int taps) const {
  double worst = 0;
  for (int o = 0; o < 3; ++o) {
    const int first = centre_cell_[o] - taps / 2;
    NeumaierSum all, cut;
    for (int t = 0; t < cells_; ++t)
      for (int d = 0; d < 3; ++d) {
        const double size = std::abs(at(o, d, first + t));
        all.add(size);
        if (t >= taps) cut.add(size);
      }
    worst = std::max(worst, cut.value() / all.value());
  }
  return worst;
}

int ImpulseResponse::taps_for(double target) const {
  // Bisection over odd numbers: the error falls as the kernel grows.
  int low = std::min((layout_.cells_x - 1) / 2, (cells_ - 1) / 2), high = (cells_ - 1) / 2;
  if (truncation_error(2 * high + 1) > target) return cells_;
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (truncation_error(2 * middle + 1) <= target) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return 2 * high + 1;
}

double ImpulseResponse::l1_norm() const {
  double worst = 0;
  for (int o = 0; o < 3; ++o) {
    NeumaierSum sum;
    for (size_t i = 0; i < 3 * static_cast<size_t>(cells_); ++i)
      sum.add(std::abs(response_[static_cast<size_t>(o) * 3 * cells_ + i]));
    worst = std::max(worst, sum.value());
  }
  return worst;
}

template <class Real>
void convolve_row(const std::array<FirKernel, 3>& kernels, int cells_per_pixel, const Real* cells, int x0, int x1,
                  Real* out) {
  for (int x = x0; x < x1; ++x)
    for (const FirKernel& kernel : kernels) {
      const Real* in = cells + 3 * (static_cast<ptrdiff_t>(cells_per_pixel) * x + kernel.first_cell);
      Real sum = 0;
      for (const double coefficient : kernel.coefficients) sum += static_cast<Real>(coefficient) * *in++;
      *out++ = sum;
    }
}
template void convolve_row(const std::array<FirKernel, 3>&, int, const float*, int, int, float*);
template void convolve_row(const std::array<FirKernel, 3>&, int, const double*, int, int, double*);

}  // namespace triad
