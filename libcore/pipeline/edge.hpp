// SPDX-License-Identifier: Apache-2.0
// What lies beyond the border of a picture.
#pragma once

#include <triad/abi/triad_plugin.h>

#include <cstdint>

namespace triad {

// The index in [0, n) whose sample stands for index i of a row (or column) of n > 0 samples, however far i is
// outside; -1 where TRIAD_EDGE_ZERO puts a zero. MIRROR repeats the border sample: c b a | a b c | c b a.
constexpr int64_t edge_index(int32_t edge, int64_t i, int64_t n) {
  if (i >= 0 && i < n) return i;
  switch (edge) {
    case TRIAD_EDGE_CLAMP: return i < 0 ? 0 : n - 1;
    case TRIAD_EDGE_MIRROR: {
      const int64_t phase = ((i % (2 * n)) + 2 * n) % (2 * n);
      return phase < n ? phase : 2 * n - 1 - phase;
    }
    case TRIAD_EDGE_WRAP: return ((i % n) + n) % n;
    default: return -1;
  }
}

}  // namespace triad
