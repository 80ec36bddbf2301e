// SPDX-License-Identifier: Apache-2.0
// triad render of functions and pictures, and what it says of them.
#include <cmath>
#include <limits>
#include <numbers>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

using RenderFunction = Cli;

TEST_F(RenderFunction, DrawsFunctionsWithEveryStrategy) {
  expect_success(
      {"render", "half-plane:angle=0,shift=.5", "-o", "a.exr", "--size", "40x20", "--strategy", "grid:n=4"});
  const Picture half = load(path("a.exr"));
  EXPECT_EQ(half.width, 40);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 40; ++x) EXPECT_EQ(half.at(x, y, 0), x < 20 ? 1 : x == 20 ? .5f : 0);
  EXPECT_EQ(half.text.at("triad:function"), "half-plane:angle=0,shift=0.5,rows=0,low=0,high=1");
  EXPECT_FALSE(half.text.contains("triad:scene"));
  EXPECT_FALSE(half.text.contains("triad:bounces"));
  // The same view in finer pixels.
  expect_success({"render", "zone-plate:rings=5", "-o", "b.exr", "--size", "40x30", "--strategy", "grid:n=3"});
  expect_success(
      {"render", "zone-plate:rings=5", "-o", "wide.exr", "--size", "40x30", "--cells", "3x1", "--strategy", "exact"});
  const Picture plain = load(path("b.exr")), wide = load(path("wide.exr"));
  ASSERT_EQ(wide.width, 120);
  EXPECT_NEAR(wide.pixel_aspect, 1 / 3., 1e-6);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      EXPECT_NEAR(plain.at(x, y, 0), (wide.at(3 * x, y, 0) + wide.at(3 * x + 1, y, 0) + wide.at(3 * x + 2, y, 0)) / 3,
                  .02);
  // Strokes are functions too, with the geometry that they lack said.
  expect_success({"render", "stems:seed=3", "-o", "c.exr", "--size", "40x30", "--strategy", "control"});
  expect_refusal({"render", "stems", "-o", "d.exr", "--size", "40x30", "--strategy", "exact"},
                 {"exact", "grid:n=16"});
}

TEST_F(RenderFunction, ExactIsTheFilteredPicture) {
  const nlohmann::json record = expect_success({"render", "discs:radius=.3,spacing=4", "-o", "a.exr", "--size",
                                                "40x20", "--strategy", "exact", "--json", "-"})
                                    .json();
  EXPECT_EQ(record["samples"], 0);
  EXPECT_EQ(record["function"], "discs:radius=0.3,spacing=4,rows=0,low=0,high=1");
  EXPECT_EQ(record["strategy"], "exact:filter=box,scale=1");
  EXPECT_FALSE(record.contains("scene"));
  EXPECT_FALSE(record.contains("triangles"));
  const Picture discs = load(path("a.exr"));
  double sum = 0;
  for (const float value : discs.values) sum += static_cast<double>(value);
  EXPECT_NEAR(sum / static_cast<double>(discs.values.size()), std::numbers::pi * .09 / 16, 1e-7);
  // Under a normal distribution a straight edge is that of the distance.
  expect_success({"render", "half-plane:angle=0", "-o", "b.exr", "--size", "8x2", "--strategy",
                  "exact:filter=normal,scale=1.4"});
  const Picture edge = load(path("b.exr"));
  for (int x = 0; x < 8; ++x)
    EXPECT_NEAR(edge.at(x, 1, 2), .5 * std::erfc((x + .5 - 4) / .7 / std::numbers::sqrt2), 1e-7);
  expect_refusal({"render", "discs", "-o", "c.exr", "--size", "8x2", "--strategy", "exact:filter=normal"},
                 {"filter=box"});
  expect_refusal({"render", "cornell", "-o", "c.exr", "--size", "8x2", "--strategy", "exact"}, {"exact", "scene"});
  expect_refusal({"render", "speck", "-o", "c.exr", "--size", "8x2", "--strategy", "exact", "--aov", "depth"},
                 {"exact", "no samples"});
}

