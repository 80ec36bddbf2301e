// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <triad/base/error.hpp>
#include <triad/display/row_filter.hpp>

namespace triad {

int ring_px(int width_px, Edge edge) {
  constexpr int kMaxWidth = 1 << 26;  // FilterDesign allows rings of 2^27
  if (width_px < 1 || width_px > kMaxWidth)
    throw_usage("a row of " + std::to_string(width_px) + " pixels: 1 to " + std::to_string(kMaxWidth) +
                " can be filtered");
  return edge == Edge::kMirror ? 2 * width_px : width_px;
}

template <class Real>
RowFilter<Real>::RowFilter(const FilterDesign& design, int width_px, Edge edge)
    : width_px_(width_px),
      ring_px_(triad::ring_px(width_px, edge)),
      aliases_(design.aliases()),
      edge_(edge),
      ring_(static_cast<size_t>(ring_px_)),
      wrap_(static_cast<size_t>(width_px) * aliases_),
      mirror_(static_cast<size_t>(width_px) * aliases_) {
  if (design.tiles() != ring_px_)
    throw_internal("a filter designed for a ring of " + std::to_string(design.tiles()) + " pixels used on one of " +
                   std::to_string(ring_px_));
  const int S = aliases_, T = ring_px_;
  const int64_t N = static_cast<int64_t>(S) * T;
  coefficients_.resize((static_cast<size_t>(T) / 2 + 1) * S * 9);
  auto* out = coefficients_.data();
  for (int m = 0; m <= T / 2; ++m)
    for (int j = 0; j < S; ++j) {
      const int64_t n = m + static_cast<int64_t>(T) * j;
      std::complex<double> factor = 1.0 / T;
      if (edge == Edge::kMirror) {
        // The DFT of the mirrored row from its DCT; n beyond the middle is the conjugate of N - n.
        const bool folded = 2 * n > N;
        const double angle = std::numbers::pi * static_cast<double>(folded ? N - n : n) / static_cast<double>(N);
        factor *= std::polar(1.0, folded ? -angle : angle);
      }
      for (int d = 0; d < 3; ++d)
        for (int o = 0; o < 3; ++o)
          *out++ = std::complex<Real>(design.transfer(m, design.layout().emitter_of(o), j, d) * factor);
    }
}

template <class Real>
RowFilter<Real>::Workspace::Workspace(const RowFilter& filter)
    : plane_(filter.wrap_.size()), drives_(static_cast<size_t>(filter.ring_px_)) {
  for (int d = 0; d < 3; ++d) {
    if (filter.edge_ == Edge::kMirror) {
      cosines_[d] = AlignedBuffer<Real>(filter.mirror_.size() + 1);  // the last is the mirrored row's zero
    } else {
      spectra_[d] = AlignedBuffer<std::complex<Real>>(filter.wrap_.spectrum_size());
    }
  }
  // The drives' spectra one after the other, each on a line of its own.
  const size_t line = kBufferAlignment_bytes / sizeof(std::complex<Real>);
  output_ = AlignedBuffer<std::complex<Real>>((filter.ring_.spectrum_size() + line - 1) / line * line * 3);
}

template <class Real>
template <class Sample>
void RowFilter<Real>::apply(const Sample* wide, Sample* drives, Workspace& work) const {
  const int S = aliases_, T = ring_px_;
  const size_t cells = wrap_.size();
  for (int d = 0; d < 3; ++d) {
    for (size_t k = 0; k < cells; ++k) work.plane_[k] = static_cast<Real>(wide[3 * k + d]);
    if (edge_ == Edge::kMirror) {
      mirror_.forward(work.plane_.data(), work.cosines_[d].data());
    } else {
      wrap_.forward(work.plane_.data(), work.spectra_[d].data());
    }
  }

  const size_t stride = work.output_.size() / 3;
  const int64_t N = static_cast<int64_t>(S) * T;
  const std::complex<Real>* h = coefficients_.data();
  for (int m = 0; m <= T / 2; ++m) {
    Real re[3] = {0, 0, 0}, im[3] = {0, 0, 0};
    for (int j = 0; j < S; ++j) {
      const int64_t n = m + static_cast<int64_t>(T) * j;
      const bool folded = 2 * n > N;
      const size_t k = static_cast<size_t>(folded ? N - n : n);
      for (int d = 0; d < 3; ++d, h += 3) {
        if (edge_ == Edge::kMirror) {
          const Real value = work.cosines_[d][k];
          for (int o = 0; o < 3; ++o) {
            re[o] += h[o].real() * value;
            im[o] += h[o].imag() * value;
          }
        } else {
          const Real x = work.spectra_[d][k].real();
          const Real y = folded ? -work.spectra_[d][k].imag() : work.spectra_[d][k].imag();
          for (int o = 0; o < 3; ++o) {
            re[o] += h[o].real() * x - h[o].imag() * y;
            im[o] += h[o].real() * y + h[o].imag() * x;
          }
        }
      }
    }
    for (size_t o = 0; o < 3; ++o) work.output_[o * stride + static_cast<size_t>(m)] = {re[o], im[o]};
  }
  for (size_t o = 0; o < 3; ++o) {
    ring_.inverse(work.output_.data() + o * stride, work.drives_.data());
    for (size_t x = 0; x < static_cast<size_t>(width_px_); ++x)
      drives[3 * x + o] = static_cast<Sample>(work.drives_[x]);
  }
}

template class RowFilter<float>;
template class RowFilter<double>;
template void RowFilter<float>::apply(const float*, float*, Workspace&) const;
template void RowFilter<double>::apply(const float*, float*, Workspace&) const;
template void RowFilter<double>::apply(const double*, double*, Workspace&) const;

bool convolution_is_cheaper(int taps, int width_px, int cells, Edge edge) {
  // Multiplications and additions per pixel. A convolution runs at about four times the operations a second
  // of a transform (FFTW 3.3.10 against an AVX2 loop, both in float on one core).
  constexpr double kConvolutionSpeed = 4;
  const double ring = ring_px(width_px, edge), samples = static_cast<double>(width_px) * cells;
  const double per_row = 3 * 2.5 * (samples * std::log2(samples + 1) + ring * std::log2(ring + 1)) +
                         (edge == Edge::kMirror ? 4. : 8.) * 9 * cells * (ring / 2 + 1);
  return 18.0 * taps * width_px <= kConvolutionSpeed * per_row;
}

}  // namespace triad
