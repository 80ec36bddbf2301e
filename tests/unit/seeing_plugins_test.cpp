// SPDX-License-Identifier: Apache-2.0
// The plugins that show what a panel shows: panel, eye, and display in the plane; judged by closed forms and by
// panel_reference.hpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "layouts.hpp"
#include "panel_reference.hpp"
#include "stage_runner.hpp"

using stage_runner::header;
using stage_runner::message_of;
using stage_runner::noise;
using stage_runner::Picture;
using stage_runner::run;
using testing::HasSubstr;
using triad::ParamTexts;
namespace reference = triad::reference;

namespace {

Picture uniform(int width, int height, std::array<float, 3> rgb) {
  Picture out{header(width, height, 1), {}};
  for (int i = 0; i < width * height; ++i) out.pixels.insert(out.pixels.end(), rgb.begin(), rgb.end());
  return out;
}

Picture wide_noise(int width, int height, const triad::Layout& panel, unsigned seed) {
  return noise(width * panel.cells_x, height * panel.cells_y, panel.cells_x, seed, -.2f, 1.2f, panel.cells_y);
}

const float* at(const Picture& p, int x, int y) {
  return &p.pixels[3 * (static_cast<size_t>(y) * static_cast<size_t>(p.image.width) + static_cast<size_t>(x))];
}

}  // namespace

TEST(PanelPlugin, DrawsALitPixelsEmittersWhereTheLayoutHasThem) {
  const int scale = 12, size = 5;  // a multiple of all bundled layouts' cells
  for (const std::string& name : reference::kLayoutNames) {
    const triad::Layout panel = reference::layout(name);
    for (int phase = 0; phase < panel.tile_x * panel.tile_y; ++phase) {
      const int px = 1 + phase % panel.tile_x, py = 1 + phase / panel.tile_x;
      Picture picture = uniform(size, size, {0, 0, 0});
      const float drive[4] = {.5f, 1, .25f, .25f};
      std::copy_n(drive, 3, &picture.pixels[3 * static_cast<size_t>(py * size + px)]);
      const auto got = run("panel", {{"layout", name}, {"gain", "1"}, {"scale", "12"}}, {&picture}, 7).out;
      ASSERT_EQ(got.image.width, size * scale);
      std::vector<double> expected(got.pixels.size());
      for (const triad::Emitter& e : panel.emitters) {
        if (e.pixel_x != px % panel.tile_x || e.pixel_y != py % panel.tile_y) continue;
        double on = static_cast<double>(drive[e.channel]);
        if (panel.derives_white && e.channel < 3) on -= .25;
        for (const triad::EmitterCell& cell : e.cells) {
          const int w = scale / panel.cells_x, h = scale / panel.cells_y;
          const int x0 = (px - e.pixel_x) * scale + cell.x * w, y0 = (py - e.pixel_y) * scale + cell.y * h;
          for (int y = y0; y < y0 + h; ++y)
            for (int x = x0; x < x0 + w; ++x)
              for (size_t d = 0; d < 3; ++d)
                expected[3 * static_cast<size_t>(y * size * scale + x) + d] +=
                    on * e.primary[d] * cell.share * panel.pixel_cells();
        }
      }
      for (size_t i = 0; i < expected.size(); ++i) ASSERT_NEAR(got.pixels[i], expected[i], 1e-6) << name << i;
    }
  }
}

TEST(PanelPlugin, StripesAtThreeAreThePixelsChannels) {
  Picture picture = uniform(2, 1, {.25f, .5f, .75f});
  picture.pixels[3] = 2;  // clamped
  const auto outcome = run("panel", {{"layout", "rgb"}, {"scale", "3"}}, {&picture});
  EXPECT_NEAR(outcome.reports.at("gain"), 1. / 3, 1e-15);
  const float row[] = {.25f, 0, 0, 0, .5f, 0, 0, 0, .75f, 1, 0, 0, 0, .5f, 0, 0, 0, .75f};
  for (int y = 0; y < 3; ++y)
    for (int i = 0; i < 18; ++i) EXPECT_NEAR(at(outcome.out, 0, y)[i], row[i], 1e-7);
}

