// SPDX-License-Identifier: Apache-2.0
// `triad compare` of many pictures: which are taken and paired, the ranking, maps in colours, sheets, and what
// becomes of pictures that fail.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class CompareMany : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    fs::create_directories(folder_ / "renders");
    grey("ref.exr", .5);
    grey("renders/far.exr", 1);
    grey("renders/near.exr", .5625);
    grey("renders/mid.exr", .25);
  }

  void grey(const std::string& name, double value) const {
    const auto v = static_cast<float>(value);
    save(path(name), constant(6, 4, {v, v, v}));
  }
  std::vector<std::string> tests_of(const std::vector<std::string>& arguments) const {
    std::vector<std::string> list;
    for (const auto& result : compare(arguments)) list.push_back(result["test"]);
    return list;
  }
  static std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }
};

TEST_F(CompareMany, ExpandsPatternsAndFolders) {
  save_text(path("renders/notes.txt"), "not a picture");
  const std::vector<std::string> end{"--ref", "ref.exr", "-m", "error"};
  const auto with = [&](std::vector<std::string> tests) {
    tests.insert(tests.end(), end.begin(), end.end());
    return tests_of(tests);
  };
  EXPECT_THAT(with({"renders/*.exr"}), ElementsAre("renders/far.exr", "renders/mid.exr", "renders/near.exr"));
  EXPECT_THAT(with({"renders/*"}), ElementsAre("renders/far.exr", "renders/mid.exr", "renders/near.exr"));
  EXPECT_THAT(with({"renders"}), ElementsAre("renders/far.exr", "renders/mid.exr", "renders/near.exr"));
  EXPECT_THAT(with({"renders/near.exr", "renders/[mn]*.exr"}), ElementsAre("renders/near.exr", "renders/mid.exr"));
  // A name is a name before it is a pattern.
  grey("renders/[mn]x.exr", .5);
  EXPECT_THAT(with({"renders/[mn]x.exr"}), ElementsAre("renders/[mn]x.exr"));
  expect_refusal({"compare", "nothing/*.exr", "--ref", "ref.exr", "-m", "error"}, {"'nothing/*.exr'", "no file"});
  fs::create_directory(folder_ / "empty");
  expect_refusal({"compare", "empty", "--ref", "ref.exr", "-m", "error"}, {"'empty'", "no picture"});
  expect_refusal({"compare", "ref.exr", "--ref", "renders/*.exr", "-m", "error"}, {"--ref", "folder"});
}

TEST_F(CompareMany, LeavesTheReferenceItselfOut) {
  grey("renders/truth.exr", .5);
  const Outcome outcome =
      expect_status(0, {"compare", "renders/*.exr", "--ref", "renders/truth.exr", "-m", "error", "--json", "-"});
  EXPECT_EQ(outcome.json()["results"].size(), 3u);
  EXPECT_THAT(outcome.err, HasSubstr("renders/truth.exr"));
  EXPECT_EQ(compare({"ref.exr", "--ref", "ref.exr", "-m", "error"})[0]["scores"]["max"], 0);
}

TEST_F(CompareMany, RanksTheBestFirst) {
  const Outcome outcome = expect_success(
      {"compare", "renders/*.exr", "--ref", "ref.exr", "-m", "error", "--json", "r.json", "--table", "t.csv"});
  const auto lines = lines_of(outcome.out);
  ASSERT_EQ(lines.size(), 5u) << outcome.out;
  EXPECT_THAT(lines[0], HasSubstr("mae"));
  EXPECT_THAT(lines[2], HasSubstr("near.exr"));
  EXPECT_THAT(lines[3], HasSubstr("mid.exr"));
  EXPECT_THAT(lines[4], HasSubstr("far.exr"));
  const auto json = nlohmann::json::parse(load_text(path("r.json")));
  const auto& order = json["ranking"][0]["order"];
  EXPECT_EQ(order[0]["test"], "renders/near.exr");
  EXPECT_EQ(order[0]["value"], .0625);
  EXPECT_EQ(order[2]["rank"], 3);
  // The table keeps the order of the pictures.
  const auto rows = lines_of(load_text(path("t.csv")));
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_THAT(rows[0], HasSubstr("test,reference"));
  EXPECT_THAT(rows[0], HasSubstr("error.rmse"));
  EXPECT_THAT(rows[1], testing::StartsWith("renders/far.exr,ref.exr,"));
  EXPECT_THAT(rows[1], HasSubstr(",0.5,"));
}

