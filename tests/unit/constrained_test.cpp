// SPDX-License-Identifier: Apache-2.0
// The constrained solver against dense matrices: its objective, its optimum and its certificate.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
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

// A panel that derives its white: what comes out is displayable by its rule and has the value told, no picture at all
// has less than the bound, and no single value can be changed to gain more than a little.
TEST(Constrained, DerivedWhiteIsWhatThePanelShowsAndItsBoundIsOne) {
  const Layout layout = reference::layout("rwbg");
  for (const double ppd : {20., 40., 67.}) {
    const int width = 6, height = 3;
    const auto cells = patches(width * layout.cells_x, height, 5);
    const SolveOptions options{{}, 400, 0};
    const reference::DenseDisplay dense(layout, reference::observer(ppd), options.filter, width, height, 0, 0, cells);
    const Solved got = solve_plane<double>(layout, ppd, width, height, 0, 0, Edge::kWrap, options, cells);
    const SolveResult& r = got.result;
    EXPECT_NEAR(r.start, dense.value(dense.start()), 1e-12) << ppd;
    EXPECT_NEAR(r.best, dense.value(dense.shown(got.drives)), 1e-12) << ppd;
    EXPECT_LT(r.best, .8 * r.start) << ppd;
    EXPECT_GT(r.bound, 0) << ppd;
    // Search by hand: each value in turn, in steps that shrink, from the solution, from grey and from noise.
    for (int from = 0; from < 3; ++from) {
      std::vector<double> rgb = from == 0 ? got.drives : reference::random_cells(width * height, 7);
      if (from == 1) std::fill(rgb.begin(), rgb.end(), .5);
      double value = dense.value(dense.shown(rgb));
      for (double step = .25; step > 1e-3; step /= 2)
        for (int sweep = 0; sweep < 4; ++sweep)
          for (double& v : rgb)
            for (const double change : {step, -step}) {
              const double before = v;
              v = std::clamp(v + change, 0., 1.);
              const double changed = dense.value(dense.shown(rgb));
              if (changed < value) {
                value = changed;
              } else {
                v = before;
              }
            }
      EXPECT_GE(value, r.bound - 1e-12) << ppd << " from " << from;
      if (from == 0) {
        EXPECT_GE(value, r.best - .02 * r.start) << ppd;
      }
    }
  }
  // Rows are the same problem.
  const auto cells = patches(7 * layout.cells_x, 1, 6);
  const SolveOptions options{{}, 300, 0};
  const Solved row = solve_row<double>(layout, 40, 7, Edge::kWrap, options, cells);
  const Solved plane = solve_plane<double>(layout, 40, 7, 1, 0, 0, Edge::kWrap, options, cells);
  EXPECT_NEAR(row.result.best, plane.result.best, 1e-12);
  for (size_t i = 0; i < row.drives.size(); ++i) EXPECT_NEAR(row.drives[i], plane.drives[i], 1e-9);
}

TEST(Constrained, RowsAndPlaneAgreeWhereAPictureHasOneRow) {
  const Layout layout = reference::layout("rgb");
  const auto cells = patches(3 * 23, 1, 8);
  const SolveOptions options{{}, 60, 0};
  const Solved row = solve_row<double>(layout, 40, 23, Edge::kWrap, options, cells);
  const Solved plane = solve_plane<double>(layout, 40, 23, 1, 0, 0, Edge::kWrap, options, cells);
  EXPECT_NEAR(row.result.best / plane.result.best, 1, 1e-9);
  for (size_t i = 0; i < row.drives.size(); ++i) EXPECT_NEAR(row.drives[i], plane.drives[i], 1e-9);
}

// With no bounds the dense optimum is a linear system's solution.
namespace {

// Whether an emitter shows channel c of the pixel at that phase of the panel.
bool drives(const Layout& layout, int x, int y, int c) {
  return std::any_of(layout.emitters.begin(), layout.emitters.end(), [&](const triad::Emitter& e) {
    return e.channel == c && x % layout.tile_x == e.pixel_x && y % layout.tile_y == e.pixel_y;
  });
}

}  // namespace

TEST(Constrained, TheLinearFilterOfThePlaneSolvesTheDenseSystem) {
  for (const Case& c : kCases)
    for (const double ppd : {20., 40., 67.})
      for (const double lambda : {.01, .001}) {
        const Layout layout = reference::layout(c.layout);
        const auto cells = patches(c.width * layout.cells_x, c.height * layout.cells_y, 11);
        const SolveOptions options{{.lambda = lambda}, 0, 0, false, false};
        const reference::DenseDisplay dense(layout, reference::observer(ppd), options.filter, c.width, c.height,
                                            c.origin_x, c.origin_y, cells);
        const Solved got =
            solve_plane<double>(layout, ppd, c.width, c.height, c.origin_x, c.origin_y, Edge::kWrap, options, cells);
        const Eigen::VectorXd expected = dense.unbounded();
        for (size_t i = 0; i < got.drives.size(); ++i) {
          const int pixel = static_cast<int>(i / 3), x = pixel % c.width + c.origin_x,
                    y = pixel / c.width + c.origin_y;
          if (!drives(layout, x, y, static_cast<int>(i % 3))) continue;  // what is stored there, the panel ignores
          ASSERT_NEAR(got.drives[i], expected[static_cast<Eigen::Index>(i)], 1e-7)
              << c.layout << ppd << " " << lambda;
        }
        EXPECT_NEAR(got.result.best, dense.value(expected), 1e-12) << c.layout << ppd;
      }
  // What lies outside is not clamped: the filter is linear.
  const Layout layout = reference::layout("qd-oled");
  auto cells = patches(16, 12, 12);
  const SolveOptions options{{}, 0, 0, false, false};
  const Solved one = solve_plane<double>(layout, 40, 8, 6, 0, 0, Edge::kMirror, options, cells);
  for (double& v : cells) v *= -3;
  const Solved three = solve_plane<double>(layout, 40, 8, 6, 0, 0, Edge::kMirror, options, cells);
  for (size_t i = 0; i < one.drives.size(); ++i) EXPECT_NEAR(three.drives[i], -3 * one.drives[i], 1e-9);
}

