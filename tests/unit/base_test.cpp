// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <clocale>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>

namespace fs = std::filesystem;
using triad::parse_bytes;
using triad::parse_double;
using triad::parse_int;

TEST(Text, SplitsOutsideQuotesOnly) {
  EXPECT_EQ(triad::split_quoted("a=1,b='x,y',c=\"p,q\"", ','),
            (std::vector<std::string>{"a=1", "b='x,y'", "c=\"p,q\""}));
  EXPECT_EQ(triad::split_quoted("", ','), std::vector<std::string>{""});
  EXPECT_EQ(triad::split_quoted("a\\,b,c", ','), (std::vector<std::string>{"a\\,b", "c"}));
  EXPECT_EQ(triad::unquote("b='x,y'"), "b=x,y");
  EXPECT_EQ(triad::unquote("a\\,b"), "a,b");
  EXPECT_EQ(triad::unquote("\"say \\\"hi\\\"\""), "say \"hi\"");
  EXPECT_EQ(triad::unquote("'C:\\dir'"), "C:\\dir");
  EXPECT_THROW(triad::split_quoted("a='b", ','), triad::Error);
}

TEST(Text, ParsesWholeNumbersOnly) {
  EXPECT_EQ(parse_double("1e-3"), 1e-3);
  EXPECT_EQ(parse_double("+.5"), .5);
  EXPECT_EQ(parse_double("-inf"), -HUGE_VAL);
  for (const char* bad : {"", " 1", "1 ", "1x", "0x10", "--1", "1,5"}) EXPECT_FALSE(parse_double(bad)) << bad;
  EXPECT_EQ(parse_int("-12"), -12);
  for (const char* bad : {"", "1.5", "9223372036854775808", "1e3"}) EXPECT_FALSE(parse_int(bad)) << bad;
  EXPECT_EQ(parse_bytes("400M"), 400u << 20);
  EXPECT_EQ(parse_bytes("1.5kB"), 1536u);
  EXPECT_EQ(parse_bytes("64"), 64u);
  for (const char* bad : {"", "M", "-1G", "0", "nan", "1e30G"}) EXPECT_FALSE(parse_bytes(bad)) << bad;
}

TEST(Text, ParsesNumbersInAnyLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8"})
    if (std::setlocale(LC_ALL, name)) {
      EXPECT_EQ(parse_double("1.5"), 1.5);
    }
  std::setlocale(LC_ALL, before.c_str());
}

TEST(Text, SuggestsTheNearestName) {
  const std::vector<std::string> names{"platt", "box", "crop", "subpixel"};
  EXPECT_EQ(triad::nearest_name("plat", names), "platt");
  EXPECT_EQ(triad::nearest_name("sub-pixel", names), "subpixel");
  EXPECT_EQ(triad::nearest_name("corp", names), "crop");
  EXPECT_EQ(triad::nearest_name("gaussian", names), std::nullopt);
  EXPECT_EQ(triad::nearest_name("", names), std::nullopt);
}

TEST(Text, FormatsForPeople) {
  EXPECT_EQ(triad::format_bytes(999), "999 B");
  EXPECT_EQ(triad::format_bytes(1000), "1.0 kB");
  EXPECT_EQ(triad::format_bytes(412'300'000), "412 MB");
  EXPECT_EQ(triad::format_double(.1), "0.1");
  EXPECT_TRUE(triad::is_valid_utf8("grün €"));
  for (const char* bad : {"\xff", "\xc0\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82"})
    EXPECT_FALSE(triad::is_valid_utf8(bad));
}

TEST(Text, EscapesWhatIsNoUtf8) {
  for (const auto& [bytes, text] : {std::pair<std::string, std::string>{"gr\xfcn.exr", "gr\\xfcn.exr"},
                                    {"gr\xc3\xbcn.exr", "gr\xc3\xbcn.exr"},
                                    {"\xe2\x82", "\\xe2\\x82"},
                                    {"\xc0\x80\xff", "\\xc0\\x80\\xff"},
                                    {"\xed\xa0\x80", "\\xed\\xa0\\x80"},
                                    {"", ""}}) {
    EXPECT_EQ(triad::escape_non_utf8(bytes), text);
    EXPECT_TRUE(triad::is_valid_utf8(text));
    EXPECT_EQ(triad::unescape_non_utf8(text), bytes);
  }
  // What was never a byte of such a name stays.
  for (const char* text : {"a\\x41", "a\\x", "a\\xf", "\\xFC", "\\xgf"})
    EXPECT_EQ(triad::unescape_non_utf8(text), text);
}