TEST_F(CompareMany, SortsByTheScoreThatIsNamed) {
  const std::vector<std::string> start{"compare", "renders/*.exr", "--ref", "ref.exr", "-m", "error"};
  const auto order = [&](const std::string& key) {
    std::vector<std::string> arguments = start;
    arguments.insert(arguments.end(), {"--sort", key, "--json", "-"});
    std::vector<std::string> names;
    const auto json = expect_success(arguments).json();
    for (const auto& entry : json["ranking"][0]["order"]) names.push_back(fs::path(entry["test"]).stem());
    return names;
  };
  EXPECT_THAT(order("error.psnr"), ElementsAre("near", "mid", "far"));
  grey("renders/mid.exr", .46875);  // now the nearest
  EXPECT_THAT(order("error.bias"), ElementsAre("mid", "near", "far"));
  for (const auto& [key, words] :
       std::map<std::string, std::vector<std::string>>{{"error.rsme", {"--sort", "rsme", "'rmse'"}},
                                                       {"eror.rmse", {"--sort", "'error'"}},
                                                       {"rmse", {"--sort"}}}) {
    std::vector<std::string> arguments = start;
    arguments.insert(arguments.end(), {"--sort", key});
    expect_refusal(arguments, words);
  }
}

TEST_F(CompareMany, CutsTheListButNotTheFiles) {
  const std::vector<std::string> start{"compare", "renders/*.exr", "--ref", "ref.exr", "-m", "error"};
  const auto out = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = start;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return expect_success(arguments).out;
  };
  const std::string one = out({"--top", "1", "--csv", "r.csv"});
  EXPECT_THAT(one, HasSubstr("near.exr"));
  EXPECT_THAT(one, Not(HasSubstr("far.exr")));
  EXPECT_THAT(one, HasSubstr("2 more"));
  EXPECT_THAT(load_text(path("r.csv")), HasSubstr("far.exr"));
  EXPECT_EQ(out({"--quiet"}), "");
}

TEST_F(CompareMany, SameScoresAsOneAtATime) {
  for (const char* name : {"a", "b"}) save(path(std::string(name) + ".exr"), noise(70, 131, 3, name[0]));
  save(path("truth.exr"), noise(70, 131, 3, 7));
  const auto both = compare({"a.exr", "b.exr", "--ref", "truth.exr", "-m", "error"});
  EXPECT_EQ(both[0]["scores"], compare({"a.exr", "--ref", "truth.exr", "-m", "error"})[0]["scores"]);
  EXPECT_EQ(both[1]["scores"], compare({"b.exr", "--ref", "truth.exr", "-m", "error"})[0]["scores"]);
}

TEST_F(CompareMany, FramesAreWorstFirstWithTheirMean) {
  for (int f = 1; f <= 3; ++f) {
    grey("shot.00" + std::to_string(f) + ".exr", .5 + (f == 2 ? .25 : .0625));
    grey("truth.00" + std::to_string(f) + ".exr", .5);
  }
  const Outcome outcome = expect_success(
      {"compare", "shot.###.exr", "--ref", "truth.###.exr", "-m", "error", "--top", "1", "--json", "r.json"});
  const auto lines = lines_of(outcome.out);
  ASSERT_EQ(lines.size(), 5u) << outcome.out;
  EXPECT_THAT(lines[2], HasSubstr("shot.002.exr"));
  EXPECT_THAT(lines[3], HasSubstr("mean of 3 frames; worst is 2"));
  EXPECT_THAT(lines[3], HasSubstr("0.125"));  // (1/4 + 2/16) / 3
  EXPECT_THAT(lines[4], HasSubstr("2 more"));
  const auto json = nlohmann::json::parse(load_text(path("r.json")));
  EXPECT_EQ(json["sequences"][0]["frames"][0]["frame"], 2);
  EXPECT_EQ(json["sequences"][0]["mean"]["mae"], .125);
  EXPECT_EQ(json["results"][2]["reference"], "truth.003.exr");
}

