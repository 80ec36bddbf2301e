// SPDX-License-Identifier: Apache-2.0
// triad render on small scenes with known pictures, and what becomes of it in the rest of the program.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "../unit/gltf_files.hpp"
#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

// A half-height of 1 unit around the origin, seen along -z, so that a picture of W x H = 2 : 1 shows x in [-2, 2] and
// y in [-1, 1]. A sheet of light .8 .4 .2 covers what lies left of the line x = edge_m before black.
gltf_files::Gltf half_plane(double edge_m, double slope = 0) {
  gltf_files::Gltf gltf;
  const auto x = [&](double y) { return static_cast<float>(edge_m + slope * y); };
  const int positions = gltf.accessor<float>({-9, -9, 0, x(-9), -9, 0, x(9), 9, 0, -9, 9, 0}, 3);
  const int indices = gltf.accessor<uint16_t>({0, 1, 2, 0, 2, 3}, 1);
  gltf.root["extensionsUsed"] = {"KHR_materials_unlit"};
  gltf.push("materials", {{"name", "sheet"},
                          {"pbrMetallicRoughness", {{"baseColorFactor", {.8, .4, .2, 1.}}}},
                          {"extensions", {{"KHR_materials_unlit", gltf_files::json::object()}}}});
  gltf.push("meshes",
            {{"name", "sheet"},
             {"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", 0}}}}});
  gltf.node({{"mesh", 0}, {"name", "sheet"}});
  gltf.push("cameras", {{"name", "front"},
                        {"type", "orthographic"},
                        {"orthographic", {{"xmag", 2.}, {"ymag", 1.}, {"znear", .1}, {"zfar", 100.}}}});
  gltf.node({{"camera", 0}, {"name", "front"}, {"translation", {0, 0, 5}}});
  return gltf;
}

// A room of light and matt surfaces, so that every sample is noisy: a ground plane under a lamp.
gltf_files::Gltf lit_ground() {
  gltf_files::Gltf gltf;
  const int ground = gltf.accessor<float>({-9, 0, -9, -9, 0, 9, 9, 0, 9, 9, 0, -9}, 3);
  const int lamp = gltf.accessor<float>({-1, 2, -1, 1, 2, -1, 1, 2, 1, -1, 2, 1}, 3);
  const int indices = gltf.accessor<uint16_t>({0, 1, 2, 0, 2, 3}, 1);
  gltf.push("materials",
            {{"name", "matt"},
             {"pbrMetallicRoughness",
              {{"baseColorFactor", {.6, .5, .4, 1.}}, {"metallicFactor", 0.}, {"roughnessFactor", 1.}}}});
  gltf.push("materials", {{"name", "lamp"}, {"emissiveFactor", {1., 1., 1.}}});
  for (const auto& [mesh, material] : {std::pair{ground, 0}, {lamp, 1}}) {
    gltf.push("meshes", {{"primitives",
                          {{{"attributes", {{"POSITION", mesh}}}, {"indices", indices}, {"material", material}}}}});
    gltf.node({{"mesh", material}});
  }
  gltf.push("cameras", {{"name", "low"}, {"type", "perspective"}, {"perspective", {{"yfov", .8}, {"znear", .1}}}});
  gltf.node({{"camera", 0}, {"name", "low"}, {"translation", {0, 1, 6}}});
  return gltf;
}

// What the one child of this process has used of the processors, all threads together: however busy the machine is,
// a program that has used a second has long begun its work.
double seconds_of_child() {
  std::ifstream children("/proc/self/task/" + std::to_string(getpid()) + "/children");
  std::string child;
  if (!(children >> child)) return 0;
  std::ifstream stat("/proc/" + child + "/stat");
  std::string field;
  std::getline(stat, field, ')');  // the program's name may hold blanks
  double ticks = 0;
  for (int i = 3; i <= 15 && stat >> field; ++i)
    if (i >= 14) ticks += std::stod(field);  // utime and stime, proc(5)
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

class Render : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    half_plane(.25).save(path("half.gltf"));
    lit_ground().save(path("lit.glb"));
  }
};

