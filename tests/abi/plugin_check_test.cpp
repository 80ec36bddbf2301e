// SPDX-License-Identifier: Apache-2.0
// `triad plugin check` finds each offence, by its rule, and passes what keeps the rules.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <clocale>
#include <filesystem>
#include <fstream>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/pipeline/plugin_check.hpp>
#include <triad/pipeline/plugin_new.hpp>

namespace fs = std::filesystem;

namespace {

std::string offender(const std::string& name) { return OFFENDER_DIR "/" + name + ".triad.so"; }

std::vector<std::string> failures(const std::vector<triad::CheckResult>& results) {
  std::vector<std::string> rules;
  for (const triad::CheckResult& r : results) {
    if (r.passed || r.skipped) continue;
    EXPECT_FALSE(r.message.empty()) << r.rule;
    rules.push_back((r.stage.empty() ? "" : r.stage + ": ") + r.rule);
  }
  return rules;
}
std::vector<std::string> found(const std::string& offence) {
  return failures(triad::check_plugin(offender("behaviour"), "offence=" + offence));
}
std::vector<std::string> found_in_metric(const std::string& offence) {
  return failures(triad::check_plugin(offender("behaviour"), "metric-offence=" + offence));
}

}  // namespace

TEST(PluginCheck, PassesWhatKeepsTheRules) {
  for (const std::string& file : {offender("good"), offender("newer"), offender("behaviour"),
                                  std::string(TRIAD_BINARY_DIR "/plugins/box.triad.so")}) {
    const auto results = triad::check_plugin(file);
    EXPECT_THAT(failures(results), testing::IsEmpty()) << file;
    EXPECT_GE(results.size(), 5u) << file;
  }
}

TEST(PluginCheck, RefusesFilesWithTheHostsRules) {
  EXPECT_THAT(failures(triad::check_plugin("/nowhere")), testing::ElementsAre("file.missing"));
  EXPECT_THAT(failures(triad::check_plugin(offender("other-version"))), testing::ElementsAre("symbol.other-version"));
  EXPECT_THAT(failures(triad::check_plugin(offender("bad-magic"))), testing::ElementsAre("record.magic"));
  EXPECT_THAT(failures(triad::check_plugin(offender("null-choices"))), testing::ElementsAre("record.choices"));
}

