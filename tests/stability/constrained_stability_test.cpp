// SPDX-License-Identifier: Apache-2.0
// The constrained solver where it is hard: pictures of every kind at every distance, and inputs that no picture
// should be.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <triad/display/constrained.hpp>
#include <triad/numeric/aligned.hpp>
#include <vector>

#include "display_reference.hpp"
#include "layouts.hpp"
#include "stability_table.hpp"

using triad::Edge;
using triad::Layout;
using triad::SolveOptions;
using triad::SolveResult;
namespace reference = triad::reference;

namespace {

// A picture as a function of place in pixels, one value per channel.
using Colour = std::array<double, 3>;
using Picture = std::function<Colour(double x, double y)>;

std::vector<float> cells_of(const Picture& picture, const Layout& layout, int width, int height) {
  std::vector<float> out;
  for (int y = 0; y < height * layout.cells_y; ++y)
    for (int x = 0; x < width * layout.cells_x; ++x)
      for (const double v : picture((x + .5) / layout.cells_x, (y + .5) / layout.cells_y))
        out.push_back(static_cast<float>(v));
  return out;
}

// Stems and bars of letters, 1.3 px thick, black on white.
Colour text(double x, double y) {
  const double u = std::fmod(x, 7.3), v = std::fmod(y, 12);
  const bool ink = v > 2 && v < 10 && (u < 1.3 || (std::abs(v - 6) < .65 && u < 5) || std::abs(u - 5 - v / 9) < .5);
  return ink ? Colour{0, 0, 0} : Colour{1, 1, 1};
}
// Thin strokes at many angles, white on black.
Colour strokes(double x, double y) {
  const double cx = std::floor(x / 12) * 12 + 6, cy = std::floor(y / 12) * 12 + 6;
  const double angle = 1.7 * std::floor(x / 12) + 2.3 * std::floor(y / 12);
  const double across = (x - cx) * std::sin(angle) - (y - cy) * std::cos(angle);
  return std::abs(across) < .6 ? Colour{1, 1, 1} : Colour{0, 0, 0};
}
// Saturated patches with slanted borders.
Colour colours(double x, double y) {
  const int k = static_cast<int>(std::floor((x + .3 * y) / 5.7)) + 3 * static_cast<int>(std::floor(y / 9.1));
  return {k % 2 ? 1. : .05, k / 2 % 2 ? .9 : 0, k / 4 % 2 ? 1. : .1};
}
// Smooth shading with a fine texture, as a photograph has.
Colour natural(double x, double y) {
  double v = .5 + .2 * std::sin(x / 37) * std::cos(y / 29);
  for (int octave = 1; octave < 6; ++octave)
    v += .18 / octave * std::sin(x * octave * .61 + 1.3 * octave) * std::sin(y * octave * .47 + .7 * octave);
  return {std::clamp(v, 0., 1.), std::clamp(.9 * v + .03 * std::sin(x), 0., 1.), std::clamp(.8 * v, 0., 1.)};
}

struct Named {
  const char* name;
  Picture picture;
};
const Named kPictures[] = {{"text", text}, {"strokes", strokes}, {"colours", colours}, {"natural", natural}};

struct Solved {
  SolveResult result;
  std::vector<float> drives;
};

template <class Real = float>
Solved solve(const Layout& layout, double ppd, int width, int height, const std::vector<float>& cells,
             const SolveOptions& options, Edge edge = Edge::kMirror) {
  Solved out;
  out.drives.resize(static_cast<size_t>(3 * width * height));
  const auto eye = reference::observer(ppd);
  if (layout.is_rows()) {
    const triad::RowSolver<Real> solver(layout, eye, width, 0, edge, options);
    typename triad::RowSolver<Real>::Workspace workspace(solver);
    for (int y = 0; y < height; ++y) {
      const auto row = solver.solve(cells.data() + static_cast<size_t>(3 * y * width * layout.cells_x),
                                    out.drives.data() + static_cast<size_t>(3 * y * width), workspace);
      if (y == 0) {
        out.result = row;
      } else {
        out.result.add(row);
      }
    }
  } else {
    const triad::PlaneSolver<Real> solver(layout, eye, width, height, 0, 0, edge, options);
    triad::AlignedBuffer<std::byte> workspace(solver.workspace_bytes());
    out.result =
        solver.solve(cells.data(), 3 * width * layout.cells_x, out.drives.data(), 3 * width, workspace.data());
  }
  return out;
}

bool displayable(const std::vector<float>& drives) {
  return std::all_of(drives.begin(), drives.end(), [](float v) { return v >= 0 && v <= 1; });
}

}  // namespace

