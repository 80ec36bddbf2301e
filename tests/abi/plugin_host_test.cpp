// SPDX-License-Identifier: Apache-2.0
// The host survives plugins that break a rule, and says which file, which plugin and which rule.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cfenv>
#include <climits>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>
#include <triad/base/file.hpp>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/stage_exercise.hpp>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace fs = std::filesystem;
using testing::HasSubstr;

namespace {

std::string offender(const std::string& name) { return OFFENDER_DIR "/" + name + ".triad.so"; }

// The rule that f breaks; the message must name the file and the rule, and the stage unless it is "".
std::string broken_rule(const std::function<void()>& f, const std::string& file, const std::string& stage) {
  try {
    f();
  } catch (const triad::PluginError& error) {
    EXPECT_THAT(error.what(), HasSubstr(file));
    EXPECT_THAT(error.what(), HasSubstr("[" + error.rule() + "]"));
    if (!stage.empty()) {
      EXPECT_THAT(error.what(), HasSubstr("'" + stage + "'"));
    }
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    EXPECT_EQ(error.kind(), triad::ErrorKind::kInput);
    return error.rule();
  } catch (const triad::Error& error) {
    ADD_FAILURE() << error.what();
  }
  return "none";
}
std::string load_rule(const std::string& path, const std::string& stage = "") {
  triad::PluginHost host;
  return broken_rule([&] { host.load_file(path); }, fs::path(path).filename(), stage);
}

class Files : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("triad-host-" + std::to_string(getpid()));
    fs::create_directories(folder_);
    fs::permissions(folder_, fs::perms(0755));
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return folder_ / (name + ".triad.so"); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
    return path(name);
  }
  fs::path folder_;
};

const triad::StageInfo& stage(const std::string& file, const std::string& id) {
  static triad::PluginHost host;
  for (const triad::StageInfo* info : host.load_file(offender(file)))
    if (info->id() == id) return *info;
  throw std::runtime_error("no stage " + id);
}

// All of a stage's life over a small picture.
triad::ExerciseOutcome use(const triad::StageInfo& info, const triad::ParamTexts& params,
                           const triad::ExerciseOptions& options = {}) {
  const triad::SyntheticPicture picture = triad::synthetic_picture(7, 5, 3, {}, 1);
  triad::StageInstance instance(info, params);
  const triad::Exercise exercise{&instance, instance.plan({&picture.image}, {nullptr}), {&picture}};
  return triad::run_exercise(exercise, options);
}
triad::ExerciseOutcome use_offender(const std::string& offence) {
  return use(stage("behaviour", "offender"), {{"offence", offence}});
}

}  // namespace

// ---- files -------------------------------------------------------------------------------------------------

TEST_F(Files, ThatAreNoPluginsAreRefused) {
  EXPECT_EQ(load_rule(path("none")), "file.missing");
  EXPECT_EQ(load_rule(write("empty", "")), "file.empty");
  EXPECT_EQ(load_rule(write("text", "#!/bin/sh\necho hello\n")), "file.not-elf");
  EXPECT_EQ(load_rule(write("short", "\x7f")), "file.not-elf");
  EXPECT_EQ(load_rule(write("magic",
                            "\x7f"
                            "ELF")),
            "file.truncated");
  fs::create_directory(path("folder"));
  EXPECT_EQ(load_rule(path("folder")), "file.folder");
  ASSERT_EQ(mkfifo(path("fifo").c_str(), 0600), 0);
  EXPECT_EQ(load_rule(path("fifo")), "file.kind");
  fs::create_symlink("nowhere", path("dangling"));
  EXPECT_EQ(load_rule(path("dangling")), "file.dangling-link");
  fs::create_symlink(path("loop"), path("loop"));
  EXPECT_EQ(load_rule(path("loop")), "file.dangling-link");
}

TEST_F(Files, CutAnywhereAreRefused) {
  const std::string good = triad::read_text_file(offender("good"));
  for (size_t bytes :
       {size_t{20}, size_t{63}, size_t{64}, size_t{100}, size_t{800}, good.size() / 2, good.size() - 1}) {
    const std::string rule = load_rule(write("cut" + std::to_string(bytes), good.substr(0, bytes)));
    EXPECT_EQ(rule, "file.truncated") << bytes << " of " << good.size();
  }
}

