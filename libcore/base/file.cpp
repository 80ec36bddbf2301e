// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/temporaries.hpp>

namespace fs = std::filesystem;

namespace triad {
namespace {

std::atomic<bool> g_cancel{false};

}  // namespace

// A name for a signal handler, which must not allocate. It goes 0 (free), 1 (being written), 2 (in use). The
// list only grows, at its head, and so can be walked at any moment.
struct TemporaryName {
  std::atomic<int> use{0};
  char text[PATH_MAX];
  TemporaryName* next = nullptr;
};

namespace {

std::atomic<TemporaryName*> g_temporaries{nullptr};

TemporaryName* remember_temporary(const std::string& name) {
  if (name.size() >= sizeof TemporaryName::text) return nullptr;  // the system does not open such a name either
  TemporaryName* slot = g_temporaries.load();
  for (; slot; slot = slot->next) {
    int expected = 0;
    if (slot->use.compare_exchange_strong(expected, 1)) break;
  }
  const bool fresh = !slot;
  if (fresh) slot = new TemporaryName;
  std::memcpy(slot->text, name.c_str(), name.size() + 1);
  slot->use.store(2);
  if (fresh) {
    slot->next = g_temporaries.load();
    while (!g_temporaries.compare_exchange_weak(slot->next, slot)) {
    }
  }
  return slot;
}

std::string reason() { return std::strerror(errno); }

// Where writing to `path` ends up: the target of links, whether it exists or not. What /proc shows of a process
// (/dev/stdout leads there) only looks like links, and is left as it is.
fs::path follow_links(const std::string& path) {
  constexpr int kMostLinks = 40;  // what Linux follows, path_resolution(7)
  fs::path at(path);
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(at, error)); ++links) {
    if (links == kMostLinks) throw_input("cannot write '" + path + "': " + std::strerror(ELOOP));
    const fs::path folder = fs::canonical(at.has_parent_path() ? at.parent_path() : fs::path("."), error);
    if (error) break;
    if (folder.string().rfind("/proc/", 0) == 0) return folder / at.filename();
    const fs::path link = fs::read_symlink(at, error);
    if (error) break;
    at = folder / link;  // an absolute link replaces the folder
  }
  return at;
}

bool is_stream(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 &&
         (S_ISCHR(info.st_mode) || S_ISFIFO(info.st_mode) || follow_links(path).string().rfind("/proc/", 0) == 0);
}

void write_through(const std::string& path, const std::string& text) {
  int descriptor = -1;
  while ((descriptor = open(path.c_str(), O_WRONLY | O_APPEND | O_NOCTTY | O_CLOEXEC)) < 0 && errno == EINTR)
    check_cancel();
  bool ok = descriptor >= 0;
  for (size_t done = 0; ok && done < text.size();) {
    const ssize_t n = write(descriptor, text.data() + done, text.size() - done);
    if (n > 0) done += static_cast<size_t>(n);
    ok = n > 0 || (n < 0 && errno == EINTR && !cancel_requested());
  }
  const std::string why = ok ? "" : reason();
  if (descriptor >= 0 && close(descriptor) != 0 && ok) throw_input("cannot write '" + path + "': " + reason());
  check_cancel();
  if (!ok) throw_input("cannot write '" + path + "': " + why);
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  if (path_.empty() || !fs::path(path_).has_filename()) throw_input("cannot write '" + path_ + "': it names no file");
  const fs::path target = follow_links(path_);
  target_ = target.string();
  const std::string folder = target.has_parent_path() ? target.parent_path().string() : ".";
  struct stat info {};
  if (stat(folder.c_str(), &info) != 0)
    throw_input("cannot write '" + path_ + "': folder '" + folder + "': " + reason());
  if (!S_ISDIR(info.st_mode)) throw_input("cannot write '" + path_ + "': '" + folder + "' is not a folder");
  if (stat(path_.c_str(), &info) == 0) {
    if (S_ISDIR(info.st_mode)) throw_input("cannot write '" + path_ + "': it is a folder");
    if (!S_ISREG(info.st_mode) || target_.rfind("/proc/", 0) == 0)
      throw_input("cannot write '" + path_ + "': it is a device, a pipe or a socket, and must be a regular file");
    mode_ = static_cast<int>(info.st_mode & 0777);
  }
  // The extension stays last, because writers choose the format by it. The rest is short, because a name has at
  // most 255 bytes and the target's may use them all.
  constexpr size_t kLongestExtension = 16;  // of any format there is; longer ones choose nothing
  const std::string extension = target.extension().string();
  remove_leftovers(folder);
  for (int attempt = 0; attempt < 100; ++attempt) {
    temporary_ = (fs::path(folder) / temporary_name(extension.size() <= kLongestExtension ? extension : "")).string();
    // Never more open than what it replaces, not even while it is written; the exact mode comes at commit().
    const mode_t mode = mode_ < 0 ? 0666 : static_cast<mode_t>((mode_ & 0666) | 0600);
    const int descriptor = open(temporary_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, mode);
    if (descriptor >= 0) {
      close(descriptor);
      slot_ = remember_temporary(temporary_);
      return;
    }
    if (errno != EEXIST) throw_input("cannot write '" + path_ + "': " + reason());
  }
  throw_input("cannot write '" + path_ + "': no free temporary name beside it");
}

