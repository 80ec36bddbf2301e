// SPDX-License-Identifier: Apache-2.0
// The plugins platt, subpixel and display through the host's own guard, judged by dense matrices and DFT sums.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <triad/display/constrained.hpp>
#include <vector>

#include "display_reference.hpp"
#include "layouts.hpp"
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

std::vector<double> dense_row(const Picture& wide, int y, const triad::FilterOptions& options, triad::Edge edge,
                              bool bgr) {
  const int width = wide.image.width;
  const auto first = wide.pixels.begin() + static_cast<ptrdiff_t>(y) * width * 3;
  const std::vector<double> cells(first, first + width * 3);
  return reference::DenseFilter(reference::observer(40), triad::ring_px(width / 3, edge), options, bgr)
      .drives(reference::ring_of(cells, edge));
}

}  // namespace

TEST(PlattPlugin, MatchesTheDenseSystemWithEveryEngine) {
  const int height = 3;
  for (const int width : {1, 2, 7, 33})
    for (const char* layout : {"rgb", "bgr"})
      for (const char* edge : {"mirror", "wrap"}) {
        const bool mirror = std::string(edge) == "mirror";
        const Picture wide = noise(3 * width, height, 3, 4);
        // Odd, and at least as long as any ring here.
        const ParamTexts common{{"layout", layout}, {"edge", edge}, {"range", "unbounded"}, {"taps", "999"}};
        for (const char* engine : {"fft", "fir"})
          for (const char* precision : {"float", "double"}) {
            ParamTexts parameters = common;
            parameters["engine"] = engine;
            parameters["precision"] = precision;
            const auto got = run("platt", parameters, {&wide});
            EXPECT_EQ(got.out.image.width, width);
            EXPECT_EQ(got.out.image.cells_x, 1);
            EXPECT_NEAR(got.out.image.pixel_aspect, 1, 1e-12);
            EXPECT_GE(got.reports.at("condition"), 1);
            for (int y = 0; y < height; ++y) {
              const auto expected = dense_row(wide, y, {}, mirror ? triad::Edge::kMirror : triad::Edge::kWrap,
                                              std::string(layout) == "bgr");
              for (int i = 0; i < 3 * width; ++i)
                EXPECT_NEAR(got.out.pixels[static_cast<size_t>(y * 3 * width + i)], expected[i],
                            precision == std::string("double") ? 1e-7 : 3e-6)
                    << width << layout << edge << engine << precision;
            }
          }
      }
}

TEST(PlattPlugin, StripsDoNotChangeABit) {
  const Picture wide = noise(120, 11, 3, 8);
  for (const ParamTexts& parameters : {ParamTexts{},
                                       {{"range", "clip"}, {"engine", "auto"}},
                                       {{"range", "clip"}, {"engine", "fft"}},
                                       {{"range", "clip"}, {"engine", "fir"}}}) {
    const auto whole = run("platt", parameters, {&wide}, 11);
    for (const int rows : {1, 4}) EXPECT_EQ(run("platt", parameters, {&wide}, rows).out.pixels, whole.out.pixels);
  }
}

TEST(PlattPlugin, ClampsAndCounts) {
  const Picture wild = noise(60, 2, 3, 5, -1, 2);
  Picture tame = wild;
  double outside = 0;
  for (float& v : tame.pixels) {
    outside += v < 0 || v > 1;
    v = std::clamp(v, 0.f, 1.f);
  }
  for (const char* engine : {"fft", "fir"}) {
    const auto got = run("platt", {{"engine", engine}, {"range", "clip"}}, {&wild});
    const auto free = run("platt", {{"engine", engine}, {"range", "unbounded"}}, {&tame});
    EXPECT_EQ(got.reports.at("clamped-inputs"), outside);
    double clipped = 0;
    for (size_t i = 0; i < free.out.pixels.size(); ++i) {
      EXPECT_EQ(got.out.pixels[i], std::clamp(free.out.pixels[i], 0.f, 1.f));
      clipped += free.out.pixels[i] < 0 || free.out.pixels[i] > 1;
    }
    EXPECT_EQ(got.reports.at("clipped-outputs"), clipped);
    EXPECT_GT(clipped, 0);
  }
}