TEST(PanelPlugin, KeepsTheLightOfAPixelAtAnyScale) {
  const std::array<float, 3> colour{.3f, .6f, .2f};
  for (const std::string& name : reference::kLayoutNames)
    for (const int scale : {1, 5, 7, 12}) {
      const triad::Layout panel = reference::layout(name);
      const Picture picture = uniform(8, 8, colour);
      const auto got =
          run("panel", {{"layout", name}, {"gain", "1"}, {"scale", std::to_string(scale)}}, {&picture}, 3).out;
      // A tile inside, which neighbours reach from both sides.
      for (int d = 0; d < 3; ++d) {
        double sum = 0;
        for (int y = 2 * scale; y < (2 + panel.tile_y) * scale; ++y)
          for (int x = 2 * scale; x < (2 + panel.tile_x) * scale; ++x) sum += static_cast<double>(at(got, x, y)[d]);
        EXPECT_NEAR(sum / (scale * scale * panel.tile_x * panel.tile_y),
                    static_cast<double>(colour[static_cast<size_t>(d)]), 1e-6)
            << name << scale;
      }
    }
}

TEST(PanelPlugin, LinesSeparateEmitters) {
  const Picture picture = uniform(3, 2, {1, 1, 1});
  const auto stripes = run("panel", {{"layout", "rgb"}, {"scale", "6"}, {"lines", "1"}}, {&picture}, 5).out;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 18; ++x) {
      const float* rgb = at(stripes, x, y);
      const bool dark = x % 2 == 1 || y % 6 == 5;
      EXPECT_EQ(rgb[0] + rgb[1] + rgb[2], dark ? 0.f : 1.f) << x << " " << y;
    }
  // Green lies over both lower emitters, without a line through it.
  const auto oled = run("panel", {{"layout", "qd-oled"}, {"scale", "8"}, {"lines", "2"}}, {&picture}).out;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 24; ++x) {
      const bool upper = y % 8 < 4;
      const bool dark = y % 4 >= 2 || (upper ? x % 8 >= 6 : x % 4 >= 2);
      EXPECT_EQ(at(oled, x, y)[0] + at(oled, x, y)[1] + at(oled, x, y)[2] == 0, dark) << x << " " << y;
    }
  // An emitter that reaches into the next tile is one.
  const auto delta = run("panel", {{"layout", "rgb-delta"}, {"scale", "12"}, {"lines", "1"}}, {&picture}).out;
  for (int x = 0; x < 36; ++x)
    EXPECT_EQ(at(delta, x, 14)[0] + at(delta, x, 14)[1] + at(delta, x, 14)[2] == 0, x < 6 || (x - 6) % 4 == 3) << x;
}

TEST(PanelPlugin, StripsAndOriginsAreAlike) {
  const Picture picture = noise(6, 6, 1, 3);
  for (const std::string& name : reference::kLayoutNames) {
    const ParamTexts whole{{"layout", name}, {"scale", "5"}};
    EXPECT_EQ(run("panel", whole, {&picture}, 1).out.pixels, run("panel", whole, {&picture}, 30).out.pixels) << name;
  }
  // The panel's phase moves with the origin: the same part of a larger picture.
  const Picture large = noise(8, 8, 1, 4);
  Picture part{header(5, 5, 1), {}};
  for (int y = 1; y < 6; ++y) part.pixels.insert(part.pixels.end(), at(large, 1, y), at(large, 6, y));
  const auto all = run("panel", {{"layout", "pentile-rgbg"}, {"scale", "2"}}, {&large}).out;
  const auto cut = run("panel", {{"layout", "pentile-rgbg"}, {"scale", "2"}, {"origin", "1,-1"}}, {&part}).out;
  for (int y = 0; y < 10; ++y)
    for (int i = 0; i < 30; ++i) EXPECT_EQ(at(cut, 0, y)[i], at(all, 2, y + 2)[i]);
}

