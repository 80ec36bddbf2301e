// SPDX-License-Identifier: Apache-2.0
// How a chain is executed: plans, strips, threads, frames, and chains in files.
#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

using Chain = Cli;

// Threads and rows of a strip: one alone, both odd, strips higher than the picture.
const std::vector<std::pair<std::string, std::string>> kCuts{
    {"1", "1"}, {"1", "64"}, {"2", "7"}, {"7", "1"}, {"7", "64"}};

TEST_F(Chain, GivesTheSameBitsForAnyThreadsAndStrips) {
  save(path("wide.exr"), noise(3 * 67, 83));
  const std::vector<std::vector<std::string>> chains{{"platt"},
                                                     {"platt:mode=plane"},
                                                     {"displaced-box"},
                                                     {"platt:range=clip,engine=fft"},
                                                     {"platt:range=clip,engine=fir,taps=31"},
                                                     {"subpixel"},
                                                     {"box:x=3,y=2", "crop:x=1,y=2,w=50,h=30"}};
  for (const auto& chain : chains) {
    std::vector<std::string> arguments{"run", "wide.exr", "--cells", "3x1"};
    arguments.insert(arguments.end(), chain.begin(), chain.end());
    arguments.insert(arguments.end(), {"-o", "out.exr", "--depth", "float"});
    expect_success(arguments);
    const std::vector<float> expected = load(path("out.exr")).values;
    for (const auto& [threads, rows] : kCuts) {
      std::filesystem::remove(path("out.exr"));
      std::vector<std::string> again = arguments;
      again.insert(again.end(), {"--threads", threads, "--strip-rows", rows});
      expect_success(again);
      EXPECT_EQ(load(path("out.exr")).values, expected) << chain[0] << " threads " << threads << " rows " << rows;
    }
  }
}

TEST_F(Chain, ScoresTheSameForAnyThreadsAndStrips) {
  save(path("wide.exr"), noise(3 * 67, 83));
  save(path("shown.exr"), noise(67, 83, 3, 2));
  save(path("other.exr"), noise(67, 83, 3, 3));
  std::set<std::string> display, error;
  for (const auto& [threads, rows] : kCuts) {
    const auto scores = [&](std::vector<std::string> arguments) {
      arguments.insert(arguments.end(), {"--threads", threads, "--strip-rows", rows});
      return compare(arguments)[0]["scores"].dump();
    };
    display.insert(scores({"shown.exr", "--ref", "wide.exr", "--ref-cells", "3x1", "-m", "display"}));
    error.insert(scores({"shown.exr", "--ref", "other.exr", "-m", "error"}));
  }
  EXPECT_EQ(display.size(), 1u);
  EXPECT_EQ(error.size(), 1u);
}

TEST_F(Chain, ExplainsWithoutTouchingAPixel) {
  save(path("whole.exr"), noise(300, 200));
  truncate_copy(path("whole.exr"), path("cut.exr"), .3);
  expect_refusal({"run", "cut.exr", "--cells", "3x1", "platt", "-o", "out.png"}, {"cut.exr"});
  const Outcome outcome = expect_success({"run", "cut.exr", "--cells", "3x1", "platt", "-o", "out.png", "--explain"});
  for (const std::string word : {"platt", "300x200", "100x200", "srgb", "MB"})
    EXPECT_NE(outcome.out.find(word), std::string::npos) << word << " is not in:\n" << outcome.out;
  EXPECT_FALSE(exists("out.png"));
}

TEST_F(Chain, SaysHowMuchMemoryItWouldTake) {
  save(path("in.exr"), noise(6, 2));
  expect_refusal({"run", "in.exr", "resample:width=500000000,height=1", "-o", "out.exr"}, {"in.exr", "--max-memory"});
}

TEST_F(Chain, RunsFramesInOneCall) {
  for (const int frame : {1, 2, 11})
    save(path("in.00" + std::string(frame < 10 ? "0" : "") + std::to_string(frame) + ".exr"),
         constant(6, 2, {static_cast<float>(frame) / 16, 0, 1}));
  expect_success({"run", "in.####.exr", "box:x=3", "-o", "out.####.exr"});
  for (const std::string frame : {"0001", "0002", "0011"}) {
    const Picture out = load(path("out." + frame + ".exr"));
    EXPECT_EQ(out.width, 2);
    EXPECT_EQ(out.at(1, 1, 0), std::stof(frame) / 16) << frame;
  }
  EXPECT_EQ(files().size(), 6u);
}

