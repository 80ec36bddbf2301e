// SPDX-License-Identifier: Apache-2.0
// What the program says about itself, its plugins and a file.
#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

class Words : public Cli {
 protected:
  void expect_words(const std::vector<std::string>& arguments, const std::vector<std::string>& words) {
    const Outcome outcome = expect_success(arguments);
    for (const std::string& word : words)
      EXPECT_NE(outcome.out.find(word), std::string::npos) << word << " is not in:\n" << outcome.out;
  }
};

TEST_F(Words, TellsItsVersion) { expect_words({"--version"}, {"triad", TRIAD_VERSION}); }

TEST_F(Words, ListsItsStages) {
  expect_words({"list"}, {"platt", "subpixel", "box", "crop", "error", "display", "panel", "eye", "dither"});
}

TEST_F(Words, ListsLayoutsWithTheirCellsAndTiles) {
  expect_words({"list", "layouts"}, {"qd-oled", "2x2", "pentile-rgbg", "repeats after 2x2 px", "rgb-delta", "6x1"});
}

TEST_F(Words, ListsScenesWithWhatTheyShow) {
  expect_words({"list", "scenes"}, {"cornell", "The classic box", "room", "thin-lines", "high-contrast-4"});
  const nlohmann::json scenes = expect_success({"list", "scenes", "--json"}).json()["scenes"];
  EXPECT_GE(scenes.size(), 14u);
  for (const auto& scene : scenes) {
    EXPECT_TRUE(std::filesystem::exists(scene["file"].get<std::string>())) << scene;
    EXPECT_NE(scene["summary"], "") << scene;
  }
}

TEST_F(Words, ExplainsParameters) {
  expect_words({"help", "platt"}, {"layout",    "rgb",      "wrap",        "csf",    "scielab",    "kolpatzik-bouman",
                                   "ppd",       "40",       "lambda",      "0.01",   "flat-field", "exact",
                                   "free",      "channels", "edge",        "mirror", "wrap",       "engine",
                                   "fft",       "fir",      "auto",        "taps",   "range",      "clip",
                                   "unbounded", "origin",   "constrained", "mode",   "plane",      "iterations",
                                   "tolerance"});
  expect_words({"help", "displaced-box"}, {"layout", "edge", "range", "origin"});
  expect_words({"help", "display"}, {"layout", "csf", "ppd", "channels", "edge", "border", "range", "mode", "rows",
                                     "plane", "rmse", "ratio", "fringe", "delta-e"});
  expect_words({"help", "panel"}, {"layout", "scale", "gain", "lines", "origin"});
  expect_words({"help", "eye"}, {"layout", "ppd", "grid", "pixels", "cells", "space", "neutral"});
  expect_words({"help", "dither"}, {"none", "ordered", "perceptual", "bits", "srgb", "passes"});
  expect_words({"help", "error"}, {"bias", "mae", "mse", "rmse", "max", "psnr"});
  expect_refusal({"help", "plat"}, {"'plat'", "'platt'"});
  expect_refusal({"help", "sobol"}, {"'sobol'", "crop", "sobol-owen", "zone-plate"});
}

TEST_F(Words, ExplainsItself) {
  expect_words({"--help"}, {"run", "compare", "info", "list", "help", "plugin"});
  expect_words({"run", "--help"}, {"--cells", "--from", "--to", "--part", "--channels", "--threads", "--strip-rows",
                                   "--max-memory", "--explain", "--chain", "--nan", "--depth"});
  expect_words({"compare", "--help"}, {"--ref", "--map", "--json", "--csv", "--fail-above", "--fail-below", "--crop",
                                       "--mask", "--nan", "--ref-cells", "--ref-from"});
}

TEST_F(Words, DescribesAFile) {
  Picture picture = noise(30, 4, 4);
  picture.channel_names = {"R", "G", "B", "Z"};
  picture.pixel_aspect = 1 / 3.;
  picture.text["Artist"] = "Ada";
  save(path("in.exr"), picture);
  expect_words({"info", "in.exr"}, {"in.exr", "30 x 4", "R", "Z", "3x1", "lin_rec709", "Ada"});
  save(path("in.png"), noise(5, 6), "uint8");
  expect_words({"info", "in.png"}, {"5 x 6", "srgb", "uint8"});
}

TEST_F(Words, DescribesAFileForPrograms) {
  Picture picture = noise(30, 4);
  picture.pixel_aspect = 1 / 3.;
  save(path("in.exr"), picture, "half");
  const nlohmann::json file = expect_success({"info", "in.exr", "--json"}).json()["files"][0];
  EXPECT_EQ(file["width"], 30);
  EXPECT_EQ(file["height"], 4);
  EXPECT_EQ(file["channels"], (std::vector<std::string>{"R", "G", "B"}));
  EXPECT_EQ(file["type"], "half");
  EXPECT_EQ(file["cells"], "3x1");
  EXPECT_EQ(file["cells_from"], "pixel aspect");
  EXPECT_EQ(file["colour_space"], "lin_rec709");
}

TEST_F(Words, WritesAPluginThatPassesItsOwnCheck) {
  expect_success({"plugin", "new", "brighten"});
  ASSERT_TRUE(exists("brighten")) << "no folder of that name";
  std::string source, build;
  for (const std::string& name : files()) {
    if (name.ends_with(".cpp") && source.empty()) source = name;
    if (name.ends_with("CMakeLists.txt")) build = name;
  }
  EXPECT_NE(source, "");
  EXPECT_NE(build, "");
  EXPECT_NE(load_text(path(build)).find("triad_add_plugin(brighten"), std::string::npos) << load_text(path(build));
  expect_refusal({"plugin", "new", "brighten"}, {"brighten"});  // it does not write over what is there
  expect_refusal({"plugin", "new", "Not A Name"}, {"Not A Name"});
}

TEST_F(Words, ChecksPlugins) {
  const std::string plugins = TRIAD_BINARY_DIR "/plugins/";
  for (const std::string name : {"platt", "box", "error"})
    expect_success({"plugin", "check", plugins + name + ".triad.so"});
  save_text(path("text.triad.so"), "not a plugin");
  const Outcome outcome = triad({"plugin", "check", "text.triad.so"});
  EXPECT_EQ(outcome.status, 1) << outcome.out << outcome.err;
  EXPECT_NE((outcome.out + outcome.err).find("text.triad.so"), std::string::npos);
  expect_refusal({"plugin", "check", "missing.triad.so"}, {"missing.triad.so", "No such file"});
}

TEST_F(Words, NeedsAVerb) {
  expect_refusal({"rum", "in.exr"}, {"rum", "run"});
  expect_refusal({"run", "in.exr", "--thread", "2"}, {"--thread"});
}

}  // namespace
}  // namespace cli