TEST(PanelPlugin, RefusesWithAClearLine) {
  const Picture wide = noise(9, 1, 3, 1), picture = noise(9, 1, 1, 1);
  EXPECT_THAT(message_of([&] { run("panel", {}, {&wide}); }), HasSubstr("has 3x1 cells a pixel"));
  EXPECT_THAT(message_of([&] {
                run("panel", {{"scale", "4"}, {"lines", "4"}}, {&picture});
              }),
              HasSubstr("lines=4 leaves nothing of pixels drawn at scale=4; at most 3"));
  EXPECT_THAT(message_of([&] { run("panel", {{"layout", "qd-oledd"}}, {&picture}); }), HasSubstr("did you mean"));
}

TEST(EyePlugin, FlatFieldsKeepTheirColour) {
  const std::array<float, 3> colour{.3f, .6f, .2f};
  for (const std::string& name : reference::kLayoutNames)
    for (const char* ppd : {"20", "40", "400"}) {
      const Picture picture = uniform(12, 8, colour);
      const auto got = run("eye", {{"layout", name}, {"ppd", ppd}, {"edge", "wrap"}}, {&picture}).out;
      ASSERT_EQ(got.image.width, 12);
      double sum[3] = {};
      for (int i = 0; i < 12 * 8; ++i)
        for (int d = 0; d < 3; ++d) {
          const auto v = static_cast<double>(got.pixels[static_cast<size_t>(3 * i + d)]);
          sum[d] += v / (12 * 8);
          if (std::string(ppd) == "400") {  // all structure is finer than what is seen there
            EXPECT_NEAR(v, static_cast<double>(colour[static_cast<size_t>(d)]), 1e-6) << name;
          }
        }
      for (int d = 0; d < 3; ++d)
        EXPECT_NEAR(sum[d], static_cast<double>(colour[static_cast<size_t>(d)]), 1e-6) << name;
    }
}

TEST(EyePlugin, AGreyWedgeHasNoColourCast) {
  // Sixteen steps from black to white at 67 ppd, half a degree each.
  const int step = 34, width = 16 * step;
  Picture wedge{header(width, 4, 1), {}};
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < width; ++x) wedge.pixels.insert(wedge.pixels.end(), 3, static_cast<float>(x / step) / 15.f);
  for (const std::string& name : reference::kLayoutNames) {
    const auto got = run("eye", {{"layout", name}, {"ppd", "67"}}, {&wedge}).out;
    for (int i = 0; i < 16; ++i) {
      const int x = i * step + step / 2;
      // Over a tile, for panels whose pixels differ.
      double rgb[3] = {};
      for (int y = 0; y < 2; ++y)
        for (int k = 0; k < 2; ++k)
          for (int d = 0; d < 3; ++d) rgb[d] += static_cast<double>(at(got, x + k, y)[d]) / 4;
      // Emitters lie up to half a pixel off their pixel's middle, on a picture that rises by this much a pixel.
      const double rise = 1. / (15 * step);
      EXPECT_NEAR(rgb[0], rgb[1], .5 * rise) << name << i;
      EXPECT_NEAR(rgb[2], rgb[1], .5 * rise) << name << i;
      EXPECT_NEAR(rgb[1], i / 15., .5 / 255) << name << i;
    }
  }
}

TEST(EyePlugin, GreyLightStaysGreyEvenAtEdges) {
  Picture wide = noise(40, 20, 2, 9, 0, 1, 2);
  for (size_t i = 0; i < wide.pixels.size(); i += 3)
    std::fill_n(&wide.pixels[i], 3, wide.pixels[i] > .5f ? 1.f : 0.f);
  const auto got = run("eye", {{"layout", "qd-oled"}, {"grid", "cells"}}, {&wide}).out;
  const auto tinted = run("eye", {{"layout", "qd-oled"}, {"grid", "cells"}, {"space", "opponent"}}, {&wide}).out;
  double worst = 0;
  for (size_t i = 0; i < wide.pixels.size(); i += 3) {
    EXPECT_NEAR(got.pixels[i], got.pixels[i + 1], 1e-6);
    EXPECT_NEAR(got.pixels[i + 2], got.pixels[i + 1], 1e-6);
    worst = std::max(worst, std::abs(static_cast<double>(tinted.pixels[i] - tinted.pixels[i + 1])));
  }
  EXPECT_GT(worst, .01);  // which is why neutral is the default
}

