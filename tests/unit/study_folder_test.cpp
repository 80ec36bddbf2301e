// SPDX-License-Identifier: Apache-2.0
// A study's folder: what is kept comes back to the last bit, and nothing of another study gets in.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <triad/base/error.hpp>
#include <triad/evaluation/study_folder.hpp>

namespace fs = std::filesystem;
using namespace triad;
using testing::HasSubstr;

namespace {

class StudyFolders : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("triad-study-folder-" + std::to_string(getpid()));
    fs::create_directories(folder_);
    plan_.work = "w";
    plan_.file = "plan.toml";
    plan_.repeats = 2;
    plan_.axes = {{"n", {"a", "b"}, {{{"x", "1"}}, {{"x", "2"}}}}};
  }
  void TearDown() override { fs::remove_all(folder_); }

  StudyFolder open(const std::string& name = "out") const {
    return StudyFolder(folder_ / name, plan_, study_settings(plan_), facts_, files_);
  }
  // What is said of a folder that cannot be opened.
  std::string refusal(const std::string& name = "out") const {
    try {
      open(name);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      return error.what();
    }
    return "accepted";
  }

  fs::path folder_;
  StudyPlan plan_;
  StudySettings facts_{{"threads", "2"}};
  StudySettings files_{{"scene.gltf", "first"}};
};

TEST_F(StudyFolders, GiveBackWhatTheyKeep) {
  const Measurements measured{{"seconds", .1},
                              {"tiny", 5e-324},
                              {"odd name, \"quoted\"", 1. / 3},
                              {"inf", std::numeric_limits<double>::infinity()},
                              {"nan", std::nan("")}};
  open().keep({1, 3}, measured);
  const StudyFolder again = open();
  const auto found = again.find({1, 3});
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), measured.size());
  for (size_t i = 0; i < measured.size(); ++i) {
    EXPECT_EQ((*found)[i].first, measured[i].first);
    if (!std::isnan(measured[i].second)) {
      EXPECT_EQ((*found)[i].second, measured[i].second);
    }
  }
  EXPECT_TRUE(std::isnan(found->back().second));
  EXPECT_FALSE(again.find({0, 3}));
  EXPECT_FALSE(again.find({1, 2}));
}

TEST_F(StudyFolders, KnowNamesAgainThatAreNoUtf8) {
  files_[0].first = "gr\xfcn.gltf";
  facts_[0].second = "\xff";
  open().keep({0, 0}, {{"seconds", 1}});
  EXPECT_EQ(refusal(), "accepted");
  EXPECT_TRUE(open().find({0, 0}));
  std::ostringstream plan;
  plan << std::ifstream(folder_ / "out/plan.json").rdbuf();
  EXPECT_THAT(plan.str(), HasSubstr("gr\\\\xfcn.gltf"));  // the backslash is itself escaped
  files_[0].first = "gr\xf6n.gltf";                       // another file, not the same question mark
  EXPECT_THAT(refusal(), HasSubstr("had no part"));
}

TEST_F(StudyFolders, TakeARunThatCannotBeReadAsNotThere) {
  open().keep({0, 0}, {{"seconds", 1}});
  std::ofstream(folder_ / "out/runs/0-0000.json") << "{\"measured\": {\"sec";
  EXPECT_FALSE(open().find({0, 0}));
}

TEST_F(StudyFolders, TakeARunThatWasTamperedWithAsNotThere) {
  open().keep({0, 0}, {{"seconds", 1}, {"rmse", 2}});
  const fs::path file = folder_ / "out/runs/0-0000.json";
  ASSERT_TRUE(open().find({0, 0}));
  fs::copy_file(file, folder_ / "out/runs/0-0001.json");
  EXPECT_FALSE(open().find({1, 0})) << "of another setting";
  fs::copy_file(file, folder_ / "out/runs/1-0000.json");
  EXPECT_FALSE(open().find({0, 1})) << "of another turn";
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  std::string without = text.str();
  const size_t comma = without.find(',', without.find("\"seconds\""));
  ASSERT_NE(comma, std::string::npos);
  without.erase(comma, without.find('}', comma) - comma);  // "rmse": 2
  std::ofstream(file) << without;
  EXPECT_FALSE(open().find({0, 0})) << without;
}

TEST_F(StudyFolders, RefuseFilesThatHaveChanged) {
  { open(); }
  EXPECT_EQ(refusal(), "accepted");
  files_[0].second = "second";
  EXPECT_THAT(refusal(), HasSubstr("the file 'scene.gltf' has changed"));
  files_ = {};
  EXPECT_THAT(refusal(), HasSubstr("'scene.gltf' is not there any more"));
  files_ = {{"scene.gltf", "first"}, {"sky.exr", "x"}};
  EXPECT_THAT(refusal(), HasSubstr("'sky.exr' had no part"));
}

