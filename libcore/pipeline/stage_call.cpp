// SPDX-License-Identifier: Apache-2.0
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/stage_call.hpp>

namespace triad {
namespace {

std::atomic<uint64_t> g_scratch_budget{uint64_t{4} << 30};
constexpr int64_t kMaxSeries = int64_t{1} << 20;  // points; more would be a file, not a report
constexpr size_t kMaxFreeBlocks = 64;

std::string who(const triad_call& call) { return std::string("stage '") + call.shared.info->desc->id + "'"; }

// Something the contract forbids that needs no end of the run: said once, naming plugin and rule.
void warn_rule(const triad_call& call, const char* rule, const std::string& what) {
  warn(PluginError(rule, call.shared.info->desc->id, call.shared.info->file,
                   std::string(function_name(call.phase)) + " " + what)
           .what());
}

// Services must not throw into a plugin that may be C: out of memory becomes the given answer.
template <class R, class F>
R quietly(R otherwise, const F& f) noexcept {
  try {
    return f();
  } catch (...) {
    return otherwise;
  }
}

void host_log(triad_call* call, int32_t level, const char* text) {
  quietly(0, [&] {
    const LogLevel at = level >= TRIAD_LOG_WARNING ? LogLevel::kWarning
                        : level <= TRIAD_LOG_DEBUG ? LogLevel::kDebug
                                                   : LogLevel::kInfo;
    log_message(at, who(*call) + ": " + (text ? text : ""));
    return 0;
  });
}

triad_status host_fail(triad_call* call, triad_status status, const char* text) {
  quietly(0, [&] {
    call->message = text ? text : "";
    return 0;
  });
  return status;
}

int32_t host_progress(triad_call*, double) { return cancel_requested() ? 1 : 0; }

void* host_scratch(triad_call* call, size_t bytes) {
  return quietly<void*>(nullptr, [&]() -> void* {
    const size_t rounded = (std::min(bytes, SIZE_MAX - 64) + 63) / 64 * 64;
    const size_t wanted = std::max<size_t>(rounded, 64);
    const uint64_t budget = g_scratch_budget.load(), before = call->root->scratch_bytes.fetch_add(wanted);
    if (wanted > budget || before > budget - wanted) {
      call->root->scratch_bytes.fetch_sub(wanted);
      return nullptr;
    }
    call->blocks.reserve(call->blocks.size() + 1);
    const ScratchPool::Block block = call->shared.scratch.take(wanted);
    if (!block.memory) {
      call->root->scratch_bytes.fetch_sub(wanted);
      return nullptr;
    }
    // One that is used again may be larger. It counts whole, as it does when it is given back.
    call->root->scratch_bytes.fetch_add(block.bytes - wanted);
    call->blocks.push_back(block);
    return block.memory;
  });
}

triad_status host_parallel_for(triad_call* call, int64_t n, triad_status (*body)(void*, triad_call*, int64_t),
                               void* context) {
  std::atomic<triad_status> result{TRIAD_OK};
  std::mutex mutex;
  const auto failed = [&](triad_status status, const std::string& message) {
    const std::lock_guard lock(mutex);
    if (result.load() != TRIAD_OK) return;
    call->message = message;
    result = status;
  };
  try {
    // Isolated: a thread that waits here must not pick up another strip of the same plugin.
    tbb::this_task_arena::isolate([&] {
      parallel_for(n, [&](int64_t i) {
        if (result.load() != TRIAD_OK) return;
        triad_call own(*call);
        try {
          const triad_status status = call_plugin(own, [&] { return body(context, &own, i); });
          if (status != TRIAD_OK) failed(status, own.message);
        } catch (const PluginError& error) {
          failed(TRIAD_E_INTERNAL, error.finding());
        }
      });
    });
  } catch (...) {
    failed(TRIAD_E_MEMORY, "parallel_for has no memory for its tasks");
  }
  return result;
}

const char* host_get_meta(triad_call* call, int32_t input, const char* key) {
  return quietly<const char*>(nullptr, [&]() -> const char* {
    if (!call->input_metadata) {
      warn_rule(*call, "call.phase", "asked for metadata, which is there in plan() only");
      return nullptr;
    }
    const auto& inputs = *call->input_metadata;
    if (!key || input < 0 || static_cast<size_t>(input) >= inputs.size() || !inputs[static_cast<size_t>(input)])
      return nullptr;
    const auto value = inputs[static_cast<size_t>(input)]->get(key);
    return value ? call->texts.emplace_back(*value).c_str() : nullptr;
  });
}

triad_status host_set_meta(triad_call* call, const char* key, const char* value) {
  return quietly<triad_status>(TRIAD_E_MEMORY, [&]() -> triad_status {
    if (!call->output_metadata) {
      call->message = "metadata can be set in plan() only";
      return TRIAD_E_INTERNAL;
    }
    if (!key || !*key || !is_valid_utf8(key) || (value && !is_valid_utf8(value))) {
      call->message = "metadata needs a key, and key and value must be UTF-8";
      return TRIAD_E_INTERNAL;
    }
    if (value)
      call->output_metadata->set(key, value);
    else
      call->output_metadata->erase(key);
    return TRIAD_OK;
  });
}

bool may_report(const triad_call& call, const char* name) {
  if (call.phase != CallPhase::kPlan && call.phase != CallPhase::kEndPass) {
    warn_rule(call, "call.phase", "reported a number, which is for plan() and end_pass()");
    return false;
  }
  if (name && *name && is_valid_utf8(name)) return true;
  warn_rule(call, "call.report", "reported a number without a name");
  return false;
}

void host_report(triad_call* call, const char* key, double value) {
  quietly(0, [&] {
    if (!may_report(*call, key)) return 0;
    const std::lock_guard lock(call->shared.mutex);
    call->shared.reports.values[key] = value;
    return 0;
  });
}

void host_series(triad_call* call, const char* name, int64_t n, const double* x, const double* y) {
  quietly(0, [&] {
    if (!may_report(*call, name)) return 0;
    if (n < 0 || n > kMaxSeries || (n > 0 && (!x || !y))) {
      warn_rule(*call, "call.report", "reported a series of " + std::to_string(n) + " points, which was left out");
      return 0;
    }
    StageReports::Series series;
    series.x.assign(x, x + n);
    series.y.assign(y, y + n);
    const std::lock_guard lock(call->shared.mutex);
    call->shared.reports.series[name] = std::move(series);
    return 0;
  });
}

const void* host_extension(const char*) { return nullptr; }

}  // namespace

ScratchPool::~ScratchPool() {
  for (const Block& block : free_) std::free(block.memory);
}

ScratchPool::Block ScratchPool::take(size_t bytes) {
  {
    const std::lock_guard lock(mutex_);
    for (size_t i = 0; i < free_.size(); ++i) {
      if (free_[i].bytes < bytes || free_[i].bytes / 2 > bytes) continue;
      const Block block = free_[i];
      free_[i] = free_.back();
      free_.pop_back();
      return block;
    }
  }
  return {std::aligned_alloc(64, bytes), bytes};
}

void ScratchPool::give_back(Block block) {
  Block surplus;
  {
    const std::lock_guard lock(mutex_);
    if (free_.capacity() == 0) free_.reserve(kMaxFreeBlocks);
    if (free_.size() < kMaxFreeBlocks) {
      free_.push_back(block);
      return;
    }
    surplus = free_.front();
    free_.front() = block;
  }
  std::free(surplus.memory);
}

const char* function_name(CallPhase phase) {
  switch (phase) {
    case CallPhase::kCreate: return "create()";
    case CallPhase::kPlan: return "plan()";
    case CallPhase::kNeed: return "need()";
    case CallPhase::kStrip: return "strip()";
    case CallPhase::kMerge: return "merge()";
    case CallPhase::kEndPass: return "end_pass()";
  }
  return "?";
}

const triad_host& plugin_services() {
  static constexpr triad_host kHost = {
      sizeof(triad_host), TRIAD_ABI_MINOR, TRIAD_VERSION, host_log,    host_fail,   host_progress, host_scratch,
      host_parallel_for,  host_get_meta,   host_set_meta, host_report, host_series, host_extension};
  return kHost;
}

void throw_call_exception(const triad_call& call, const std::string& what) {
  throw PluginError("call.exception", call.shared.info->desc->id, call.shared.info->file,
                    std::string(function_name(call.phase)) + " threw an exception across the boundary" + what);
}

void set_scratch_budget(uint64_t bytes) { g_scratch_budget = bytes; }

}  // namespace triad

triad_call::~triad_call() {
  uint64_t given = 0;
  for (const triad::ScratchPool::Block& block : blocks) {
    given += block.bytes;
    shared.scratch.give_back(block);
  }
  if (root != this) root->scratch_bytes.fetch_sub(given);
}
