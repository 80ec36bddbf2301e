// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/plugin_guard.hpp>
#include <triad/pipeline/plugin_library.hpp>
#include <utility>

namespace triad {
namespace {

struct Loaded {
  std::string real_path;
  std::vector<StageInfo> stages;
  std::optional<PluginError> refused;
};

struct Registry {
  std::recursive_mutex mutex;  // a library's constructor may load another plugin through libtriad
  std::map<std::pair<dev_t, ino_t>, std::unique_ptr<Loaded>> files;
};
// Never destroyed: stages are in use until the very end of the process.
Registry& registry() {
  static auto* instance = new Registry;
  return *instance;
}

// By descriptor, so that what was checked is what is loaded. A file that looks for its libraries beside
// itself ($ORIGIN) is opened through its folder's descriptor, or the linker would look in /proc.
void* open_library(PluginFile& file) {
  constexpr int kFlags = RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE;
  std::string name = "/proc/self/fd/" + std::to_string(file.descriptor());
  if (file.uses_origin()) {
    const size_t slash = file.real_path().rfind('/');
    const std::string folder = file.real_path().substr(0, slash + 1);
    const int descriptor = open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (descriptor >= 0) name = "/proc/self/fd/" + std::to_string(descriptor) + file.real_path().substr(slash);
  }
  struct stat info {};
  if (stat(name.c_str(), &info) != 0) name = file.real_path();  // no /proc here
  if (stat(name.c_str(), &info) != 0 || info.st_ino != file.inode() || info.st_dev != file.device())
    throw PluginError("file.changed", "", file.real_path(), "it was replaced while it was checked; try again");
  const PluginScope scope({"", file.real_path().c_str(), "its constructors"});
  try {
    return dlopen(name.c_str(), kFlags);
  } catch (...) {
    throw PluginError("file.load", "", file.real_path(), "a constructor threw an exception");
  }
}

std::string linker_error(const PluginFile& file) {
  const char* error = dlerror();
  std::string text = error ? error : "the linker refused it";
  // The linker knows the file by its descriptor; the user does not.
  if (const size_t at = text.find("/proc/self/fd/"); at != std::string::npos) {
    const size_t end = text.find(':', at);
    text.replace(at, end == std::string::npos ? end : end - at, file.real_path());
  }
  return text;
}

void load(PluginFile& file, Loaded& out) {
  out.real_path = file.real_path();
  file.release();
  void* handle = open_library(file);
  if (!handle) throw PluginError("file.load", "", file.real_path(), linker_error(file));
  link_map* map = nullptr;
  if (dlinfo(handle, RTLD_DI_LINKMAP, &map) != 0 || !map)
    throw PluginError("file.load", "", file.real_path(), linker_error(file));
  const auto* library = static_cast<const triad_library*>(dlsym(handle, "triad_library_v1"));
  if (!library)
    throw PluginError("symbol.missing", "", file.real_path(), "the linker does not find triad_library_v1");
  if (reinterpret_cast<uint64_t>(library) != map->l_addr + file.symbol_value())
    throw PluginError("symbol.elsewhere", "", file.real_path(),
                      "its triad_library_v1 is another file's: build it with -fvisibility=hidden -fno-gnu-unique");
  validate_library(library, file.symbol_size(), PluginMemory(file.segments(), map->l_addr), file.real_path());
  for (uint32_t i = 0; i < library->n_descs; ++i)
    out.stages.push_back({library->descs[i], out.real_path, library->name});
}

}  // namespace

bool PluginMemory::holds(const void* p, uint64_t bytes) const { return p && room(p) >= bytes; }

uint64_t PluginMemory::room(const void* p) const {
  const uint64_t address = reinterpret_cast<uint64_t>(p) - base_;
  for (const PluginSegment& segment : segments_)
    if (address >= segment.begin && address < segment.end) return segment.end - address;
  return 0;
}

bool PluginMemory::holds_code(const void* p) const {
  const uint64_t address = reinterpret_cast<uint64_t>(p) - base_;
  for (const PluginSegment& segment : segments_)
    if (segment.executable && address >= segment.begin && address < segment.end) return true;
  return false;
}

const std::vector<StageInfo>& load_plugin_file(const std::string& path, PathTrust trust) {
  PluginFile file(path, trust);
  Registry& known = registry();
  const std::lock_guard lock(known.mutex);
  std::unique_ptr<Loaded>& loaded = known.files[{file.device(), file.inode()}];
  if (!loaded) {
    loaded = std::make_unique<Loaded>();
    try {
      load(file, *loaded);
    } catch (const PluginError& error) {
      loaded->refused = error;
    }
  }
  if (loaded->refused) throw PluginError(*loaded->refused);
  return loaded->stages;
}

}  // namespace triad
