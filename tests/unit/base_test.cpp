// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <filesystem>
#include <fstream>
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