TEST(EyePlugin, ASinusoidIsAttenuatedByTheTransfer) {
  const int width = 12, height = 8, cycles_x = 3, cycles_y = 2;
  const triad::Layout panel = reference::layout("qd-oled");
  const int nx = width * panel.cells_x, ny = height * panel.cells_y;
  Picture wide{header(nx, ny, panel.cells_x, panel.cells_y), {}};
  const double swing[3] = {.3, .1, .2};
  const auto phase = [&](int x, int y) {
    return std::cos(2 * std::numbers::pi *
                    (static_cast<double>(cycles_x * x) / nx + static_cast<double>(cycles_y * y) / ny));
  };
  for (int y = 0; y < ny; ++y)
    for (int x = 0; x < nx; ++x)
      for (const double s : swing) wide.pixels.push_back(static_cast<float>(.5 + s * phase(x, y)));
  for (const bool neutral : {false, true}) {
    const auto csf = neutral ? triad::Csf::kScielab : triad::Csf::kKolpatzikBouman;
    const auto eye = reference::observer(30, csf);
    const auto got = run("eye",
                         {{"layout", "qd-oled"},
                          {"ppd", "30"},
                          {"edge", "wrap"},
                          {"grid", "cells"},
                          {"space", neutral ? "neutral" : "opponent"},
                          {"csf", csf == triad::Csf::kScielab ? "scielab" : "kolpatzik-bouman"}},
                         {&wide})
                         .out;
    ASSERT_EQ(got.image.cells_x, 2);
    ASSERT_EQ(got.image.width, nx);
    Eigen::Matrix3d C;
    for (int i = 0; i < 9; ++i) C(i / 3, i % 3) = triad::opponent_matrix(eye)[static_cast<size_t>(i)];
    // Colour is then what is left beside the grey of the same luminance.
    const Eigen::Vector3d white = C * Eigen::Vector3d::Ones(), luminance = C.row(0);
    if (neutral)
      for (int c = 1; c < 3; ++c) C.row(c) -= white[c] / white[0] * luminance.transpose();
    Eigen::Vector3d opponent = C * Eigen::Vector3d(swing[0], swing[1], swing[2]);
    const double f = std::hypot(cycles_x * 30. / width, cycles_y * 30. / height);
    for (int c = 0; c < 3; ++c) opponent[c] *= triad::mtf(eye, c, f) / triad::mtf(eye, c, 0);
    const Eigen::Vector3d left = C.inverse() * opponent;
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        for (int d = 0; d < 3; ++d) EXPECT_NEAR(at(got, x, y)[d], .5 + left[d] * phase(x, y), 2e-7);
  }
}

TEST(EyePlugin, TwoViewsDifferByWhatTheMetricMeasures) {
  const int width = 7, height = 6;
  for (const std::string name : {"rgb", "qd-oled", "rwbg", "rgb-delta"}) {
    const triad::Layout panel = reference::layout(name);
    const Picture test = noise(width, height, 1, 1, -.2f, 1.2f), wide = wide_noise(width, height, panel, 2);
    const ParamTexts seen{{"layout", name}, {"ppd", "25"}, {"grid", "cells"}, {"space", "opponent"}};
    const auto shown = run("eye", seen, {&test}).out, meant = run("eye", seen, {&wide}).out;
    const auto map =
        run("display", {{"layout", name}, {"ppd", "25"}, {"mode", "plane"}}, {&test, &wide, nullptr}).out;
    const auto eye = reference::observer(25);
    const auto C = triad::opponent_matrix(eye);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        double energy = 0;
        for (int v = y * panel.cells_y; v < (y + 1) * panel.cells_y; ++v)
          for (int u = x * panel.cells_x; u < (x + 1) * panel.cells_x; ++u)
            for (size_t c = 0; c < 3; ++c) {
              double e = 0;
              for (size_t d = 0; d < 3; ++d)
                e += C[3 * c + d] * static_cast<double>(at(shown, u, v)[d] - at(meant, u, v)[d]);
              energy += std::pow(e * triad::mtf(eye, static_cast<int>(c), 0), 2) / panel.pixel_cells();
            }
        EXPECT_NEAR(map.pixels[static_cast<size_t>(y * width + x)] / std::sqrt(energy), 1, 1e-4) << name;
      }
  }
}

