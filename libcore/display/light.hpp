// SPDX-License-Identifier: Apache-2.0
// Light over a plane of fine cells, made a row at a time, so that no stage needs a whole picture of it in memory.
#pragma once

#include <cstddef>
#include <functional>

namespace triad {

// Writes the linear RGB of all cells of row y, interleaved, white at 1. Called for any rows, in any order, on several
// threads at once.
using Light = std::function<void(size_t y, double* rgb)>;

// Takes the finished values of row y; their number and meaning is the caller's to say. As above.
using RowSink = std::function<void(size_t y, const double* values)>;

}  // namespace triad
