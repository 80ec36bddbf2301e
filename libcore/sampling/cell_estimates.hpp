// SPDX-License-Identifier: Apache-2.0
// What the samples in a film of cells say of the display's pixels and of cells that have none.
#pragma once

#include <triad/sampling/film.hpp>

namespace triad {

// An estimate of the error of the mean of display pixel (x, y), with its sign, by red, green and blue: the difference
// between the means of its samples' two halves, as Film::estimated_rmse() takes them, times the root of their shares.
// Single cells have too few samples for halves. Infinite while a half is empty. Needs planes().error.
std::array<double, 3> estimated_error(const Film& film, const Cells& cells, int x, int y);
// Its root mean square over display pixels and channels.
double estimated_rmse(const Film& film, const Cells& cells);

// The film's means, and for each pixel without a sample the mean of the nearest that have some, in squares of at most
// two display pixels to either side; 0 if there is none. Nothing if all have samples.
std::vector<std::array<double, 3>> filled_means(const Film& film, const Cells& cells);

}  // namespace triad
