// SPDX-License-Identifier: Apache-2.0
// The best picture that a panel can show: drives within [0, 1] whose light differs least, to an eye, from a fine
// picture's. The unconstrained optimum asks for light below zero and above white, and clipped it is worse than no
// filter at all.
//
// Minimised over 0 <= a <= 1, with W, E and the displaced box as in filter_design.hpp:
//
//   J(a) = mean over the torus of the squared error as the eye blurs it + lambda^2 |a - box|^2 in D's norm
//
// a convex problem, by the alternating direction method of multipliers (Boyd et al. 2011, over-relaxed by 1.7, in the
// form of Douglas and Rachford that keeps one state per drive). Its inner step is one transform there and back and a
// small matrix per tile frequency. It starts from the displaced box. For any x with mu = b - A x, convexity bounds
// the optimum from below, which certifies how far a result can be from it: "gap".
//
// Where the panel derives its white, what it can show is not convex: the nearest of the three convex pieces is taken
// pixel by pixel, then the pieces are kept and solved again; the bound is that of the convex hull.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <triad/display/filter_design.hpp>
#include <triad/display/torus.hpp>

namespace triad {

struct SolveOptions {
  FilterOptions filter;
  int iterations = 40;      // at most; 0 gives the displaced box
  double tolerance = 1e-2;  // stops when the gap is at most this part of the start's J; 0 runs all iterations
  // False, for PlaneSolver<double> only: the linear filter, the least J with no bounds on drives; exact, without
  // iterations. lambda must be at least kLeastLinearLambda.
  bool bounded = true;
  bool clamp_input = true;  // PlaneSolver: whether the picture is clamped to [0, 1] on the way in
};

// Below it the linear filter in the plane would amplify rounding by more than 1e8.
inline constexpr double kLeastLinearLambda = 1e-4;

// J's, as mean squared errors of linear light with white at 1; they can be added over rows, divided by the rows.
struct SolveResult {
  double start = 0;  // of the displaced box
  double best = 0;   // of the drives that came out; never above start
  double bound = 0;  // no drives have less; 0 .. best
  int iterations = 0;
  bool converged = true;

  // What is certified: best is at most this part of `start` above the optimum.
  double gap() const { return start > 0 ? (best - bound) / start : 0; }
  // Adds another row's: sums, the most iterations, converged if both.
  void add(const SolveResult& other);
};

// Rows one by one, for layouts with independent rows. Immutable and thread-safe; each thread needs a Workspace of its
// own. Real is the precision of transforms and drives; tables are made in double. The same row gives the same
// bits wherever and whenever it is solved.
template <class Real>
class RowSolver {
 public:
  // origin_px: the panel's pixel under pixel 0. Throws Error(kUsage) for a layout without independent rows and what
  // torus_axis, FilterOptions and observers refuse.
  RowSolver(const Layout& layout, const Observer& observer, int width_px, int origin_px, Edge edge,
            const SolveOptions& options);
  ~RowSolver();
  RowSolver(RowSolver&&) noexcept;

  class Workspace {
   public:
    explicit Workspace(const RowSolver& solver);
    ~Workspace();
    Workspace(Workspace&&) noexcept;

   private:
    friend class RowSolver;
    struct Buffers;
    std::unique_ptr<Buffers> buffers_;
  };

  // wide: the row's cells, interleaved RGB, finite; clamped to [0, 1] on the way in. drives: width_px RGB pixels.
  template <class Sample>
  SolveResult solve(const Sample* wide, Sample* drives, Workspace& workspace) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

// The whole picture at once, in the plane, for any layout; all cores through parallel_for, the same bits for any
// number of them. Immutable and thread-safe.
template <class Real>
class PlaneSolver {
 public:
  // origin: the panel's pixel under pixel (0, 0). Throws Error(kUsage) for what torus_axis, FilterOptions and
  // observers refuse.
  PlaneSolver(const Layout& layout, const Observer& observer, int width_px, int height_px, int origin_x_px,
              int origin_y_px, Edge edge, const SolveOptions& options);
  ~PlaneSolver();
  PlaneSolver(PlaneSolver&&) noexcept;

  // The memory of a solve, to be given as `workspace`; known beforehand. What each thread holds besides is small: a
  // few columns of the torus.
  uint64_t workspace_bytes() const;

  // cells: the picture's fine cells, interleaved RGB, finite, stride samples from row to row; clamped to [0, 1] on
  // the way in. drives: width x height RGB pixels. workspace: 64-byte aligned. progress, if any, is called now and
  // then with the part done, on the calling thread; what it throws ends the solve.
  template <class Sample>
  SolveResult solve(const Sample* cells, ptrdiff_t stride, Sample* drives, ptrdiff_t drives_stride, void* workspace,
                    const std::function<void(double)>& progress = {}) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace triad
