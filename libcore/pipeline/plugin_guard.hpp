// SPDX-License-Identifier: Apache-2.0
// Around every moment in which a plugin's code runs: who is blamed for a crash, and what is put back after it.
#pragma once

#include <cfenv>
#include <cstdint>

namespace triad {

// Names what runs. The strings must outlive the scope.
struct PluginFrame {
  const char* id;  // the stage, or "" while the file is loaded
  const char* file;
  const char* function;  // "strip()", "its constructors"
};

// While alive on a thread: a crash or an exit() ends the process with status 3 and one line that names the
// plugin, after the temporary files are removed. The plugin starts with the default floating-point
// environment (round to nearest, no flush to zero); the caller's is restored at the end of the scope.
// Scopes nest; each thread needs its own.
class PluginScope {
 public:
  explicit PluginScope(const PluginFrame& frame);
  // Restores, and warns once for each plugin that changed the floating-point control word or rounding mode.
  ~PluginScope();
  PluginScope(const PluginScope&) = delete;
  PluginScope& operator=(const PluginScope&) = delete;

 private:
  PluginFrame frame_;
  const PluginFrame* outer_;
  std::fenv_t environment_;
  uint32_t control_ = 0;
};

// What runs on this thread, or nullptr. Async-signal-safe.
const PluginFrame* current_plugin_frame();

// How often a plugin left a changed floating-point environment behind, in this process.
uint64_t float_control_changes();

// For the child of check_plugin, whose parent looks at how it ends: signals and exit() act as usual again,
// and nothing is printed.
void disable_plugin_crash_report();

}  // namespace triad