TEST_F(Render, DrawsWhatTheSceneSays) {
  // The edge x = .25 is 2.25 / 4 of the width: column 22.5 of 40.
  for (const char* strategy : {"control", "grid:n=4", "sobol-owen:spp=16"}) {
    expect_success({"render", "half.gltf", "-o", "a.exr", "--size", "40x20", "--strategy", strategy});
    const Picture picture = load(path("a.exr"));
    ASSERT_EQ(picture.width, 40);
    ASSERT_EQ(picture.height, 20);
    EXPECT_EQ(picture.pixel_type, "float");
    const float colour[3] = {.8f, .4f, .2f};
    for (int y = 0; y < 20; ++y)
      for (int c = 0; c < 3; ++c) {
        EXPECT_FLOAT_EQ(picture.at(21, y, c), colour[c]);
        EXPECT_EQ(picture.at(23, y, c), 0);
        // Stratified in each power of two, so the half that is covered is met by half of the points.
        if (std::string(strategy) != "control") {
          EXPECT_FLOAT_EQ(picture.at(22, y, c), colour[c] / 2) << strategy;
        }
      }
  }
}

TEST_F(Render, WideShowsTheSameViewInFinerPixels) {
  half_plane(.3, .37).save(path("slant.gltf"));
  expect_success(
      {"render", "slant.gltf", "-o", "wide.exr", "--size", "40x20", "--strategy", "grid:n=4", "--cells", "3x1"});
  expect_success(
      {"render", "slant.gltf", "-o", "rgb.exr", "--size", "40x20", "--strategy", "grid:n=4", "--cells", "rgb"});
  const Picture wide = load(path("wide.exr"));
  EXPECT_EQ(load(path("rgb.exr")).values, wide.values);
  EXPECT_EQ(load(path("rgb.exr")).text.at("triad:layout"), "rgb");
  EXPECT_FALSE(wide.text.contains("triad:layout"));
  EXPECT_EQ(wide.width, 120);
  EXPECT_EQ(wide.height, 20);
  EXPECT_NEAR(wide.pixel_aspect, 1 / 3., 1e-6);
  EXPECT_EQ(wide.text.at("triad:cells"), "3x1");
  // Each pixel's area left of the edge: columns of 12 by rows of 4 points against the finest render.
  expect_success({"render", "slant.gltf", "-o", "fine.exr", "--size", "40x20", "--strategy", "grid:n=64"});
  const Picture fine = load(path("fine.exr"));
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 40; ++x)
      EXPECT_NEAR((wide.at(3 * x, y, 0) + wide.at(3 * x + 1, y, 0) + wide.at(3 * x + 2, y, 0)) / 3, fine.at(x, y, 0),
                  .8 / 12 + .01);
  // It goes straight through the chain, onto subpixels and back to display pixels, and into a comparison.
  expect_success({"run", "wide.exr", "platt:layout=rgb,ppd=40", "-o", "shown.exr"});
  EXPECT_EQ(load(path("shown.exr")).width, 40);
  expect_success({"run", "wide.exr", "box:x=3", "-o", "boxed.exr"});
  const double rmse = compare({"boxed.exr", "--ref", "fine.exr", "-m", "error"})[0]["scores"]["rmse"];
  EXPECT_LT(rmse, .8 / 12 * std::sqrt(1 / 40.));  // one pixel in 40 is on the edge
}

