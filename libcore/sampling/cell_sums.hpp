// SPDX-License-Identifier: Apache-2.0
// Answers for points of display pixels, summed by cells before the film sees them.
#pragma once

#include <triad/sampling/cell_points.hpp>
#include <triad/sampling/sample_taker.hpp>

namespace triad {

// What spp samples in display pixels of so many cells need of a film.
Film::Holds film_for_cells(const Cells& cells, uint32_t spp);

// Asks for a batch that is placed, and adds what comes back to the film, each sample to its cell. False: the render
// was stopped.
// The film's bits depend on how the points of a pixel are parted into batches, but not on whether its very first is
// alone: as it waits for nothing, it counts as a batch of its own.
bool take_into_cells(SampleTaker& taker, const Cells& cells, CellBatch& batch, std::span<Sample> samples);

}  // namespace triad
