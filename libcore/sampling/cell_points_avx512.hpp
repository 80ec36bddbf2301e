// SPDX-License-Identifier: Apache-2.0
// The places of scrambled Sobol points in cells by hand for processors with AVX-512: a compiler that writes them from
// plain vector types takes twice as long for conversions and shuffles. CellBatch's plain loops give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <triad/sampling/cell_strata.hpp>
#include <triad/sampling/source.hpp>

namespace triad::avx512 {

inline constexpr size_t kTogether = 16;  // samples

// On a film of cells.
struct CellPixels {
  size_t n;
  const int32_t *x, *y;
  const uint32_t *seed_x, *seed_y;  // of their scrambling
};

// Sets all but the seeds of the requests of n pixels, of each the same multiple of kTogether, and their cells in it,
// from their points after owen_scramble_start(), in reverse order; and of a pixel's first request it takes
// footprint_px and index. Strata that are told apart are a power of 2. Only where cpu_can_run(CpuPath::kAvx512).
void place_in_cells(const CellPixels& pixels, const CellSide& across, const CellSide& down, const uint32_t* start_x,
                    const uint32_t* start_y, std::span<SampleRequest> requests, uint32_t* cell);

}  // namespace triad::avx512