TEST_F(Render, DrawsOnAnyLayoutsCells) {
  half_plane(.3, .37).save(path("slant.gltf"));
  expect_success(
      {"render", "slant.gltf", "-o", "oled.exr", "--size", "40x20", "--strategy", "grid:n=4", "--cells", "qd-oled"});
  const Picture wide = load(path("oled.exr"));
  EXPECT_EQ(wide.width, 80);
  EXPECT_EQ(wide.height, 40);
  EXPECT_EQ(wide.text.at("triad:cells"), "2x2");
  EXPECT_EQ(wide.text.at("triad:layout"), "qd-oled");
  // The picture names the panel that judges it and shows it.
  expect_success({"run", "oled.exr", "box:x=2,y=2", "-o", "boxed.exr", "--depth", "float"});
  const auto scores = compare({"boxed.exr", "--ref", "oled.exr", "-m", "display"})[0]["scores"];
  EXPECT_NEAR(scores["ratio"], 1, 1e-5);  // box is the pixel average
  EXPECT_GT(scores["rmse"], 1e-3);
  expect_success({"run", "boxed.exr", "panel:scale=4", "-o", "panel.exr"});
  EXPECT_EQ(load(path("panel.exr")).width, 160);
  expect_success({"run", "boxed.exr", "eye", "-o", "seen.exr"});
  EXPECT_EQ(load(path("seen.exr")).width, 40);
  // Stored in eight bits: the codes that were chosen are those that the file holds.
  expect_success({"run", "boxed.exr", "dither", "-o", "codes.exr", "--depth", "float"});
  expect_success({"run", "boxed.exr", "dither", "-o", "codes.png"});
  const Picture codes = load(path("codes.exr")), stored = load(path("codes.png"));
  ASSERT_EQ(codes.values.size(), stored.values.size());
  for (size_t i = 0; i < codes.values.size(); ++i) {
    const double v = static_cast<double>(codes.values[i]);
    const double encoded = v <= .0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - .055;  // IEC 61966-2-1
    EXPECT_NEAR(encoded * 255, static_cast<double>(stored.values[i]) * 255, 1e-3);
  }
  // A whole picture takes memory, which the plan counts; it says how much would do.
  expect_refusal({"compare", "boxed.exr", "--ref", "oled.exr", "-m", "display", "--max-memory", "140M"},
                 {"--max-memory", "would do"});
  expect_refusal({"run", "oled.exr", "eye:layout=rgb", "-o", "x.exr"}, {"2x2 cells", "layout rgb", "3x1"});
  expect_refusal({"compare", "boxed.exr", "--ref", "oled.exr", "-m", "display:layout=rgb"}, {"2x2", "rgb", "3x1"});
}

TEST_F(Render, TheStagesTakeThePanelFromThePicture) {
  half_plane(.3, .37).save(path("slant.gltf"));
  expect_success(
      {"render", "slant.gltf", "-o", "wide.exr", "--size", "40x20", "--strategy", "grid:n=4", "--cells", "bgr"});
  for (const char* stage : {"platt", "displaced-box", "subpixel"}) {
    const std::string name = stage;
    expect_success({"run", "wide.exr", name, "-o", "shown.exr", "--depth", "float"});
    expect_success({"run", "wide.exr", name + ":layout=bgr", "-o", "told.exr", "--depth", "float"});
    const Picture shown = load(path("shown.exr"));
    EXPECT_EQ(shown.values, load(path("told.exr")).values) << stage;
    EXPECT_EQ(shown.text.at("triad:layout"), "bgr") << stage;
  }
  expect_success({"run", "wide.exr", "platt", "-o", "shown.exr", "--depth", "float"});
  const double ratio = compare({"shown.exr", "--ref", "wide.exr", "-m", "display"})[0]["scores"]["ratio"];
  EXPECT_LT(ratio, 1);  // better than the pixel average

  const auto told = expect_status(0, {"run", "wide.exr", "platt:layout=rgb", "-o", "other.exr", "--depth", "float"});
  ASSERT_EQ(told.error_lines().size(), 1u);
  EXPECT_NE(told.error_lines()[0].find("'bgr'"), std::string::npos) << told.err;
  EXPECT_EQ(load(path("other.exr")).text.at("triad:layout"), "rgb");
  expect_refusal({"compare", "other.exr", "--ref", "wide.exr", "-m", "display"}, {"'rgb'", "'bgr'", "layout="});
  const double wrong = compare({"other.exr", "--ref", "wide.exr", "-m", "display:layout=bgr"})[0]["scores"]["ratio"];
  EXPECT_GT(wrong, 1);  // its red and blue lie where they should not
}

TEST_F(Render, CropKeepsThePhaseOfThePanel) {
  half_plane(.3, .37).save(path("slant.gltf"));
  expect_success({"render", "slant.gltf", "-o", "wide.exr", "--size", "60x20", "--strategy", "grid:n=4", "--cells",
                  "pentile-rgbg"});
  // An odd number of pixels of a panel that repeats after two: red and blue would change places.
  expect_success({"run", "wide.exr", "platt", "crop:x=9,w=40", "-o", "shown.exr", "--depth", "float"});
  expect_success({"run", "wide.exr", "crop:x=18,w=80", "-o", "part.exr", "--depth", "float"});
  EXPECT_EQ(load(path("shown.exr")).text.at("triad:origin"), "9,0");
  EXPECT_EQ(load(path("part.exr")).text.at("triad:origin"), "9,0");
  const double ratio = compare({"shown.exr", "--ref", "part.exr", "-m", "display"})[0]["scores"]["ratio"];
  EXPECT_LT(ratio, 1);
  const double shifted =
      compare({"shown.exr", "--ref", "part.exr", "-m", "display:origin='1,0'"})[0]["scores"]["ratio"];
  EXPECT_GT(shifted, 2 * ratio);
}