TEST_F(Files, ForOtherMachinesAreRefused) {
  const std::string good = triad::read_text_file(offender("good"));
  const auto changed = [&](const char* name, size_t at, char to) {
    std::string bytes = good;
    bytes[at] = to;
    return load_rule(write(name, bytes));
  };
  EXPECT_EQ(changed("class", 4, 1), "file.elf-class");       // EI_CLASS: ELFCLASS32
  EXPECT_EQ(changed("endian", 5, 2), "file.elf-class");      // EI_DATA: big-endian
  EXPECT_EQ(changed("machine", 18, 8), "file.elf-machine");  // e_machine: MIPS
  EXPECT_EQ(changed("object", 16, 1), "file.elf-type");      // e_type: ET_REL
  EXPECT_EQ(changed("program", 16, 2), "file.elf-type");     // e_type: ET_EXEC
}

TEST_F(Files, ThatEverybodyMayWriteToAreRefusedUnlessNamed) {
  fs::copy_file(offender("good"), path("victim"));
  fs::permissions(path("victim"), fs::perms(0666));
  const auto implicit = [&] {
    setenv("XDG_DATA_HOME", folder_.c_str(), 1);
    fs::create_directories(folder_ / "triad");
    fs::remove(folder_ / "triad" / "plugins");
    fs::create_directory_symlink(folder_, folder_ / "triad" / "plugins");
    return broken_rule([] { triad::PluginHost().find("victim"); }, "victim.triad.so", "");
  };
  EXPECT_EQ(implicit(), "file.world-writable");
  fs::permissions(path("victim"), fs::perms(0644));
  fs::permissions(folder_, fs::perms(0777));
  EXPECT_EQ(implicit(), "file.world-writable");
  testing::internal::CaptureStderr();
  triad::PluginHost host({folder_});
  EXPECT_EQ(host.find("victim").id(), "victim");
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::AllOf(HasSubstr("warning"), HasSubstr("file.world-writable"), HasSubstr("victim.triad.so")));
  fs::permissions(folder_, fs::perms(0755));
  unsetenv("XDG_DATA_HOME");
  EXPECT_EQ(triad::PluginHost({folder_}).find("victim").file, path("victim")) << "named by folder";
}

TEST_F(Files, KeepTheirDescriptorsSoThatTheNextIsNotTheFirst) {
  fs::copy_file(offender("good"), path("one"));
  fs::copy_file(offender("newer"), path("two"));
  triad::PluginHost host;
  EXPECT_EQ(host.load_file(path("one")).at(0)->id(), "victim");
  EXPECT_EQ(host.load_file(path("two")).at(0)->id(), "newer");
  fs::create_symlink(path("two"), path("link"));
  EXPECT_EQ(host.load_file(path("link")).at(0)->file, path("two")) << "the real path is shown";
}

