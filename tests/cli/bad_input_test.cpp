// SPDX-License-Identifier: Apache-2.0
// Files that are missing, empty, cut short, corrupt or not pictures, in every format and in every place where a
// picture is read. Each ends in one line that names the file, and leaves nothing behind.
#include <sys/stat.h>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

constexpr rlim_t kPlentyOfMemory = rlim_t{6} << 30;

// Every command that reads a picture, on the file named.
void expect_refused_everywhere(const std::function<void(const std::vector<std::string>&)>& refuse,
                               const std::string& name) {
  refuse({"run", name, "box", "-o", "out.exr"});
  refuse({"run", name, "-o", "out.png"});
  refuse({"run", "good.exr", "-o", "out.exr", "-m", "error", "--ref", name});
  refuse({"compare", name, "--ref", "good.exr", "-m", "error", "--map", "map.exr", "--json", "out.json"});
  refuse({"compare", "good.exr", "--ref", name, "-m", "error", "--csv", "out.csv"});
}

std::string by_extension(const testing::TestParamInfo<const char*>& each) { return each.param; }

class BadInput : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    save(path("good.exr"), noise(24, 16));
  }
  void expect_all_refused(const std::string& name) {
    expect_refused_everywhere(
        [&](const std::vector<std::string>& arguments) { expect_refusal(arguments, {name}, limited()); }, name);
  }
  static Options limited() {
    Options options;
    options.memory_bytes = kPlentyOfMemory;
    return options;
  }
};

// An installation that lacks the library which reads pictures: what needs none goes on.
TEST_F(BadInput, PicturesWithoutTheirLibrary) {
  std::filesystem::create_directory(folder_ / "lib");
  std::filesystem::copy(TRIAD_LIBRARY, folder_ / "lib/libtriad.so.0");
  save(path("a.exr"), constant(4, 4, {.5f, .5f, .5f}));
  Options options;
  options.environment = {{"LD_LIBRARY_PATH", path("lib")}, {"TRIAD_DATA", TRIAD_SOURCE_DIR "/data"}};
  expect_status(0, {"--version"}, options);
  expect_refusal({"info", "a.exr"}, {"cannot load", "lib/triad/openimageio.so", "pictures"}, options);
}

TEST_F(BadInput, IsMissing) {
  expect_all_refused("missing.exr");
  expect_refusal({"info", "missing.exr"}, {"missing.exr"});
  expect_refusal({"compare", "good.exr", "--ref", "good.exr", "-m", "error", "--mask", "missing.png"},
                 {"missing.png"});
}

TEST_F(BadInput, IsAFolderOrAPipe) {
  std::filesystem::create_directory(path("folder.exr"));
  expect_all_refused("folder.exr");
  ASSERT_EQ(mkfifo(path("pipe.exr").c_str(), 0600), 0);
  expect_refusal({"run", "pipe.exr", "-o", "out.png"}, {"pipe.exr"});  // and does not wait for a writer
}

TEST_F(BadInput, CannotBeRead) {
  std::filesystem::permissions(path("good.exr"), std::filesystem::perms::none);
  std::filesystem::permissions(folder_, std::filesystem::perms::all);
  Options options;
  options.as_nobody = true;
  expect_refusal({"run", "good.exr", "-o", "out.png"}, {"good.exr", "ermission"}, options);
}

TEST_F(BadInput, IsNotAPicture) {
  save_text(path("text.txt"), "To whom it may concern\n");
  expect_all_refused("text.txt");
  save_text(path("script.png"), "#!/bin/sh\n" + std::string(4000, 'x'));
  expect_all_refused("script.png");
}

class BadFormat : public BadInput, public testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override {
    BadInput::SetUp();
    extension_ = GetParam();
    whole_ = "whole." + extension_;
    // Noise fills a file evenly with pixels, so that a part of the file is about the same part of the picture.
    const bool integers = extension_ == "png" || extension_ == "jpg";
    save(path(whole_), noise(64, 48), integers ? "uint8" : "float");
  }
  std::string extension_, whole_;
};

