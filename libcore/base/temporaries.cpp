// SPDX-License-Identifier: Apache-2.0
#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string_view>
#include <triad/base/temporaries.hpp>
#include <triad/base/text.hpp>

namespace triad {
namespace {

constexpr std::string_view kPrefix = ".triad-";
constexpr size_t kMachineDigits = 8;
constexpr time_t kLeastAge_s = 10;

// Folders may be shared over a network, and process numbers mean nothing there.
std::string find_machine() {
  char text[PATH_MAX] = {};
  if (gethostname(text, sizeof text - 1) != 0) text[0] = 0;
  std::string all = text;
  std::string id;
  std::ifstream("/etc/machine-id") >> id;
  all += '\n' + id + '\n';
  const ssize_t length = readlink("/proc/self/ns/pid", text, sizeof text);
  if (length > 0) all.append(text, static_cast<size_t>(length));
  uint32_t hash = 2166136261;  // FNV-1a: G. Fowler, L. C. Noll, K.-P. Vo
  for (const char c : all) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619;
  char digits[kMachineDigits + 1];
  std::snprintf(digits, sizeof digits, "%08x", hash);
  return digits;
}

const std::string& machine() {
  static const std::string name = find_machine();
  return name;
}

// A number as it is printed, and the text behind it.
std::optional<int64_t> take_number(std::string_view& text) {
  const size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
  if (digits == 0 || (text[0] == '0' && digits > 1)) return std::nullopt;
  const auto number = parse_int(text.substr(0, digits));
  text.remove_prefix(digits);
  return number;
}

// The process that made a file of this name; none if temporary_name() did not on this machine.
std::optional<pid_t> maker_of(std::string_view name) {
  const std::string start = std::string(kPrefix) + machine() + "-";
  if (!name.starts_with(start)) return std::nullopt;
  name.remove_prefix(start.size());
  const auto pid = take_number(name);
  if (!pid || *pid < 1 || *pid > INT_MAX || !name.starts_with('-')) return std::nullopt;
  name.remove_prefix(1);
  if (!take_number(name)) return std::nullopt;
  if (!name.empty() && (name[0] != '.' || name.find('.', 1) != std::string_view::npos)) return std::nullopt;
  return static_cast<pid_t>(*pid);
}

}  // namespace

std::string temporary_name(const std::string& extension) {
  static std::atomic<unsigned> counter{0};
  return std::string(kPrefix) + machine() + "-" + std::to_string(getpid()) + "-" + std::to_string(counter++) +
         extension;
}

void remove_leftovers(const std::string& folder) {
  {
    static std::mutex mutex;
    static std::set<std::string> seen;
    const std::lock_guard lock(mutex);
    if (!seen.insert(folder).second) return;
  }
  const std::unique_ptr<DIR, int (*)(DIR*)> names(opendir(folder.c_str()), closedir);
  if (!names) return;
  const int at = dirfd(names.get());
  while (const dirent* entry = readdir(names.get())) {
    const auto maker = maker_of(entry->d_name);
    struct stat info {};
    if (!maker || fstatat(at, entry->d_name, &info, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(info.st_mode) ||
        info.st_uid != geteuid() || info.st_mtime > time(nullptr) - kLeastAge_s)
      continue;
    if (kill(*maker, 0) != 0 && errno == ESRCH) unlinkat(at, entry->d_name, 0);
  }
}

}  // namespace triad
