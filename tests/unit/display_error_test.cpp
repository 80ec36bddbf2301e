// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <triad/display/display_error.hpp>
#include <vector>

#include "display_reference.hpp"

using triad::DisplayError;
using triad::DisplayTotals;
using triad::Edge;
using triad::Range;
namespace reference = triad::reference;

namespace {

triad::Layout layout(bool bgr = false) {
  return triad::load_layout(std::string(TRIAD_SOURCE_DIR "/data/layouts/") + (bgr ? "bgr" : "rgb") + ".toml");
}

// Values from -.2 to 1.2.
std::vector<float> random_row(size_t samples, unsigned seed) {
  std::mt19937 bits(seed);
  std::vector<float> out(samples);
  for (float& value : out) value = static_cast<float>(static_cast<double>(bits()) / 4294967296.0 * 1.4 - .2);
  return out;
}

DisplayTotals score(const DisplayError& measure, const std::vector<float>& test, const std::vector<float>& target,
                    const float* mask = nullptr, int border_px = 0) {
  DisplayError::Workspace workspace(measure);
  std::vector<double> energy(test.size());
  DisplayTotals totals{};
  const auto clamped = measure.row(test.data(), target.data(), energy.data(), workspace);
  totals.add_pixels(energy.data(), mask, border_px, measure.width_px() - border_px);
  totals.clamped_test_pixels += clamped.test_pixels;
  totals.clamped_target_cells += clamped.target_cells;
  return totals;
}

}  // namespace

TEST(DisplayErrorTest, MatchesTheSumsOfItsDefinition) {
  for (const int width : {1, 2, 3, 7, 40})
    for (const Edge edge : {Edge::kMirror, Edge::kWrap})
      for (const bool clip : {false, true})
        for (const bool bgr : {false, true})
          for (const auto csf : {triad::Csf::kScielab, triad::Csf::kKolpatzikBouman}) {
            const auto eye = reference::observer(25, csf);
            const DisplayError measure(layout(bgr), eye, width, edge, clip ? Range::kClip : Range::kUnbounded);
            const auto test = random_row(3 * static_cast<size_t>(width), 1);
            const auto target = random_row(9 * static_cast<size_t>(width), 2);
            double parts[3];
            const double expected =
                reference::row_energy(eye, test.data(), target.data(), width, edge, clip, bgr, parts);
            const DisplayTotals totals = score(measure, test, target);
            EXPECT_NEAR(totals.rmse() * totals.rmse() / expected, 1, 1e-12) << width;
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(totals.share(c), parts[c] / expected, 1e-12);
          }
}

TEST(DisplayErrorTest, TheWholeRingIsTheSumOverFrequencies) {
  const int width = 17;
  const auto eye = reference::observer(15);
  const auto test = random_row(3 * width, 5), target = random_row(9 * width, 6);
  double parts[3], ring;
  reference::row_energy(eye, test.data(), target.data(), width, Edge::kWrap, false, false, parts, &ring);
  const DisplayError wrap(layout(), eye, width, Edge::kWrap, Range::kUnbounded);
  EXPECT_NEAR(std::pow(score(wrap, test, target).rmse(), 2) / ring, 1, 1e-12);
  // The ring of a mirrored picture is its own mirror image, but for the panel: the half that is cut off is the
  // first one of the reversed panel.
  reference::row_energy(eye, test.data(), target.data(), width, Edge::kMirror, false, false, parts, &ring);
  const DisplayError there(layout(), eye, width, Edge::kMirror, Range::kUnbounded);
  const DisplayError back(layout(true), eye, width, Edge::kMirror, Range::kUnbounded);
  const double halves =
      std::pow(score(there, test, target).rmse(), 2) + std::pow(score(back, test, target).rmse(), 2);
  EXPECT_NEAR(halves / 2 / ring, 1, 1e-12);
}

TEST(DisplayErrorTest, OneCellOfLightIsSeenAsItsBlurredPoint) {
  // A single green subpixel on black: energy over all cells is sum over n of W_c |C_c,g 3|^2 / N^2, by Parseval.
  const int width = 30;
  const auto eye = reference::observer(40);
  const auto C = triad::opponent_matrix(eye);
  const int N = 3 * width;
  double expected = 0;
  for (int c = 0; c < 3; ++c)
    for (int n = 0; n < N; ++n)
      expected +=
          std::pow(triad::mtf(eye, c, static_cast<double>(std::min(n, N - n)) / N * 120) * 3 * C[3 * c + 1], 2) / N /
          N;
  std::vector<float> test(3 * width), target(9 * width);
  test[3 * 11 + 1] = 1;
  const DisplayError measure(layout(), eye, width, Edge::kWrap, Range::kClip);
  EXPECT_NEAR(std::pow(score(measure, test, target).rmse(), 2) / expected, 1, 1e-12);
}