AtomicFile::~AtomicFile() {
  if (!committed_) unlink(temporary_.c_str());
  if (slot_) slot_->use.store(0);
}

void unlink_temporaries() noexcept {
  for (TemporaryName* slot = g_temporaries.load(); slot; slot = slot->next)
    if (slot->use.load() == 2) unlink(slot->text);
}

void AtomicFile::commit() {
  if ((mode_ >= 0 && chmod(temporary_.c_str(), static_cast<mode_t>(mode_)) != 0) ||
      std::rename(temporary_.c_str(), target_.c_str()) != 0)
    throw_input("cannot write '" + path_ + "': " + reason());
  committed_ = true;
}

void write_text_file(const std::string& path, const std::string& text) {
  if (path == "-") {
    std::cout << text << std::flush;
    if (!std::cout) throw_input("cannot write to standard output");
    return;
  }
  if (is_stream(path)) return write_through(path, text);
  AtomicFile file(path);
  std::ofstream stream(file.temporary(), std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  if (!stream) throw_input("cannot write '" + path + "': " + reason());
  file.commit();
}

void check_text_file(const std::string& path) {
  if (path == "-" || is_stream(path)) return;
  const AtomicFile probe(path);
}

std::string read_text_file(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) throw_input("cannot read '" + path + "': " + reason());
  if (S_ISDIR(info.st_mode)) throw_input("cannot read '" + path + "': it is a folder");
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw_input("cannot read '" + path + "': " + reason());
  return text.str();
}

std::string library_folder() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&data_folder), &info) && info.dli_fname) {
    std::error_code error;
    const fs::path real = fs::canonical(info.dli_fname, error);
    if (!error) return real.parent_path().string();
  }
  return {};
}

std::string data_folder() {
  if (const char* named = secure_getenv("TRIAD_DATA"); named && *named) {
    if (!fs::is_directory(named)) throw_input("TRIAD_DATA: '" + std::string(named) + "' is not a folder");
    return named;
  }
  const fs::path installed = fs::path(library_folder()) / TRIAD_RELATIVE_DATA_DIR;
  if (fs::is_directory(installed / "colour")) return installed.lexically_normal().string();
  if (fs::is_directory(fs::path(TRIAD_SOURCE_DATA_DIR) / "colour")) return TRIAD_SOURCE_DATA_DIR;
  throw_input("Triad's data folder is missing: looked at '" + installed.string() +
              "'; set TRIAD_DATA to the folder that holds colour/ and layouts/");
}

std::string plugin_folder() {
  // In the build tree the library and the plugins have folders of their own; installed, the plugins lie in
  // a folder beside the library. The one that belongs to this copy of the library wins.
  const fs::path installed = fs::path(library_folder()) / "triad" / "plugins";
  if (fs::is_directory(installed)) return installed.string();
  return (fs::path(library_folder()) / ".." / "plugins").lexically_normal().string();
}

void request_cancel() noexcept { g_cancel.store(true, std::memory_order_relaxed); }
bool cancel_requested() noexcept { return g_cancel.load(std::memory_order_relaxed); }
void check_cancel() {
  if (cancel_requested()) throw Error(ErrorKind::kCancelled, "interrupted");
}

}  // namespace triad
