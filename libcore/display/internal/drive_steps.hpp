// SPDX-License-Identifier: Apache-2.0
// What a panel can show, as the constrained solver needs it: projections of all emitters of a row of tiles, and the
// steps made of them.
#pragma once

#include <array>
#include <cstdint>
#include <triad/display/internal/descent.hpp>
#include <triad/display/internal/tile_equations.hpp>
#include <triad/display/layout.hpp>
#include <vector>

namespace triad::descent {

// Where the drives may lie. Most panels: each within [0, 1]. A panel that derives its white shows one of three convex
// pieces per pixel, min(r, g, b) = 0 by which of them is 0, with w >= 0 and each colour + w <= 1. It is solved in
// three stages: in their convex hull r + g + b + 2 w <= 2, which gives the bound; in the nearest piece; in pieces
// kept as they were found.
enum class Stage { kBounds, kHull, kPieces, kFixed };

// Rows of n tiles, E emitters each, one every `stride` elements. pieces: one byte for each derived white of a tile,
// the emitter 0, 1 or 2 (red, green, blue) that is dark.
template <class Real>
struct TileRow {
  size_t n;
  const Real* x;
  size_t x_stride;
  const Real* box;
  Real* state;
  size_t stride;  // of box, state
  Real* next;
  size_t next_stride;
  uint8_t* pieces;
  size_t pieces_stride;
};

template <class Real>
class DriveSteps {
 public:
  DriveSteps(const TileEquations& equations, double lambda);

  // In the order in which they are solved.
  const std::vector<Stage>& stages() const { return stages_; }
  // Derived whites of a tile: planes of `pieces`.
  int whites() const { return static_cast<int>(pixels_.size()); }

  // s and, in next, the v to be transformed.
  void advance(Stage stage, const TileRow<Real>& row) const;
  // s and, in next, z - x.
  Sums advance_certified(Stage stage, const TileRow<Real>& row) const;
  // v from s, in next.
  void reflect(Stage stage, const TileRow<Real>& row) const;
  // z from s, in next.
  void project(Stage stage, const TileRow<Real>& row) const;
  // The pieces nearest to s.
  void choose_pieces(const TileRow<Real>& row) const;

 private:
  using Pixel = std::array<Real, 4>;  // r, g, b, w
  // The nearest point to a, in D's norm.
  Pixel nearest(Stage stage, const Pixel& a, const Pixel& D, int piece) const;
  template <class Body>
  void for_each_white(const TileRow<Real>& row, const Body& body) const;

  int E_;
  std::vector<Stage> stages_;
  std::vector<std::array<int, 4>> pixels_;  // the emitters r, g, b, w of pixels with derived white
  std::vector<Real> D_, rho_, penalty_, floor_;
};

// Which iteration comes next, and what is known so far. Loop while next() is true.
class Schedule {
 public:
  Schedule(const std::vector<Stage>& stages, const SolveOptions& options, const SolveResult& start,
           double negligible);

  bool next();
  Stage stage() const { return stages_[at_]; }
  bool first_of_stage() const { return iteration_ == 1; }
  bool first() const { return result_.iterations == 1; }  // s and v are still 0
  bool check() const {
    return (options_.tolerance > 0 && iteration_ >= kFirstCheck && iteration_ % kCheckEvery == 0) ||
           iteration_ == options_.iterations;
  }
  // The part of the iterations that are behind, at least.
  double done() const;
  // After a checked iteration: quadratic_x = x^H A x over T, quadratic_d that of z - x. True where z is displayable
  // and the best so far.
  bool certify(double quadratic_x, double quadratic_d, const Sums& sums, double tiles);
  const SolveResult& result() const { return result_; }

 private:
  const std::vector<Stage>& stages_;
  SolveOptions options_;
  SolveResult result_, hull_;
  size_t at_ = 0;
  int iteration_ = 0;
  bool stage_done_ = false;
};

}  // namespace triad::descent