TEST_F(CompareMany, MissingFramesAreListed) {
  for (const int f : {1, 2, 3, 5, 8}) grey("shot." + std::to_string(f) + ".exr", .5);
  for (const int f : {1, 5, 6, 7}) grey("truth." + std::to_string(f) + ".exr", .25);
  const std::vector<std::string> start{"compare", "shot.#.exr", "--ref", "truth.#.exr", "-m", "error"};
  expect_refusal(start, {"'truth.#.exr' lacks 2-3, 8", "'shot.#.exr' lacks 6-7", "--skip-missing"});
  std::vector<std::string> skip = start;
  skip.insert(skip.end(), {"--skip-missing", "--json", "-"});
  const Outcome outcome = expect_status(0, skip);
  EXPECT_EQ(outcome.json()["results"].size(), 2u);
  EXPECT_THAT(outcome.err, HasSubstr("lacks 2-3, 8"));
}

TEST_F(CompareMany, FindsReferencesByNameInAFolder) {
  fs::create_directories(folder_ / "approved");
  grey("approved/far.exr", 1);
  grey("approved/near.exr", .5);
  save(path("approved/mid.png"), constant(6, 4, {1, 1, 1}), "uint8");  // the same stem will do
  const auto results = compare({"renders", "--ref", "approved/", "-m", "error"});
  ASSERT_EQ(results.size(), 3u);
  EXPECT_EQ(results[0]["scores"]["mae"], 0);
  EXPECT_EQ(results[1]["scores"]["mae"], .75);
  EXPECT_EQ(results[1]["reference"], "approved/mid.png");
  EXPECT_EQ(results[2]["scores"]["mae"], .0625);
  fs::remove(folder_ / "approved/near.exr");
  grey("approved/old.exr", 1);
  expect_refusal({"compare", "renders", "--ref", "approved", "-m", "error"}, {"renders/near.exr", "--skip-missing"});
  EXPECT_EQ(compare({"renders/far.exr", "--ref", "approved", "-m", "error"}).size(), 1u);
  const Outcome skipped =
      expect_status(0, {"compare", "renders", "--ref", "approved", "-m", "error", "--skip-missing", "--json", "-"});
  EXPECT_EQ(skipped.json()["results"].size(), 2u);
  EXPECT_THAT(skipped.err, HasSubstr("approved/old.exr"));
}

TEST_F(CompareMany, OneThatFailsDoesNotStopTheOthers) {
  save_text(path("renders/bad.exr"), "no picture");
  save(path("renders/small.exr"), constant(5, 4, {1, 1, 1}));
  const Outcome outcome = expect_status(2, {"compare", "renders/*.exr", "--ref", "ref.exr", "-m", "error", "--json",
                                            "r.json", "--fail-above", "error.mae=0.2", "--table", "t.csv"});
  // Two that cannot be compared, two over the limit.
  const auto lines = outcome.error_lines();
  ASSERT_EQ(lines.size(), 4u) << outcome.err;
  EXPECT_THAT(lines[0], HasSubstr("renders/bad.exr"));
  EXPECT_THAT(lines[1], testing::AllOf(HasSubstr("5x4"), HasSubstr("6x4"), HasSubstr("renders/small.exr")));
  EXPECT_THAT(lines[2], HasSubstr("renders/far.exr: error.mae is 0.5, above 0.2"));
  EXPECT_THAT(lines[3], HasSubstr("renders/mid.exr: error.mae is 0.25, above 0.2"));
  const auto json = nlohmann::json::parse(load_text(path("r.json")));
  EXPECT_EQ(json["failed"].size(), 2u);
  EXPECT_EQ(json["failed"][0]["test"], "renders/bad.exr");
  EXPECT_EQ(lines_of(load_text(path("t.csv"))).size(), 6u);
  EXPECT_THAT(outcome.out, HasSubstr("FAILED"));
}

