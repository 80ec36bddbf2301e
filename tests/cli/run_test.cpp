// SPDX-License-Identifier: Apache-2.0
// `triad run`: what goes in, what comes out.
#include <algorithm>
#include <cmath>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

class Run : public Cli {
 protected:
  // Every value of `got` is within `tolerance` of value(x, y, c).
  static void expect_values(const Picture& got, int width, int height, double tolerance,
                            const std::function<double(int, int, int)>& value) {
    ASSERT_EQ(got.width, width);
    ASSERT_EQ(got.height, height);
    double worst = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < std::min(got.channels, 3); ++c)
          worst = std::max(worst, std::abs(got.at(x, y, c) - value(x, y, c)));
    EXPECT_LE(worst, tolerance);
  }
};

TEST_F(Run, WithoutStagesKeepsEveryValue) {
  const Picture picture = noise(33, 17);
  save(path("in.exr"), picture);
  for (const std::string out : {"out.exr", "out.tif"}) {
    expect_success({"run", "in.exr", "-o", out, "--depth", "float"});
    EXPECT_EQ(load(path(out)).values, picture.values) << out;
    EXPECT_EQ(load(path(out)).pixel_type, "float") << out;
  }
}

TEST_F(Run, AveragesBoxes) {
  const Picture picture = noise(12, 10);
  save(path("in.exr"), picture);
  expect_success({"run", "in.exr", "box:x=3,y=2", "-o", "out.exr", "--depth", "float"});
  expect_values(load(path("out.exr")), 4, 5, 1e-7, [&](int x, int y, int c) {
    double sum = 0;
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 3; ++i) sum += picture.at(3 * x + i, 2 * y + j, c);
    return sum / 6;
  });
}

TEST_F(Run, AveragesWhatThereIsAtTheBorders) {
  const Picture picture = noise(5, 3);
  save(path("in.exr"), picture);
  expect_success({"run", "in.exr", "box:x=3,y=2", "-o", "out.exr", "--depth", "float"});
  expect_values(load(path("out.exr")), 2, 2, 1e-7, [&](int x, int y, int c) {
    double sum = 0;
    int count = 0;
    for (int j = 2 * y; j < std::min(3, 2 * y + 2); ++j)
      for (int i = 3 * x; i < std::min(5, 3 * x + 3); ++i, ++count) sum += picture.at(i, j, c);
    return sum / count;
  });
}

TEST_F(Run, TakesOneSampleForEachSubpixel) {
  const Picture picture = noise(21, 5);
  save(path("wide.exr"), picture);
  for (const bool bgr : {false, true}) {
    expect_success({"run", "wide.exr", "--cells", "3x1", bgr ? "subpixel:layout=bgr" : "subpixel", "-o", "out.exr",
                    "--depth", "float"});
    expect_values(load(path("out.exr")), 7, 5, 0,
                  [&](int x, int y, int c) { return picture.at(3 * x + (bgr ? 2 - c : c), y, c); });
  }
}

TEST_F(Run, ShowsFlatFieldsAsTheyAre) {
  save(path("wide.exr"), constant(96, 4, {.25f, .5f, .75f}));
  for (const std::string engine : {"fft", "fir", "auto"}) {
    expect_success({"run", "wide.exr", "--cells", "3x1", "platt:range=clip,engine=" + engine, "-o", "out.exr",
                    "--depth", "float"});
    expect_values(load(path("out.exr")), 32, 4, 1e-5, [](int, int, int c) { return .25 * (c + 1); });
  }
}

TEST_F(Run, CropsAndChains) {
  const Picture picture = noise(30, 20);
  save(path("in.exr"), picture);
  expect_success({"run", "in.exr", "crop:x=5,y=3,w=12,h=8", "write:part.exr", "box:x=2,y=2", "-o", "out.exr",
                  "--depth", "float"});
  expect_values(load(path("out.exr")), 6, 4, 1e-7, [&](int x, int y, int c) {
    const int left = 5 + 2 * x, top = 3 + 2 * y;
    return (double{picture.at(left, top, c)} + picture.at(left + 1, top, c) + picture.at(left, top + 1, c) +
            picture.at(left + 1, top + 1, c)) /
           4;
  });
  const Picture part = load(path("part.exr"));
  // The tap's depth is its format's own or the one asked for: half float errs by at most 2^-12 below 1.
  expect_values(part, 12, 8, 0x1p-12, [&](int x, int y, int c) { return picture.at(5 + x, 3 + y, c); });
}

