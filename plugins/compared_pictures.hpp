// SPDX-License-Identifier: Apache-2.0
// What the metrics that compare two pictures pixel by pixel share.
#pragma once

#include <triad/abi/triad_plugin.hpp>

#include <algorithm>
#include <string>
#include <triad/numeric/weighted_mean.hpp>

namespace compared_pictures {

namespace tp = triad_plugin;

inline constexpr tp::Input kMask{"mask", "weights of the pixels", "mask", nullptr, TRIAD_INPUT_OPTIONAL};
inline constexpr int kBlock_px = 256;  // pixels at a time

// In plan: refuses pictures of different sizes.
inline void require_same_size(const tp::PlanCall& call) {
  const auto size = [](const triad_image& image) {
    return std::to_string(image.width) + "x" + std::to_string(image.height);
  };
  const triad_image &test = call.in(0), &reference = call.in(1);
  if (test.width != reference.width || test.height != reference.height)
    throw tp::Error(TRIAD_E_INPUT, "the test picture is " + size(test) + ", the reference " + size(reference) +
                                       "; they must be alike");
}

// body(x, y, n, weights) for the strip's pixels (x, y) .. (x + n - 1, y), n <= kBlock_px; weights is null where all
// are 1. mask: the input's index.
template <class F>
void for_blocks(const tp::StripCall& call, int mask, const F& body) {
  const bool weighted = call.has(mask);
  for (int y = call.r.y0; y < call.r.y1; ++y)
    for (int x = call.r.x0; x < call.r.x1; x += kBlock_px)
      body(x, y, static_cast<size_t>(std::min(kBlock_px, call.r.x1 - x)),
           weighted ? call.in(mask).at(x, y) : nullptr);
}

// Writes values into a map of one channel.
inline void write_map(const tp::StripCall& call, int x, int y, const double* values, size_t count) {
  float* to = call.out().at(x, y);
  for (size_t i = 0; i < count; ++i) to[i] = static_cast<float>(values[i]);
}

// In end_pass: the mean, or the reason why there is none.
inline double mean_of(const triad::WeightedMean& all) {
  if (all.nonfinite > 0)
    throw tp::Error(TRIAD_E_INPUT, "the error of " + std::to_string(all.nonfinite) +
                                       " pixels is not a number or infinite; leave them out or replace them first");
  if (all.counted == 0) throw tp::Error(TRIAD_E_INPUT, "every pixel is left out by the mask or the crop");
  return all.mean();
}

}  // namespace compared_pictures