class Files : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("triad-base-" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  size_t entries() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}));
  }
  fs::path folder_;
};

// A process that was killed while it wrote leaves its file; the next one removes that file and nothing else.
TEST_F(Files, WhatAKilledProcessLeftIsRemoved) {
  const auto age = [](const fs::path& file, int seconds) {
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::seconds(seconds));
  };
  const pid_t child = fork();
  if (child == 0) {
    triad::AtomicFile file(folder_ / "a.exr");
    raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_EQ(entries(), 1u);
  const std::string left = fs::directory_iterator(folder_)->path().filename();
  age(folder_ / left, 60);

  const std::string dead = std::to_string(child), machine = left.substr(0, left.find(dead));  // ".triad-MACHINE-"
  const std::string own = std::to_string(getpid());
  std::vector<std::string> stay{machine + own + "-900.exr",  machine + "1-0.exr",
                                machine + dead + "-x.exr",   machine + dead + "-0.exr.bak",
                                machine + dead + "-00.exr",  machine + dead + "-.exr",
                                machine + dead + "-0exr",    machine + "0" + dead + "-0.exr",
                                machine + "-0.exr",          ".triad-00000000-" + dead + "-0.exr",
                                ".triad-" + dead + "-0.exr", "x" + left};
  for (const std::string& name : stay) {
    std::ofstream(folder_ / name) << "x";
    age(folder_ / name, 60);
  }
  stay.push_back(machine + dead + "-901.exr");  // just written
  std::ofstream(folder_ / stay.back()) << "x";
  stay.push_back(machine + dead + "-902.exr");
  fs::create_directory(folder_ / stay.back());
  age(folder_ / stay.back(), 60);
  stay.push_back(machine + dead + "-903.exr");
  fs::create_symlink("nowhere", folder_ / stay.back());
  std::ofstream(folder_ / (machine + dead + "-904")) << "x";  // without an extension, to be removed as well
  age(folder_ / (machine + dead + "-904"), 60);

  triad::write_text_file(folder_ / "b.txt", "b");
  EXPECT_FALSE(fs::exists(folder_ / left));
  for (const std::string& name : stay) EXPECT_TRUE(fs::exists(fs::symlink_status(folder_ / name))) << name;
  EXPECT_EQ(entries(), stay.size() + 1);
}

TEST_F(Files, AppearAtCommitOrNotAtAll) {
  const std::string path = folder_ / "a.txt";
  {
    triad::AtomicFile file(path);
    std::ofstream(file.temporary()) << "half";
    EXPECT_FALSE(fs::exists(path));
    EXPECT_EQ(fs::path(file.temporary()).extension(), ".txt");
  }
  EXPECT_EQ(entries(), 0u);
  triad::write_text_file(path, "whole");
  EXPECT_EQ(triad::read_text_file(path), "whole");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(Files, RefuseWhatCannotBeWritten) {
  EXPECT_THROW(triad::AtomicFile(folder_ / "none" / "a.txt"), triad::Error);
  EXPECT_THROW(triad::AtomicFile(folder_.string()), triad::Error);
  EXPECT_THROW(triad::AtomicFile(""), triad::Error);
  EXPECT_THROW(triad::read_text_file(folder_ / "none"), triad::Error);
}

namespace {

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const triad::Error& error) {
    return error.what();
  }
  return "";
}

int mode_of(const fs::path& path) {
  struct stat info {};
  EXPECT_EQ(lstat(path.c_str(), &info), 0);
  return static_cast<int>(info.st_mode & 07777);
}

}  // namespace