TEST(ConstrainedStability, DefaultsReachTheirToleranceOnEveryPicture) {
  const int width = 72, height = 28;
  std::printf("part of the way from the displaced box to the optimum, and the gap and iterations by default\n");
  double least_way = 1, largest_gap = 0;
  for (const char* name : {"rgb", "qd-oled", "pentile-rgbg", "rgb-delta"})
    for (const Named& picture : kPictures)
      for (const double ppd : {20., 40., 67., 120.}) {
        const Layout layout = reference::layout(name);
        const auto cells = cells_of(picture.picture, layout, width, height);
        const SolveResult by_default = solve(layout, ppd, width, height, cells, {}).result;
        const SolveResult optimum = solve<double>(layout, ppd, width, height, cells, {{}, 500, 1e-5}).result;
        const int preview = ppd > 100 ? 25 : 15;
        const SolveResult early = solve(layout, ppd, width, height, cells, {{}, preview, 0}).result;
        const double way = (early.start - early.best) / (early.start - optimum.best);
        std::printf("  %-12s %-8s %3g ppd: %.3f in %d, gap %.4f in %d\n", name, picture.name, ppd, way, preview,
                    by_default.gap(), by_default.iterations);
        const std::string what = std::string(name) + " " + picture.name + " " + std::to_string(ppd);
        EXPECT_TRUE(by_default.converged) << what;
        EXPECT_LE(by_default.gap(), 1e-2) << what;
        EXPECT_LE(by_default.best - optimum.best, 1e-2 * by_default.start * (1 + 1e-4)) << what;
        EXPECT_GE(way, .9) << what;
        least_way = std::min(least_way, way);
        largest_gap = std::max(largest_gap, by_default.gap());
      }
  triad::stability::at_most("constrained solver", "certified gap by default, 4 layouts, 4 pictures, 20 ... 120 ppd",
                            largest_gap, 1e-2);
  triad::stability::at_most("constrained solver",
                            "left of the way to the optimum after 15 iterations (25 at 120 ppd)", 1 - least_way, .1);
}

TEST(ConstrainedStability, NeverWorseThanItsStartAtAnyCount) {
  const int width = 40, height = 12;
  uint64_t worse = 0, solved = 0;
  for (const Layout& layout : reference::all_layouts())
    for (const Named& picture : kPictures)
      for (const double ppd : {5., 40., 300.}) {
        const auto cells = cells_of(picture.picture, layout, width, height);
        for (const int iterations : {0, 1, 2, 3, 7, 11}) {
          const Solved got =
              solve(layout, ppd, width, height, cells, {{}, iterations, 0}, ppd > 100 ? Edge::kWrap : Edge::kMirror);
          EXPECT_LE(got.result.best, got.result.start) << layout.name << picture.name << ppd;
          worse += got.result.best > got.result.start ? 1 : 0;
          ++solved;
          EXPECT_LE(got.result.bound, got.result.best);
          EXPECT_GE(got.result.bound, 0);
          EXPECT_TRUE(displayable(got.drives)) << layout.name << picture.name << ppd << " " << iterations;
        }
      }
  triad::stability::never("constrained solver", "worse than its start, all layouts, 0 ... 11 iterations", worse,
                          solved);
}

TEST(ConstrainedStability, FloatIsDouble) {
  const int width = 64, height = 20;
  double worst_of_all = 0;
  for (const Layout& layout : reference::all_layouts()) {
    if (layout.derives_white) continue;  // which piece a pixel falls into may turn on the last bit
    for (const double ppd : {20., 40., 67.}) {
      const auto cells = cells_of(colours, layout, width, height);
      // The same iterations: 40 of them, from both.
      const Solved single = solve<float>(layout, ppd, width, height, cells, {{}, 40, 0});
      const Solved exact = solve<double>(layout, ppd, width, height, cells, {{}, 40, 0});
      double worst = 0;
      for (size_t i = 0; i < single.drives.size(); ++i)
        worst = std::max(worst, static_cast<double>(std::abs(single.drives[i] - exact.drives[i])));
      EXPECT_LT(worst, 1e-5) << layout.name << " at " << ppd;
      worst_of_all = std::max(worst_of_all, worst);
      EXPECT_NEAR(single.result.best, exact.result.best, 1e-5 * exact.result.start) << layout.name << " at " << ppd;
      EXPECT_NEAR(single.result.bound, exact.result.bound, 1e-4 * exact.result.start) << layout.name << " at " << ppd;
    }
  }
  triad::stability::at_most("constrained solver", "float against double, all linear layouts", worst_of_all, 1e-5);
}