TEST_P(BadFormat, IsEmpty) {
  save_text(path("empty." + extension_), "");
  expect_all_refused("empty." + extension_);
}

TEST_P(BadFormat, IsCutShort) {
  for (const double share : {.5, .95}) {
    const std::string name = "cut." + extension_;
    truncate_copy(path(whole_), path(name), share);
    expect_refusal({"run", name, "box:x=2,y=2", "-o", "out.exr"}, {name});
    expect_refusal({"run", name, "--cells", "3x1", "crop:w=63", "platt", "-o", "out.exr"}, {name});
    expect_refusal({"compare", whole_, "--ref", name, "-m", "error", "--map", "map.exr"}, {name});
  }
}

TEST_P(BadFormat, IsCutInItsHeader) {
  for (const size_t bytes : {3, 9, 20}) {
    const std::string name = "head." + extension_;
    save_text(path(name), load_text(path(whole_)).substr(0, bytes));
    expect_refusal({"run", name, "-o", "out.exr"}, {name});
    expect_refusal({"info", name}, {name});
  }
}

TEST_P(BadFormat, HasAHeaderOfNoise) {
  std::string bytes = load_text(path(whole_));
  for (size_t i = 8; i < 200 && i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 89 + 31);
  save_text(path("noise." + extension_), bytes);
  expect_refusal({"run", "noise." + extension_, "-o", "out.exr"}, {"noise." + extension_}, limited());
}

INSTANTIATE_TEST_SUITE_P(Formats, BadFormat, testing::Values("exr", "png", "tif", "hdr", "jpg"), by_extension);

// Where the format can tell. (A changed byte of a TIFF or HDR pixel is just another pixel.)
class CorruptPixels : public BadInput, public testing::WithParamInterface<const char*> {};

TEST_P(CorruptPixels, AreFound) {
  const std::string extension = GetParam(), name = "corrupt." + extension;
  save(path(name), from_function(300, 200, 3, [](int x, int y, int) { return (x * y % 97) / 97.; }),
       extension == "png" ? "uint8" : "half");
  std::string bytes = load_text(path(name));
  for (size_t i = bytes.size() / 2; i < bytes.size() / 2 + 64; ++i) bytes[i] = static_cast<char>(~bytes[i]);
  save_text(path(name), bytes);
  expect_refusal({"run", name, "-o", "out.exr"}, {name});
}

INSTANTIATE_TEST_SUITE_P(Formats, CorruptPixels, testing::Values("exr", "png"), by_extension);

class AbsurdClaim : public BadInput, public testing::WithParamInterface<const char*> {};

TEST_P(AbsurdClaim, IsRefusedAtOnce) {
  const std::string name = std::string("claim.") + GetParam();
  save_claim(path(name), 1000000, 1000000);
  Options options = limited();
  options.time_limit_s = 5;
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"run", name, "box", "-o", "out.exr"},
                                                    {"run", name, "platt", "--cells", "3x1", "-o", "out.exr"},
                                                    {"compare", name, "--ref", "good.exr", "-m", "error"},
                                                    {"compare", "good.exr", "--ref", name, "-m", "error"}})
    expect_refusal(arguments, {name}, options);
}

INSTANTIATE_TEST_SUITE_P(Formats, AbsurdClaim, testing::Values("exr", "png", "tif", "hdr"), by_extension);

TEST_F(BadInput, IsAChain) {
  expect_refusal({"run", "good.exr", "--chain", "missing.toml", "-o", "out.png"}, {"missing.toml"});
  save_text(path("broken.toml"), "[[stage\nname = 3");
  expect_refusal({"run", "good.exr", "--chain", "broken.toml", "-o", "out.png"}, {"broken.toml"});
}

}  // namespace
}  // namespace cli