TEST_F(Chain, RefusesFramesThatCannotBe) {
  expect_refusal({"run", "in.####.exr", "-o", "out.####.exr"}, {"in.####.exr"});
  save(path("in.0001.exr"), noise(4, 4));
  save(path("in.0002.exr"), noise(4, 4));
  expect_refusal({"run", "in.####.exr", "-o", "out.exr"}, {"out.exr", "#"});
}

TEST_F(Chain, KeepsIntermediatePictures) {
  save(path("in.exr"), noise(12, 6));
  expect_success({"run", "in.exr", "write:first.exr", "box:x=2", "write:second.png", "box:x=2", "-o", "third.exr"});
  EXPECT_EQ(load(path("first.exr")).width, 12);
  EXPECT_EQ(load(path("second.png")).width, 6);
  EXPECT_EQ(load(path("third.exr")).width, 3);
}

TEST_F(Chain, IsTheSameInAFile) {
  save(path("wide.exr"), noise(60, 12));
  save(path("ref.exr"), noise(8, 6, 3, 2));
  save_text(path("chain.toml"),
            "[[stage]]\nname = \"platt\"\nppd = 55.5\nlayout = \"bgr\"\n\n"
            "[[stage]]\nwrite = \"filed-mid.exr\"\n\n"
            "[[stage]]\nname = \"crop\"\nx = 4\ny = 2\nw = 8\nh = 6\n\n"
            "[[metric]]\nname = \"error\"\nlabel = \"plain\"\n");
  const std::vector<std::string> common{"run",     "wide.exr", "--cells", "3x1",    "--ref",
                                        "ref.exr", "--depth",  "float",   "--json", "-"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), common.begin(), common.end());
    return expect_success(more).json()["results"][0];
  };
  const nlohmann::json filed = with({"--chain", "chain.toml", "-o", "filed.exr"});
  const nlohmann::json typed = with({"platt:ppd=55.5,layout=bgr", "write:typed-mid.exr", "crop:x=4,y=2,w=8,h=6", "-m",
                                     "error@plain", "-o", "typed.exr"});
  EXPECT_EQ(filed["scores"], typed["scores"]);
  EXPECT_EQ(filed["label"], "plain");
  EXPECT_EQ(load(path("filed.exr")).values, load(path("typed.exr")).values);
  EXPECT_EQ(load(path("filed-mid.exr")).values, load(path("typed-mid.exr")).values);
  EXPECT_EQ(load(path("filed.exr")).width, 8);
}

TEST_F(Chain, StaysWithinItsMemory) {
  save(path("in.exr"), noise(3000, 600), "half");
  expect_success({"run", "in.exr", "--cells", "3x1", "platt:range=clip,engine=fir,taps=31", "-o", "out.exr",
                  "--max-memory", "160M"});
  EXPECT_EQ(load(path("out.exr")).width, 1000);
  expect_refusal({"run", "in.exr", "--cells", "3x1", "platt", "-o", "no.exr", "--max-memory", "4K"},
                 {"--max-memory"});
  // The plane takes the whole picture: what it needs is known beforehand, and what would do is said.
  expect_refusal({"run", "in.exr", "--cells", "3x1", "platt:mode=plane", "-o", "no.exr", "--max-memory", "160M"},
                 {"in.exr", "--max-memory", "would do"});
}

TEST_F(Chain, TellsHowGoodTheDisplayableOptimumIs) {
  save(path("wide.exr"), noise(3 * 67, 83));
  for (const std::string stage : {"platt", "platt:mode=plane", "platt:iterations=12,tolerance=0"}) {
    std::set<std::string> told;
    for (const auto& [threads, rows] : kCuts) {
      expect_success({"run", "wide.exr", "--cells", "3x1", stage, "box:x=1,y=3", "-o", "out.exr", "--json",
                      "told.json", "--threads", threads, "--strip-rows", rows});
      const auto reports = nlohmann::json::parse(load_text(path("told.json")))["runs"][0]["stages"][0]["reports"];
      EXPECT_GE(reports["gap"].get<double>(), 0) << reports.dump();
      EXPECT_LE(reports["gap"].get<double>(), .1) << reports.dump();
      EXPECT_LE(reports["rmse"].get<double>(), reports["rmse-displaced-box"].get<double>());
      EXPECT_EQ(reports["clamped-inputs"].get<double>(), 0);
      told.insert(std::to_string(reports["iterations"].get<int>()));
    }
    EXPECT_EQ(told.size(), 1u) << stage;
  }
}

}  // namespace
}  // namespace cli
