// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <string>
#include <triad/base/error.hpp>
#include <triad/display/emission.hpp>
#include <vector>

#include "layouts.hpp"

using triad::Beyond;
using triad::CellRect;
using triad::DriveRows;
using triad::Emission;
using triad::Layout;

namespace {

std::vector<double> noise(int count, unsigned seed) {
  std::mt19937 bits(seed);
  std::vector<double> out(static_cast<size_t>(count));
  for (double& v : out) v = static_cast<double>(bits()) / 4294967296.0;
  return out;
}

int mod(int a, int n) { return ((a % n) + n) % n; }

// Each emitter of each tile throws its light on the cells, far enough around the picture.
std::vector<double> scattered(const Layout& layout, const std::vector<double>& pixels, int width, int height,
                              int origin_x, int origin_y, Beyond beyond, const CellRect& r) {
  std::vector<double> out(static_cast<size_t>(3 * (r.x1 - r.x0) * (r.y1 - r.y0)));
  const int margin = 64;
  for (int y = -margin; y < height + margin; ++y)
    for (int x = -margin; x < width + margin; ++x) {
      int sx = x, sy = y;
      if (beyond == Beyond::kMirror) {
        sx = mod(x, 2 * width), sy = mod(y, 2 * height);
        sx = sx < width ? sx : 2 * width - 1 - sx;
        sy = sy < height ? sy : 2 * height - 1 - sy;
      } else if (beyond == Beyond::kWrap) {
        sx = mod(x, width), sy = mod(y, height);
      } else if (x < 0 || y < 0 || x >= width || y >= height) {
        continue;
      }
      const double* rgb = &pixels[static_cast<size_t>(3 * (sy * width + sx))];
      const double white = layout.derives_white ? std::min({rgb[0], rgb[1], rgb[2]}) : 0;
      for (const triad::Emitter& e : layout.emitters) {
        if (mod(x + origin_x, layout.tile_x) != e.pixel_x || mod(y + origin_y, layout.tile_y) != e.pixel_y) continue;
        const double drive = e.channel == triad::kWhiteChannel ? white : rgb[e.channel] - white;
        for (const triad::EmitterCell& cell : e.cells) {
          const int cx = (x - e.pixel_x) * layout.cells_x + cell.x, cy = (y - e.pixel_y) * layout.cells_y + cell.y;
          if (cx < r.x0 || cx >= r.x1 || cy < r.y0 || cy >= r.y1) continue;
          for (int i = 0; i < 3; ++i)
            out[static_cast<size_t>(3 * ((cy - r.y0) * (r.x1 - r.x0) + cx - r.x0) + i)] +=
                drive * e.primary[i] * cell.share * layout.pixel_cells();
        }
      }
    }
  return out;
}

}  // namespace

TEST(Emission, IsWhatTheEmittersThrow) {
  const int width = 5, height = 3;
  const auto pixels = noise(3 * width * height, 1);
  const DriveRows<double> rows{pixels.data(), 3 * width, width, height, 0, height};
  for (const Layout& layout : triad::reference::all_layouts())
    for (const Beyond beyond : {Beyond::kDark, Beyond::kMirror, Beyond::kWrap})
      for (const auto& [ox, oy] : {std::pair{0, 0}, {1, 0}, {0, 1}, {-3, 7}}) {
        const CellRect rect{-13, -9, width * layout.cells_x + 8, height * layout.cells_y + 11};
        const auto expected = scattered(layout, pixels, width, height, ox, oy, beyond, rect);
        std::vector<double> got(expected.size(), 99);
        Emission(layout, ox, oy).light(rows, beyond, rect, got.data());
        for (size_t i = 0; i < got.size(); ++i)
          ASSERT_NEAR(got[i], expected[i], 1e-14) << layout.name << " origin " << ox << "," << oy << " value " << i;
      }
}

TEST(Emission, WhiteIsWhiteAndColoursKeepTheirColourOnEveryLayout) {
  for (const Layout& layout : triad::reference::all_layouts()) {
    const int width = 2 * layout.tile_x, height = 2 * layout.tile_y;
    for (const std::array<double, 3>& colour : {std::array<double, 3>{1, 1, 1}, {.5, .25, .75}}) {
      std::vector<double> pixels, light(static_cast<size_t>(12 * layout.tile_cells()));
      for (int i = 0; i < width * height; ++i) pixels.insert(pixels.end(), colour.begin(), colour.end());
      const DriveRows<double> rows{pixels.data(), 3 * width, width, height, 0, height};
      Emission(layout).light(rows, Beyond::kWrap, {0, 0, width * layout.cells_x, height * layout.cells_y},
                             light.data());
      for (size_t d = 0; d < 3; ++d) {
        double sum = 0;
        for (size_t i = d; i < light.size(); i += 3) sum += light[i];
        EXPECT_NEAR(sum / (4 * layout.tile_cells()), colour[d], 1e-12) << layout.name;
      }
    }
  }
}

TEST(Emission, RowsOneByOneAreTheSameBitsAndMissingRowsAnError) {
  const Layout layout = triad::reference::layout("rgb-delta");
  const int width = 7, height = 6;
  const auto exact = noise(3 * width * height, 2);
  const std::vector<float> pixels(exact.begin(), exact.end());
  const Emission emission(layout, 0, 1);
  EXPECT_EQ(emission.reach_left_px(), 1);
  EXPECT_EQ(emission.reach_right_px() + emission.reach_up_px() + emission.reach_down_px(), 0);
  const int cells = width * layout.cells_x;
  std::vector<float> whole(static_cast<size_t>(3 * cells * height)), row(static_cast<size_t>(3 * cells));
  emission.light(DriveRows<float>{pixels.data(), 3 * width, width, height, 0, height}, Beyond::kMirror,
                 {0, 0, cells, height}, whole.data());
  for (int y = 0; y < height; ++y) {
    const DriveRows<float> one{pixels.data() + 3 * width * y, 3 * width, width, height, y, y + 1};
    emission.light(one, Beyond::kMirror, {0, y, cells, y + 1}, row.data());
    EXPECT_TRUE(std::equal(row.begin(), row.end(), whole.begin() + 3 * cells * y));
  }
  const DriveRows<float> one{pixels.data(), 3 * width, width, height, 0, 1};
  EXPECT_THROW(emission.light(one, Beyond::kMirror, {0, 1, cells, 2}, row.data()), triad::Error);
}