TEST_F(Files, LinksAndPermissionsStay) {
  fs::create_directories(folder_ / "far");
  const fs::path target = folder_ / "far" / "b.txt";
  std::ofstream(target) << "old";
  ASSERT_EQ(chmod(target.c_str(), 0640), 0);
  fs::create_symlink("far/b.txt", folder_ / "a.txt");
  fs::create_symlink("a.txt", folder_ / "link to link.txt");
  triad::write_text_file(folder_ / "link to link.txt", "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link to link.txt"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "a.txt"));
  EXPECT_FALSE(fs::is_symlink(target));
  EXPECT_EQ(triad::read_text_file(target), "new");
  EXPECT_EQ(mode_of(target), 0640);

  // Not even root's own temporary file is more open than what it replaces.
  ASSERT_EQ(chmod(target.c_str(), 0400), 0);
  {
    triad::AtomicFile file(folder_ / "a.txt");
    EXPECT_EQ(fs::path(file.temporary()).parent_path(), fs::canonical(folder_ / "far"));
    EXPECT_EQ(mode_of(file.temporary()), 0600);
    file.commit();
  }
  EXPECT_EQ(mode_of(target), 0400);

  fs::create_symlink("far/none.txt", folder_ / "dangling.txt");
  triad::write_text_file(folder_ / "dangling.txt", "made");
  EXPECT_TRUE(fs::is_symlink(folder_ / "dangling.txt"));
  EXPECT_EQ(triad::read_text_file(folder_ / "far" / "none.txt"), "made");
  fs::create_symlink("round.txt", folder_ / "round.txt");
  EXPECT_THAT(error_of([&] { triad::AtomicFile(folder_ / "round.txt"); }), testing::HasSubstr("symbolic links"));
}

TEST_F(Files, StreamsAreWrittenToAndNotReplaced) {
  const std::string pipe = folder_ / "pipe.json";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  fs::create_symlink("pipe.json", folder_ / "link.json");
  for (const std::string& path : {pipe, (folder_ / "link.json").string()}) {
    ASSERT_THAT(error_of([&] { triad::AtomicFile{path}; }), testing::HasSubstr("must be a regular file"));
    std::string text;
    std::thread reader([&] { text = triad::read_text_file(pipe); });
    triad::check_text_file(path);
    triad::write_text_file(path, "through");
    reader.join();
    EXPECT_EQ(text, "through");
    EXPECT_TRUE(fs::is_fifo(pipe));
  }
  // Only through links of ours, and after the refusal above: nothing here may rename over a device.
  fs::create_symlink("/dev/null", folder_ / "null.json");
  fs::create_symlink("/dev/full", folder_ / "full.json");
  triad::write_text_file(folder_ / "null.json", "away");
  EXPECT_THAT(error_of([&] { triad::write_text_file(folder_ / "full.json", "text"); }),
              testing::AllOf(testing::HasSubstr("full.json"), testing::HasSubstr("No space left")));
  EXPECT_TRUE(fs::is_symlink(folder_ / "null.json"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  EXPECT_EQ(entries(), 4u);
}

TEST_F(Files, AnOpenFileByItsDescriptorIsAppendedTo) {
  // What /dev/stdout is when the shell sent it to a file: replacing that file would lose what was printed.
  const std::string path = folder_ / "out.txt";
  std::ofstream held(path);
  held << "first " << std::flush;
  std::string through;
  for (const auto& entry : fs::directory_iterator("/proc/self/fd")) {
    std::error_code error;
    if (fs::read_symlink(entry.path(), error) == fs::canonical(path)) through = entry.path();
  }
  ASSERT_NE(through, "");
  triad::check_text_file(through);
  triad::write_text_file(through, "second");
  EXPECT_EQ(triad::read_text_file(path), "first second");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(Files, TheLongestNamesCanBeWritten) {
  for (const std::string& name : {std::string(251, 'n') + ".txt", "a." + std::string(253, 'e')}) {
    triad::write_text_file(folder_ / name, "whole");
    EXPECT_EQ(triad::read_text_file(folder_ / name), "whole");
  }
}

TEST_F(Files, AHandlerFindsEveryTemporaryName) {
  std::vector<std::unique_ptr<triad::AtomicFile>> files;
  for (int i = 0; i < 200; ++i)
    files.push_back(std::make_unique<triad::AtomicFile>(folder_ / (std::to_string(i) + ".txt")));
  files[100]->commit();
  files.erase(files.begin() + 100);
  EXPECT_EQ(entries(), 200u);
  triad::unlink_temporaries();
  EXPECT_EQ(entries(), 1u);
}