TEST(PluginCheck, SurvivesLoading) {
  EXPECT_THAT(failures(triad::check_plugin(offender("exit-on-load"))), testing::ElementsAre("call.exit"));
  EXPECT_THAT(failures(triad::check_plugin(offender("crash-on-load"))), testing::ElementsAre("call.crash"));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THAT(failures(triad::check_plugin(offender("hang-on-load"), "", .3)), testing::ElementsAre("call.hang"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(15));  // not the 20 s by default
  EXPECT_THAT(failures(triad::check_plugin(offender("fast-math"))), testing::ElementsAre("float.control-word"));
}

TEST(PluginCheck, FindsWhatCallsDo) {
  using testing::Contains;
  EXPECT_THAT(found("null-instance"), Contains("offender: create.null-instance"));
  EXPECT_THAT(found("create-throws"), Contains("offender: call.exception"));
  EXPECT_THAT(found("need-throws"), Contains("offender: call.exception"));
  EXPECT_THAT(found("strip-throws-int"), Contains("offender: call.exception"));
  EXPECT_THAT(found("strip-throws-in-parallel"), Contains("offender: call.internal"));
  EXPECT_THAT(found("strip-segfault"), Contains("offender: call.crash"));
  EXPECT_THAT(found("strip-abort"), Contains("offender: call.crash"));
  EXPECT_THAT(found("strip-exit"), Contains("offender: call.exit"));
  EXPECT_THAT(failures(triad::check_plugin(offender("behaviour"), "offence=strip-hangs", .5)),
              Contains("offender: call.hang"));
  EXPECT_THAT(found("plan-negative"), Contains("offender: plan.size"));
  EXPECT_THAT(found("plan-state"), Contains("offender: plan.state"));
  EXPECT_THAT(found("need-int-min"), Contains("offender: need.far"));
}

TEST(PluginCheck, FindsWhatAPluginMustLeaveAlone) {
  using testing::Contains;
  EXPECT_THAT(found("strip-stdout"), Contains("offender: call.stdout"));
  EXPECT_THAT(failures(triad::check_plugin(offender("print-on-load"))), Contains("record.magic"));
  EXPECT_THAT(found("strip-locale"), Contains("offender: call.locale"));
  EXPECT_THAT(found("strip-signal"), Contains("offender: call.signal-handlers"));
  EXPECT_THAT(found("strip-rounding"), Contains("offender: float.control-word"));
#if defined(__SSE__)
  EXPECT_THAT(found("strip-flushes"), Contains("offender: float.control-word"));
#endif
}

TEST(PluginCheck, FindsWhatHappensToPixels) {
  using testing::ElementsAre;
  EXPECT_THAT(found("past-strip"), ElementsAre("offender: pixels.writes-past-strip"));
  EXPECT_THAT(found("before-strip"), ElementsAre("offender: pixels.writes-past-strip"));
  EXPECT_THAT(found("unwritten"), ElementsAre("offender: pixels.unwritten"));
  EXPECT_THAT(found("depends-on-split"), ElementsAre("offender: pixels.depends-on-split"));
  EXPECT_THAT(found("not-repeatable"), testing::Contains("offender: pixels.not-repeatable"));
  EXPECT_THAT(found("writes-input"), ElementsAre("offender: pixels.writes-input"));
  EXPECT_THAT(found("reads-past-input"), ElementsAre("offender: pixels.reads-past-input"));
  EXPECT_THAT(found("race"), testing::Contains("offender: threads.race"));
}

TEST(PluginCheck, FindsWhatAMetricDoesWrong) {
  using testing::ElementsAre;
  EXPECT_THAT(found_in_metric("score-nan"), ElementsAre("offending-metric: score.not-a-number"));
  EXPECT_THAT(found_in_metric("score-infinite"), ElementsAre("offending-metric: score.infinite"));
  EXPECT_THAT(found_in_metric("state-overrun"), ElementsAre("offending-metric: state.writes-past-end"));
  EXPECT_THAT(found_in_metric("last-strip-only"), ElementsAre("offending-metric: pixels.depends-on-split"));
  EXPECT_THAT(found_in_metric("map-size"), ElementsAre("offending-metric: plan.map"));
}

TEST(PluginCheck, RefusesParametersItCannotRead) {
  EXPECT_THROW(triad::check_plugin(offender("good"), "amount"), triad::Error);
  EXPECT_THROW(triad::check_plugin(offender("good"), "=1"), triad::Error);
}

TEST(PluginNew, WritesThreeFilesAndTouchesNothingElse) {
  const fs::path folder = fs::path(testing::TempDir()) / ("triad-new-" + std::to_string(getpid()));
  fs::create_directories(folder);
  const auto files = triad::new_plugin("soft-glow", folder);
  EXPECT_THAT(files, testing::ElementsAre(folder / "soft-glow" / "soft-glow.cpp",
                                          folder / "soft-glow" / "CMakeLists.txt", folder / "soft-glow" / "test.sh"));
  EXPECT_THAT(triad::read_text_file(files[0]), testing::HasSubstr("TRIAD_PLUGIN(\"soft-glow\", SoftGlow)"));
  EXPECT_EQ(triad::read_text_file(files[0]).find('@'), std::string::npos);
  EXPECT_EQ(access(files[2].c_str(), X_OK), 0);
  EXPECT_THROW(triad::new_plugin("soft-glow", folder), triad::Error) << "it is there already";
  for (const char* bad : {"", "Upper", "9lives", "a/b", "..", "a_b", "test", "all"})
    EXPECT_THROW(triad::new_plugin(bad, folder), triad::Error) << bad;
  EXPECT_THROW(triad::new_plugin("fine", folder / "missing"), triad::Error);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator{}), 1);
  fs::remove_all(folder);
}
