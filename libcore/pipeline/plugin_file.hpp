// SPDX-License-Identifier: Apache-2.0
// A plugin's file before it is loaded: permissions, ELF header, exported symbol.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace triad {

enum class PathTrust {
  kImplicit,  // found in a folder that nobody named: a world-writable file or folder is an error
  kNamed      // the user named it: a warning
};

// One loadable segment: addresses relative to where the file is mapped.
struct PluginSegment {
  uint64_t begin = 0, end = 0;
  bool executable = false;
};

// A file that passed all checks that need no loading. Owns the descriptor until release().
class PluginFile {
 public:
  // Checks, in this order: existence (file.missing, file.dangling-link), kind (file.folder, file.kind,
  // file.empty, file.too-big), permissions (file.unreadable, file.world-writable), ELF (file.not-elf,
  // file.truncated, file.elf-class, file.elf-machine, file.elf-type), and the symbol triad_library_v1
  // (symbol.missing, symbol.other-version, symbol.not-data, symbol.too-small).
  // Throws PluginError with the rule named in brackets.
  PluginFile(const std::string& path, PathTrust trust);
  ~PluginFile();
  PluginFile(const PluginFile&) = delete;
  PluginFile& operator=(const PluginFile&) = delete;

  const std::string& real_path() const { return real_path_; }  // links resolved
  int descriptor() const { return descriptor_; }
  // From here on the descriptor stays open for the life of the process: glibc knows a library by the name it
  // was opened with, and "/proc/self/fd/3" must not come to mean another file.
  void release() { owned_ = false; }
  dev_t device() const { return device_; }
  ino_t inode() const { return inode_; }
  const std::vector<PluginSegment>& segments() const { return segments_; }
  uint64_t symbol_value() const { return symbol_value_; }  // address of triad_library_v1 in the file's terms
  uint64_t symbol_size() const { return symbol_size_; }
  // Whether the file looks for its libraries relative to its own place ($ORIGIN).
  bool uses_origin() const { return uses_origin_; }

 private:
  void check_permissions(PathTrust trust) const;
  void check_elf();
  [[noreturn]] void refuse(const char* rule, const std::string& what_was_wrong) const;

  std::string real_path_;
  int descriptor_ = -1;
  bool owned_ = true;
  dev_t device_ = 0;
  ino_t inode_ = 0;
  uint64_t size_ = 0;
  uint32_t mode_ = 0;
  std::vector<PluginSegment> segments_;
  uint64_t symbol_value_ = 0, symbol_size_ = 0;
  bool uses_origin_ = false;
};

}  // namespace triad
