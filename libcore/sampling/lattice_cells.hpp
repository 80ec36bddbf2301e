// SPDX-License-Identifier: Apache-2.0
// One pixel of POV-Ray's method 2 and its descendants: a tree of cells with samples at their corners.
#pragma once

#include <triad/sampling/lattice.hpp>

namespace triad {

// What makes pov2, pov3, pov4 and pov5 of the same tree.
struct CellRules {
  int depth = 3;  // how often a pixel may be divided
  double threshold = .3;
  bool by_area = false;      // pov3: the threshold rises as less of the pixel still changes
  bool along_lines = false;  // pov4: the centre first, edges if need be, and differences along all of an edge
  bool with_centre = false;  // pov5: the pixel's centre, always
};

// Divides pixels, one after the other, as far as the samples go that a lattice has. Not for several threads at once.
class PixelCells {
 public:
  // Both must outlive it.
  PixelCells(const Lattice& lattice, const CellRules& rules)
      : lattice_(lattice), rules_(rules), row_(static_cast<size_t>(lattice.side()) + 1), found_(row_ * row_) {}

  // Whether the pixel is more than one cell. Much faster than divide(), which need not be called if not.
  bool divides(int pixel_x, int pixel_y);
  // Divides the pixel level by level. False if that takes samples that are not there: they are added to `wanted`,
  // and the pixel is divided down to the level that needs them.
  bool divide(int pixel_x, int pixel_y, std::vector<LatticePoint>& wanted);

  // Of the pixel that was asked about last, divided as far as it is now. The mean of its cells by area, where a cell
  // is the mean of its corners; of what is known. 0 if nothing is.
  std::array<double, 3> colour();
  // How often it was divided at most.
  int depth() const { return depth_; }
  // How many samples its colour is made of, those on its border included.
  int points();

 private:
  // Corners are numbered x + 2 y.
  struct Cell {
    LatticePoint at;  // upper left
    int side;
    std::array<PovColour, 4> corner;
    PovColour centre;  // unknown until it is needed
    float distance;
    int children = -1;  // the first of four, in the order of corners
  };
  struct Edge {
    LatticePoint from, to;  // by ascending coordinate
    const PovColour &a, &b;
  };
  struct Mean {
    std::array<double, 3> sum{};
    double weight = 0;
  };

  void begin(int pixel_x, int pixel_y);
  Edge edge(const Cell& cell, int number) const;
  // As the lattice's, which is asked once about each point.
  const PovColour* find(LatticePoint point);
  float difference(const Edge& edge);
  float difference(const Cell& cell);
  bool may_have_more(const Edge& edge) const;
  // Sets area_ to the share of the pixel in cells that change, of those from `first` on; returns whether any does.
  bool find_active(size_t first);
  bool active(const Cell& cell) const { return cell.distance * area_ >= rules_.threshold; }
  bool look_at_centre(Cell& cell, std::vector<LatticePoint>& wanted);
  void want_midpoints(const Cell& cell, std::vector<LatticePoint>& wanted);
  void add_children(size_t parent);
  PovColour midpoint(const Edge& edge);
  Mean mean(const Cell& cell) const;

  const Lattice& lattice_;
  const CellRules& rules_;
  int depth_ = 0;
  double area_ = 1;
  std::vector<Cell> cells_;  // a level after the other
  std::vector<LatticePoint> points_;
  struct Found {
    uint64_t pixel = 0;  // for which of the pixels asked about, by number, this was found
    const PovColour* colour = nullptr;
  };
  size_t row_;  // points on a side of a pixel
  std::vector<Found> found_;
  uint64_t pixel_ = 0;
};

}  // namespace triad