TEST_F(Render, SameFileForAnyThreads) {
  const std::vector<std::string> render{
      "render", "lit.glb", "--size", "45x30",
      "--spp",  "8",       "--aov",  "depth,normal,albedo,object-id,variance,samples,position,material-id"};
  std::string first;
  for (const char* threads : {"1", "2", "7"}) {
    std::vector<std::string> each = render;
    each.insert(each.end(), {"-o", "t.exr", "--threads", threads});
    expect_success(each);
    if (first.empty()) first = load_text(path("t.exr"));
    EXPECT_EQ(load_text(path("t.exr")), first) << threads << " threads";
  }
  std::vector<std::string> other = render;
  other.insert(other.end(), {"-o", "t.exr", "--seed", "1"});
  expect_success(other);
  EXPECT_NE(load_text(path("t.exr")), first);
}

TEST_F(Render, SaysHowItWasMade) {
  const nlohmann::json record = expect_success({"render", "lit.glb", "-o", "a.exr", "--size", "20x10", "--spp", "32",
                                                "--seed", "5", "--camera", "low", "--json", "-"})
                                    .json();
  EXPECT_EQ(record["samples"], 32 * 20 * 10);
  EXPECT_EQ(record["work"]["camera rays"], 32 * 20 * 10);
  EXPECT_GT(record["work"]["shadow rays"], 0);
  EXPECT_GT(record["seconds"]["render"], 0);
  EXPECT_GT(record["rmse"], 0);
  EXPECT_EQ(record["complete"], true);
  EXPECT_EQ(record["passes"].size(), 2u);  // to 16, 32
  const Picture picture = load(path("a.exr"));
  EXPECT_EQ(picture.text.at("triad:scene"), "lit.glb");
  EXPECT_EQ(picture.text.at("triad:camera"), "low");
  EXPECT_EQ(picture.text.at("triad:strategy"), "sobol-owen:spp=32");
  EXPECT_EQ(picture.text.at("triad:seed"), "5");
  EXPECT_EQ(picture.text.at("triad:samples"), "6400");
  EXPECT_EQ(picture.text.at("triad:camera_rays"), "6400");
  EXPECT_EQ(picture.text.count("triad:partial"), 0u);
  for (const auto& [key, value] : picture.text) EXPECT_EQ(key.find("second"), std::string::npos) << key << value;
  // And what it was goes along through the chain.
  expect_success({"run", "a.exr", "box:x=2,y=2", "-o", "b.exr"});
  EXPECT_EQ(load(path("b.exr")).text.at("triad:scene"), "lit.glb");
}

TEST_F(Render, WritesOtherFormats) {
  expect_success({"render", "half.gltf", "-o", "a.png", "--size", "40x20"});
  EXPECT_NEAR(load(path("a.png")).at(0, 0, 1), srgb_encode(.4), .5 / 255 + 1e-6);
  expect_success({"render", "half.gltf", "-o", "a.exr", "--size", "40x20", "--depth", "half"});
  EXPECT_EQ(load(path("a.exr")).pixel_type, "half");
}

TEST_F(Render, StopsAtTheErrorAskedFor) {
  const nlohmann::json record =
      expect_success({"render", "lit.glb", "-o", "a.exr", "--size", "40x30", "--until", "rmse=.01", "--json", "-"})
          .json();
  EXPECT_EQ(record["until_reached"], true);
  EXPECT_LE(record["rmse"], .01);
  // The true error, against a render with other random numbers and an error of its own that is far smaller.
  expect_success({"render", "lit.glb", "-o", "truth.exr", "--size", "40x30", "--spp", "4096", "--seed", "77"});
  const double rmse = compare({"a.exr", "--ref", "truth.exr", "-m", "error"})[0]["scores"]["rmse"];
  EXPECT_LT(rmse, .011);
  EXPECT_GT(rmse, .01 / 8)
      << "it took far more samples than it had to";  // passes double, and the estimate is careful
  const Outcome outcome = expect_status(
      0, {"render", "lit.glb", "-o", "a.exr", "--size", "20x10", "--until", "rmse=1e-6", "--spp", "16"});
  EXPECT_NE(outcome.err.find("rmse=1e-6"), std::string::npos) << outcome.err;
}

