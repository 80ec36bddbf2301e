// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <cstdio>
#include <mutex>
#include <set>
#include <triad/base/log.hpp>

namespace triad {
namespace {
std::atomic<LogLevel> g_level{LogLevel::kWarning};
std::mutex g_mutex;
}  // namespace

void set_log_level(LogLevel level) { g_level = level; }
LogLevel log_level() { return g_level; }

std::string printable(const std::string& text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    if (u < 0x20 || u == 0x7f) {
      char escape[5];
      std::snprintf(escape, sizeof escape, "\\x%02x", u);
      out += escape;
    } else {
      out += c;
    }
  }
  return out;
}

void log_message(LogLevel level, const std::string& message) {
  if (level < g_level.load()) return;
  const std::string line =
      std::string("triad: ") + (level == LogLevel::kWarning ? "warning: " : "") + printable(message) + "\n";
  const std::lock_guard lock(g_mutex);
  if (level == LogLevel::kWarning) {
    static std::set<std::string> seen;
    if (!seen.insert(line).second) return;
  }
  std::fputs(line.c_str(), stderr);
}

}  // namespace triad