TEST(Constrained, AMarginOfTheMirrorImageStandsForAllOfIt) {
  // A ring of the picture and its whole mirror image, made by hand, against the margin that the solver takes.
  const Layout layout = reference::layout("rgb");
  for (const double ppd : {20., 40., 67., 120.}) {
    const int width = 400;
    const auto cells = patches(3 * width, 1, 9);
    auto whole = cells;
    for (int k = 3 * width; k-- > 0;)
      whole.insert(whole.end(), &cells[static_cast<size_t>(3 * k)], &cells[static_cast<size_t>(3 * k)] + 3);
    const SolveOptions options{{}, 2000, 1e-9};
    const Solved margin = solve_row<double>(layout, ppd, width, Edge::kMirror, options, cells);
    const Solved ring = solve_row<double>(layout, ppd, 2 * width, Edge::kWrap, options, whole);
    double worst = 0;
    for (size_t i = 0; i < margin.drives.size(); ++i)
      worst = std::max(worst, std::abs(margin.drives[i] - ring.drives[i]));
    std::printf("margin of %d px at %g ppd: drives differ by %.1e\n", triad::mirror_margin_px(ppd), ppd, worst);
    EXPECT_LT(worst, 2e-5) << ppd;
  }
}

TEST(Constrained, FlatFieldsStayExactInFloatOnEveryLayoutAndPpd) {
  for (const Layout& layout : reference::all_layouts())
    for (const double ppd : {5., 10., 20., 40., 67., 120., 300., 1000.})
      for (const std::array<double, 3>& colour : {std::array<double, 3>{1, 1, 1}, {.5, .25, .75}, {0, 0, 0}}) {
        const int width = 5, height = 4;
        std::vector<double> cells;
        for (int i = 0; i < width * height * layout.pixel_cells(); ++i)
          cells.insert(cells.end(), colour.begin(), colour.end());
        const Edge edge = ppd > 120 ? Edge::kWrap : Edge::kMirror;
        const Solved got = solve_plane<float>(layout, ppd, width, height, 0, 0, edge, {}, cells);
        for (int p = 0; p < width * height; ++p)
          for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(got.drives[static_cast<size_t>(3 * p + c)], colour[static_cast<size_t>(c)], 1e-6)
                << layout.name << " at " << ppd;
          }
        EXPECT_TRUE(got.result.converged);
      }
}

TEST(Constrained, ThreadsDoNotChangeABit) {
  const Layout layout = reference::layout("qd-oled");
  const auto cells = patches(2 * 61, 2 * 47, 10);
  triad::set_thread_limit(1);
  const Solved one = solve_plane<float>(layout, 40, 61, 47, 0, 0, Edge::kMirror, {}, cells);
  triad::set_thread_limit(5);
  const Solved five = solve_plane<float>(layout, 40, 61, 47, 0, 0, Edge::kMirror, {}, cells);
  triad::set_thread_limit(0);
  EXPECT_EQ(one.drives, five.drives);
  EXPECT_EQ(one.result.best, five.result.best);
  EXPECT_EQ(one.result.bound, five.result.bound);
}

TEST(Constrained, RefusesWhatItCannotSolve) {
  const auto eye = reference::observer(40);
  EXPECT_THROW(RowSolver<float>(reference::layout("qd-oled"), eye, 10, 0, Edge::kMirror, {}), triad::Error);
  EXPECT_THROW(RowSolver<float>(reference::layout("rgb"), eye, 0, 0, Edge::kMirror, {}), triad::Error);
  EXPECT_THROW(PlaneSolver<float>(reference::layout("rgb"), eye, 10, -1, 0, 0, Edge::kMirror, {}), triad::Error);
  EXPECT_THROW(PlaneSolver<float>(reference::layout("rgb"), reference::observer(0), 10, 10, 0, 0, Edge::kWrap, {}),
               triad::Error);
  EXPECT_THROW(PlaneSolver<float>(reference::layout("rgb"), eye, 1 << 20, 1 << 20, 0, 0, Edge::kWrap, {}),
               triad::Error);
  EXPECT_THROW(RowSolver<float>(reference::layout("rgb"), eye, 10, 0, Edge::kWrap, {{.lambda = 2}, 1, 0}),
               triad::Error);
}