TEST_F(Render, InterruptedKeepsWhatIsDone) {
  Options options;
  options.interrupt_when = [] { return seconds_of_child() > 1; };
  const Outcome outcome = expect_status(
      130, {"render", "half.gltf", "-o", "a.exr", "--size", "400x200", "--spp", "1000000", "--json", "a.json"},
      options);
  EXPECT_LT(outcome.seconds_after_interrupt, 3);
  EXPECT_EQ(outcome.error_lines().size(), 1u) << outcome.err;
  EXPECT_NE(outcome.err.find("'a.exr'"), std::string::npos) << outcome.err;
  const Picture picture = load(path("a.exr"));
  EXPECT_EQ(picture.text.at("triad:partial"), "true");
  EXPECT_FLOAT_EQ(picture.at(0, 0, 0), .8f);
  EXPECT_FLOAT_EQ(picture.at(10, 199, 0), .8f);
  EXPECT_EQ(picture.at(399, 199, 0), 0);
  EXPECT_EQ(files(), (std::set<std::string>{"a.exr", "a.json", "half.gltf", "lit.glb"}));
}

TEST_F(Render, FindsBundledScenesByName) {
  const auto pixels_of = [&](const std::string& scene) {
    expect_success({"render", scene, "-o", "a.exr", "--size", "32x18", "--spp", "2"});
    return load(path("a.exr"));
  };
  const Picture named = pixels_of("text"), read = pixels_of(TRIAD_SOURCE_DIR "/data/scenes/text.gltf");
  EXPECT_EQ(named.values, read.values);
  EXPECT_EQ(named.text.at("triad:scene"), "text");
  expect_refusal({"render", "cornel", "-o", "b.exr", "--size", "9x9"}, {"'cornel'", "'cornell'", "'texture'"});
  // A name without a dot may be a file's as well; a bundled scene's name means that.
  std::filesystem::copy(path("half.gltf"), path("half"));
  std::filesystem::copy(path("half.gltf"), path("text"));
  EXPECT_EQ(pixels_of("half").values, pixels_of("half.gltf").values);
  EXPECT_EQ(pixels_of("text").values, named.values);
  EXPECT_EQ(pixels_of("./text").values, pixels_of("half.gltf").values);
}

TEST_F(Render, RefusesInOneLine) {
  const auto refuse = [&](std::vector<std::string> rest, const std::vector<std::string>& words) {
    std::vector<std::string> arguments{"render", "half.gltf"};
    const bool out = std::find(rest.begin(), rest.end(), "-o") != rest.end();
    const bool size = std::find(rest.begin(), rest.end(), "--size") != rest.end();
    if (!out) arguments.insert(arguments.end(), {"-o", "a.exr"});
    if (!size) arguments.insert(arguments.end(), {"--size", "9x9"});
    arguments.insert(arguments.end(), rest.begin(), rest.end());
    expect_refusal(arguments, words);
  };
  refuse({"--size", "9"}, {"--size", "400x225"});
  refuse({"--size", "0x9"}, {"--size"});
  refuse({"--size", "2000000x2000000"}, {"GB", "--size"});
  refuse({"--size", "2147483647x1", "--cells", "3x1"}, {"--size", "--cells"});
  refuse({"--cells", "3"}, {"--cells", "3x1"});
  refuse({"--cells", "rbg"}, {"rbg"});
  refuse({"--spp", "0"}, {"--spp", "1 to"});
  refuse({"--spp", "4", "--strategy", "grid"}, {"--spp", "--strategy"});
  refuse({"--strategy", "gird"}, {"--strategy", "grid"});
  refuse({"--strategy", "grid:n=0"}, {"--strategy", "grid:n", "1 to 1024"});
  refuse({"--until", "1e-3"}, {"--until", "rmse=1e-3"});
  refuse({"--until", "rmse=1", "--strategy", "control"}, {"--until", "sobol-owen"});
  refuse({"--aov", "dept"}, {"--aov", "depth"});
  refuse({"--aov", "depth", "-o", "a.png"}, {"--aov", "exr"});
  refuse({"--effects", "mirrors"}, {"--effects", "mirror"});
  refuse({"--camera", "fron"}, {"front"});
  refuse({"--seed", "-1"}, {"--seed"});
  refuse({"--bounces", "-1"}, {"--bounces"});
  refuse({"--depth", "8"}, {"--depth"});
  refuse({"-o", "no/a.exr"}, {"no"});
  refuse({"-o", "a.xyz"}, {"xyz"});
  expect_refusal({"render", "none.gltf", "-o", "a.exr", "--size", "9x9"}, {"none.gltf"});
  expect_refusal({"render", "half.gltf", "--size", "9x9"}, {"--output"});
  expect_refusal({"render", "half.gltf", "-o", "a.exr"}, {"--size"});
  // A picture that fits nowhere is refused before the scene is even read.
  expect_refusal({"render", "none.gltf", "-o", "a.exr", "--size", "2000000x2000000"}, {"GB"});
}