TEST(EyePlugin, ThePixelGridIsTheMeanOfTheCells) {
  const triad::Layout panel = reference::layout("qd-oled");
  const Picture wide = wide_noise(5, 4, panel, 3);
  const auto cells = run("eye", {{"layout", "qd-oled"}, {"grid", "cells"}}, {&wide}).out;
  const auto pixels = run("eye", {{"layout", "qd-oled"}}, {&wide}).out;
  ASSERT_EQ(pixels.image.width, 5);
  EXPECT_EQ(pixels.image.cells_x, 1);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 5; ++x)
      for (int d = 0; d < 3; ++d)
        EXPECT_NEAR(at(pixels, x, y)[d],
                    (at(cells, 2 * x, 2 * y)[d] + at(cells, 2 * x + 1, 2 * y)[d] + at(cells, 2 * x, 2 * y + 1)[d] +
                     at(cells, 2 * x + 1, 2 * y + 1)[d]) /
                        4,
                    2e-7);
}

TEST(EyePlugin, RefusesWithAClearLine) {
  Picture odd{header(9, 3, 2, 2), std::vector<float>(81)}, wide = noise(9, 1, 3, 1);
  EXPECT_THAT(message_of([&] {
                run("eye", {{"layout", "qd-oled"}}, {&odd});
              }),
              HasSubstr("9x3 is no whole number of pixels of 2x2 cells"));
  EXPECT_THAT(message_of([&] {
                run("eye", {{"layout", "qd-oled"}}, {&wide});
              }),
              HasSubstr("has 3x1 cells a pixel; for layout qd-oled it must have one, or 2x2"));
  wide.metadata.set("triad:layout", "../../etc/passwd");
  EXPECT_THAT(message_of([&] { run("eye", {}, {&wide}); }), HasSubstr("which is not known here"));
}

TEST(DisplayPlugin, MatchesTheSumsOfItsDefinitionInThePlane) {
  const int width = 4, height = 4;
  for (const std::string& name : reference::kLayoutNames) {
    const triad::Layout panel = reference::layout(name);
    const Picture test = noise(width, height, 1, 1, -.2f, 1.2f), wide = wide_noise(width, height, panel, 2);
    const auto eye = reference::observer(15);
    const reference::Torus torus{&panel, width, height, true, 1, 0};
    // The pixel average as an integer-free mean of clamped cells.
    std::vector<float> average;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int d = 0; d < 3; ++d) {
          double sum = 0;
          for (int v = 0; v < panel.cells_y; ++v)
            for (int u = 0; u < panel.cells_x; ++u)
              sum += reference::clipped(at(wide, x * panel.cells_x + u, y * panel.cells_y + v)[d], true);
          average.push_back(static_cast<float>(sum / panel.pixel_cells()));
        }
    const auto energies = reference::plane_energy(torus, eye, test.pixels, wide.pixels, true);
    const auto of_average = reference::plane_energy(torus, eye, average, wide.pixels, true);
    double all = 0, colour = 0, conventional = 0;
    // One pixel of border all round.
    for (int y = 1; y < height - 1; ++y)
      for (int x = 1; x < width - 1; ++x)
        for (int c = 0; c < 3; ++c) {
          const auto i = static_cast<size_t>((y * width + x) * 3 + c);
          all += energies[i];
          colour += c > 0 ? energies[i] : 0;
          conventional += of_average[i];
        }
    const auto got =
        run("display", {{"layout", name}, {"ppd", "15"}, {"border", "1"}, {"mode", "plane"}, {"origin", "1,0"}},
            {&test, &wide, nullptr});
    EXPECT_NEAR(got.scores[0] / std::sqrt(all / 4), 1, 1e-12) << name;
    EXPECT_NEAR(got.scores[1] / std::sqrt(all / conventional), 1, 1e-12) << name;
    EXPECT_NEAR(got.scores[2], colour / all, 1e-12) << name;
    EXPECT_GT(got.scores[3], 0);
    EXPECT_GE(got.scores[4], .9 * got.scores[3]);
    double sum = 0;
    for (int y = 1; y < height - 1; ++y)
      for (int x = 1; x < width - 1; ++x)
        sum += std::pow(static_cast<double>(got.out.pixels[static_cast<size_t>(y * width + x)]), 2);
    EXPECT_NEAR(std::sqrt(sum / 4) / got.scores[0], 1, 1e-6);
  }
}

