// SPDX-License-Identifier: Apache-2.0
// In single precision and in the order of the authors' program, so that exposures and their count are the same.
#include <algorithm>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/flip_exposures.hpp>

namespace triad {
namespace {

constexpr float kBright = .85f;
constexpr int kMostExposures = 1000;

// The light that is shown as kBright: the larger solution of a quadratic equation.
float bright_light(FlipToneMapper mapper) {
  const FlipToneCurve t = flip_tone_curve(mapper);
  const float a = t.n2 - kBright * t.d2, b = t.n1 - kBright * t.d1, c = t.n0 - kBright * t.d0;
  if (a == 0) return -c / b;
  const float half = -.5f * (b / a);
  return half + std::sqrt(half * half - c / a);
}

float log2_float(float x) { return static_cast<float>(std::log2(static_cast<double>(x))); }

}  // namespace

FlipToneCurve flip_tone_curve(FlipToneMapper mapper) {
  switch (mapper) {
    case FlipToneMapper::kReinhard: return {0, 1, 0, 0, 1, 1};
    case FlipToneMapper::kHable: return {.231683f, .013791f, 0, .18f, .3f, .018f};
    case FlipToneMapper::kAces: break;
  }
  constexpr float kExposure = .6f;
  return {kExposure * kExposure * 2.51f, kExposure * .03f, 0, kExposure * kExposure * 2.43f, kExposure * .59f, .14f};
}

float flip_light(float code) { return code <= .04045f ? code / 12.92f : std::pow((code + .055f) / 1.055f, 2.4f); }

float FlipExposures::at(int i) const {
  if (count < 2) return start_stops;
  const float step = (stop_stops - start_stops) / static_cast<float>(count - 1);
  return start_stops + static_cast<float>(i) * step;
}

FlipExposures flip_exposures(FlipToneMapper mapper, std::optional<float> start_stops, std::optional<float> stop_stops,
                             int count, float median, float largest) {
  const float bright = bright_light(mapper);
  FlipExposures made;
  made.start_stops = start_stops ? *start_stops : log2_float(bright / largest);
  made.stop_stops = stop_stops ? *stop_stops : log2_float(bright / median);
  const auto text = [](float stops) { return format_double(static_cast<double>(stops)); };
  if (!std::isfinite(made.start_stops) || !std::isfinite(made.stop_stops))
    throw_usage("exposures from " + text(made.start_stops) + " to " + text(made.stop_stops) +
                " stops are no numbers");
  if (made.start_stops > made.stop_stops)
    throw_usage("the first exposure, " + text(made.start_stops) + " stops, lies above the last, " +
                text(made.stop_stops) + " stops; give start= and stop= in ascending order");
  const float stops = std::ceil(made.stop_stops - made.start_stops);
  if (count == 0 && stops > static_cast<float>(kMostExposures))
    throw_usage("exposures from " + text(made.start_stops) + " to " + text(made.stop_stops) +
                " stops are more than " + std::to_string(kMostExposures) + "; say how many with count=");
  made.count = count > 0 ? count : static_cast<int>(std::max(2.f, stops));
  return made;
}

FloatRank::Place FloatRank::find(std::span<const uint64_t> counts, uint64_t rank) {
  uint32_t bin = 0;
  for (; rank >= counts[bin]; ++bin) rank -= counts[bin];
  return {bin, rank};
}

}  // namespace triad
