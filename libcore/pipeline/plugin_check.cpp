// SPDX-License-Identifier: Apache-2.0
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/plugin_check.hpp>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/plugin_file.hpp>
#include <triad/pipeline/plugin_probe.hpp>

namespace triad {
namespace {

using Clock = std::chrono::steady_clock;

ParamTexts parse_params(const std::string& text) {
  ParamTexts params;
  if (text.empty()) return params;
  for (const std::string& part : split_quoted(text, ',')) {
    const size_t equals = part.find('=');
    if (equals == 0 || equals == std::string::npos)
      throw_usage("parameters to check with: '" + part + "' is not of the form key=value");
    params[part.substr(0, equals)] = unquote(std::string_view(part).substr(equals + 1));
  }
  return params;
}

// Reads lines from the child until it ends or its time is up.
class Listener {
 public:
  Listener(int descriptor, Clock::time_point deadline) : descriptor_(descriptor), deadline_(deadline) {}

  // False when the time was up first.
  bool listen() {
    for (char buffer[4096];;) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now()).count();
      pollfd wait{descriptor_, POLLIN, 0};
      if (left <= 0) return false;
      const int ready = poll(&wait, 1, static_cast<int>(std::min<long long>(left + 1, 1000)));
      if (ready < 0 && errno != EINTR) return true;
      if (ready <= 0) continue;
      const ssize_t got = read(descriptor_, buffer, sizeof buffer);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return true;
      for (ssize_t i = 0; i < got; ++i) {
        if (buffer[i] != '\n') {
          line_ += buffer[i];
          continue;
        }
        take(line_);
        line_.clear();
      }
    }
  }

  std::vector<CheckResult> results;
  std::string doing, stage;  // of the last mark
  bool done = false;

 private:
  void take(const std::string& line) {
    std::vector<std::string> parts;
    for (size_t at = 0; at <= line.size();) {
      const size_t end = std::min(line.find('\t', at), line.size());
      parts.push_back(line.substr(at, end - at));
      at = end + 1;
    }
    if (parts.size() != 4 || parts[0].size() != 1) return;
    switch (parts[0][0]) {
      case 'D': done = true; break;
      case 'M':
        stage = parts[2];
        doing = parts[3];
        break;
      default: results.push_back({parts[1], parts[2], parts[0] == "P", parts[0] == "S", parts[3]});
    }
  }
  int descriptor_;
  Clock::time_point deadline_;
  std::string line_;
};

}  // namespace

std::vector<CheckResult> check_plugin(const std::string& path, const std::string& stage_params, double time_limit_s) {
  const ParamTexts params = parse_params(stage_params);
  std::vector<CheckResult> results;
  try {
    const PluginFile file(path, PathTrust::kNamed);
  } catch (const PluginError& error) {
    return {{error.rule(), "", false, false, error.finding()}};
  }
  results.push_back({"file", "", true, false, "a shared object with the symbol triad_library_v1"});

  int ends[2];
  if (pipe(ends) != 0) throw_input("cannot check '" + path + "': no pipe: " + std::strerror(errno));
  std::fflush(stdout);
  std::fflush(stderr);
  const pid_t child = fork();
  if (child < 0) {
    close(ends[0]);
    close(ends[1]);
    throw_input("cannot check '" + path + "': no process: " + std::strerror(errno));
  }
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    close(ends[0]);
    probe_plugin(path, params, ends[1]);
  }
  close(ends[1]);
  Listener listener(ends[0], Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                std::chrono::duration<double>(time_limit_s)));
  const bool in_time = listener.listen();
  close(ends[0]);
  if (!in_time) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  results.insert(results.end(), listener.results.begin(), listener.results.end());
  if (!in_time)
    results.push_back({"call.hang", listener.stage, false, false,
                       "it did not end within " + format_double(time_limit_s) + " s, while " + listener.doing});
  else if (!listener.done && WIFSIGNALED(status))
    results.push_back(
        {"call.crash", listener.stage, false, false,
         std::string("it ended by the signal ") + strsignal(WTERMSIG(status)) + ", while " + listener.doing});
  else if (!listener.done &&
           std::none_of(results.begin(), results.end(), [](const CheckResult& r) { return !r.passed && !r.skipped; }))
    results.push_back({"call.exit", listener.stage, false, false, "it ended the process, while " + listener.doing});
  return results;
}

}  // namespace triad
