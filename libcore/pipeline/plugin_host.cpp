// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/plugin_file.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/plugin_library.hpp>

namespace fs = std::filesystem;

namespace triad {
namespace {

constexpr char kSuffix[] = ".triad.so";

// A place to look at: a folder, or one file that the user named.
struct Place {
  std::string path;
  PathTrust trust;
  bool file = false;
};

// Something has this name, even a link that leads nowhere: that is an error to show, not to pass by.
bool exists(const std::string& path) {
  struct stat info {};
  return lstat(path.c_str(), &info) == 0;
}
bool is_folder(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 && S_ISDIR(info.st_mode);
}

// *.triad.so of a folder, sorted, so that the order does not depend on the file system.
std::vector<std::string> plugin_files(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().filename().string().ends_with(kSuffix)) files.push_back(it->path().string());
  std::sort(files.begin(), files.end());
  return files;
}

const StageInfo* stage_of(const std::vector<StageInfo>& stages, const std::string& id) {
  for (const StageInfo& stage : stages)
    if (stage.id() == id) return &stage;
  return nullptr;
}

}  // namespace

struct PluginHost::Impl {
  std::vector<Place> places;
  std::vector<std::string> folders;
  std::map<std::string, const StageInfo*> found;

  void add(const std::string& path, PathTrust trust) {
    for (const Place& place : places)
      if (place.path == path) return;
    const bool file = trust == PathTrust::kNamed && !is_folder(path);
    places.push_back({path, trust, file});
    if (!file) folders.push_back(path);
  }

  const StageInfo* look_up(const std::string& id) {
    for (const Place& place : places) {
      const std::string path = place.file ? place.path : (fs::path(place.path) / (id + kSuffix)).string();
      if (!place.file && !exists(path)) continue;
      const auto& stages = load_plugin_file(path, place.trust);
      if (const StageInfo* stage = stage_of(stages, id)) return stage;
      if (!place.file)
        warn("plugin file '" + path + "' bears the name of a stage '" + id + "' that it does not have");
    }
    // Nothing bears that name: now the other files count.
    const auto all = collect();
    const auto it = all.find(id);
    return it == all.end() ? nullptr : it->second;
  }

  // Every stage of every file; of two with the same id the earlier wins.
  std::map<std::string, const StageInfo*> collect() const {
    std::map<std::string, const StageInfo*> all;
    for (const Place& place : places) {
      for (const std::string& path : place.file ? std::vector{place.path} : plugin_files(place.path)) {
        try {
          for (const StageInfo& stage : load_plugin_file(path, place.trust)) {
            const auto [it, added] = all.emplace(stage.id(), &stage);
            if (!added && it->second != &stage)
              warn("stage '" + stage.id() + "' of '" + stage.file + "' is hidden by that of '" + it->second->file +
                   "', which comes earlier [record.duplicate-id]");
          }
        } catch (const Error& error) {
          warn(error.what());
        }
      }
    }
    return all;
  }
};

PluginHost::PluginHost(std::vector<std::string> plugin_path) : impl_(std::make_unique<Impl>()) {
  for (const std::string& path : plugin_path) {
    if (!exists(path)) throw_input("--plugin-path: '" + path + "': " + std::strerror(errno));
    impl_->add(path, PathTrust::kNamed);
  }
  if (const char* value = secure_getenv("TRIAD_PLUGIN_PATH")) {
    for (const std::string& path : [&] {
           std::vector<std::string> parts;
           std::string_view rest = value;
           for (size_t at; (at = rest.find(':')) != std::string_view::npos; rest.remove_prefix(at + 1))
             parts.emplace_back(rest.substr(0, at));
           parts.emplace_back(rest);
           return parts;
         }()) {
      // An empty part would mean the current folder to other programs; here it means nothing.
      if (path.empty()) continue;
      if (exists(path))
        impl_->add(path, PathTrust::kNamed);
      else
        warn("TRIAD_PLUGIN_PATH: '" + path + "': " + std::strerror(errno));
    }
  }
  const char* data_home = secure_getenv("XDG_DATA_HOME");
  const char* home = secure_getenv("HOME");
  if (data_home && *data_home == '/')  // the XDG specification says that relative ones are to be ignored
    impl_->add(std::string(data_home) + "/triad/plugins", PathTrust::kImplicit);
  else if (home && *home == '/')
    impl_->add(std::string(home) + "/.local/share/triad/plugins", PathTrust::kImplicit);
  impl_->add(plugin_folder(), PathTrust::kImplicit);
}

PluginHost::~PluginHost() = default;

const StageInfo& PluginHost::find(const std::string& id) {
  if (const auto it = impl_->found.find(id); it != impl_->found.end()) return *it->second;
  const StageInfo* stage = is_plugin_name(id) ? impl_->look_up(id) : nullptr;
  if (stage) {
    impl_->found[id] = stage;
    return *stage;
  }
  std::vector<std::string> names;
  for (const auto& [name, info] : impl_->collect()) names.push_back(name);
  if (names.empty()) throw_usage("unknown stage '" + id + "': there is no plugin in " + join(impl_->folders, ", "));
  throw_usage("unknown stage '" + id + "'" + did_you_mean(id, names) + "; there are " + join(names, ", "));
}

std::vector<const StageInfo*> PluginHost::list() {
  std::vector<const StageInfo*> stages;
  for (const auto& [name, info] : impl_->collect()) stages.push_back(info);
  return stages;
}

std::vector<const StageInfo*> PluginHost::load_file(const std::string& path) {
  std::vector<const StageInfo*> stages;
  for (const StageInfo& stage : load_plugin_file(path, PathTrust::kNamed)) {
    stages.push_back(&stage);
    impl_->found.emplace(stage.id(), &stage);
  }
  return stages;
}

const std::vector<std::string>& PluginHost::folders() const { return impl_->folders; }

}  // namespace triad