TEST(PlattPlugin, ChoosesTapsForATruncationAndTheEngineByFormula) {
  const Picture wide = noise(1200, 1, 3, 6);
  const auto chosen = run("platt", {{"range", "clip"}}, {&wide}).reports;
  ASSERT_TRUE(chosen.contains("taps"));  // the default is a convolution at this width
  EXPECT_LE(chosen.at("truncation"), 1e-3);
  EXPECT_EQ(run("platt", {{"range", "clip"}, {"engine", "fir"}, {"taps", "31"}}, {&wide}).reports.at("taps"), 31);
  // Without regularisation kernels are long: transforms it is.
  const auto far = run("platt", {{"range", "clip"}, {"lambda", "0"}, {"csf", "kolpatzik-bouman"}}, {&wide});
  EXPECT_FALSE(far.reports.contains("taps"));
  EXPECT_EQ(
      far.out.pixels,
      run("platt", {{"range", "clip"}, {"lambda", "0"}, {"csf", "kolpatzik-bouman"}, {"engine", "fft"}}, {&wide})
          .out.pixels);
}

TEST(PlattPlugin, RefusesWithAClearLine) {
  const auto error = [](const ParamTexts& parameters, int width, int cells_x, int cells_y = 1) {
    const Picture picture{header(width, 1, cells_x, cells_y), std::vector<float>(3 * static_cast<size_t>(width))};
    return message_of([&] { run("platt", parameters, {&picture}); });
  };
  EXPECT_THAT(error({}, 300, 1), HasSubstr("say --cells 3x1"));
  EXPECT_THAT(error({}, 300, 2, 2), HasSubstr("has 2x2 cells a pixel, and layout rgb needs 3x1"));
  EXPECT_THAT(error({}, 301, 3), HasSubstr("width 301 is not a multiple of 3 cells; 300 or 303 would do"));
  EXPECT_THAT(error({}, 2, 3), HasSubstr("width 2 is not a multiple of 3 cells; 3 would do"));
  EXPECT_THAT(error({{"taps", "30"}}, 300, 3), HasSubstr("taps=30 has no middle: 29 or 31 would do"));
  EXPECT_THAT(error({{"layout", "rbg"}}, 300, 3), HasSubstr("did you mean 'rgb'"));
  EXPECT_THAT(error({{"origin", ".5,0"}}, 300, 3), HasSubstr("whole numbers"));
  EXPECT_THAT(error({{"origin", "1"}}, 300, 3), HasSubstr("two whole numbers"));
  EXPECT_EQ(error({{"origin", "7,-2"}}, 300, 3), "nothing was thrown");
}

TEST(PlattPlugin, OptimumIsTheSolversAndSaysHowGoodItIs) {
  const Picture wide = noise(3 * 40, 3, 3, 9, -.5f, 1.5f);
  const triad::Layout panel = triad::load_layout(TRIAD_SOURCE_DIR "/data/layouts/rgb.toml");
  std::vector<double> cells(wide.pixels.begin(), wide.pixels.end());
  double outside = 0;
  for (const double v : cells) outside += v < 0 || v > 1;
  {
    const triad::RowSolver<double> solver(panel, reference::observer(40), 40, 0, triad::Edge::kMirror, {});
    triad::RowSolver<double>::Workspace workspace(solver);
    const auto got = run("platt", {{"precision", "double"}}, {&wide}, 2);
    triad::SolveResult sum;
    for (int y = 0; y < 3; ++y) {
      std::vector<double> drives(120);
      sum.add(solver.solve(cells.data() + 360 * y, drives.data(), workspace));
      for (int i = 0; i < 120; ++i)
        EXPECT_EQ(got.out.pixels[static_cast<size_t>(120 * y + i)], static_cast<float>(drives[i]));
    }
    EXPECT_DOUBLE_EQ(got.reports.at("gap"), sum.gap());
    EXPECT_EQ(got.reports.at("iterations"), sum.iterations);
    EXPECT_EQ(got.reports.at("converged"), 1);
    EXPECT_EQ(got.reports.at("clamped-inputs"), outside);
    EXPECT_DOUBLE_EQ(got.reports.at("rmse"), std::sqrt(sum.best / 3));
    EXPECT_DOUBLE_EQ(got.reports.at("rmse-displaced-box"), std::sqrt(sum.start / 3));
  }
  // No iteration is the displaced box, and a gap that was asked for in vain is told.
  const auto start = run("platt", {{"iterations", "0"}}, {&wide});
  EXPECT_EQ(start.out.pixels, run("displaced-box", {}, {&wide}).out.pixels);
  EXPECT_EQ(start.reports.at("gap"), 1);
  EXPECT_EQ(start.reports.at("converged"), 0);
}