TEST_F(RenderFunction, GeometryWhereThereIsSome) {
  expect_success({"render", "white-on-white:angle=0,step=1", "-o", "a.exr", "--size", "4x2", "--strategy", "control",
                  "--aov", "depth,object-id"});
  const Picture picture = load(path("a.exr"));
  ASSERT_EQ(picture.channel_names, (std::vector<std::string>{"R", "G", "B", "Z", "object_id"}));
  for (int x = 0; x < 4; ++x) {
    EXPECT_EQ(picture.at(x, 0, 1), 1);
    EXPECT_EQ(picture.at(x, 0, 3), x < 2 ? 4 : 5);
    EXPECT_EQ(picture.at(x, 0, 4), x < 2 ? 2 : 1);
  }
  expect_refusal({"render", "checker", "-o", "b.exr", "--size", "4x2", "--aov", "depth"}, {"--aov", "checker"});
  // Nothing is made up that a picture's file does not hold.
  expect_refusal({"render", "a.exr", "-o", "b.exr", "--size", "4x2", "--aov", "depth,object-id,albedo,position"},
                 {"--aov", "a.exr", "does not tell position, albedo"});
}

TEST_F(RenderFunction, SamplesPicturesAnew) {
  const Picture big = noise(60, 30);
  save(path("big.exr"), big);
  const nlohmann::json record =
      expect_success({"render", "big.exr", "-o", "a.exr", "--size", "20x10", "--strategy", "exact", "--json", "-"})
          .json();
  EXPECT_EQ(record["picture"], "big.exr");
  EXPECT_FALSE(record.contains("scene"));
  const Picture exact = load(path("a.exr"));
  EXPECT_EQ(exact.text.at("triad:picture"), "big.exr");
  expect_success({"render", "big.exr", "-o", "b.exr", "--size", "20x10", "--strategy", "grid:n=12"});
  const Picture grid = load(path("b.exr"));  // 12 x 12 points over 3 x 3 pixels meet each as often
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 20; ++x)
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int j = 0; j < 3; ++j)
          for (int i = 0; i < 3; ++i) sum += static_cast<double>(big.at(3 * x + i, 3 * y + j, c));
        EXPECT_NEAR(exact.at(x, y, c), sum / 9, 1e-6);
        EXPECT_NEAR(grid.at(x, y, c), sum / 9, 1e-6);
      }
  // A display-encoded one becomes light.
  save(path("grey.png"), constant(8, 8, {.5f, .5f, .5f}), "uint8");
  expect_success({"render", "grey.png", "-o", "c.exr", "--size", "4x4", "--strategy", "control"});
  EXPECT_NEAR(load(path("c.exr")).at(1, 1, 0), srgb_decode(128 / 255.), 2e-5);
  expect_success(
      {"render", "grey.png", "-o", "d.exr", "--size", "4x4", "--strategy", "control", "--from", "lin_rec709"});
  EXPECT_NEAR(load(path("d.exr")).at(1, 1, 0), 128 / 255., 1e-6);
}

