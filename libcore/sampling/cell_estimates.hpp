// SPDX-License-Identifier: Apache-2.0
// What the samples in a film of cells say of the display's pixels and of cells that have none.
#pragma once

#include <array>
#include <triad/display/vision.hpp>
#include <triad/sampling/film.hpp>

namespace triad {

// An estimate of the error of the mean of display pixel (x, y), with its sign, by red, green and blue: the difference
// between the means of its samples' two halves, as Film::estimated_rmse() takes them, times the root of their shares.
// Single cells may have too few samples for halves. Infinite while a half is empty; 0 where there is nothing, as
// Film::has_nothing() has it. Needs planes().error.
std::array<double, 3> estimated_error(const Film& film, const Cells& cells, int x, int y);

// How much an eye sees of errors of pixels that are independent of each other, along a row.
class NoiseSeen {
 public:
  // ppd: pixels of the display in a degree of the view, above 0.
  explicit NoiseSeen(double ppd);
  // The root of the energy that is left of an error in red, green and blue; white is 1.
  double operator()(const std::array<double, 3>& rgb) const;

 private:
  std::array<double, 9> to_opponent_{};
  std::array<double, kOpponentChannels> passed_{};
};

// The film's means, and for each pixel without a sample the mean of the nearest that have some, in squares of at most
// two display pixels to either side; 0 if there is none. Nothing if all have samples.
std::vector<std::array<double, 3>> filled_means(const Film& film, const Cells& cells);

}  // namespace triad
