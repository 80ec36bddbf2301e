// SPDX-License-Identifier: Apache-2.0
// Pictures at several resolutions, each of which says where the next one needs samples of its own: what quad and tri
// are made of. After the thesis "Tri-Adaptive Sampling" and Lawlor and Genetti's multi-resolution rendering (2014).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <triad/numeric/huge_pages.hpp>
#include <triad/sampling/source.hpp>
#include <vector>

namespace triad {

// Square cells in rows, one sample in each. In a shifted lattice the samples of odd rows lie half a cell to the
// right of their cells' centres, so that each has six neighbours at nearly the same distance.
struct LevelLattice {
  int width = 1, height = 1;  // cells that cover the film, the last ones perhaps only in part
  double cell_px = 1;
  bool shifted = false;

  // Of a film of that many pixels.
  LevelLattice(int film_width, int film_height, double side_px, bool shift);
  // By how many half cells the samples of a row are to the right of the centres.
  int shift(int row) const { return shifted && (row & 1) != 0; }
  double sample_x(int x, int row) const { return (x + .5 + .5 * shift(row)) * cell_px; }
  double sample_y(int row) const { return (row + .5) * cell_px; }
  bool operator==(const LevelLattice&) const = default;
};

// When a cell's neighbourhood says that finer cells are to be sampled: when a mean exceeds its threshold.
struct LevelThresholds {
  double colour = .03;    // of |difference| in any channel, in linear light
  double position = .03;  // of the length of the difference of positions over the distance from the viewer
  bool geometry = true;   // whether positions are looked at
  bool ids = false;       // whether a neighbour of another object is reason enough
};

// Why a cell's children are sampled. Colour is looked at first, then positions, then ids.
enum class LevelReason : uint8_t { kNone, kColour, kPosition, kId, kUnknown };

// What is known of each cell of a lattice, sampled or interpolated.
class Level {
 public:
  // Cells of which nothing is known. Without geometry, there are only colours.
  Level(const LevelLattice& lattice, bool geometry);
  // What each cell takes, judged or not.
  static size_t cell_bytes(bool geometry) {
    return (geometry ? kPlanes * sizeof(float) + sizeof(uint32_t) : kDistance * sizeof(float)) + sizeof(uint8_t);
  }

  const LevelLattice& lattice() const { return lattice_; }
  // The mean of samples taken at one place, of which those that are not valid are left out. The geometry is that of
  // the first valid one. False, and the cell stays as it is, if none is valid. Different threads may set different
  // cells.
  bool set(int x, int y, std::span<const Sample> samples);
  // Each cell's reason for its children to be sampled; to be called when all cells are set. A difference is
  // |a - (b + c) / 2| between a cell and two opposite neighbours, and its mean is over the opposing pairs: 4, of all
  // 8 neighbours, or in a shifted lattice 3, of the 6 nearest. Beyond the border the last cell repeats. Pairs with a
  // cell that is not known do not count; a cell without pairs, or not known itself, has the reason kUnknown. Cells of
  // which some hit and some miss differ in position by infinity.
  void judge(const LevelThresholds& thresholds);
  // Of the cell here in which one of `finer` lies, whose cells are half as large.
  LevelReason reason_for(const LevelLattice& finer, int x, int y) const {
    return static_cast<LevelReason>(reasons_[parent(finer, x, y)]);
  }

  // Fills a row of this lattice from one of cells twice as large: linear along its rows, then between them, which for
  // lattices without shift is bilinear. Cells that are not known take no part. What a cell hit is that of the cell
  // that it lies in, and position and distance are means over those that hit.
  void interpolate_row(int y, const Level& above);

  // At a cell's centre: its own colour, or in a shifted row the mean of those to the left and right. `weight` is 0 if
  // nothing is known there, and `sum` the colour times the weight.
  struct Weighted {
    std::array<float, 3> sum{};
    float weight = 0;
  };
  Weighted at_centre(int x, int y) const {
    Weighted result;
    if (lattice_.shift(y)) {
      add(result, at(std::max(0, x - 1), y), .5f);
      add(result, at(x, y), .5f);
    } else {
      add(result, at(x, y), 1);
    }
    return result;
  }

 private:
  enum Plane { kRed, kGreen, kBlue, kKnown, kDistance, kX, kY, kZ, kHit, kPlanes };

  // With the borders.
  size_t cells() const { return stride_ * static_cast<size_t>(lattice_.height); }
  // One column more on either side, so that loops need no care at borders.
  size_t at(int x, int y) const { return static_cast<size_t>(y) * stride_ + static_cast<size_t>(x + 1); }
  size_t parent(const LevelLattice& finer, int x, int y) const {
    return at((2 * x + 1 + finer.shift(y) - 2 * lattice_.shift(y >> 1)) >> 2, y >> 1);
  }
  void add(Weighted& result, size_t cell, float weight) const {
    const float known = weight * planes_[kKnown][cell];
    result.weight += known;
    for (size_t c = 0; c < 3; ++c) result.sum[c] += known * planes_[kRed + c][cell];
  }
  float* plane(Plane p) { return planes_[p].data(); }
  const float* plane(Plane p) const { return planes_[p].data(); }
  void repeat_border(int y);
  void judge_row(int y, const LevelThresholds& thresholds);

  LevelLattice lattice_;
  bool geometry_;
  size_t stride_;
  // Where nothing is known or hit, 0: sums leave it out by themselves.
  template <class T>
  using Values = std::vector<T, HugePageAllocator<T>>;
  Values<float> planes_[kPlanes];
  Values<uint32_t> ids_;
  Values<uint8_t> reasons_;  // of a level that was judged
};

}  // namespace triad