TEST(PlattPlugin, ModesAndParametersThatDoNotGoTogetherAreRefused) {
  const Picture wide = noise(30, 2, 3, 1), square{header(8, 6, 2, 2), std::vector<float>(144)},
                white{header(16, 2, 4, 1), std::vector<float>(96)};
  const auto error = [](const ParamTexts& parameters, const Picture& picture) {
    return message_of([&] { run("platt", parameters, {&picture}, picture.image.height); });
  };
  EXPECT_THAT(error({{"taps", "31"}}, wide), HasSubstr("taps is of the linear filter: it needs range=clip"));
  EXPECT_THAT(error({{"engine", "fir"}}, wide), HasSubstr("engine is of the linear filter"));
  EXPECT_THAT(error({{"layout", "qd-oled"}, {"mode", "rows"}}, square), HasSubstr("mode=plane solves it"));
  EXPECT_THAT(error({{"layout", "qd-oled"}, {"range", "clip"}, {"engine", "fir"}}, square), HasSubstr("has no taps"));
  EXPECT_THAT(error({{"layout", "qd-oled"}, {"range", "clip"}, {"lambda", "0"}}, square),
              HasSubstr("needs 1e-04 or more"));
  EXPECT_THAT(error({{"layout", "rwbg"}, {"mode", "plane"}, {"range", "clip"}}, white),
              HasSubstr("derives its white"));
  EXPECT_THAT(error({{"layout", "rwbg"}, {"range", "clip"}}, white), HasSubstr("range=constrained works on rwbg"));
  EXPECT_EQ(error({{"layout", "qd-oled"}, {"range", "clip"}}, square), "nothing was thrown");
  EXPECT_THAT(error({{"layout", "qd-oled"}}, wide), HasSubstr("has 3x1 cells a pixel, and layout qd-oled needs 2x2"));
  EXPECT_EQ(error({{"layout", "qd-oled"}}, square), "nothing was thrown");
}

TEST(DisplacedBoxPlugin, IsTheSolversStartOnEveryLayoutHoweverItIsCut) {
  for (const triad::Layout& panel : reference::all_layouts())
    for (const char* edge : {"mirror", "wrap"})
      for (const char* origin : {"0,0", "1,1"}) {
        // Whole tiles where the ring is the picture.
        const int width = 6, height = 4;
        Picture wide{header(width * panel.cells_x, height * panel.cells_y, panel.cells_x, panel.cells_y), {}};
        for (const double v : reference::random_cells(width * height * panel.pixel_cells(), 5))
          wide.pixels.push_back(static_cast<float>(2 * v - .5));
        const std::string path = TRIAD_SOURCE_DIR "/data/layouts/" + panel.name + ".toml";
        const ParamTexts parameters{{"layout", path}, {"edge", edge}, {"origin", origin}};
        ParamTexts start = parameters;
        start["iterations"] = "0";
        start["mode"] = "plane";
        const auto expected = run("platt", start, {&wide}, height).out.pixels;
        for (const int rows : {1, 3, 4}) {
          const auto got = run("displaced-box", parameters, {&wide}, rows).out;
          EXPECT_EQ(got.image.width, width);
          EXPECT_EQ(got.image.height, height);
          for (size_t i = 0; i < expected.size(); ++i)
            ASSERT_NEAR(got.pixels[i], expected[i], 1e-7) << panel.name << edge << origin << rows << " at " << i;
        }
      }
}

TEST(SubpixelPlugin, TakesEachChannelFromItsCell) {
  const Picture wide = noise(15, 2, 3, 7, -5, 5);
  for (const bool bgr : {false, true}) {
    const auto got = run("subpixel", {{"layout", bgr ? "bgr" : "rgb"}}, {&wide}).out;
    EXPECT_EQ(got.image.width, 5);
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 5; ++x)
        for (int c = 0; c < 3; ++c)
          EXPECT_EQ(got.pixels[static_cast<size_t>((y * 5 + x) * 3 + c)],
                    wide.pixels[static_cast<size_t>((y * 15 + 3 * x + (bgr ? 2 - c : c)) * 3 + c)]);
  }
  const Picture narrow{header(15, 1, 1), std::vector<float>(45)};
  EXPECT_THAT(message_of([&] { run("subpixel", {}, {&narrow}); }), HasSubstr("--cells 3x1"));
}

