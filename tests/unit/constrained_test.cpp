// SPDX-License-Identifier: Apache-2.0
// The constrained solver against dense matrices: its objective, its optimum and its certificate.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/display/constrained.hpp>
#include <triad/numeric/aligned.hpp>
#include <vector>

#include "dense_display.hpp"
#include "display_reference.hpp"
#include "layouts.hpp"

using triad::Edge;
using triad::Layout;
using triad::PlaneSolver;
using triad::RowSolver;
using triad::SolveOptions;
using triad::SolveResult;
namespace reference = triad::reference;

namespace {

struct Solved {
  SolveResult result;
  std::vector<double> drives;
};

template <class Real, class Sample = Real>
Solved solve_plane(const Layout& layout, double ppd, int width, int height, int origin_x, int origin_y, Edge edge,
                   const SolveOptions& options, const std::vector<double>& cells) {
  const PlaneSolver<Real> solver(layout, reference::observer(ppd), width, height, origin_x, origin_y, edge, options);
  triad::AlignedBuffer<std::byte> workspace(solver.workspace_bytes());
  const std::vector<Sample> in(cells.begin(), cells.end());
  std::vector<Sample> out(static_cast<size_t>(3 * width * height));
  const auto result = solver.solve(in.data(), 3 * width * layout.cells_x, out.data(), 3 * width, workspace.data());
  return {result, {out.begin(), out.end()}};
}

template <class Real, class Sample = Real>
Solved solve_row(const Layout& layout, double ppd, int width, Edge edge, const SolveOptions& options,
                 const std::vector<double>& cells) {
  const RowSolver<Real> solver(layout, reference::observer(ppd), width, 0, edge, options);
  typename RowSolver<Real>::Workspace workspace(solver);
  const std::vector<Sample> in(cells.begin(), cells.end());
  std::vector<Sample> out(static_cast<size_t>(3 * width));
  const auto result = solver.solve(in.data(), out.data(), workspace);
  return {result, {out.begin(), out.end()}};
}

Eigen::VectorXd vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

// Black, white and colours in patches: much of the optimum lies on bounds.
std::vector<double> patches(int cells_x, int cells_y, unsigned seed) {
  auto values = reference::random_cells(cells_x * cells_y, seed);
  for (int y = 0; y < cells_y; ++y)
    for (int x = 0; x < cells_x; ++x)
      for (int d = 0; d < 3; ++d) {
        double& v = values[static_cast<size_t>(3 * (y * cells_x + x) + d)];
        if ((x / 3 + y / 2 + static_cast<int>(seed)) % 3 != 0) v = (x / 3 + y / 2) % 2;
      }
  return values;
}

struct Case {
  const char* layout;
  int width, height, origin_x, origin_y;
};
// Small tori of whole tiles, even and odd, each layout once at least; sizes that the dense solver can do.
constexpr Case kCases[] = {{"rgb", 6, 1, 0, 0},          {"rgb", 5, 3, 0, 0},          {"bgr", 4, 2, 0, 0},
                           {"vrgb", 3, 5, 0, 0},         {"vbgr", 2, 4, 0, 0},         {"qd-oled", 4, 3, 0, 0},
                           {"qd-oled", 5, 4, 0, 0},      {"qd-oled-fine", 2, 3, 0, 0}, {"pentile-rgbg", 4, 6, 0, 0},
                           {"pentile-rgbg", 6, 2, 1, 0}, {"pentile-rgbg", 4, 4, 1, 1}, {"rgb-delta", 3, 4, 0, 0},
                           {"rgb-delta", 2, 4, 0, 1}};

int g_certified = 0;  // problems of a test that were worth solving

// What must hold of a solver against the dense problem: `solve` takes options.
template <class Solve>
void expect_certified(const reference::DenseDisplay& dense, const Solve& solve, const std::string& what) {
  const Eigen::VectorXd best = dense.optimum();
  ASSERT_LT(dense.optimality(best), 1e-10) << what;
  const double least = dense.value(best), start = dense.value(dense.start());
  if (start < 1e-9) return;  // high ppd on a few pixels: nothing is seen, rounding is all there is
  ++g_certified;
  double before = start;
  // The dense value is a difference of numbers of about 1.
  constexpr double kRounding = 1e-13;
  for (const int iterations : {0, 1, 2, 3, 5, 8, 13, 21, 34, 3000}) {
    const Solved got = solve(iterations);
    const SolveResult& r = got.result;
    EXPECT_NEAR(r.start, start, kRounding) << what;
    EXPECT_NEAR(r.best, dense.value(vector_of(got.drives)), kRounding) << what << ", iterations " << iterations;
    // The certificate: the optimum lies between bound and best. Never worse than before, or than the start.
    EXPECT_LE(r.bound, least + kRounding) << what << ", iterations " << iterations;
    EXPECT_GE(r.best, least - kRounding) << what << ", iterations " << iterations;
    EXPECT_LE(r.best, start + kRounding) << what;
    EXPECT_LE(r.best, r.start) << what;
    for (const double v : got.drives) EXPECT_TRUE(v >= 0 && v <= 1) << what;
    if (iterations == 3000) {
      EXPECT_LE(r.best - least, 1e-7 * start) << what;
      EXPECT_LE(r.gap(), 1e-6) << what;
      EXPECT_LE(r.best, before * (1 + 1e-12)) << what;
    }
  }
}

}  // namespace

TEST(Constrained, PlaneIsCertifiedByADenseSolverOnEveryLayout) {
  g_certified = 0;
  for (const Case& c : kCases)
    for (const double ppd : {20., 40., 67., 120.})
      for (const bool exact : {true, false}) {
        const Layout layout = reference::layout(c.layout);
        const auto cells = patches(c.width * layout.cells_x, c.height * layout.cells_y, 3);
        SolveOptions options{{.exact_flat_fields = exact}, 0, 0};
        const reference::DenseDisplay dense(layout, reference::observer(ppd), options.filter, c.width, c.height,
                                            c.origin_x, c.origin_y, cells);
        expect_certified(
            dense,
            [&](int iterations) {
              options.iterations = iterations;
              return solve_plane<double>(layout, ppd, c.width, c.height, c.origin_x, c.origin_y, Edge::kWrap, options,
                                         cells);
            },
            std::string(c.layout) + " " + std::to_string(c.width) + "x" + std::to_string(c.height) + " at " +
                std::to_string(ppd) + (exact ? " exact" : " free"));
      }
}

TEST(Constrained, RowsAreCertifiedByADenseSolver) {
  g_certified = 0;
  for (const char* name : {"rgb", "bgr"})
    for (const int width : {1, 2, 7, 12})
      for (const double ppd : {20., 40., 67., 120.})
        for (const auto csf_lambda : {.01, .1}) {
          const Layout layout = reference::layout(name);
          const auto cells = patches(3 * width, 1, 4);
          SolveOptions options{{.lambda = csf_lambda}, 0, 0};
          const reference::DenseDisplay dense(layout, reference::observer(ppd), options.filter, width, 1, 0, 0,
                                              cells);
          expect_certified(
              dense,
              [&](int iterations) {
                options.iterations = iterations;
                return solve_row<double>(layout, ppd, width, Edge::kWrap, options, cells);
              },
              std::string(name) + " " + std::to_string(width) + " at " + std::to_string(ppd));
        }
  EXPECT_GE(g_certified, 36);  // of 64: a single pixel is flat
}