TEST(DisplayErrorTest, BlackScoresZeroAndWhiteWhatIsSeenOfTheStripes) {
  const int width = 50;
  for (const double ppd : {10., 20., 40., 120.})
    for (const Edge edge : {Edge::kMirror, Edge::kWrap}) {
      const auto eye = reference::observer(ppd);
      const DisplayError measure(layout(), eye, width, edge, Range::kClip);
      EXPECT_EQ(score(measure, std::vector<float>(3 * width), std::vector<float>(9 * width)).rmse(), 0);
      const double white = score(measure, std::vector<float>(3 * width, 1), std::vector<float>(9 * width, 1)).rmse();
      if (ppd >= 40) {
        EXPECT_LT(white, ppd >= 120 ? 1e-15 : 3e-6);
      }
      // The only frequency is the stripes': n = N/3 and its mirror image, |E| = N |C_r + C_g w + C_b w^2|.
      const auto C = triad::opponent_matrix(eye);
      double energy = 0;
      for (int c = 0; c < 3; ++c) {
        std::complex<double> carrier = 0;
        for (int d = 0; d < 3; ++d) carrier += C[3 * c + d] * std::polar(1., -2 * std::numbers::pi * d / 3);
        energy += 2 * std::pow(triad::mtf(eye, c, ppd), 2) * std::norm(carrier);
      }
      EXPECT_NEAR(white, std::sqrt(energy), 1e-12 + 1e-10 * white) << ppd;
    }
}

TEST(DisplayErrorTest, TheOptimalFilterScoresBest) {
  const int width = 64;
  const auto eye = reference::observer(40);
  const auto cells = reference::random_cells(3 * width, 21);
  const triad::FilterDesign design(layout(), eye, width, {.lambda = 0, .exact_flat_fields = false});
  const triad::RowFilter<double> filter(design, width, Edge::kWrap);
  triad::RowFilter<double>::Workspace workspace(filter);
  std::vector<double> drives(3 * width);
  filter.apply(cells.data(), drives.data(), workspace);
  const auto box = reference::box_drives(cells, false);
  const std::vector<float> target(cells.begin(), cells.end()), best(drives.begin(), drives.end()),
      conventional(box.begin(), box.end());
  const DisplayError unbounded(layout(), eye, width, Edge::kWrap, Range::kUnbounded);
  const DisplayError clipped(layout(), eye, width, Edge::kWrap, Range::kClip);
  const double floor = score(unbounded, best, target).rmse(),
               box_score = score(unbounded, conventional, target).rmse();
  EXPECT_LT(floor, .1 * box_score);
  // On a display it is another story: the drives leave [0, 1].
  EXPECT_GT(score(clipped, best, target).rmse(), box_score);
  EXPECT_GT(score(clipped, best, target).clamped_test_pixels, width / 2);
}

TEST(DisplayErrorTest, MasksAndBordersSelectPixels) {
  const int width = 23;
  const auto eye = reference::observer(20);
  const DisplayError measure(layout(), eye, width, Edge::kMirror, Range::kUnbounded);
  const auto test = random_row(3 * width, 3), target = random_row(9 * width, 4);
  DisplayError::Workspace workspace(measure);
  std::vector<double> energy(3 * width);
  measure.row(test.data(), target.data(), energy.data(), workspace);
  double sum = 0;
  for (int i = 3 * 4; i < 3 * (width - 4); ++i) {
    EXPECT_GE(energy[i], 0);
    sum += energy[i];
  }
  EXPECT_NEAR(score(measure, test, target, nullptr, 4).rmse(), std::sqrt(sum / (width - 8)), 1e-14);
  std::vector<float> mask(width);
  for (int x = 4; x < width - 4; ++x) mask[x] = .5f;
  EXPECT_NEAR(score(measure, test, target, mask.data()).rmse(), std::sqrt(sum / (width - 8)), 1e-14);
  EXPECT_TRUE(std::isnan(score(measure, test, target, std::vector<float>(width).data()).rmse()));
  EXPECT_EQ(triad::automatic_border_px(40, 400), 8);
  EXPECT_EQ(triad::automatic_border_px(41, 400), 9);
  EXPECT_EQ(triad::automatic_border_px(40, 10), 4);
  EXPECT_EQ(triad::automatic_border_px(40, 1), 0);
}

TEST(DisplayErrorTest, CountsWhatItClamps) {
  const int width = 4;
  const DisplayError clip(layout(), reference::observer(40), width, Edge::kWrap, Range::kClip);
  const DisplayError free(layout(), reference::observer(40), width, Edge::kWrap, Range::kUnbounded);
  std::vector<float> test(12, .5f), target(36, .5f);
  test[0] = test[1] = 2;
  test[9] = -1e-6f;
  target[5] = 1000;
  const auto totals = score(clip, test, target);
  EXPECT_EQ(totals.clamped_test_pixels, 2);
  EXPECT_EQ(totals.clamped_target_cells, 1);
  EXPECT_EQ(score(free, test, target).clamped_target_cells, 0);
  test[0] = test[1] = 1;
  test[9] = 0;
  target[5] = 1;
  EXPECT_EQ(score(clip, test, target).rmse(), totals.rmse());
}

TEST(DisplayErrorTest, PartsMergeToTheWhole) {
  const int width = 12;
  const DisplayError measure(layout(), reference::observer(40), width, Edge::kMirror, Range::kClip);
  DisplayTotals parts{};
  double energy[3] = {}, clamped = 0;
  for (unsigned row = 0; row < 9; ++row) {
    const DisplayTotals one = score(measure, random_row(3 * width, row), random_row(9 * width, 50 + row));
    for (int c = 0; c < 3; ++c) energy[c] += one.energy[c].value();
    clamped += static_cast<double>(one.clamped_target_cells);
    parts.merge(one);
  }
  EXPECT_NEAR(parts.rmse(), std::sqrt((energy[0] + energy[1] + energy[2]) / (9 * width)), 1e-14);
  EXPECT_EQ(static_cast<double>(parts.clamped_target_cells), clamped);
}
