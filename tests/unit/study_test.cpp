// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
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
           std::string("work = 'render'\n"),
           std::string("[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work=3\n[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work='r'\nrepeats=0\n[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work='r'\nfoo=1\n[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[]\n"),
           std::string("work='r'\n[[axis]]\nvalues=[1]\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[1]\nx=2\n"),
           std::string("work='r'\n[fixed]\na=1\n[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[1,1]\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[1]\n[[axis]]\nname='a'\nvalues=[{label='x',b=1}]\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[1,{label='x',b=1}]\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[{b=1}]\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[{label='x'}]\n"),
           std::string("work='r'\n[fixed]\nb=1\n[[axis]]\nname='a'\nvalues=[{label='x',b=1}]\n"),
           std::string("work='r'\nseeds=0\n[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work='r'\nseeds=2\n[[axis]]\nname='seed'\nvalues=[1]\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[1]\n[[faster]]\naxis='a'\nfirst='1'\nsecond='2'\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[1]\n[[faster]]\naxis='a'\nfirst='1'\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[1]\n[[equal]]\naxis='a'\nbase='1'\nalong='a'\n"
                       "at='s'\ncompare='r'\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[1]\n[[axis]]\nname='b'\nvalues=[1,2]\n[[published]]\n"
                       "title='t'\nmeasure='m'\nrows='a'\ncolumns='b'\nbase='1'\nvalues={1=[3]}\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[1]\n[[axis]]\nname='b'\nvalues=[1]\n[[published]]\n"
                       "title='t'\nmeasure='m'\nrows='a'\ncolumns='b'\nbase='1'\nvalues={1=[0]}\n"),
           std::string("work='r'\n[[axis]]\nname='a'\nvalues=[[1]]\n"),
           std::string("work='r'\naxis=3\n"),
           std::string("work='r'\npareto='s'\n[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work='r'\nwithin=['a']\n[[axis]]\nname='a'\nvalues=[1]\n"),
           std::string("work='r'\npareto=['s']\nwithin=['b']\n[[axis]]\nname='a'\nvalues=[1]\n"),
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
  StudyRunner runner;
  runner.work = [&](const StudySettings& settings, const StudyTurn& turn) {
    EXPECT_EQ(turn.setting, static_cast<size_t>(calls % 6));
    EXPECT_EQ(turn.turn, calls / 6 - 1);
    EXPECT_EQ(settings.back(), (std::pair<std::string, std::string>{"spp", "4"}));
    order.push_back(settings[0].second + settings[1].second);
    // The first turn is not counted: 1000 must not show. Then 1, 2, 6 for every setting.
    static constexpr double kSeconds[] = {1000, 1, 2, 6};
    return Measurements{{"seconds", kSeconds[calls++ / 6]}, {"rays", 7}};
  };
  const auto records = run_study(plan, study_settings(plan), runner);
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

// One record with a single run.
StudyRecord record(const StudySettings& settings, double seconds, double rmse) {
  return {settings, {{"seconds", {seconds}}, {"rmse", {rmse}}}, {"seconds", "rmse"}, 1};
}

StudyPlan plan_of(const std::vector<std::string>& axes, const std::vector<std::string>& within) {
  StudyPlan plan;
  for (const std::string& axis : axes) plan.axes.push_back({axis, {"1"}, {}});
  plan.pareto = {"seconds", "rmse"};
  plan.within = within;
  return plan;
}

TEST(Pareto, MarksWhatNothingBeats) {
  // By hand: a is quickest, d best; b beats c in both; e costs as much as d and is worse; f is as good as b and
  // slower.
  const std::vector<StudyRecord> records{record({{"n", "a"}}, 1, 9), record({{"n", "b"}}, 2, 5),
                                         record({{"n", "c"}}, 3, 6), record({{"n", "d"}}, 4, 1),
                                         record({{"n", "e"}}, 4, 2), record({{"n", "f"}}, 2.5, 5)};
  EXPECT_THAT(pareto_optimal(plan_of({"n"}, {}), records), ElementsAre(true, true, false, true, false, false));
}

TEST(Pareto, TiesDoNotBeatEachOther) {
  const std::vector<StudyRecord> records{record({{"n", "a"}}, 1, 1), record({{"n", "b"}}, 1, 1),
                                         record({{"n", "c"}}, 1, 2)};
  EXPECT_THAT(pareto_optimal(plan_of({"n"}, {}), records), ElementsAre(true, true, false));
}

