// SPDX-License-Identifier: Apache-2.0
// FLIP, the difference that a viewer sees on flipping between two pictures:
//   P. Andersson, J. Nilsson, T. Akenine-Moller, M. Oskarsson, K. Astrom, M. D. Fairchild, "FLIP: A Difference
//   Evaluator for Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020, article 15 (LDR);
//   P. Andersson, J. Nilsson, P. Shirley, T. Akenine-Moller, "Visualizing Errors in Rendered High Dynamic Range
//   Images", Eurographics 2021 Short Papers (HDR).
#pragma once

#include <cstddef>
#include <cstdint>
#include <triad/evaluation/flip_exposures.hpp>
#include <triad/evaluation/flip_filters.hpp>
#include <vector>

namespace triad {

// Pixel (0, 0) of a picture's part that is to be judged, three floats a pixel, rows row_floats apart. The pixels
// within Flip::reach_px() around the part must be there, beyond the picture's border as copies of those at it.
struct FlipPicture {
  const float* rgb = nullptr;
  int64_t row_floats = 0;
};

// What the numbers are, and how they come to the display.
struct FlipViewing {
  bool srgb_codes = false;  // code values of IEC 61966-2-1; else linear light of its primaries
  // HDR: exposures of the display, in stops, and what then maps light to [0, 1]. Empty: LDR, as it is. Either way
  // values are cut to [0, 1] at the end.
  std::vector<float> exposures_stops = {};
  FlipToneMapper tone_mapper = FlipToneMapper::kAces;
};

// The metric for one distance from the display. Immutable: all functions may be called on several threads at once.
class Flip {
 public:
  // ppd: pixels per degree, from FlipFilters::kLeast_ppd to kMost_ppd; others are a usage error.
  explicit Flip(double ppd);

  // How far from a pixel, in rows and in columns, its error depends on the pictures.
  int reach_px() const { return filters_.reach_px(); }

  // Floats from a row of evaluate()'s results to the next.
  static int row_floats(int width);

  // Floats that one call of evaluate() works in. Wide parts are best cut into pieces of some hundred columns, whose
  // work stays in a processor's cache.
  size_t work_floats(int width, int height) const;

  // The errors of a part of width x height pixels, in [0, 1]; with several exposures the largest of each pixel's, and
  // then `worst_stops`, unless it is nullptr, gets the exposure at which that was first met. Both have rows of
  // row_floats(width), of which the first width are meant. errors, worst_stops and work must lie on 64-byte
  // boundaries. A pixel's result is the same bits whatever part it is computed in and on every processor.
  void evaluate(const FlipPicture& test, const FlipPicture& reference, int width, int height,
                const FlipViewing& viewing, float* errors, float* worst_stops, float* work) const;

 private:
  FlipFilters filters_;
};

}  // namespace triad
