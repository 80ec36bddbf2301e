// SPDX-License-Identifier: Apache-2.0
// What a plugin gets to talk to while one of its functions runs: the triad_call and the triad_host.
#pragma once

#include <triad/abi/triad_plugin.h>

#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <triad/image/image.hpp>
#include <triad/pipeline/plugin_guard.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <vector>

namespace triad {

// Scratch memory that calls of one instance take and give back, so that not every strip pays for fresh pages.
class ScratchPool {
 public:
  ScratchPool() = default;
  ~ScratchPool();
  ScratchPool(const ScratchPool&) = delete;
  ScratchPool& operator=(const ScratchPool&) = delete;

  struct Block {
    void* memory = nullptr;
    size_t bytes = 0;
  };
  // At least `bytes`, 64-byte aligned; memory nullptr when the system has none.
  Block take(size_t bytes);
  void give_back(Block block);

 private:
  std::mutex mutex_;
  std::vector<Block> free_;
};

// What all calls of one instance share.
struct StageShared {
  const StageInfo* info = nullptr;
  std::mutex mutex;  // guards reports
  StageReports reports;
  ScratchPool scratch;
};

enum class CallPhase { kCreate, kPlan, kNeed, kStrip, kMerge, kEndPass };
const char* function_name(CallPhase phase);  // "strip()"

}  // namespace triad

// One call into the plugin, on one thread. C knows it as an opaque struct.
struct triad_call {
  triad_call(triad::StageShared& s, triad::CallPhase p) : shared(s), phase(p), root(this) {}
  // A body of parallel_for: a thread of its own, the memory budget of its parent's.
  explicit triad_call(triad_call& parent) : shared(parent.shared), phase(parent.phase), root(parent.root) {}
  ~triad_call();
  triad_call(const triad_call&) = delete;
  triad_call& operator=(const triad_call&) = delete;

  triad::StageShared& shared;
  const triad::CallPhase phase;
  triad_call* const root;
  std::string message;  // of fail(); "" none
  std::vector<triad::ScratchPool::Block> blocks;
  std::atomic<uint64_t> scratch_bytes{0};                               // of the root: with all its bodies
  std::deque<std::string> texts;                                        // what get_meta returned
  const std::vector<const triad::Metadata*>* input_metadata = nullptr;  // in plan only
  triad::Metadata* output_metadata = nullptr;                           // in plan only
};

namespace triad {

// The table of services, one for all plugins.
const triad_host& plugin_services();

// Runs one function of the plugin on this thread: frame, floating-point environment, exceptions. Returns the
// plugin's status. An exception that crosses the boundary becomes PluginError call.exception.
template <class F>
triad_status call_plugin(triad_call& call, const F& function);

[[noreturn]] void throw_call_exception(const triad_call& call, const std::string& what);

template <class F>
triad_status call_plugin(triad_call& call, const F& function) {
  const PluginScope scope({call.shared.info->desc->id, call.shared.info->file.c_str(), function_name(call.phase)});
  try {
    return function();
  } catch (const std::exception& error) {
    throw_call_exception(call, std::string(": ") + error.what());
  } catch (...) {
    throw_call_exception(call, "");
  }
}

}  // namespace triad
