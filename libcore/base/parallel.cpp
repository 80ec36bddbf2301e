// SPDX-License-Identifier: Apache-2.0
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <unistd.h>

#include <memory>
#include <triad/base/parallel.hpp>

namespace triad {
namespace {
int g_threads = 0;
std::unique_ptr<tbb::global_control> g_control;
}  // namespace

void set_thread_limit(int threads) {
  g_control.reset();
  g_threads = threads;
  if (threads > 0)
    g_control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                      static_cast<size_t>(threads));
}

int thread_limit() { return g_threads > 0 ? g_threads : tbb::info::default_concurrency(); }

uint64_t machine_memory_bytes() {
  return static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

void parallel_for(int64_t n, const std::function<void(int64_t)>& body) {
  if (n <= 0) return;
  if (n == 1) return body(0);
  // Isolated: a thread that waits here must not pick up other work of this process, such as another strip.
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(int64_t{0}, n, [&](int64_t i) { body(i); }); });
}

}  // namespace triad