TEST_F(RenderFunction, PicturesWithHolesAreSaidAndLeftOut) {
  Picture holes = constant(8, 4, {.25f, .5f, .75f});
  holes.values[3 * 9 + 1] = std::numeric_limits<float>::quiet_NaN();
  save(path("holes.exr"), holes);
  const Outcome outcome =
      expect_status(0, {"render", "holes.exr", "-o", "a.exr", "--size", "4x2", "--strategy", "grid:n=2"});
  ASSERT_GE(outcome.error_lines().size(), 1u);
  EXPECT_NE(outcome.err.find("1 of its pixels"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("the first 1,1"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("1 of 32 samples"), std::string::npos) << outcome.err;
  for (const float value : load(path("a.exr")).values) EXPECT_TRUE(value == .25f || value == .5f || value == .75f);
  // Another shape than the film's.
  const Outcome stretched =
      expect_status(0, {"render", "holes.exr", "-o", "b.exr", "--size", "4x4", "--strategy", "exact"});
  EXPECT_NE(stretched.err.find("stretched"), std::string::npos) << stretched.err;
}

TEST_F(RenderFunction, RefusesInOneLine) {
  save(path("big.exr"), noise(60, 40));
  truncate_copy(path("big.exr"), path("cut.exr"), .6);
  save_text(path("words.png"), "no picture");
  save_claim(path("claim.exr"), 2000000, 2000000);
  const auto refuse = [&](const std::string& source, std::vector<std::string> rest,
                          const std::vector<std::string>& words) {
    rest.insert(rest.begin(), {"render", source, "-o", "a.exr"});
    if (std::find(rest.begin(), rest.end(), "--size") == rest.end()) rest.insert(rest.end(), {"--size", "9x6"});
    expect_refusal(rest, words);
  };
  refuse("zone-plat", {}, {"zone-plat", "did you mean 'zone-plate'", "'cornell'"});
  refuse("checker:cel=3", {}, {"SOURCE", "checker", "'cel'", "'cell'"});
  refuse("checker:cell=-1", {}, {"SOURCE", "checker:cell", "1e-04"});
  refuse("thin-line:width=x", {}, {"thin-line:width", "number"});
  refuse("discs:radius=9", {}, {"radius=9", "spacing"});
  for (const std::string option : {"--effects", "--camera", "--bounces"}) {
    const std::string value = option == "--bounces" ? "3" : "all";
    refuse("checker", {option, value}, {option, "a function"});
    refuse("big.exr", {option, value}, {option, "a picture"});
  }
  refuse("checker", {"--from", "srgb"}, {"--from", "a function"});
  refuse("cornell", {"--from", "srgb"}, {"--from", "a scene"});
  refuse("big.exr", {"--from", "sgrb"}, {"--from", "srgb"});
  refuse("big.exr", {"--size", "61x40"}, {"big.exr", "60x40", "61x40"});
  refuse("big.exr", {"--size", "30x20", "--cells", "3x1"}, {"90x20"});
  refuse("none.exr", {}, {"none.exr"});
  refuse("cut.exr", {}, {"cut.exr"});
  refuse("words.png", {}, {"words.png"});
  refuse("claim.exr", {}, {"claim.exr"});
  refuse("big.exr", {"--aov", "depth"}, {"--aov", "big.exr"});
}

TEST_F(RenderFunction, TellsOfFunctions) {
  const Outcome list = expect_success({"list", "functions"});
  for (const std::string name : {"half-plane", "thin-line", "checker", "horizon", "zone-plate", "discs", "chirp",
                                 "strokes", "white-on-white", "small-object", "stripes", "speck"})
    EXPECT_NE(list.out.find("  " + name + " "), std::string::npos) << name;
  const nlohmann::json functions = expect_success({"list", "functions", "--json"}).json()["functions"];
  // Each can be drawn as it is listed.
  for (const auto& function : functions) {
    EXPECT_NE(function["summary"], "");
    expect_success({"render", function["id"], "-o", "a.exr", "--size", "16x9", "--strategy", "control"});
  }
  const Outcome help = expect_success({"help", "zone-plate"});
  for (const std::string word : {"Fresnel", "rings=60", "0.01 to 1e+06", "low=0", "high=1"})
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  const nlohmann::json json = expect_success({"help", "white-on-white", "--json"}).json();
  EXPECT_EQ(json["kind"], "function");
  EXPECT_EQ(json["parameters"][3]["name"], "tell");
  EXPECT_EQ(json["parameters"][3]["default"], "both");
  EXPECT_EQ(json["parameters"][3]["choices"], (nlohmann::json{"both", "ids", "position"}));
  EXPECT_EQ(json["parameters"][0]["max"], 360);
}

}  // namespace
}  // namespace cli
