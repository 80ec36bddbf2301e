// SPDX-License-Identifier: Apache-2.0
// Places that cannot be written to, disks that fill up, and Ctrl-C: what was there before stays, and nothing new.
#include <sys/wait.h>

#include <chrono>
#include <cstdlib>

#include "cli.hpp"
#include "pictures.hpp"

namespace fs = std::filesystem;

namespace cli {
namespace {

class BadOutput : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    save(path("in.exr"), noise(300, 200));
  }
  bool any_file_with(const std::string& part) const {
    for (const std::string& name : files())
      if (name.find(part) != std::string::npos) return true;
    return false;
  }
};

TEST_F(BadOutput, FolderIsMissing) {
  expect_refusal({"run", "in.exr", "-o", "missing/out.png"}, {"missing/out.png", "'missing'"});
  expect_refusal({"run", "in.exr", "write:missing/tap.exr", "box:x=2", "-o", "out.png"}, {"missing/tap.exr"});
  for (const std::string option : {"--json", "--csv", "--map"})
    expect_refusal({"compare", "in.exr", "--ref", "in.exr", "-m", "error", option, "missing/out.exr"},
                   {"missing/out.exr"});
}

TEST_F(BadOutput, IsAFolder) {
  fs::create_directory(path("out.png"));
  expect_refusal({"run", "in.exr", "-o", "out.png"}, {"out.png"});
  save_text(path("file"), "");
  expect_refusal({"run", "in.exr", "-o", "file/out.png"}, {"file/out.png"});
}

TEST_F(BadOutput, FolderIsReadOnly) {
  fs::create_directory(path("locked"));
  fs::permissions(path("locked"), fs::perms(0555));
  fs::permissions(folder_, fs::perms(0777));
  Options options;
  options.as_nobody = true;
  expect_refusal({"run", "in.exr", "-o", "locked/out.png"}, {"locked/out.png", "ermission"}, options);
  expect_refusal({"compare", "in.exr", "--ref", "in.exr", "-m", "error", "--json", "locked/out.json"},
                 {"locked/out.json", "ermission"}, options);
  // The same rights are enough where writing is allowed: it was the folder.
  expect_success({"run", "in.exr", "-o", "out.png"}, options);
}

TEST_F(BadOutput, DiskIsFull) {
  save_text(path("out.exr"), "what was there before");
  Options options;
  options.file_bytes = 20000;  // 300 x 200 x 3 values of noise need 360 kB in half, 180 kB in 8 bits
  for (const std::string name : {"out.exr", "out.png", "out.tif", "out.hdr", "out.jpg"}) {
    if (name == "out.jpg") options.file_bytes = 4000;
    expect_refusal({"run", "in.exr", "-o", name}, {name}, options);
  }
  expect_refusal({"run", "in.exr", "write:tap.exr", "box:x=20,y=20", "-o", "small.png"}, {"tap.exr"}, options);
  EXPECT_EQ(load_text(path("out.exr")), "what was there before");
}

TEST_F(BadOutput, StandardOutputIsFull) {
  // /dev/full is what a full disk looks like on stdout; a report that was lost must not count as success.
  for (const std::string& words : std::vector<std::string>{
           "compare in.exr --ref in.exr -m error --json -", "compare in.exr --ref in.exr -m error", "list",
           "info in.exr", "run in.exr box:x=2 -o out.exr --explain"}) {
    const std::string command = "cd '" + folder_.string() + "' && '" TRIAD_PROGRAM "' " + words + " >/dev/full 2>err";
    const int status = std::system(command.c_str());
    EXPECT_EQ(WEXITSTATUS(status), 2) << words;
    EXPECT_NE(load_text(path("err")).find("standard output"), std::string::npos) << load_text(path("err"));
  }
}

TEST_F(BadOutput, IsTheInput) {
  const std::string before = load_text(path("in.exr"));
  const Outcome outcome = triad({"run", "in.exr", "box:x=2", "-o", "in.exr"});
  // Either is fine: a refusal that changes nothing, or the right result. What must not be is a broken file.
  if (outcome.status == 0) {
    EXPECT_EQ(load(path("in.exr")).width, 150);
  } else {
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(load_text(path("in.exr")), before);
  }
  EXPECT_EQ(files(), std::set<std::string>{"in.exr"});
}

TEST_F(BadOutput, OfTwoStagesIsOneFile) {
  expect_refusal({"run", "in.exr", "write:out.exr", "box:x=2", "-o", "out.exr"}, {"out.exr"});
}

// A picture of 1.3 thousand million pixels, and next to nothing on the disk: there is time to interrupt.
class Interrupted : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    save_claim(path("long.tif"), 12000, 110000);
  }
  void expect_clean_end(const std::vector<std::string>& arguments, const std::function<bool()>& when) {
    const std::set<std::string> before = files();
    Options options;
    options.interrupt_when = when;
    const Outcome outcome = triad(arguments, options);
    EXPECT_EQ(outcome.status, 130) << outcome.err;
    EXPECT_EQ(files(), before);
    EXPECT_LT(outcome.seconds_after_interrupt, 3);
    EXPECT_LE(outcome.error_lines().size(), 1u) << outcome.err;
  }
  // True once something has been written under a temporary name: the run is on its way.
  std::function<bool()> something_was_written() {
    return [this, before = files()] {
      std::error_code error;
      for (const auto& entry : fs::directory_iterator(folder_, error))
        if (!before.count(entry.path().filename().string()) && entry.is_regular_file(error) &&
            entry.file_size(error) > 100000)
          return true;
      return false;
    };
  }
};

TEST_F(Interrupted, RunLeavesNothing) {
  for (const std::string stage :
       {"box:x=3", "subpixel", "platt", "platt:range=clip,engine=fir,taps=31", "platt:range=clip,engine=fft"})
    expect_clean_end({"run", "long.tif", "--cells", "3x1", stage, "-o", "out.tif"}, something_was_written());
}

TEST_F(Interrupted, RunKeepsWhatWasThere) {
  save_text(path("out.tif"), "what was there before");
  expect_clean_end({"run", "long.tif", "--cells", "3x1", "write:tap.tif", "box:x=3", "-o", "out.tif"},
                   something_was_written());
  EXPECT_EQ(load_text(path("out.tif")), "what was there before");
}

TEST_F(Interrupted, CompareLeavesNothing) {
  const auto start = std::chrono::steady_clock::now();
  expect_clean_end({"compare", "long.tif", "--ref", "long.tif", "-m", "error", "--json", "out.json"},
                   [=] { return std::chrono::steady_clock::now() - start > std::chrono::milliseconds(600); });
}

}  // namespace
}  // namespace cli