TEST(DrivesTest, AreForThePanelThatThePictureNamesAndNameIt) {
  const std::string key = "triad:layout";
  for (const char* stage : {"platt", "displaced-box", "subpixel"}) {
    Picture wide = noise(30, 4, 3, 1);
    const auto of = [&](const ParamTexts& parameters, std::string* warnings) {
      testing::internal::CaptureStderr();
      const auto out = run(stage, parameters, {&wide}, 4).out;
      *warnings = testing::internal::GetCapturedStderr();
      return out;
    };
    std::string warnings;
    const auto stripes = of({}, &warnings);
    EXPECT_EQ(stripes.pixels, of({{"layout", "rgb"}}, &warnings).pixels);
    EXPECT_EQ(stripes.metadata.get(key), "rgb");
    const auto mirrored = of({{"layout", "bgr"}}, &warnings);
    EXPECT_NE(mirrored.pixels, stripes.pixels);
    EXPECT_EQ(mirrored.metadata.get(key), "bgr");
    EXPECT_EQ(warnings, "");

    wide.metadata.set(key, "bgr");
    const auto automatic = of({}, &warnings);
    EXPECT_EQ(automatic.pixels, mirrored.pixels) << stage;
    EXPECT_EQ(automatic.metadata.get(key), "bgr");
    EXPECT_EQ(warnings, "");
    const auto told = of({{"layout", "rgb"}}, &warnings);
    EXPECT_EQ(told.pixels, stripes.pixels) << stage;
    EXPECT_EQ(told.metadata.get(key), "rgb");
    EXPECT_THAT(warnings, HasSubstr("layout=rgb is not the layout that the picture was made for, 'bgr'")) << stage;
    EXPECT_EQ(std::count(warnings.begin(), warnings.end(), '\n'), 1);

    wide.metadata.set(key, "../rgb");
    EXPECT_THAT(message_of([&] { run(stage, {}, {&wide}); }), HasSubstr("which is not known here"));
  }
  Picture square = noise(12, 8, 2, 3, 0, 1, 2);
  square.metadata.set(key, "qd-oled");
  const auto oled = run("displaced-box", {}, {&square}).out;
  EXPECT_EQ(oled.pixels, run("displaced-box", {{"layout", "qd-oled"}}, {&square}).out.pixels);
  EXPECT_EQ(oled.metadata.get(key), "qd-oled");
  EXPECT_THAT(message_of([&] { run("subpixel", {}, {&square}); }), HasSubstr("vertical stripes"));
}

TEST(DisplayPlugin, MatchesTheSumsOfItsDefinition) {
  const int width = 21, height = 5;
  const Picture test = noise(width, height, 1, 1, -.2f, 1.2f), wide = noise(3 * width, height, 3, 2, -.2f, 1.2f);
  for (const bool clip : {false, true})
    for (const auto edge : {triad::Edge::kWrap, triad::Edge::kMirror}) {
      double expected = 0, parts[3], shares[3] = {};
      for (int y = 0; y < height; ++y) {
        expected +=
            reference::row_energy(reference::observer(30), &test.pixels[static_cast<size_t>(y) * width * 3],
                                  &wide.pixels[static_cast<size_t>(y) * width * 9], width, edge, clip, false, parts) /
            height;
        for (int c = 0; c < 3; ++c) shares[c] += parts[c] / height;
      }
      const ParamTexts parameters{{"ppd", "30"},
                                  {"border", "0"},
                                  {"edge", edge == triad::Edge::kWrap ? "wrap" : "mirror"},
                                  {"range", clip ? "clip" : "unbounded"}};
      const auto got = run("display", parameters, {&test, &wide, nullptr}, 2);
      ASSERT_EQ(got.scores.size(), 5u);
      EXPECT_NEAR(got.scores[0] / std::sqrt(expected), 1, 1e-12);
      EXPECT_NEAR(got.reports.at("share-red-green"), shares[1] / expected, 1e-12);
      EXPECT_EQ(got.reports.contains("clamped-reference-cells"), clip);
      // The map holds what was pooled.
      double sum = 0;
      for (const float v : got.out.pixels) sum += static_cast<double>(v) * v;
      EXPECT_NEAR(std::sqrt(sum / (width * height)) / got.scores[0], 1, 1e-6);
    }
}

TEST(DisplayPlugin, PoolsInsideBorderAndMask) {
  const int width = 40, height = 4;
  const Picture test = noise(width, height, 1, 1), wide = noise(3 * width, height, 3, 2);
  Picture mask{header(width, height, 1), std::vector<float>(width * height)};
  mask.image.channels = 1;
  for (int y = 0; y < height; ++y)
    for (int x = 8; x < width - 8; ++x) mask.pixels[static_cast<size_t>(y * width + x)] = 1;
  const auto automatic = run("display", {}, {&test, &wide, nullptr});
  EXPECT_EQ(automatic.reports.at("border"), 8);  // 40 ppd / 5
  EXPECT_EQ(run("display", {{"border", "8"}}, {&test, &wide, nullptr}).scores, automatic.scores);
  EXPECT_NEAR(run("display", {{"border", "0"}}, {&test, &wide, &mask}).scores[0], automatic.scores[0], 1e-15);
  EXPECT_NE(run("display", {{"border", "0"}}, {&test, &wide, nullptr}).scores, automatic.scores);
  std::fill(mask.pixels.begin(), mask.pixels.end(), 0.f);
  EXPECT_THAT(message_of([&] { run("display", {}, {&test, &wide, &mask}); }), HasSubstr("every pixel is left out"));
}