TEST_F(CompareMany, ExitsWithOneOverALimitAlone) {
  const std::vector<std::string> start{"compare", "renders/*.exr", "--ref", "ref.exr", "-m", "error", "--quiet"};
  const auto run = [&](const std::string& limit) {
    std::vector<std::string> arguments = start;
    arguments.insert(arguments.end(), {"--fail-above", limit});
    return triad(arguments);
  };
  EXPECT_EQ(run("error.mae=.5").status, 0);
  const Outcome crossed = run("error.mae=.49");
  EXPECT_EQ(crossed.status, 1);
  EXPECT_EQ(crossed.error_lines().size(), 1u) << crossed.err;
}

// A page holds its pictures: 20 bytes a pixel of each, and what packing takes.
TEST_F(CompareMany, ReportsStayWithinTheMemory) {
  save_claim(path("renders/large.tif"), 2000, 2000);  // whole and black
  const std::vector<std::string> start{"compare", "renders/*", "--ref", "ref.exr", "-m", "error"};
  std::vector<std::string> with_report = start;
  with_report.insert(with_report.end(), {"--report", "page.html", "--max-memory", "300M"});
  if (triad({"compare", "ref.exr", "--ref", "ref.exr", "-m", "error", "--report", "p.html"}).status != 0)
    GTEST_SKIP() << "built without the viewer";
  // Before the work: the pictures are not judged, nor are files left.
  expect_refusal(with_report, {"a report of 5 pictures", "--max-memory", "M would do"});
  fs::remove(path("renders/large.tif"));
  expect_success(with_report);
  expect_success({"compare", "ref.exr", "--ref", "ref.exr", "-m", "error", "--json", "s.json"});
  expect_refusal({"report", "s.json", "--max-memory", "100M"},
                 {"a report of 2 pictures", "--max-memory 14", "M would"});
  expect_refusal({"report", "s.json", "--max-memory", "much"}, {"--max-memory", "much"});
  expect_success({"report", "s.json", "--max-memory", "160M"});
}

TEST_F(CompareMany, SaysThatAReferenceIsBlack) {
  grey("black.exr", 0);
  const Outcome outcome = expect_status(0, {"compare", "renders/*.exr", "--ref", "black.exr", "-m", "error", "-q"});
  EXPECT_EQ(outcome.error_lines().size(), 1u) << outcome.err;
  EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("'black.exr'"), HasSubstr("black: all")));
}

TEST_F(CompareMany, PicturesOfNothingButNanSaySo) {
  save(path("nan.exr"), from_function(6, 4, 3, [](int, int, int) { return std::nan(""); }));
  const Outcome failed = expect_status(1, {"compare", "nan.exr", "--ref", "ref.exr", "-m", "error", "-q"});
  EXPECT_THAT(failed.err, testing::AllOf(HasSubstr("nan.exr"), HasSubstr("72 NaN")));
  expect_refusal({"compare", "nan.exr", "--ref", "ref.exr", "-m", "error", "--nan", "ignore"}, {"nan.exr"});
}

// The map of `error` has three channels; a picture of their mean, in the colours of the map.
TEST_F(CompareMany, MapsAreFloatsOrColours) {
  save(path("a.exr"), from_function(6, 4, 3, [](int x, int, int c) { return .5 + (c == 0 ? x * .03 : 0); }));
  expect_success({"compare", "a.exr", "--ref", "ref.exr", "-m", "error", "--map", "m.exr"});
  const Picture floats = load(path("m.exr"));
  EXPECT_EQ(floats.pixel_type, "float");
  EXPECT_NEAR(floats.at(5, 0, 0), .15, 1e-6);
  expect_success({"compare", "a.exr", "--ref", "ref.exr", "-m", "error", "--map", "m.png", "--map-scale", "0:0.05"});
  const Picture colours = load(path("m.png"));
  ASSERT_EQ(colours.width, 6);
  ASSERT_EQ(colours.height, 4);
  EXPECT_EQ(colours.pixel_type, "uint8");
  const auto expect_code = [&](int x, int red, int green, int blue) {
    const int want[] = {red, green, blue};
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(colours.at(x, 2, c) * 255, want[c], 1.01) << x << " channel " << c;
  };
  expect_code(0, 0, 0, 4);        // magma's first,
  expect_code(5, 252, 253, 191);  // and last, at a mean of .15 / 3
  EXPECT_EQ(files().count("m.png"), 1u);
  for (const std::string& name : files()) EXPECT_THAT(name, Not(HasSubstr(".triad"))) << "left behind";
  expect_success(
      {"compare", "a.exr", "--ref", "ref.exr", "-m", "error", "--map", "v.png", "--colour-map", "viridis"});
  EXPECT_NEAR(load(path("v.png")).at(0, 0, 0) * 255, 68, 1.01);
}