TEST_F(Run, EncodesForTheFileItWrites) {
  save(path("in.exr"), constant(8, 8, {.02f, .5f, .001f}));
  expect_success({"run", "in.exr", "-o", "eight.png"});
  expect_success({"run", "in.exr", "-o", "sixteen.png", "--depth", "16"});
  expect_success({"run", "in.exr", "-o", "linear.png", "--depth", "16", "--to", "lin_rec709"});
  const double in[] = {.02, .5, .001};
  expect_values(load(path("eight.png")), 8, 8, 1e-7,
                [&](int, int, int c) { return std::floor(srgb_encode(in[c]) * 255 + .5) / 255; });
  // OpenColorIO's curve is up to 1e-5 from the standard's, and a step is 1/65535.
  expect_values(load(path("sixteen.png")), 8, 8, 2e-5, [&](int, int, int c) { return srgb_encode(in[c]); });
  expect_values(load(path("linear.png")), 8, 8, .51 / 65535, [&](int, int, int c) { return in[c]; });
  EXPECT_EQ(load(path("eight.png")).pixel_type, "uint8");
  EXPECT_EQ(load(path("sixteen.png")).pixel_type, "uint16");
}

TEST_F(Run, BringsFilesToLinearLight) {
  const double codes[] = {17, 128, 250};
  save(path("in.png"), constant(6, 4, {17 / 255.f, 128 / 255.f, 250 / 255.f}), "uint8");
  expect_success({"run", "in.png", "-o", "out.exr", "--depth", "float"});
  expect_values(load(path("out.exr")), 6, 4, 3e-5, [&](int, int, int c) { return srgb_decode(codes[c] / 255); });
  expect_success({"run", "in.png", "--from", "lin_rec709", "-o", "asis.exr", "--depth", "float"});
  expect_values(load(path("asis.exr")), 6, 4, 1e-7, [&](int, int, int c) { return codes[c] / 255; });
}

TEST_F(Run, KeepsMetadataAndTheShapeOfPixels) {
  Picture picture = noise(30, 4);
  picture.pixel_aspect = 1 / 3.;
  picture.text["Artist"] = "Ada";
  save(path("wide.exr"), picture);
  expect_success({"run", "wide.exr", "-o", "same.exr"});
  expect_success({"run", "wide.exr", "box:x=3", "-o", "narrow.exr"});
  expect_success({"run", "wide.exr", "subpixel", "-o", "shown.exr"});  // wide by its pixel aspect alone
  EXPECT_NEAR(load(path("same.exr")).pixel_aspect, 1 / 3., 1e-6);
  EXPECT_NEAR(load(path("narrow.exr")).pixel_aspect, 1, 1e-6);
  EXPECT_NEAR(load(path("shown.exr")).pixel_aspect, 1, 1e-6);
  for (const std::string name : {"same.exr", "narrow.exr", "shown.exr"})
    EXPECT_EQ(load(path(name)).text["Artist"], "Ada") << name;
}

TEST_F(Run, RemembersTheCellsItWasTold) {
  save(path("aspect-1.exr"), noise(30, 4));
  expect_success({"run", "aspect-1.exr", "--cells", "3x1", "-o", "wide.exr"});
  expect_success({"run", "wide.exr", "subpixel", "-o", "shown.exr"});
  EXPECT_EQ(load(path("shown.exr")).width, 10);
}

TEST_F(Run, TakesChannelsByName) {
  Picture picture = noise(5, 3, 6);
  picture.channel_names = {"R", "G", "B", "diffuse.R", "diffuse.G", "diffuse.B"};
  save(path("in.exr"), picture);
  expect_success(
      {"run", "in.exr", "--channels", "diffuse.R,diffuse.G,diffuse.B", "-o", "out.exr", "--depth", "float"});
  // OpenImageIO sorts channels on writing by its own rule; names decide, not places.
  const Picture out = load(path("out.exr"));
  ASSERT_EQ(out.channels, 3);
  expect_values(out, 5, 3, 0, [&](int x, int y, int c) { return picture.at(x, y, 3 + c); });
}

TEST_F(Run, WorksOnOnePixel) {
  save(path("one.exr"), constant(1, 1, {.5f, .25f, 2}));
  expect_success({"run", "one.exr", "box", "-o", "out.exr"});
  expect_values(load(path("out.exr")), 1, 1, 0, [](int, int, int c) { return c == 0 ? .5 : c == 1 ? .25 : 2; });
  save(path("three.exr"), constant(3, 1, {.5f, .25f, 1}));
  for (const std::string stage :
       {"subpixel", "displaced-box", "platt", "platt:range=clip,engine=fir", "platt:edge=wrap", "platt:mode=plane"}) {
    expect_success({"run", "three.exr", "--cells", "3x1", stage, "-o", "narrow.exr", "--depth", "float"});
    expect_values(load(path("narrow.exr")), 1, 1, 1e-5, [](int, int, int c) {
      return c == 0 ? .5 : c == 1 ? .25 : 1;
    });
  }
}

