// SPDX-License-Identifier: Apache-2.0
// Answers for points of display pixels, summed by cells before the film sees them.
#pragma once

#include <triad/sampling/cell_points.hpp>
#include <triad/sampling/sample_taker.hpp>

namespace triad {

// Asks for a batch that is placed, and adds what comes back to the film, each sample to its cell. False: the render
// was stopped. The film's bits depend on the points of each pixel's batches and on nothing else.
bool take_into_cells(SampleTaker& taker, const Cells& cells, CellBatch& batch, std::span<Sample> samples);

}  // namespace triad
