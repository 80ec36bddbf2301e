// SPDX-License-Identifier: Apache-2.0
// Loops over independent work on all threads of the process-wide limit; and what else this machine has.
#pragma once

#include <cstdint>
#include <functional>

namespace triad {

// Limits the threads of all parallel work in this process from here on; 0: as many as the machine has.
// Call it once, early, from the main thread.
void set_thread_limit(int threads);
int thread_limit();

// Bytes of memory that this machine has.
uint64_t machine_memory_bytes();

// body(i) for i in [0, n), in any order, on up to thread_limit() threads. The first exception is rethrown.
void parallel_for(int64_t n, const std::function<void(int64_t)>& body);

}  // namespace triad