// Half of the pixels are not numbers.
class NotNumbers : public Run {
 protected:
  void SetUp() override {
    Run::SetUp();
    save(path("bad.exr"), from_function(6, 2, 3, [](int x, int y, int) {
           return y == 1 ? .5 : x % 2 == 0 ? std::nan("") : HUGE_VAL;
         }));
  }
};

TEST_F(NotNumbers, AreZeroForStagesThatSeeWholeRows) {
  const Outcome outcome = expect_status(0, {"run", "bad.exr", "--cells", "3x1", "platt", "-o", "out.exr"});
  EXPECT_EQ(outcome.error_lines().size(), 1u) << outcome.err;
  for (const std::string word : {"platt", "9 NaN", "9 infinite", "bad.exr"})
    EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
  expect_values(load(path("out.exr")), 2, 2, 1e-3, [](int, int y, int) { return .5 * y; });
}

TEST_F(NotNumbers, AreZeroForStagesThatWouldSpreadThem) {
  const Outcome outcome =
      expect_status(0, {"run", "bad.exr", "resample:filter=tent,factor=2,edge=clamp", "-o", "out.exr"});
  EXPECT_EQ(outcome.error_lines().size(), 1u) << outcome.err;
  for (const std::string word : {"resample", "9 NaN", "9 infinite", "bad.exr"})
    EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
  // 0 above and .5 below, linear at quarters between.
  expect_values(load(path("out.exr")), 12, 4, 1e-3,
                [](int, int y, int) { return std::clamp(.25 * y - .125, 0., .5); });
}

TEST_F(NotNumbers, FailOnRequest) {
  expect_refusal({"run", "bad.exr", "box", "-o", "out.exr", "--nan", "fail"}, {"bad.exr"});
}

TEST_F(NotNumbers, GiveNoScoresAndAdviceThatTheVerbTakes) {
  const Outcome failed = expect_status(1, {"run", "bad.exr", "-m", "error", "--ref", "bad.exr"});
  EXPECT_EQ(failed.error_lines().size(), 1u) << failed.err;
  EXPECT_NE(failed.err.find("--nan zero"), std::string::npos) << failed.err;
  EXPECT_EQ(failed.err.find("ignore"), std::string::npos) << failed.err;  // not of run
  save(path("good.exr"), constant(6, 2, {.5f, .5f, .5f}));
  expect_status(0, {"run", "bad.exr", "-m", "error", "--ref", "good.exr", "--nan", "zero"});
}

TEST_F(Run, SaysThatAReferenceIsBlack) {
  save(path("black.exr"), constant(6, 4, {0, 0, 0}));
  save(path("grey.exr"), constant(6, 4, {.5f, .5f, .5f}));
  const Outcome outcome = expect_status(0, {"run", "grey.exr", "-m", "error", "-m", "error", "--ref", "black.exr"});
  EXPECT_EQ(outcome.error_lines().size(), 1u) << outcome.err;
  EXPECT_NE(outcome.err.find("'black.exr' is black"), std::string::npos) << outcome.err;
  expect_success({"run", "black.exr", "-m", "error", "--ref", "grey.exr"});
}

TEST_F(NotNumbers, AreZeroOnRequest) {
  expect_status(0, {"run", "bad.exr", "box:x=3", "-o", "out.exr", "--nan", "zero"});
  expect_values(load(path("out.exr")), 2, 2, 0, [](int, int y, int) { return .5 * y; });
}

TEST_F(NotNumbers, AreKeptOnRequest) {
  expect_status(0, {"run", "bad.exr", "-o", "out.exr", "--nan", "keep"});
  const Picture out = load(path("out.exr"));
  EXPECT_TRUE(std::isnan(out.at(0, 0, 0)));
  EXPECT_TRUE(std::isinf(out.at(1, 0, 1)));
  EXPECT_EQ(out.at(1, 1, 1), .5f);
}

TEST_F(Run, JudgesWhatComesOut) {
  save(path("in.exr"), constant(6, 4, {.5f, .5f, .5f}));
  save(path("ref.exr"), constant(3, 4, {.25f, .25f, .25f}));
  const Outcome outcome =
      expect_success({"run", "in.exr", "box:x=2", "-m", "error", "--ref", "ref.exr", "--json", "-"});
  const nlohmann::json result = outcome.json()["results"][0];
  EXPECT_EQ(result["metric"], "error");
  EXPECT_NEAR(result["scores"]["bias"].get<double>(), .25, 1e-12);
  EXPECT_NEAR(result["scores"]["mse"].get<double>(), .0625, 1e-12);
  EXPECT_EQ(files(), (std::set<std::string>{"in.exr", "ref.exr"}));
}

}  // namespace
}  // namespace cli