TEST(DisplayPlugin, RowsAndPlaneAgreeOnWhatIsConstantInY) {
  Picture test = noise(30, 1, 1, 1), wide = noise(90, 1, 3, 2);
  for (Picture* p : {&test, &wide}) {
    const std::vector<float> row = p->pixels;
    p->image.height = 12;
    for (int y = 1; y < 12; ++y) p->pixels.insert(p->pixels.end(), row.begin(), row.end());
  }
  const auto rows = run("display", {{"border", "3"}}, {&test, &wide, nullptr}, 5);
  const auto plane = run("display", {{"border", "3"}, {"mode", "plane"}}, {&test, &wide, nullptr});
  for (const size_t s : {0u, 1u, 2u}) EXPECT_NEAR(plane.scores[s] / rows.scores[s], 1, 1e-12);
  for (const size_t s : {3u, 4u}) EXPECT_NEAR(plane.scores[s] / rows.scores[s], 1, 1e-6);
}

TEST(DisplayPlugin, APerfectPictureAndThePixelAverage) {
  // Grey shows as grey at a distance from which no emitter can be told.
  const Picture grey = uniform(12, 12, {.5f, .5f, .5f});
  Picture wide{header(24, 24, 2, 2), std::vector<float>(3 * 24 * 24, .5f)};
  const auto perfect =
      run("display", {{"layout", "qd-oled"}, {"ppd", "400"}, {"border", "2"}}, {&grey, &wide, nullptr});
  EXPECT_NEAR(perfect.scores[0], 0, 1e-9);
  EXPECT_EQ(perfect.scores[1], 1);  // it is the pixel average
  EXPECT_NEAR(perfect.scores[3], 0, 1e-3);
  // A grey that is off by a known amount, everywhere: Delta E of the two greys.
  const Picture lighter = uniform(12, 12, {.6f, .6f, .6f});
  const auto off =
      run("display", {{"layout", "qd-oled"}, {"ppd", "400"}, {"border", "2"}}, {&lighter, &wide, nullptr});
  const double expected = 116 * (std::cbrt(.6) - std::cbrt(.5));
  EXPECT_NEAR(off.scores[3], expected, 1e-3);
  EXPECT_NEAR(off.scores[4], expected, .01 * expected);
  EXPECT_NEAR(off.reports.at("rmse-as-delta-e"), 53 * off.scores[0], 1e-12);
}

TEST(DisplayPlugin, TakesTheLayoutFromThePictures) {
  Picture test = noise(6, 6, 1, 1), wide = noise(12, 12, 2, 2, 0, 1, 2);
  const auto error = [&] { return message_of([&] { run("display", {{"border", "0"}}, {&test, &wide, nullptr}); }); };
  EXPECT_THAT(error(), HasSubstr("reference has 2x2 cells a pixel, and layout rgb needs 3x1"));
  wide.metadata.set("triad:layout", "qd-oled");
  const auto automatic = run("display", {{"border", "0"}}, {&test, &wide, nullptr});
  EXPECT_EQ(automatic.scores,
            run("display", {{"border", "0"}, {"layout", "qd-oled"}}, {&test, &wide, nullptr}).scores);
  test.metadata.set("triad:layout", "rgb");
  EXPECT_THAT(error(), HasSubstr("one picture was made for layout 'rgb', the other for 'qd-oled'; say with layout="));
  EXPECT_EQ(automatic.scores,
            run("display", {{"border", "0"}, {"layout", "qd-oled"}}, {&test, &wide, nullptr}).scores);
}

