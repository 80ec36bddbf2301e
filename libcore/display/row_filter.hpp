// SPDX-License-Identifier: Apache-2.0
// Applies a filter design to whole rows of a wide picture, by FFT.
#pragma once

#include <complex>
#include <triad/display/filter_design.hpp>
#include <triad/numeric/aligned.hpp>
#include <triad/numeric/fft.hpp>
#include <vector>

namespace triad {

// What lies beyond the ends of a row.
enum class Edge {
  kMirror,  // the row backwards, border sample repeated: solved on the ring of 2 W pixels, then cut
  kWrap     // the other end: solved on the ring of W pixels. The left edge ghosts into the right
};

// Pixels of the ring on which a row of width_px is solved: FilterDesign's `tiles`. Throws Error(kUsage) below 1
// and where the ring would be longer than FilterDesign allows.
int ring_px(int width_px, Edge edge);

// Immutable and thread-safe; each thread needs a Workspace of its own. Real is the precision of transforms
// and coefficients. The same row gives the same bits wherever and whenever it is filtered.
template <class Real>
class RowFilter {
 public:
  // design.tiles() must be ring_px(width_px, edge). The design is not needed afterwards.
  RowFilter(const FilterDesign& design, int width_px, Edge edge);

  int width_px() const { return width_px_; }

  class Workspace {
   public:
    explicit Workspace(const RowFilter& filter);

   private:
    friend class RowFilter;
    AlignedBuffer<Real> plane_, cosines_[3], drives_;
    AlignedBuffer<std::complex<Real>> spectra_[3], output_;
  };

  // wide: cells_x * width_px interleaved RGB cells; drives: width_px interleaved RGB pixels. One not finite
  // value spoils the row.
  template <class Sample>
  void apply(const Sample* wide, Sample* drives, Workspace& workspace) const;

 private:
  int width_px_, ring_px_, aliases_;
  Edge edge_;
  RealFft<Real> ring_, wrap_;
  CosineTransform<Real> mirror_;
  // [m][alias * 3 + rgb][output channel], scaled by 1 / ring, with the phase of the mirrored row in it.
  std::vector<std::complex<Real>> coefficients_;
};

// Whether a convolution with `taps` cells should take less time than the FFT for rows of width_px pixels of
// `cells` cells, by counting operations; the same answer on every machine.
bool convolution_is_cheaper(int taps, int width_px, int cells, Edge edge);

}  // namespace triad
