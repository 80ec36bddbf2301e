// SPDX-License-Identifier: Apache-2.0
// Wall-clock time, piece by piece.
#pragma once

#include <chrono>
#include <utility>

namespace triad::app {

class Stopwatch {
 public:
  // Seconds since the last call, or since it was made.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace triad::app