TEST_F(StudyFolders, LeaveFilesAloneThatAreNotTheirs) {
  fs::create_directories(folder_ / "mine");
  std::ofstream(folder_ / "mine/.triad-notes") << "Dear";
  open("mine");
  EXPECT_TRUE(fs::exists(folder_ / "mine/.triad-notes"));
}

TEST_F(StudyFolders, RefuseOtherPlansAndSayWhatDiffers) {
  { open(); }
  plan_.title = plan_.name = "else";  // how results are shown makes no other study
  plan_.measure = {"seconds"};
  EXPECT_EQ(refusal(), "accepted");
  const StudyPlan good = plan_;
  plan_.repeats = 3;
  EXPECT_THAT(refusal(), testing::AllOf(HasSubstr("out"), HasSubstr("repeats"), HasSubstr("'2'"), HasSubstr("'3'")));
  plan_ = good;
  plan_.axes[0].tables[1][0].second = "7";
  EXPECT_THAT(refusal(), testing::AllOf(HasSubstr("'x'"), HasSubstr("'2'"), HasSubstr("'7'")));
  plan_ = good;
  plan_.fixed = {{"size", "4x4"}};
  EXPECT_THAT(refusal(), testing::AllOf(HasSubstr("'size'"), HasSubstr("nothing"), HasSubstr("'4x4'")));
  plan_ = good;
  plan_.axes[0].values.push_back("c");
  plan_.axes[0].tables.push_back({{"x", "3"}});
  EXPECT_THAT(refusal(), testing::AllOf(HasSubstr("2 there"), HasSubstr("3 here")));
  plan_ = good;
  facts_[0].second = "1";
  EXPECT_THAT(refusal(), testing::AllOf(HasSubstr("threads"), HasSubstr("'2'"), HasSubstr("'1'")));
}

TEST_F(StudyFolders, RefuseWhatIsNoStudysFolder) {
  fs::create_directories(folder_ / "mine");
  std::ofstream(folder_ / "mine/letter.txt") << "Dear";
  EXPECT_THAT(refusal("mine"), HasSubstr("not empty"));
  EXPECT_THAT(refusal("mine/letter.txt"), HasSubstr("is a file"));
  EXPECT_THAT(refusal("mine/letter.txt/out"), HasSubstr("cannot make"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "mine"), fs::directory_iterator()), 1);
}

TEST_F(StudyFolders, ServeOneProcessAtATime) {
  const StudyFolder held = open();
  EXPECT_THAT(refusal(), HasSubstr("another study is at work"));
}

TEST_F(StudyFolders, ForgetWhatWasHalfWritten) {
  { open(); }
  std::ofstream(folder_ / "out/runs/.triad-17-0.json") << "{";
  open();
  EXPECT_FALSE(fs::exists(folder_ / "out/runs/.triad-17-0.json"));
}

TEST_F(StudyFolders, AreGoneOnWith) {
  plan_.seeds = 2;
  std::vector<StudyTurn> done;
  int left = 5;
  const auto run = [&] {
    const StudyFolder folder = open();
    StudyRunner runner;
    runner.warm_up = false;
    runner.known = [&](const StudyTurn& turn) { return folder.find(turn); };
    runner.keep = [&](const StudyTurn& turn, const Measurements& measured) { folder.keep(turn, measured); };
    runner.work = [&](const StudySettings& settings, const StudyTurn& turn) {
      if (left-- == 0) throw Error(ErrorKind::kCancelled, "killed");
      done.push_back(turn);
      return Measurements{{"score", std::stod(settings[0].second) * 10 + std::stod(settings.back().second)},
                          {"place", turn.turn}};
    };
    return run_study(plan_, study_settings(plan_), runner);
  };
  EXPECT_THROW(run(), Error);
  EXPECT_EQ(done.size(), 5u);
  left = 100;
  const auto records = run();
  EXPECT_EQ(done.size(), 8u) << "two settings, two repeats, two seeds, each once";
  EXPECT_THAT(records[1].values.at("score"), testing::ElementsAre(20, 21, 20, 21));
  EXPECT_THAT(records[1].values.at("place"), testing::ElementsAre(0, 1, 2, 3));
  run();
  EXPECT_EQ(done.size(), 8u);
}

}  // namespace
