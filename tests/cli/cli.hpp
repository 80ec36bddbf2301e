// SPDX-License-Identifier: Apache-2.0
// Runs the program as a shell would, and says what came of it.
#pragma once

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace cli {

struct Options {
  std::map<std::string, std::string> environment;  // added to the caller's
  std::string input;                               // what the program reads on stdin
  double time_limit_s = 30;                        // killed after that
  rlim_t file_bytes = RLIM_INFINITY;               // the largest file it can write
  rlim_t memory_bytes = RLIM_INFINITY;             // of address space
  bool as_nobody = false;                          // drops root's rights; needs nothing if there are none to drop
  std::function<bool()> interrupt_when;            // polled every millisecond; the signal is sent once it is true
  int interrupt_signal = SIGINT;
};

struct Outcome {
  int status = -1;  // exit status; 128 + N after signal N, as shells have it
  bool timed_out = false;
  std::string out, err;
  double seconds_after_interrupt = 0;

  // Of stderr. Without those that libpng prints, which OpenImageIO gives no way to silence.
  std::vector<std::string> error_lines() const;
  // stdout as JSON; a test failure and null if it is none.
  nlohmann::json json() const;
};

// Every test gets an empty folder of its own, which is the program's working folder, and which is removed.
class Cli : public testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }
  // Names of all files and folders below the folder, hidden ones too.
  std::set<std::string> files() const;

  // `triad ARGUMENTS...`
  Outcome triad(const std::vector<std::string>& arguments, const Options& options = {}) const;
  // The same, and a test failure unless it ends with `status`.
  Outcome expect_status(int status, const std::vector<std::string>& arguments, const Options& options = {}) const;
  // Status 0 and nothing on stderr.
  Outcome expect_success(const std::vector<std::string>& arguments, const Options& options = {}) const;
  // A refusal: exit status 2, exactly one line on stderr that contains each of `words` and nothing below the
  // folder that was not there before.
  void expect_refusal(const std::vector<std::string>& arguments, const std::vector<std::string>& words,
                      const Options& options = {}) const;
  // The results of `triad compare ARGUMENTS... --json -`.
  nlohmann::json compare(std::vector<std::string> arguments) const;

  std::filesystem::path folder_;
};

}  // namespace cli