TEST_F(CompareMany, MapsShareAScaleUnlessTold) {
  const std::vector<std::string> start{"compare", "renders/*.exr", "--ref",        "ref.exr", "-m",     "error",
                                       "--map",   "maps/",         "--map-format", "png",     "--json", "-"};
  const auto highs = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = start;
    arguments.insert(arguments.end(), more.begin(), more.end());
    std::vector<double> list;
    const auto json = expect_success(arguments).json();
    for (const auto& file : json["files"]) list.push_back(file["scales"]["error"]["high"]);
    return list;
  };
  EXPECT_THAT(highs({}), ElementsAre(.5, .5, .5));
  EXPECT_THAT(highs({"--map-scale", "each"}), ElementsAre(.5, .25, .063));
  EXPECT_THAT(highs({"--map-scale", "0:2"}), ElementsAre(2, 2, 2));
  EXPECT_TRUE(exists("maps/near.error.png"));
}

// Stops: the exposure at which a pixel is worst. Of light that is bright, they are all below 0.
TEST_F(CompareMany, MapsWithValuesBelowZeroSpanWhatTheyHold) {
  const auto light = [&](const std::string& name, double error) {
    save(path(name), from_function(24, 16, 3, [&](int x, int y, int) {
           return std::exp2(4 + x % 5) * (1 + error * ((x * 7 + y * 3) % 4));
         }));
  };
  light("light.exr", 0);
  light("a.exr", .2);
  light("b.exr", .01);
  const auto json =
      expect_success({"compare", "a.exr", "b.exr", "--ref", "light.exr", "-m", "flip:mode=hdr,map=exposure", "--map",
                      "maps/", "--map-format", "png", "--sheet", "maps/", "--json", "-"})
          .json();
  expect_success(
      {"compare", "a.exr", "b.exr", "--ref", "light.exr", "-m", "flip:mode=hdr,map=exposure", "--map", "floats/"});
  float least = 1e9f, greatest = -1e9f;
  for (const std::string name : {"floats/a.flip.exr", "floats/b.flip.exr"})
    for (const float stops : load(path(name)).values) {
      least = std::min(least, stops);
      greatest = std::max(greatest, stops);
    }
  ASSERT_LT(least, greatest);
  ASSERT_LT(greatest, 0);
  ASSERT_EQ(json["files"].size(), 4u);
  for (const auto& file : json["files"]) {
    // Two digits, outwards.
    EXPECT_LE(file["scales"]["flip"]["low"], least);
    EXPECT_NEAR(file["scales"]["flip"]["low"], least, .051 * std::abs(least));
    EXPECT_GE(file["scales"]["flip"]["high"], greatest);
    EXPECT_NEAR(file["scales"]["flip"]["high"], greatest, .051 * std::abs(greatest));
  }
  float brightest = 0;
  for (const std::string name : {"maps/a.flip.png", "maps/b.flip.png"})
    for (const float code : load(path(name)).values) brightest = std::max(brightest, code);
  EXPECT_GT(brightest, .9f);
}

TEST_F(CompareMany, AMetricMaySayHowFarItsMapReaches) {
  expect_success({"compare", "renders/far.exr", "--ref", "ref.exr", "-m", "bounded-map", "--plugin-path",
                  TRIAD_BOUNDED_PLUGIN, "--map", "m.png"});
  const Picture map = load(path("m.png"));
  const int want[] = {81, 18, 124};  // entry 64 of magma, a quarter of the way to 2
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(map.at(3, 2, c) * 255, want[c], 1.01) << c;
}

