// SPDX-License-Identifier: Apache-2.0
// Runs a stage over small synthetic pictures in every way a host may, watching the memory around each strip.
#pragma once

#include <triad/abi/triad_plugin.h>

#include <cstdint>
#include <string>
#include <triad/pipeline/plugin_host.hpp>
#include <vector>

namespace triad {

struct SyntheticPicture {
  triad_image image{};
  std::vector<float> pixels;
};

// Reproducible values in [0, 1), the same for the same seed; alpha, if there is one, is the last channel.
SyntheticPicture synthetic_picture(int width, int height, int channels, Cells cells, uint32_t seed);

struct ExerciseOptions {
  // The upper borders of the strips, ascending from 0 (those below the
  // picture are ignored); {} the whole picture. The stage's own strip_rows wins.
  std::vector<int> borders = {};
  bool descending = false;  // order of the strips; TRIAD_REENTRANT only
  int threads = 1;          // TRIAD_REENTRANT only
  bool want_map = true;     // of a metric
};

struct ExerciseOutcome {
  std::vector<float> pixels;  // of the output or map; {} if there is none
  std::vector<double> scores;
  // The same bits, so that -0 differs from 0.
  bool operator==(const ExerciseOutcome& other) const;
};

// A planned stage and its inputs (nullptr where an optional one is absent).
struct Exercise {
  StageInstance* stage;
  StageInstance::Plan plan;
  std::vector<const SyntheticPicture*> inputs;
};

// All passes of a stage. Throws what StageInstance throws, and PluginError pixels.unwritten,
// pixels.writes-past-strip, state.writes-past-end. A write to an input, or a read past its end, is a
// segmentation fault at an address that watched_memory() knows.
ExerciseOutcome run_exercise(const Exercise& exercise, const ExerciseOptions& options);

enum class WatchedMemory { kNone, kInput, kBeyondInput };
// What an address belongs to. Async-signal-safe.
WatchedMemory watched_memory(const void* address);

}  // namespace triad