TEST(SeeingTest, AColourFilteredForAPanelIsThatColourUpToTheBorder) {
  // Where a pixel of the panel lacks a colour, what is stored there must serve the mirrored picture beyond the
  // border.
  const std::array<float, 3> colour{.2f, .5f, .8f};
  for (const auto& [layout, cells_x, cells_y] :
       {std::tuple{"pentile-rgbg", 2, 1}, {"rgb-delta", 6, 1}, {"qd-oled", 2, 2}}) {
    Picture wide{header(20 * cells_x, 12 * cells_y, cells_x, cells_y), {}};
    for (int i = 0; i < wide.image.width * wide.image.height; ++i)
      wide.pixels.insert(wide.pixels.end(), colour.begin(), colour.end());
    for (const char* filter : {"platt", "displaced-box"}) {
      const Picture shown = run(filter, {{"layout", layout}}, {&wide}).out;
      for (size_t i = 0; i < shown.pixels.size(); ++i) EXPECT_NEAR(shown.pixels[i], colour[i % 3], 2e-6) << layout;
      const auto scores = run("display", {{"layout", layout}, {"border", "0"}}, {&shown, &wide, nullptr}).scores;
      EXPECT_NEAR(scores[1], 1, .02) << layout << " " << filter;  // of the pixel average, which is the same picture
    }
  }
}

TEST(SeeingTest, ThePanelsOwnFilterShowsLessColourThanTheStripes) {
  // White strokes at all angles on black, one pixel wide, as a QD-OLED panel shows them at 40 ppd: driven by its own
  // optimum, and by that for RGB stripes. 4 x 4 points in each cell.
  const int width = 96, height = 72;
  const auto strokes = [&](int cells_x, int cells_y) {
    Picture out{header(width * cells_x, height * cells_y, cells_x, cells_y), {}};
    for (int y = 0; y < out.image.height; ++y)
      for (int x = 0; x < out.image.width; ++x) {
        int inside = 0;
        for (int i = 0; i < 16; ++i) {
          const double u = (x + (i % 4 + .5) / 4) / cells_x, v = (y + (i / 4 + .5) / 4) / cells_y;
          // Spokes around the middle of each square of 24 pixels.
          const double dx = std::fmod(u, 24) - 12.3, dy = std::fmod(v, 24) - 11.8;
          const double angle = 2.4 * (std::floor(u / 24) + 4 * std::floor(v / 24));
          const double across = std::abs(dx * std::sin(angle) - dy * std::cos(angle)), r = std::hypot(dx, dy);
          inside += across < .5 && r < 10;
        }
        out.pixels.insert(out.pixels.end(), 3, static_cast<float>(inside) / 16.f);
      }
    return out;
  };
  const Picture oled = strokes(2, 2), wide = strokes(3, 1);
  const Picture own = run("platt", {{"layout", "qd-oled"}}, {&oled}).out;
  const Picture stripes = run("platt", {{"layout", "rgb"}}, {&wide}).out;
  const auto judge = [&](const Picture& test) {
    return run("display", {{"layout", "qd-oled"}}, {&test, &oled, nullptr}).scores;
  };
  const auto best = judge(own), wrong = judge(stripes);
  EXPECT_LT(best[1], .35);  // of the pixel average
  EXPECT_GT(wrong[1], .6);
  EXPECT_LT(best[2] * best[0] * best[0], .1 * wrong[2] * wrong[0] * wrong[0]);  // the energy in colour
  EXPECT_LT(best[3], wrong[3]);                                                 // S-CIELAB
  // And to look at: how far from grey.
  const auto colour = [&](const Picture& picture) {
    const Picture seen = run("eye", {{"layout", "qd-oled"}}, {&picture}).out;
    double sum = 0;
    for (size_t i = 0; i < seen.pixels.size(); i += 3)
      for (const size_t d : {0u, 2u})
        sum += std::pow(static_cast<double>(seen.pixels[i + d] - seen.pixels[i + 1]), 2);
    return std::sqrt(sum);
  };
  EXPECT_LT(colour(own), .5 * colour(stripes));
}
