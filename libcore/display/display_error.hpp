// SPDX-License-Identifier: Apache-2.0
// How much of the difference between what a panel shows and what it should show an eye can see.
//
// In the plane: e = sum over opponent channels c and frequencies n = (nx, ny) of W_c(f_n) |E_c(n)|^2 / (Nx Ny)^2,
// f = sqrt(fx^2 + fy^2), W = MTF^2, where E is the unnormalised DFT over the Nx x Ny fine cells of (light of the
// panel) - (light of the target), in opponent space with the channels' gains. By rows, after Platt (2000): the same
// for each row as a picture of its own that is constant in y, and e the mean over rows. The two are equal for
// pictures that are constant in y. By Parseval e is the mean, over the cells, of the squared error as the eye has
// blurred it, and so is computed in space: pixels can be weighed, and a map falls out. Units: linear light with
// white at 1, squared; rmse = sqrt(e).
//
// Edges: PanelTorus. A white picture scores what the eye sees of the panel's own structure: for stripes 2e-6 at
// 40 ppd, 0 at 120.
#pragma once

#include <array>
#include <cstdint>
#include <triad/display/panel_torus.hpp>
#include <triad/display/s_cielab.hpp>
#include <triad/display/vision.hpp>
#include <triad/numeric/plane_blur.hpp>
#include <triad/numeric/sum.hpp>
#include <vector>

namespace triad {

// Immutable and thread-safe; each thread needs a Workspace of its own. Whole pictures are measured on all threads of
// the process; the same pictures give the same bits for any number of them.
class DisplayError {
 public:
  // What `target` is below.
  enum class Target {
    kCells,  // a fine picture, the light that an ideal panel would show: cells_x * cells_y cells for each pixel
    kDrives  // a picture of the test's size that the same panel shows; then equal pictures have no error
  };
  // Row by row. Throws Error(kUsage): layout without independent rows, observer refused, width outside 1 .. 2^26.
  DisplayError(const Layout& layout, const Observer& observer, int width_px, Edge edge, Range range);
  // What the shape says: in the plane, or row by row for one_row. Throws Error(kUsage): observer or shape refused.
  DisplayError(const Layout& layout, const Observer& observer, const PanelTorus::Shape& shape, Range range,
               Target target = Target::kCells);

  const PanelTorus& torus() const { return torus_; }
  int width_px() const { return torus_.shape().width_px; }
  int height_px() const { return torus_.shape().height_px; }
  // What a Workspace holds.
  uint64_t workspace_bytes() const;

  class Workspace {
   public:
    explicit Workspace(const DisplayError& measure);

   private:
    friend class DisplayError;
    PlaneBlur::Workspace blur_;
    std::vector<float> clamped_, clamped_target_;
    std::vector<double> row_energies_;  // [fine row][pixel]
  };

  struct Clamped {
    // With at least one channel outside [0, 1]; 0 if kUnbounded. Of a target of drives: its pixels.
    int64_t test_pixels = 0, target_cells = 0;
  };

  // test: width_px * height_px RGB pixels; target: as many, or for kCells cells_x * cells_y times as many.
  // energy[(y * width_px + x) * 3 + c]: the mean over the pixel's cells of channel c's squared blurred error, never
  // negative; e = sum of energy / pixels.
  Clamped picture(const PictureView& test, const PictureView& target, double* energy, Workspace& workspace) const;
  // The same where pictures are one row high.
  Clamped row(const float* test, const float* target, double* energy, Workspace& workspace) const;

  // What conventional antialiasing would show of a target of cells: each pixel the mean of its own, clamped first if
  // kClip.
  // drives: width_px * height_px RGB pixels, the rows touching.
  void pixel_average(const PictureView& target, float* drives) const;

  // S-CIELAB between the light of the panel and the target: delta_e[y * width_px + x] is the mean over the pixel's
  // cells. Clamps as picture() does.
  class PerceivedWorkspace {
   public:
    explicit PerceivedWorkspace(const DisplayError& measure);

   private:
    friend class DisplayError;
    SCielab::Workspace scielab_;
    std::vector<float> clamped_, clamped_target_;
    std::vector<double> row_sums_;
  };
  uint64_t perceived_workspace_bytes() const;
  void delta_e(const PictureView& test, const PictureView& target, double* delta_e,
               PerceivedWorkspace& workspace) const;

 private:
  PictureView shown(const PictureView& test, std::vector<float>& clamped, int64_t& outside) const;
  Light meant(const PictureView& target, std::vector<float>& clamped, int64_t& outside) const;

  PanelTorus torus_;
  Range range_;
  Target target_;
  PlaneBlur blur_;
  SCielab scielab_;
  std::array<double, 9> opponent_;
  PlaneBlur::Transfer transfer_[3];
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

// Weighted colour differences over pixels: their mean and percentiles. A plain record like DisplayTotals.
struct DeltaTotals {
  // Delta E in steps of 1/64 octave from 2^-10 to 2^10; what is below or above counts in the first or last.
  static constexpr int kBinsPerOctave = 64, kLowestOctave = -10, kOctaves = 20;
  static constexpr int kBins = kBinsPerOctave * kOctaves;

  NeumaierSum sum, weight;
  double bins[kBins];

  void add(double delta_e, double w);
  void merge(const DeltaTotals& later);
  double mean() const { return sum.value() / weight.value(); }
  // The Delta E that the share p of all weight does not exceed, to 1%; 0 where it is below 2^-10. p in 0 .. 1.
  double percentile(double p) const;
};

// Pixels that `border=auto` leaves out at each end of a row or column, ceil(ppd / 5) but always leaving one pixel or
// two: there, what is imagined beyond the edge shows.
int automatic_border_px(double ppd, int size_px);

}  // namespace triad
