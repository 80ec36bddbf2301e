// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>

namespace fs = std::filesystem;

namespace triad {
namespace {

std::atomic<bool> g_cancel{false};

// Names for a signal handler, which must not allocate. A slot goes 0 (free), 1 (being written), 2 (in use).
struct TemporaryName {
  std::atomic<int> use{0};
  char text[4096];
};
TemporaryName g_temporaries[64];

int remember_temporary(const std::string& name) {
  if (name.size() >= sizeof g_temporaries[0].text) return -1;
  for (int i = 0; i < static_cast<int>(std::size(g_temporaries)); ++i) {
    TemporaryName& slot = g_temporaries[i];
    int expected = 0;
    if (!slot.use.compare_exchange_strong(expected, 1)) continue;
    std::memcpy(slot.text, name.c_str(), name.size() + 1);
    slot.use.store(2);
    return i;
  }
  return -1;
}

std::string reason() { return std::strerror(errno); }

// The folder of the shared library that holds this function, with links resolved.
fs::path library_folder() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&data_folder), &info) && info.dli_fname) {
    std::error_code error;
    const fs::path real = fs::canonical(info.dli_fname, error);
    if (!error) return real.parent_path();
  }
  return {};
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  const fs::path target(path_);
  const std::string folder = target.has_parent_path() ? target.parent_path().string() : ".";
  struct stat info {};
  if (path_.empty() || !target.has_filename()) throw_input("cannot write '" + path_ + "': it names no file");
  if (stat(folder.c_str(), &info) != 0)
    throw_input("cannot write '" + path_ + "': folder '" + folder + "': " + reason());
  if (!S_ISDIR(info.st_mode)) throw_input("cannot write '" + path_ + "': '" + folder + "' is not a folder");
  if (stat(path_.c_str(), &info) == 0 && S_ISDIR(info.st_mode))
    throw_input("cannot write '" + path_ + "': it is a folder");
  // The extension stays last, because writers choose the format by it.
  static std::atomic<unsigned> counter{0};
  for (int attempt = 0; attempt < 100; ++attempt) {
    temporary_ = (fs::path(folder) / ("." + target.stem().string() + ".triad-" + std::to_string(getpid()) + "-" +
                                      std::to_string(counter++) + target.extension().string()))
                     .string();
    const int descriptor = open(temporary_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
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
  if (slot_ >= 0) g_temporaries[slot_].use.store(0);
}

void unlink_temporaries() noexcept {
  for (TemporaryName& slot : g_temporaries)
    if (slot.use.load() == 2) unlink(slot.text);
}

void AtomicFile::commit() {
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) throw_input("cannot write '" + path_ + "': " + reason());
  committed_ = true;
}

void write_text_file(const std::string& path, const std::string& text) {
  if (path == "-") {
    std::cout << text << std::flush;
    if (!std::cout) throw_input("cannot write to standard output");
    return;
  }
  AtomicFile file(path);
  std::ofstream stream(file.temporary(), std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  if (!stream) throw_input("cannot write '" + path + "': " + reason());
  file.commit();
}

void check_text_file(const std::string& path) {
  struct stat info {};
  // What is neither a file nor a folder (a terminal, a pipe) is written to and not replaced.
  if (path == "-" || (stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode))) return;
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

std::string data_folder() {
  if (const char* named = secure_getenv("TRIAD_DATA"); named && *named) {
    if (!fs::is_directory(named)) throw_input("TRIAD_DATA: '" + std::string(named) + "' is not a folder");
    return named;
  }
  const fs::path installed = library_folder() / TRIAD_RELATIVE_DATA_DIR;
  if (fs::is_directory(installed / "colour")) return installed.lexically_normal().string();
  if (fs::is_directory(fs::path(TRIAD_SOURCE_DATA_DIR) / "colour")) return TRIAD_SOURCE_DATA_DIR;
  throw_input("Triad's data folder is missing: looked at '" + installed.string() +
              "'; set TRIAD_DATA to the folder that holds colour/ and layouts/");
}

std::string plugin_folder() {
  // In the build tree the library and the plugins have folders of their own; installed, the plugins lie in
  // a folder beside the library. The one that belongs to this copy of the library wins.
  const fs::path installed = library_folder() / "triad" / "plugins";
  if (fs::is_directory(installed)) return installed.string();
  return (library_folder() / ".." / "plugins").lexically_normal().string();
}

void request_cancel() noexcept { g_cancel.store(true, std::memory_order_relaxed); }
bool cancel_requested() noexcept { return g_cancel.load(std::memory_order_relaxed); }
void check_cancel() {
  if (cancel_requested()) throw Error(ErrorKind::kCancelled, "interrupted");
}

}  // namespace triad