TEST_F(Render, ItsRecordDestroysNothing) {
  const auto refuse = [&](const std::string& json, const std::vector<std::string>& words) {
    expect_refusal({"render", "half.gltf", "-o", "a.exr", "--size", "9x9", "--json", json}, words);
  };
  refuse("a.exr", {"--json", "'a.exr'", "another file"});
  refuse("./a.exr", {"--json", "another file"});
  refuse("half.gltf", {"--json", "'half.gltf'", "another file"});
  // Not after hours: the scene is not even looked for.
  expect_refusal({"render", "none.gltf", "-o", "a.exr", "--size", "9x9", "--json", "no/a.json"}, {"no/a.json"});
}

TEST_F(Render, RefusesSizesThatTheFormatCannotHold) {
  expect_refusal({"render", "half.gltf", "-o", "a.jpg", "--size", "70000x1"}, {"a.jpg", "65500", "70000x1"});
  // It is what comes out of the chain that counts, and that is named.
  const Outcome boxed = expect_success({"render", "half.gltf", "-o", "a.jpg", "--size", "30000x1", "--cells", "3x1",
                                        "--spp", "1", "--chain", "box:x=3"});
  EXPECT_NE(boxed.out.find("a.jpg: 30000x1,"), std::string::npos) << boxed.out;
  EXPECT_EQ(load(path("a.jpg")).width, 30000);
  std::filesystem::remove(path("a.jpg"));
  expect_refusal({"render", "half.gltf", "-o", "a.jpg", "--size", "30000x1", "--chain", "panel:layout=rgb,scale=3"},
                 {"a.jpg", "65500"});
}

TEST_F(Render, ExtremeShapesWork) {
  expect_success({"render", "half.gltf", "-o", "a.exr", "--size", "1x1", "--spp", "1"});
  expect_success({"render", "half.gltf", "-o", "a.exr", "--size", "100000x1", "--spp", "1"});
  expect_success({"render", "half.gltf", "-o", "a.exr", "--size", "1x100000", "--spp", "1"});
  EXPECT_EQ(load(path("a.exr")).height, 100000);
}

TEST_F(Render, StrategiesAreListedAndExplained) {
  const std::string list = expect_success({"list", "strategies"}).out;
  for (const char* name :
       {"control", "grid", "sobol-owen", "cells", "splat", "pov1", "pov4", "quad", "variance", "exact"}) {
    EXPECT_NE(list.find(name), std::string::npos) << list;
    EXPECT_NE(expect_success({"help", name}).out.find(name), std::string::npos);
  }
  EXPECT_NE(
      expect_success({"help", "splat"}).out.find("filter=gaussian  the reconstruction filter (box, box2, tent, "),
      std::string::npos);
  EXPECT_EQ(expect_success({"help", "grid", "--json"}).json()["parameters"][0]["name"], "n");
  // A line for the heading, then one for each.
  EXPECT_EQ(expect_success({"list", "strategies", "--json"}).json()["strategies"].size() + 1,
            static_cast<size_t>(std::count(list.begin(), list.end(), '\n')));
  const auto threshold = expect_success({"help", "variance", "--json"}).json()["parameters"][0];
  EXPECT_EQ(threshold["name"], "threshold");
  EXPECT_EQ(threshold["type"], "float");
  EXPECT_TRUE(threshold["max"].is_null()) << "no end";
}

}  // namespace
}  // namespace cli