TEST(ConstrainedStability, InputsThatNoPictureShouldBe) {
  const int width = 24, height = 10;
  uint64_t wrong = 0, solved = 0;
  for (const Layout& layout : reference::all_layouts()) {
    const int cells_x = width * layout.cells_x, cells = cells_x * height * layout.cells_y;
    const auto check = [&](const char* name, const std::function<double(int, int)>& value) {
      std::vector<float> in, clamped;
      for (int k = 0; k < cells; ++k)
        for (int d = 0; d < 3; ++d) {
          in.push_back(static_cast<float>(value(k, d)));
          clamped.push_back(std::clamp(in.back(), 0.f, 1.f));
        }
      for (const double ppd : {5., 40., 120.}) {
        if (layout.derives_white && ppd != 40) continue;  // time: three stages, each with searches per pixel
        const Solved got = solve(layout, ppd, width, height, in, {});
        const std::string what = layout.name + " " + name + " at " + std::to_string(ppd);
        EXPECT_TRUE(displayable(got.drives)) << what;
        EXPECT_TRUE(std::isfinite(got.result.best) && std::isfinite(got.result.bound)) << what;
        wrong += displayable(got.drives) && got.result.best <= got.result.start ? 0 : 1;
        ++solved;
        EXPECT_LE(got.result.best, got.result.start) << what;
        EXPECT_TRUE(!got.result.converged || got.result.gap() <= 1e-2 || got.result.start < 1e-11) << what;
        // What is outside is the peak or black, and nothing else.
        EXPECT_EQ(got.drives, solve(layout, ppd, width, height, clamped, {}).drives) << what;
      }
    };
    check("black", [](int, int) { return 0; });
    check("white", [](int, int) { return 1; });
    check("far outside", [](int k, int d) { return 1e30 * ((k * 7 + d) % 5 - 2); });
    check("checker", [&](int k, int) { return (k % cells_x / layout.cells_x + k / cells_x / layout.cells_y) % 2; });
    check("cell checker", [&](int k, int) { return (k % cells_x + k / cells_x) % 2; });
    check("one white cell", [&](int k, int) { return k == cells / 2; });
    check("one bright red cell", [&](int k, int d) { return k == cells / 2 && d == 0 ? 1e6 : .25; });
  }
  triad::stability::never("constrained solver",
                          "outside 0 ... 1 or worse: black, white, 1e30, checkers, single cells", wrong, solved);
}

TEST(ConstrainedStability, LongAndPrimeRows) {
  const Layout layout = reference::layout("rgb");
  double worst = 0;
  for (const int width : {1, 2, 3, 97, 100003})
    for (const Edge edge : {Edge::kMirror, Edge::kWrap}) {
      const auto cells = cells_of([](double x, double y) { return text(x, y + 4); }, layout, width, 1);
      const Solved single = solve<float>(layout, 40, width, 1, cells, {{}, 15, 0}, edge);
      const Solved exact = solve<double>(layout, 40, width, 1, cells, {{}, 15, 0}, edge);
      for (size_t i = 0; i < single.drives.size(); ++i) ASSERT_NEAR(single.drives[i], exact.drives[i], 1e-5) << width;
      for (size_t i = 0; i < single.drives.size(); ++i)
        worst = std::max(worst, static_cast<double>(std::abs(single.drives[i] - exact.drives[i])));
      EXPECT_LE(single.result.best, single.result.start);
    }
  triad::stability::at_most("constrained solver", "rows of 1, 2, 3, 97, 100003 px, float against double", worst,
                            1e-5);
}

TEST(ConstrainedStability, LambdaFromNothingToOne) {
  const int width = 48, height = 8;
  for (const char* name : {"rgb", "qd-oled"})
    for (const double lambda : {0., 1e-6, 1e-3, .1, 1.})
      for (const auto csf : {triad::Csf::kScielab, triad::Csf::kKolpatzikBouman}) {
        const Layout layout = reference::layout(name);
        const auto cells = cells_of(text, layout, width, height);
        auto eye = reference::observer(40, csf);
        std::vector<float> drives(static_cast<size_t>(3 * width * height));
        const triad::PlaneSolver<double> solver(layout, eye, width, height, 0, 0, Edge::kMirror,
                                                {{.lambda = lambda}, 200, 0});
        triad::AlignedBuffer<std::byte> workspace(solver.workspace_bytes());
        const auto result =
            solver.solve(cells.data(), 3 * width * layout.cells_x, drives.data(), 3 * width, workspace.data());
        EXPECT_TRUE(displayable(drives)) << name << lambda;
        EXPECT_LE(result.best, result.start) << name << lambda;
        EXPECT_LE(result.gap(), lambda > 0 ? .05 : 1) << name << lambda;
      }
}