TEST_F(Files, NamedAfterTheStageAreOpenedFirstAndAlone) {
  fs::copy_file(offender("good"), path("victim"));
  write("broken", "text");
  triad::PluginHost host({folder_});
  testing::internal::CaptureStderr();
  EXPECT_EQ(host.find("victim").file, path("victim"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "the broken file was opened";
  // Another name: now all files count, the broken one is a warning.
  fs::rename(path("victim"), path("renamed"));
  fs::copy_file(offender("newer"), path("zz"));
  testing::internal::CaptureStderr();
  EXPECT_EQ(triad::PluginHost({folder_}).find("newer").file, path("zz"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("broken.triad.so"));
}

TEST_F(Files, WithTheSameIdInAnotherFolderAreHidden) {
  fs::create_directory(folder_ / "a");
  fs::create_directory(folder_ / "b");
  fs::copy_file(offender("good"), folder_ / "a" / "first.triad.so");
  fs::copy_file(offender("good"), folder_ / "b" / "second.triad.so");
  triad::PluginHost host({folder_ / "b", folder_ / "a"});
  testing::internal::CaptureStderr();
  std::string file;
  for (const triad::StageInfo* info : host.list())
    if (info->id() == "victim") file = info->file;
  EXPECT_EQ(file, folder_ / "b" / "second.triad.so") << "the earlier folder wins";
  EXPECT_THAT(
      testing::internal::GetCapturedStderr(),
      testing::AllOf(HasSubstr("first.triad.so"), HasSubstr("second.triad.so"), HasSubstr("record.duplicate-id")));
}

TEST_F(Files, AreNotLookedForInTheCurrentFolder) {
  fs::copy_file(offender("good"), path("victim"));
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  setenv("TRIAD_PLUGIN_PATH", ":", 1);  // empty parts
  EXPECT_THROW(triad::PluginHost().find("victim"), triad::Error);
  setenv("TRIAD_PLUGIN_PATH", folder_.c_str(), 1);
  EXPECT_EQ(triad::PluginHost().find("victim").id(), "victim");
  unsetenv("TRIAD_PLUGIN_PATH");
  fs::current_path(before);
}

// ---- symbols and records -----------------------------------------------------------------------------------

TEST(Symbols, ThatAreNotThePluginsAreRefused) {
  EXPECT_EQ(load_rule(offender("other-symbol")), "symbol.missing");
  EXPECT_EQ(load_rule(offender("other-version")), "symbol.other-version");
  EXPECT_EQ(load_rule(offender("function")), "symbol.not-data");
  EXPECT_EQ(load_rule(offender("small-symbol")), "symbol.too-small");
  // A library that is no plugin at all.
  EXPECT_EQ(load_rule(fs::canonical("/proc/self/exe")), "symbol.missing");
}

TEST(Records, ThatAreSpoiltAreRefused) {
  const std::tuple<const char*, const char*, const char*> cases[] = {
      {"bad-magic", "", "record.magic"},
      {"bad-major", "", "record.major"},
      {"small-library", "", "record.size"},
      {"large-library", "", "record.size"},
      {"null-descs", "", "record.null"},
      {"null-desc", "", "record.null"},
      {"zero-descs", "", "record.count"},
      {"huge-descs", "", "record.count"},
      {"huge-params", "victim", "record.count"},
      {"duplicate-id", "victim", "record.duplicate-id"},
      {"bad-utf8", "victim", "record.text"},
      {"nan-range", "victim", "record.range"},
      {"bad-default", "victim", "record.default"},
      {"null-choices", "victim", "record.choices"},
      {"bad-type", "victim", "record.enum"},
      {"bad-name", "victim", "record.name"},
      {"bad-kind", "victim", "record.enum"},
      {"bad-channels", "victim", "record.inputs"},
      {"small-param", "victim", "record.size"},
      {"filter-scores", "victim", "record.count"},
      {"null-function", "victim", "record.null"},
      {"desc-outside", "", "record.outside-file"},
      {"code-outside", "victim", "record.code-outside-file"}};
  for (const auto& [file, id, rule] : cases) {
    EXPECT_EQ(load_rule(offender(file), id), rule) << file;
    EXPECT_EQ(load_rule(offender(file), id), rule) << file << ", asked for again";
  }
}

TEST(Records, OfNewerAndOlderHeadersAreAccepted) {
  EXPECT_EQ(use(stage("good", "victim"), {}).pixels.size(), 7u * 5 * 3);  // made with sizes of 1.0
  const triad::ExerciseOutcome white = use(stage("newer", "newer"), {{"amount", "4"}});
  EXPECT_THAT(white.pixels, testing::Each(1.0f));
}

TEST(Records, ThatUnifyWithAnotherFilesAreRefused) {
  triad::PluginHost host;
  EXPECT_EQ(host.load_file(offender("unified-a")).at(0)->id(), "unified-a");
  EXPECT_EQ(load_rule(offender("unified-b")), "record.outside-file");
}

// ---- floating point ----------------------------------------------------------------------------------------

#if defined(__SSE__)
TEST(FloatingPoint, SurvivesAPluginBuiltWithFastMath) {
  const uint32_t before = _mm_getcsr();
  testing::internal::CaptureStderr();
  triad::PluginHost host;
  EXPECT_EQ(host.load_file(offender("fast-math")).at(0)->id(), "fast-math");
  EXPECT_EQ(_mm_getcsr(), before);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::AllOf(HasSubstr("fast-math.triad.so"), HasSubstr("float.control-word")));
}

TEST(FloatingPoint, IsRestoredAfterEachCallOnEveryThread) {
  const auto run = [] {
    const uint32_t before = _mm_getcsr() & ~0x3fu;
    use_offender("strip-flushes");
    EXPECT_EQ(_mm_getcsr() & ~0x3fu, before);
    use_offender("strip-rounding");
    EXPECT_EQ(std::fegetround(), FE_TONEAREST);
  };
  run();
  std::thread(run).join();
}

TEST(FloatingPoint, IsTheDefaultInsideWhateverTheCallerHas) {
  const triad::ExerciseOutcome expected = use_offender("none");
  const uint32_t before = _mm_getcsr();
  _mm_setcsr(before | 0x8040 | 0x6000);  // flush to zero, round toward zero
  const triad::ExerciseOutcome outcome = use_offender("none");
  const uint32_t kept = _mm_getcsr();
  _mm_setcsr(before);
  EXPECT_TRUE(outcome == expected);
  EXPECT_EQ(kept & 0xe040u, 0xe040u) << "the caller's own mode is not the plugin's business";
}
#endif

// ---- calls -------------------------------------------------------------------------------------------------

TEST(Calls, ThatBreakARuleAreErrorsThatNameIt) {
  const std::pair<const char*, const char*> cases[] = {{"null-instance", "create.null-instance"},
                                                       {"create-throws", "call.exception"},
                                                       {"create-status", "call.status"},
                                                       {"create-silent", "call.silent-failure"},
                                                       {"plan-throws", "call.exception"},
                                                       {"plan-cancelled", "call.cancelled"},
                                                       {"plan-negative", "plan.size"},
                                                       {"plan-zero", "plan.size"},
                                                       {"plan-product", "plan.size"},
                                                       {"plan-int-max", "plan.channels"},
                                                       {"plan-channels", "plan.channels"},
                                                       {"plan-alpha", "plan.channels"},
                                                       {"plan-cells", "plan.cells"},
                                                       {"plan-aspect", "plan.colour"},
                                                       {"plan-threads", "plan.enum"},
                                                       {"plan-passes", "plan.passes"},
                                                       {"plan-rows", "plan.strip-rows"},
                                                       {"plan-state", "plan.state"},
                                                       {"plan-state-without-merge", "plan.merge"},
                                                       {"need-inverted", "need.empty"},
                                                       {"need-empty", "need.empty"},
                                                       {"need-int-min", "need.far"},
                                                       {"need-int-max", "need.far"},
                                                       {"need-throws", "call.exception"},
                                                       {"strip-throws-int", "call.exception"},
                                                       {"strip-throws-in-parallel", "call.internal"},
                                                       {"past-strip", "pixels.writes-past-strip"},
                                                       {"before-strip", "pixels.writes-past-strip"},
                                                       {"unwritten", "pixels.unwritten"}};
  for (const auto& [offence, rule] : cases)
    EXPECT_EQ(broken_rule([&] { use_offender(offence); }, "behaviour.triad.so", "offender"), rule) << offence;
  EXPECT_EQ(use_offender("none").pixels.size(), 7u * 5 * 3);
  EXPECT_EQ(use_offender("scratch-huge").pixels.size(), 7u * 5 * 3) << "NULL is the answer to absurd wishes";
}

TEST(Calls, OfAMetricThatBreakARuleAreErrorsThatNameIt) {
  const std::pair<const char*, const char*> cases[] = {{"score-nan", "score.not-a-number"},
                                                       {"score-infinite", "score.infinite"},
                                                       {"state-overrun", "state.writes-past-end"},
                                                       {"map-size", "plan.map"}};
  const triad::StageInfo& metric = stage("behaviour", "offending-metric");
  for (const auto& [offence, rule] : cases)
    EXPECT_EQ(broken_rule(
                  [&] {
                    use(metric, {{"metric-offence", offence}});
                  },
                  "behaviour.triad.so", "offending-metric"),
              rule)
        << offence;
  EXPECT_EQ(use(metric, {}).scores.size(), 1u);
}

TEST(Calls, ThatThrowInDestroyAreAWarning) {
  testing::internal::CaptureStderr();
  use_offender("destroy-throws");
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::AllOf(HasSubstr("offender"), HasSubstr("behaviour.triad.so"), HasSubstr("call.exception")));
}

TEST(Calls, ThatEndTheProcessNameThePluginAndRemoveTemporaryFiles) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const auto die = [](const char* offence) {
    const triad::AtomicFile file(std::string(testing::TempDir()) + "triad-crash-test.png");
    std::ofstream(std::string(testing::TempDir()) + "triad-crash-name") << file.temporary();
    use_offender(offence);
  };
  const auto left_behind = [] {
    const std::string name = triad::read_text_file(std::string(testing::TempDir()) + "triad-crash-name");
    return fs::exists(name) ? name : "";
  };
  const std::string who = R"(triad: plugin 'offender' \(.*behaviour\.triad\.so\) crashed in strip\(\) )";
  EXPECT_EXIT(die("strip-segfault"), testing::ExitedWithCode(3), who + R"(\(SIGSEGV\))");
  EXPECT_EQ(left_behind(), "");
  EXPECT_EXIT(die("strip-abort"), testing::ExitedWithCode(3), who + R"(\(SIGABRT\))");
  EXPECT_EXIT(die("strip-divides"), testing::ExitedWithCode(3), who + R"(\(SIGFPE\))");
  EXPECT_EXIT(die("stack-overflow"), testing::ExitedWithCode(3), who + R"(\(SIGSEGV\))");
  EXPECT_EXIT(die("strip-exit"), testing::ExitedWithCode(3), "plugin 'offender' .* called exit\\(\\) in strip\\(\\)");
  EXPECT_EQ(left_behind(), "");
  EXPECT_EXIT(triad::PluginHost().load_file(offender("crash-on-load")), testing::ExitedWithCode(3),
              "crash-on-load.triad.so' crashed in its constructors");
  EXPECT_EXIT(triad::PluginHost().load_file(offender("exit-on-load")), testing::ExitedWithCode(3),
              "exit-on-load.triad.so' called exit\\(\\) in its constructors");
#else
  GTEST_SKIP() << "the sanitizer reports crashes itself";
#endif
}