TEST_F(CompareMany, MapOptionsThatDoNotGoTogetherAreRefused) {
  const std::vector<std::string> start{"compare", "renders/far.exr", "--ref", "ref.exr", "-m", "error"};
  const auto refuse = [&](const std::vector<std::string>& more, const std::vector<std::string>& words) {
    std::vector<std::string> arguments = start;
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_refusal(arguments, words);
  };
  refuse({"--map", "m.exr", "--map-format", "png"}, {"m.exr", "--map-format"});
  refuse({"--map", "m/", "--map-format", "tif"}, {"--map-format", "tif"});
  refuse({"--map", "m.png", "--map-scale", "1:0"}, {"--map-scale", "1:0"});
  refuse({"--map", "m.png", "--map-scale", "all"}, {"--map-scale", "common"});
  refuse({"--map", "m.png", "--colour-map", "jet"}, {"--colour-map", "jet"});
  refuse({"--map", "m.png", "--sheet", "m.png"}, {"m.png", "overwrite"});
  refuse({"--sheet", "ref.exr"}, {"--sheet", ".png"});
  // A name in a folder that is one of the pictures.
  grey("renders/far.error.exr", .5);
  refuse({"renders/far.error.exr", "--map", "renders/"}, {"renders/far.error.exr", "overwrite"});
}

TEST_F(CompareMany, SheetsShowReferenceTestAndMap) {
  // Six cells wide for two pixels of the test: each shown pixel is the mean of three.
  save(path("wide.exr"), from_function(300, 70, 3, [](int x, int, int) { return x % 3 == 0 ? .3 : 0; }));
  save(path("shown.exr"), constant(100, 70, {.2f, .2f, .2f}));
  expect_success({"compare", "shown.exr", "--ref", "wide.exr", "--ref-cells", "3x1", "-m", "display:ppd=40",
                  "--sheet", "sheet.png", "--map-scale", "0:1", "--exposure", "1"});
  const Picture sheet = load(path("sheet.png"));
  EXPECT_EQ(sheet.width, 3 * 100 + 2 * 8);
  EXPECT_GT(sheet.height, 70);
  for (const int y : {0, 64, 69}) {
    EXPECT_NEAR(sheet.at(50, y, 0), srgb_encode(.2), 3e-3) << y;        // 2 * .3 / 3
    EXPECT_NEAR(sheet.at(108 + 50, y, 1), srgb_encode(.4), 3e-3) << y;  // 2 * .2
  }
  EXPECT_NEAR(sheet.at(104, 10, 0) * 255, 46, .1);  // between the two
  // Highlights are bent, not cut: .75 + .25 * 1 / 1.25 of light for 1.75.
  save(path("bright.exr"), constant(100, 70, {1.75f, 1.75f, 1.75f}));
  save(path("dark.exr"), constant(100, 70, {.25f, .25f, .25f}));
  expect_success({"compare", "bright.exr", "--ref", "dark.exr", "-m", "error", "--sheet", "sheet.png"});
  EXPECT_NEAR(load(path("sheet.png")).at(150, 10, 0), srgb_encode(.95), 3e-3);
  EXPECT_NEAR(load(path("sheet.png")).at(50, 10, 0), srgb_encode(.25), 3e-3);
}

TEST_F(CompareMany, EncodedPicturesAreShownAsTheyAre) {
  save(path("a.png"), constant(20, 10, {1, 200 / 255.f, 0}), "uint8");
  save(path("b.png"), constant(20, 10, {1, 100 / 255.f, 0}), "uint8");
  expect_success({"compare", "a.png", "--ref", "b.png", "-m", "error", "--sheet", "sheets/"});
  const Picture sheet = load(path("sheets/a.sheet.png"));
  EXPECT_NEAR(sheet.at(5, 5, 1) * 255, 100, .6);
  EXPECT_NEAR(sheet.at(33, 5, 0) * 255, 255, .6);
  EXPECT_NEAR(sheet.at(33, 5, 1) * 255, 200, .6);
}

}  // namespace
}  // namespace cli
