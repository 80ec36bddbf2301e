// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <triad/base/error.hpp>
#include <triad/evaluation/study.hpp>

namespace fs = std::filesystem;
using namespace triad;
using testing::ElementsAre;

namespace {

class Studies : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("triad-study-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string write(const std::string& text) {
    std::ofstream(folder_ / "plan.toml") << text;
    return folder_ / "plan.toml";
  }
  fs::path folder_;
};

constexpr const char* kPlan =
    "title = 'T'\nwork = 'render'\nrepeats = 3\n[fixed]\nspp = 4\n"
    "[[axis]]\nname = 'scene'\nvalues = ['a', 'b']\n[[axis]]\nname = 'n'\nvalues = [1, 2.5, true]\n";

TEST_F(Studies, ReadPlansAndCombineAxes) {
  const StudyPlan plan = load_study(write(kPlan));
  EXPECT_EQ(plan.name, "plan");
  EXPECT_EQ(plan.repeats, 3);
  EXPECT_EQ(plan.fixed, (StudySettings{{"spp", "4"}}));
  const auto settings = study_settings(plan);
  ASSERT_EQ(settings.size(), 6u);
  EXPECT_EQ(settings[0], (StudySettings{{"scene", "a"}, {"n", "1"}}));
  EXPECT_EQ(settings[1], (StudySettings{{"scene", "a"}, {"n", "2.5"}}));
  EXPECT_EQ(settings[5], (StudySettings{{"scene", "b"}, {"n", "true"}}));
}

TEST_F(Studies, RefuseWhatIsNoPlan) {
  for (const std::string& bad : std::vector<std::string>{
           std::string("work = 'render'\n"), std::string("[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work=3\n[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work='r'\nrepeats=0\n[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work='r'\nfoo=1\n[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[]\n"), std::string("work='r'\n[[axis]]\nvalues=[1]\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[1]\nx=2\n"),
           std::string("work='r'\n[fixed]\na=1\n[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[[1]]\n"), std::string("work='r'\naxis=3\n"),
           std::string("work = \n")}) {
    try {
      load_study(write(bad));
      ADD_FAILURE() << bad;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("plan.toml")) << bad;
    }
  }
  EXPECT_THROW(load_study("no-such-study"), Error);
}

TEST_F(Studies, RunInTurnsAndSummarise) {
  const StudyPlan plan = load_study(write(kPlan));
  std::vector<std::string> order;
  int calls = 0;
  const auto records = run_study(plan, study_settings(plan), [&](const StudySettings& settings) {
    EXPECT_EQ(settings.back(), (std::pair<std::string, std::string>{"spp", "4"}));
    order.push_back(settings[0].second + settings[1].second);
    // The first turn is not counted: 1000 must not show. Then 1, 2, 6 for every setting.
    static constexpr double kSeconds[] = {1000, 1, 2, 6};
    return Measurements{{"seconds", kSeconds[calls++ / 6]}, {"rays", 7}};
  });
  EXPECT_EQ(order.size(), 24u);
  for (size_t i = 6; i < order.size(); ++i) EXPECT_EQ(order[i], order[i - 6]) << "in turns";
  ASSERT_EQ(records.size(), 6u);
  EXPECT_THAT(records[4].values.at("seconds"), ElementsAre(1, 2, 6));
  EXPECT_EQ(records[4].median("seconds"), 2);
  EXPECT_EQ(records[4].spread("seconds"), (4 - 1.5) / 2);  // quartiles of 1, 2, 6 by interpolation: 1.5 and 4
  EXPECT_EQ(records[4].spread("rays"), 0);
  const std::string table = study_table(plan, records);
  EXPECT_THAT(table, testing::StartsWith("T\nscene  n     seconds  rays\na      1     2 ±1.25     7\n"));
  const auto json = nlohmann::json::parse(study_to_json(plan, records));
  EXPECT_EQ(json.at("runs").size(), 6u);
  EXPECT_EQ(json.at("runs")[1].at("settings").at("n"), "2.5");
  EXPECT_EQ(json.at("runs")[1].at("median").at("seconds"), 2);
  EXPECT_EQ(json.at("runs")[1].at("values").at("rays"), nlohmann::json({7, 7, 7}));
  EXPECT_EQ(json.at("fixed").at("spp"), "4");
}

}  // namespace