TEST(Calls, ThatCrashOutsideAPluginAreNotBlamedOnOne) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const auto die = [] {
    use_offender("none");  // the handlers are there from here on
    raise(SIGSEGV);
    raise(SIGSEGV);
  };
  EXPECT_EXIT(die(), testing::KilledBySignal(SIGSEGV), "^$");
#else
  GTEST_SKIP() << "the sanitizer reports crashes itself";
#endif
}

// ---- parameters --------------------------------------------------------------------------------------------

namespace {
std::string usage_error(const triad::ParamTexts& params) {
  try {
    triad::StageInstance(stage("good", "victim"), params);
  } catch (const triad::Error& error) {
    EXPECT_EQ(error.kind(), triad::ErrorKind::kUsage);
    return error.what();
  }
  return "";
}
}  // namespace

TEST(Parameters, AreCheckedAgainstTheTable) {
  EXPECT_THAT(usage_error({{"amuont", "1"}}),
              testing::AllOf(HasSubstr("'victim'"), HasSubstr("did you mean 'amount'?"), HasSubstr("amount, mode")));
  EXPECT_THAT(usage_error({{"amount", "1.5"}}), testing::AllOf(HasSubstr("amount='1.5'"), HasSubstr("0 to 1")));
  EXPECT_THAT(usage_error({{"amount", "much"}}), HasSubstr("a number"));
  EXPECT_THAT(usage_error({{"amount", "nan"}}), HasSubstr("a number"));
  EXPECT_THAT(usage_error({{"mode", "slwo"}}),
              testing::AllOf(HasSubstr("did you mean 'slow'?"), HasSubstr("one of fast, slow")));
  EXPECT_EQ(usage_error({{"amount", "1"}, {"mode", "slow"}}), "");
}