TEST(DisplayPlugin, TakesAReferenceOfTheTestsSizeForAPictureOnTheSamePanel) {
  const int width = 40, height = 6;
  const Picture test = noise(width, height, 1, 1), other = noise(width, height, 1, 2);
  // What the panel's stripes send out, as a wide picture of its own: each lights its third of the pixel three times
  // as brightly.
  Picture light{header(3 * width, height, 3), std::vector<float>(test.pixels.size() * 3)};
  for (size_t i = 0; i < other.pixels.size() / 3; ++i)
    for (size_t d = 0; d < 3; ++d) light.pixels[(3 * i + d) * 3 + d] = 3 * other.pixels[3 * i + d];
  for (const char* mode : {"rows", "plane"}) {
    // Wrapped: a mirror image of stripes would have them in another order.
    const ParamTexts clipped{{"mode", mode}, {"edge", "wrap"}};
    const ParamTexts unbounded{{"mode", mode}, {"edge", "wrap"}, {"range", "unbounded"}};
    const auto got = run("display", clipped, {&test, &other, nullptr});
    const auto expected = run("display", unbounded, {&test, &light, nullptr});
    EXPECT_NEAR(got.scores[0], expected.scores[0], 1e-7) << mode;
    EXPECT_NEAR(got.scores[2], expected.scores[2], 1e-6) << mode;
    EXPECT_NEAR(got.scores[3], expected.scores[3], 1e-4) << mode;
    EXPECT_TRUE(std::isinf(got.scores[1])) << mode;
    const auto equal = run("display", clipped, {&test, &test, nullptr});
    EXPECT_EQ(equal.scores[0], 0) << mode;
    EXPECT_EQ(equal.scores[1], 1) << mode;
    EXPECT_EQ(equal.scores[3], 0) << mode;
  }
  Picture bright = other;
  for (float& v : bright.pixels) v = 2 * v;
  Picture shown = bright;
  for (float& v : shown.pixels) v = std::min(v, 1.f);
  EXPECT_EQ(run("display", {}, {&test, &bright, nullptr}).scores,
            run("display", {}, {&test, &shown, nullptr}).scores);
}

TEST(DisplayPlugin, RefusesWithAClearLine) {
  const Picture test = noise(40, 4, 1, 1), wide = noise(120, 4, 3, 2), short_one = noise(119, 4, 3, 2);
  Picture other = wide;
  other.image.rgb_to_xyz[0] = .6;
  const auto error = [&](const ParamTexts& parameters, const Picture& reference_picture) {
    return message_of([&] { run("display", parameters, {&test, &reference_picture, nullptr}); });
  };
  EXPECT_THAT(error({}, short_one), HasSubstr("test picture is 40x4 and the reference 119x4; for layout rgb the "
                                              "reference must be a wide render of 120x4"));
  EXPECT_THAT(error({}, noise(40, 5, 1, 2)), HasSubstr("40x5; for layout rgb the reference must be a wide render of "
                                                       "120x4, or a picture of the test's own size"));
  EXPECT_THAT(error({{"layout", "qd-oled"}}, wide),
              HasSubstr("reference has 3x1 cells a pixel, and layout qd-oled needs 2x2"));
  EXPECT_THAT(error({{"mode", "rows"}, {"layout", "vrgb"}}, noise(40, 12, 1, 2)),
              HasSubstr("vrgb' has no independent rows: it needs mode=plane"));
  EXPECT_THAT(error({{"origin", "1,.5"}}, wide), HasSubstr("whole numbers"));
  EXPECT_THAT(error({}, other), HasSubstr("different primaries"));
  EXPECT_THAT(error({{"border", "20"}}, wide), HasSubstr("border=20 leaves nothing of a width of 40: at most 19"));
  EXPECT_THAT(error({{"border", "some"}}, wide), HasSubstr("border is 'some'"));
  EXPECT_EQ(error({{"border", "19"}}, wide), "nothing was thrown");
}
