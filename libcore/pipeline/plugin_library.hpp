// SPDX-License-Identifier: Apache-2.0
// Loading a plugin's file and checking the records in it.
#pragma once

#include <triad/abi/triad_plugin.h>

#include <string>
#include <string_view>
#include <triad/pipeline/plugin_file.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <vector>

namespace triad {

// Where a loaded file lies in memory, to tell its own records from somebody else's.
class PluginMemory {
 public:
  PluginMemory(std::vector<PluginSegment> segments, uint64_t base) : segments_(std::move(segments)), base_(base) {}
  // Whether [p, p + bytes) lies within one segment of the file.
  bool holds(const void* p, uint64_t bytes) const;
  // Whether a function's address lies in the file's code.
  bool holds_code(const void* p) const;
  // Bytes from p to the end of its segment; 0 when p is not in the file.
  uint64_t room(const void* p) const;

 private:
  std::vector<PluginSegment> segments_;
  uint64_t base_;
};

// Opens, checks and loads `path`; a file that is loaded already (same device and inode) gives the same
// stages again. Never unloaded. Serialised; callable from any thread.
// Throws PluginError: the rules of PluginFile, file.load (the linker's words), file.changed, symbol.elsewhere, and
// those of validate_library. A file whose records were refused stays loaded, but gives the same error each time.
const std::vector<StageInfo>& load_plugin_file(const std::string& path, PathTrust trust);

// Checks every record that hangs on `library`, reading nothing outside the file. Throws PluginError:
// record.magic, record.major, record.size, record.outside-file, record.code-outside-file, record.null,
// record.count, record.text, record.name, record.duplicate-id, record.duplicate-name, record.enum,
// record.range, record.default, record.choices, record.inputs, record.scores.
void validate_library(const triad_library* library, uint64_t symbol_size, const PluginMemory& memory,
                      const std::string& file);

// [a-z][a-z0-9-]{0,31}
bool is_plugin_name(std::string_view name);

}  // namespace triad