TEST(Parameters, AreShownAsTheyAreInForce) {
  const triad::StageInstance instance(stage("good", "victim"), {{"mode", "slow"}});
  EXPECT_EQ(instance.text(), "victim:mode=slow");
  EXPECT_THAT(instance.parameters(),
              testing::ElementsAre(testing::Pair("amount", "0.5"), testing::Pair("mode", "slow")));
  const std::string help = triad::stage_help(instance.info());
  for (const char* part : {"victim 1.0 (filter)", "amount=NUMBER", "0 to 1", "default 0.5", "mode=fast|slow"})
    EXPECT_THAT(help, HasSubstr(part));
}

TEST(Stages, ThatAreUnknownGetASuggestion) {
  triad::PluginHost host({OFFENDER_DIR "/good.triad.so"});
  EXPECT_EQ(host.find("victim").file, offender("good"));
  try {
    host.find("victin");
    FAIL();
  } catch (const triad::Error& error) {
    EXPECT_EQ(error.kind(), triad::ErrorKind::kUsage);
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("'victin'"), HasSubstr("did you mean 'victim'?")));
  }
  EXPECT_THROW(host.find("../victim"), triad::Error);
  EXPECT_THROW(triad::PluginHost({"/nowhere/at/all"}), triad::Error);
}
