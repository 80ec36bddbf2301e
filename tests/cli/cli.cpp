// SPDX-License-Identifier: Apache-2.0
#include "cli.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <sstream>
#include <thread>

namespace fs = std::filesystem;

namespace cli {
namespace {

constexpr uid_t kNobody = 65534;

// A file in memory: unlike a pipe it never fills up, so that nobody has to read while the program runs.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& content = "") : descriptor_(memfd_create("cli", MFD_CLOEXEC)) {
    if (descriptor_ < 0 || write(descriptor_, content.data(), content.size()) != static_cast<ssize_t>(content.size()))
      throw std::runtime_error("no file in memory");
    lseek(descriptor_, 0, SEEK_SET);
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  int descriptor() const { return descriptor_; }
  std::string content() const {
    std::string text(static_cast<size_t>(lseek(descriptor_, 0, SEEK_END)), '\0');
    if (pread(descriptor_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size())) return "";
    return text;
  }

 private:
  int descriptor_;
};

// What the program needs in a place that everybody may read: the build folder may be below /root.
fs::path public_copy(const fs::path& folder) {
  const fs::path copy = folder.parent_path() / (folder.filename().string() + "-program");
  if (!fs::exists(copy)) {
    const fs::path build = TRIAD_BINARY_DIR;
    fs::create_directories(copy / "bin");
    fs::copy_file(TRIAD_PROGRAM, copy / "bin/triad");
    fs::copy(build / "lib", copy / "lib", fs::copy_options::recursive | fs::copy_options::copy_symlinks);
    fs::copy(build / "plugins", copy / "plugins");
    fs::copy(fs::path(TRIAD_SOURCE_DIR) / "data", copy / "data", fs::copy_options::recursive);
    for (const fs::path& each : {copy, copy / "bin", copy / "bin/triad"}) fs::permissions(each, fs::perms(0755));
    for (const char* part : {"lib", "plugins", "data"})
      for (const auto& entry : fs::recursive_directory_iterator(copy / part))
        if (!entry.is_symlink())
          fs::permissions(entry.path(), fs::perms::others_read | fs::perms::others_exec, fs::perm_options::add);
  }
  return copy;
}

void limit(int what, rlim_t value) {
  if (value == RLIM_INFINITY) return;
  const rlimit both{value, value};
  if (setrlimit(static_cast<__rlimit_resource>(what), &both) != 0) _exit(126);
}

[[noreturn]] void become(const std::string& program, const std::vector<std::string>& arguments,
                         const Options& options, const fs::path& folder, bool drop_rights, int in, int out, int err) {
  dup2(in, 0);
  dup2(out, 1);
  dup2(err, 2);
  if (chdir(folder.c_str()) != 0) _exit(126);
  for (const auto& [key, value] : options.environment) setenv(key.c_str(), value.c_str(), 1);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, options.file_bytes);
  limit(RLIMIT_AS, options.memory_bytes);
  if (drop_rights && (setgroups(0, nullptr) != 0 || setgid(kNobody) != 0 || setuid(kNobody) != 0)) _exit(126);
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  _exit(127);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string text_of(const std::vector<std::string>& arguments) {
  std::string text = "triad";
  for (const std::string& argument : arguments) text += " " + argument;
  return text;
}

}  // namespace

std::vector<std::string> Outcome::error_lines() const {
  std::vector<std::string> lines;
  std::istringstream stream(err);
  for (std::string line; std::getline(stream, line);)
    if (line.rfind("libpng ", 0) != 0) lines.push_back(line);
  return lines;
}

nlohmann::json Outcome::json() const {
  nlohmann::json value = nlohmann::json::parse(out, nullptr, false);
  EXPECT_FALSE(value.is_discarded()) << "not JSON: " << out;
  return value.is_discarded() ? nlohmann::json() : value;
}

void Cli::SetUp() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(info->test_suite_name()) + "." + info->name();
  std::replace(name.begin(), name.end(), '/', '-');
  folder_ = fs::temp_directory_path() / ("triad-cli-" + name + "-" + std::to_string(getpid()));
  fs::create_directories(folder_);
}

void Cli::TearDown() {
  fs::remove_all(folder_);
  fs::remove_all(folder_.string() + "-program");
}

std::set<std::string> Cli::files() const {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder_))
    names.insert(entry.path().lexically_relative(folder_).string());
  return names;
}

Outcome Cli::triad(const std::vector<std::string>& arguments, const Options& options) const {
  Options used = options;
  std::string program = TRIAD_PROGRAM;
  const bool drop_rights = options.as_nobody && geteuid() == 0;
  if (drop_rights) {
    const fs::path copy = public_copy(folder_);
    program = (copy / "bin/triad").string();
    used.environment["LD_LIBRARY_PATH"] = (copy / "lib").string();
    used.environment["TRIAD_DATA"] = (copy / "data").string();
  }
  const MemoryFile in(options.input), out, err;
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0)
    become(program, arguments, used, folder_, drop_rights, in.descriptor(), out.descriptor(), err.descriptor());
  Outcome outcome;
  int status = 0;
  bool interrupted = false;
  std::chrono::steady_clock::time_point interrupt_time;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (options.interrupt_when && !interrupted && options.interrupt_when()) {
      interrupted = true;
      interrupt_time = std::chrono::steady_clock::now();
      kill(child, options.interrupt_signal);
    }
    if (seconds_since(start) > options.time_limit_s) {
      outcome.timed_out = true;
      kill(child, SIGKILL);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (interrupted) outcome.seconds_after_interrupt = seconds_since(interrupt_time);
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = out.content();
  outcome.err = err.content();
  EXPECT_FALSE(outcome.timed_out) << text_of(arguments) << " ran for " << options.time_limit_s << " s";
  return outcome;
}

Outcome Cli::expect_status(int status, const std::vector<std::string>& arguments, const Options& options) const {
  Outcome outcome = triad(arguments, options);
  EXPECT_EQ(outcome.status, status) << text_of(arguments) << "\n" << outcome.err;
  return outcome;
}

Outcome Cli::expect_success(const std::vector<std::string>& arguments, const Options& options) const {
  Outcome outcome = expect_status(0, arguments, options);
  EXPECT_EQ(outcome.err, "") << text_of(arguments);
  return outcome;
}

void Cli::expect_refusal(const std::vector<std::string>& arguments, const std::vector<std::string>& words,
                         const Options& options) const {
  const std::set<std::string> before = files();
  const Outcome outcome = expect_status(2, arguments, options);
  EXPECT_EQ(outcome.error_lines().size(), 1u) << text_of(arguments) << "\n" << outcome.err;
  for (const std::string& word : words)
    EXPECT_NE(outcome.err.find(word), std::string::npos)
        << text_of(arguments) << "\n'" << word << "' is not in: " << outcome.err;
  EXPECT_EQ(files(), before) << text_of(arguments);
}

nlohmann::json Cli::compare(std::vector<std::string> arguments) const {
  arguments.insert(arguments.begin(), "compare");
  arguments.insert(arguments.end(), {"--json", "-"});
  const nlohmann::json report = expect_success(arguments).json();
  EXPECT_TRUE(report.contains("results")) << report;
  return report.contains("results") ? report["results"] : nlohmann::json::array();
}

}  // namespace cli
