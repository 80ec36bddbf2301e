// SPDX-License-Identifier: Apache-2.0
// The sums of samples in display pixels of three cells in a row, as most displays have them, by hand for processors
// with AVX-512: the sums stay in registers, and a sample goes to the one of its cell by a mask. take_into_cells()'
// plain loops give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <triad/sampling/source.hpp>

namespace triad::avx512 {

// All are called only where cpu_can_run(CpuPath::kAvx512).

// n samples of a pixel, n > first_alone, each in the cell that `cells` says, 0, 1 or 2, go into the cells' records on
// a film of few, which have nothing yet: three floats each, a mean, and behind them 16 bits each how many samples it
// is of and how many were left out. With `first_alone` the first one is the very first of all, and is added last, as
// the others are its sum. False, and nothing was changed: a sample is not valid or not finite, or there was
// something.
bool put_few_in_three(float* records, const Sample* samples, const uint32_t* cells, size_t n, bool first_alone);

// The same for a film of some, to what there is: three sums, and 32 bits each how many samples they are of and how
// many were left out. The very first of all comes to cells without any, and before the others.
bool add_to_three(double* records, const Sample* samples, const uint32_t* cells, size_t n, bool first_alone);

// The sums of each cell, three and how many samples they are of, all doubles; with `first_alone` without the first
// one, which `first` is then. False: a sample is not valid or not finite.
bool sums_of_three(const Sample* samples, const uint32_t* cells, size_t n, bool first_alone, void* sums, void* first);

}  // namespace triad::avx512