TEST(Pareto, ComparesWithinGroupsOnly) {
  // Each of ppd 20's beats its fellow of ppd 40, which are judged among themselves.
  const std::vector<StudyRecord> records{
      record({{"ppd", "20"}, {"n", "a"}}, 1, 2), record({{"ppd", "20"}, {"n", "b"}}, 2, 3),
      record({{"ppd", "40"}, {"n", "a"}}, 3, 5), record({{"ppd", "40"}, {"n", "b"}}, 4, 4)};
  EXPECT_THAT(pareto_optimal(plan_of({"ppd", "n"}, {"ppd"}), records), ElementsAre(true, false, true, true));
  EXPECT_THAT(pareto_optimal(plan_of({"ppd", "n"}, {}), records), ElementsAre(true, false, false, false));
}

TEST(Pareto, TakesMediansAndLeavesOutWhatIsNoNumber) {
  std::vector<StudyRecord> records{record({{"n", "a"}}, 5, 5), record({{"n", "b"}}, 5, 5),
                                   record({{"n", "c"}}, 1, 1)};
  records[0].values["seconds"] = {1, 4, 100};  // median 4, mean 35
  records[2].values["rmse"] = {std::nan("")};
  EXPECT_THAT(pareto_optimal(plan_of({"n"}, {}), records), ElementsAre(true, false, false));
  const double infinite = std::numeric_limits<double>::infinity();
  records[2].values["rmse"] = {infinite, infinite};
  EXPECT_EQ(records[2].median("rmse"), infinite);
  StudyPlan none = plan_of({"n"}, {});
  none.pareto.clear();
  EXPECT_TRUE(pareto_optimal(none, records).empty());
}

TEST_F(Studies, ShowTheParetoOptimal) {
  const StudyPlan plan = load_study(
      write("title='T'\nwork='w'\nrepeats=1\nmeasure=['seconds']\npareto=['seconds','rmse']\nwithin=['g']\n"
            "[[axis]]\nname='g'\nvalues=[1]\n[[axis]]\nname='n'\nvalues=['a','b']\n"));
  StudyRunner runner;
  runner.work = [](const StudySettings& settings, const StudyTurn&) {
    const bool first = settings[1].second == "a";
    return Measurements{{"seconds", first ? 1. : 2.}, {"rmse", first ? 3. : 4.}};
  };
  const auto records = run_study(plan, study_settings(plan), runner);
  EXPECT_EQ(study_table(plan, records), "T\ng  n  seconds  best\n1  a        1     *\n1  b        2\n");
  const auto json = nlohmann::json::parse(study_to_json(plan, records));
  EXPECT_EQ(json.at("pareto").at("measures"), nlohmann::json({"seconds", "rmse"}));
  EXPECT_EQ(json.at("pareto").at("within"), nlohmann::json({"g"}));
  EXPECT_EQ(json.at("runs")[0].at("pareto"), true);
  EXPECT_EQ(json.at("runs")[1].at("pareto"), false);
}

TEST_F(Studies, RefuseToCompareWhatIsNotMeasuredBeforeAllIsRun) {
  const StudyPlan plan = load_study(write("work='w'\npareto=['second']\n[[axis]]\nname='n'\nvalues=['a','b']\n"));
  int runs = 0;
  StudyRunner runner;
  runner.work = [&](const StudySettings&, const StudyTurn&) {
    ++runs;
    return Measurements{{"seconds", 1}};
  };
  try {
    run_study(plan, study_settings(plan), runner);
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("'second'"), testing::HasSubstr("'seconds'")));
  }
  EXPECT_EQ(runs, 1);
}

TEST_F(Studies, RefuseColumnsThatNothingMeasures) {
  const auto run = [&](const std::string& measure) -> std::string {
    const StudyPlan plan = load_study(
        write("work='w'\nrepeats=2\nmeasure=['seconds'," + measure + "]\n[[axis]]\nname='n'\nvalues=['a','b']\n"));
    StudyRunner runner;
    runner.warm_up = false;
    int runs = 0;
    runner.work = [&](const StudySettings& settings, const StudyTurn&) {
      ++runs;
      Measurements measured{{"seconds", 1}};
      if (settings[0].second == "b") measured.emplace_back("gap", 2);
      return measured;
    };
    try {
      run_study(plan, study_settings(plan), runner);
    } catch (const Error& error) {
      EXPECT_EQ(runs, 2) << "found after one turn";
      return error.what();
    }
    EXPECT_EQ(runs, 4);
    return "accepted";
  };
  EXPECT_EQ(run("'gap'"), "accepted") << "one of the two has it";
  EXPECT_THAT(run("'gaps'"), testing::AllOf(testing::HasSubstr("'gaps'"), testing::HasSubstr("'gap'")));
}

}  // namespace
