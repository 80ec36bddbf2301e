// SPDX-License-Identifier: Apache-2.0
// The innermost loops of a render, by hand for processors with AVX-512: a compiler that writes them from plain
// vector types takes twice as long for conversions and shuffles. The plain ones beside their callers give the same
// bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <triad/sampling/source.hpp>

namespace triad::avx512 {

// All are called only where cpu_can_run(CpuPath::kAvx512).

// Film::add_run() of the sums alone: `sum` holds three sums and behind them three compensations. `fresh`: nothing was
// added to them yet, and n > 1. `half` and `in_half`, unless null: the sums and the number of the samples in half 1.
// False, and nothing was changed, if a sample is not valid or not finite.
bool add_run(double* sum, bool fresh, const SampleRequest* requests, const Sample* samples, size_t n, double* half,
             uint32_t* in_half);

// Film::add_few() for `each` samples of every one of some pixels in a row, whose records are three floats, a mean,
// and behind them 16 bits each how many samples it is of and how many were left out. Goes as far as all samples of a
// pixel are valid and finite, and it had at most one and will have no more than a film of few may; returns how many
// pixels that is.
size_t add_few(float* records, size_t pixels, const Sample* samples, size_t each);

// What place_sobol_owen() does for sixteen samples of one pixel whose coordinates before the scrambling, in reverse
// order and after owen_scramble_start(), are given; and say_all(), with the pixel's first request in the same array.
void place_sixteen(const uint32_t* start_x, const uint32_t* start_y, uint32_t seed_x, uint32_t seed_y,
                   const SampleRequest& first, SampleRequest* requests);

}  // namespace triad::avx512
