// SPDX-License-Identifier: Apache-2.0
// How much of the difference between what a panel shows and what it should show an eye can see.
//
// Per row: e = sum over opponent channels c and frequencies n of W_c(f_n) |E_c(n)|^2 / N^2, W = MTF^2, where E
// is the unnormalised DFT over the N fine cells of (light of the panel) - (light of the target), in opponent
// space with the channels' gains: Platt (2000), rows taken one by one. By Parseval e is the mean, over the
// row's cells, of the squared error as the eye has blurred it, and so is computed in space: pixels can be
// weighed, and a map falls out. Units: linear light with white at 1, squared; rmse = sqrt(mean of e over rows).
//
// Edges: kWrap takes the row as a ring of N = S W cells. kMirror continues both pictures with their mirror
// images, on a panel that goes on as it was, N = 2 S W, and keeps the error of the W pixels that are there.
// A white picture scores what the eye sees of the panel's own stripes: 2e-6 at 40 ppd, 0 at 120.
#pragma once

#include <complex>
#include <cstdint>
#include <triad/display/layout.hpp>
#include <triad/display/row_filter.hpp>
#include <triad/display/vision.hpp>
#include <triad/numeric/aligned.hpp>
#include <triad/numeric/fft.hpp>
#include <triad/numeric/sum.hpp>

namespace triad {

enum class Range {
  kClip,      // test and target are first clamped to [0, 1]: what a panel can show, and what it could
  kUnbounded  // as they are: Platt's own measure
};

// Immutable and thread-safe; each thread needs a Workspace of its own.
class DisplayError {
 public:
  // Throws Error(kUsage): layout not is_rows(), observer refused, width outside 1 .. 2^26.
  DisplayError(const Layout& layout, const Observer& observer, int width_px, Edge edge, Range range);

  int width_px() const { return width_px_; }

  class Workspace {
   public:
    explicit Workspace(const DisplayError& measure);

   private:
    friend class DisplayError;
    AlignedBuffer<double> error_[3];
    AlignedBuffer<std::complex<double>> spectrum_;
  };

  struct Clamped {
    int64_t test_pixels = 0, target_cells = 0;  // with at least one channel outside [0, 1]; 0 if kUnbounded
  };

  // test: width_px RGB pixels; target: cells_x * width_px RGB cells. energy[x * 3 + c]: the mean over pixel
  // x's cells of channel c's squared blurred error, never negative; e = sum of energy / width_px.
  Clamped row(const float* test, const float* target, double* energy, Workspace& workspace) const;

 private:
  Layout layout_;
  int width_px_, ring_px_;
  Range range_;
  double opponent_[9];
  double emission_[3][3];  // [rgb channel that drives][opponent channel]: cells_x * C P_e
  RealFft<double> ring_;
  AlignedBuffer<double> weights_[3];  // MTF at each frequency, over the number of cells
};

// Weighted sums of energies over pixels. A plain record: all bytes zero is empty, and it may be copied as
// bytes. Bits depend on how rows are grouped into records: keep that fixed.
struct DisplayTotals {
  NeumaierSum energy[3], weight;
  int64_t clamped_test_pixels, clamped_target_cells;

  // Adds the pixels x0 .. x1 - 1 of a row. energies: as DisplayError::row gave them, of the whole row; mask: one
  // weight >= 0 per pixel, mask[x] of pixel x, or null for all 1.
  void add_pixels(const double* energies, const float* mask, int x0, int x1);
  void merge(const DisplayTotals& later);

  // sqrt of the weighted mean energy; not a number when every weight was 0.
  double rmse() const;
  // The part of the energy in opponent channel c, 0 .. 1; 0 where there is no error at all.
  double share(int c) const;
};

// Pixels that `border=auto` leaves out at each end of a row, ceil(ppd / 5) but always leaving one pixel or two:
// there, what is imagined beyond the edge shows.
int automatic_border_px(double ppd, int width_px);

}  // namespace triad
