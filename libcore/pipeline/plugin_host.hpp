// SPDX-License-Identifier: Apache-2.0
// Finding, checking and loading plugins, and calling the stages in them.
//
// A plugin runs with the user's full rights. The checks here catch mistakes, not enemies.
#pragma once

#include <triad/abi/triad_plugin.h>

#include <map>
#include <memory>
#include <string>
#include <triad/image/image.hpp>
#include <vector>

namespace triad {

// A stage that a plugin file offers. Constant data; lives as long as the process.
struct StageInfo {
  const triad_desc* desc = nullptr;
  std::string file;          // the real path, links resolved
  std::string library_name;  // triad_library::name
  std::string id() const { return desc->id; }
  bool is_metric() const { return desc->kind == TRIAD_METRIC; }
};

// Looks a stage up by its id. `ID.triad.so` is tried first in each folder, in search order; other files are
// opened only if none bears that name. Search order: the folders or files given (--plugin-path), then
// $TRIAD_PLUGIN_PATH (colon-separated, by secure_getenv), $XDG_DATA_HOME/triad/plugins
// (~/.local/share/triad/plugins), then plugin_folder(). Not recursive, never the current folder unless named.
// Not thread-safe; the StageInfo it hands out may be used from any thread.
class PluginHost {
 public:
  explicit PluginHost(std::vector<std::string> plugin_path = {});
  ~PluginHost();
  PluginHost(const PluginHost&) = delete;
  PluginHost& operator=(const PluginHost&) = delete;

  // Throws Error(kUsage) for an unknown id, with the nearest one; Error(kInput) naming the file and the rule
  // when the file that should hold it is refused.
  const StageInfo& find(const std::string& id);
  // All stages of all folders, sorted by id. A file that is refused is a warning, once.
  std::vector<const StageInfo*> list();
  // Loads one file, by path. Throws Error(kInput) naming the file and the rule it breaks.
  std::vector<const StageInfo*> load_file(const std::string& path);
  const std::vector<std::string>& folders() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Parameter values as the user wrote them: name -> text.
using ParamTexts = std::map<std::string, std::string>;

// What a stage said while it ran, besides pixels.
struct StageReports {
  std::map<std::string, double> values;
  struct Series {
    std::vector<double> x, y;
  };
  std::map<std::string, Series> series;
};

// One use of a stage in a chain. Calls go through a guard: exceptions become errors, the floating-point
// control word and rounding mode are restored, a crash names the plugin, failures carry the plugin's message.
// All errors name the stage id; where the fault is the plugin's, also its file.
//
// Threads: as triad_plugin.h says of the functions of the same names; the guard itself is thread-safe.
class StageInstance {
 public:
  // Parses and checks `params` against the table: unknown names get a suggestion, values a type and range
  // check, required ones must be there. Throws Error(kUsage).
  StageInstance(const StageInfo& info, const ParamTexts& params);
  ~StageInstance();
  StageInstance(StageInstance&&) noexcept;
  StageInstance& operator=(StageInstance&&) noexcept;

  const StageInfo& info() const;
  // Every parameter with its value in force (given or default) as text, in the table's order.
  const std::vector<std::pair<std::string, std::string>>& parameters() const;
  // "platt:layout=rgb,ppd=40" with only what was given.
  std::string text() const;

  struct Plan {
    triad_image out{};  // channels == 0: no picture comes out (a metric without a map)
    triad_plan plan{};
    Metadata metadata;  // of the output: the first input's, as the stage changed it
  };
  // inputs: one per input of the descriptor, nullptr where an optional one is absent; metadata likewise.
  // Checks what comes back (sizes positive and below 2^31, channels 0..1024, known enum values, rows, passes
  // 1..64, state below 1 GiB) and throws Error naming the rule.
  Plan plan(const std::vector<const triad_image*>& inputs, const std::vector<const Metadata*>& metadata);

  // One rect per input. Checked: not inverted, not empty, at most one picture's size (or 4096 pixels, if that
  // is more) beyond the picture on each side. Before plan() it is an error.
  std::vector<triad_rect> need(int pass, triad_rect out) const;

  // Strips are described by triad_strip; out may be nullptr; state may be nullptr when state_bytes is 0.
  void strip(int pass, triad_rect r, const std::vector<const triad_strip*>& in, const triad_strip* out, void* state);
  void merge(int pass, void* into, const void* from) const;
  // scores: empty unless this is a metric's last pass.
  std::vector<double> end_pass(int pass, const void* state);

  // What was reported so far. Call when no other call is running.
  const StageReports& reports() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Bytes of scratch memory one call may take; set once from --max-memory. Default 4 GiB.
void set_scratch_budget(uint64_t bytes);

// The text that `triad help ID` prints: summary, doc, inputs, and each parameter with type, range, default
// and unit; a metric's scores.
std::string stage_help(const StageInfo& info);

}  // namespace triad
