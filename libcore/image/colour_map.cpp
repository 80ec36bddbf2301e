// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/image/colour_map.hpp>

namespace triad {
namespace {

constexpr int kTerms = 13;
using Polynomial = std::array<double, kTerms>;  // coefficients of T0 ... T12 on [-1, 1]

// Red, green and blue, full signal 1. Least squares, reweighted until the largest residual no longer fell.
constexpr Polynomial kMagma[3] = {
    {.59089, .55129, -.11850, -.06192, .01640, .00787, .00739, -.00546, -.00388, .00244, .00149, -.00002, .00047},
    {.36998, .48008, .14412, .02042, -.01948, -.00745, -.00332, .00804, .00492, -.00829, .00161, -.00056, -.00188},
    {.41405, .24590, -.04375, .15333, .00677, -.02744, .00033, -.00780, .00766, .00584, -.00535, .00106, .00197}};
constexpr Polynomial kViridis[3] = {
    {.40870, .29833, .25500, .08024, -.03314, -.01966, -.00175, .00658, .00210, -.00360, -.00161, .00251, .00084},
    {.51872, .45466, -.05738, -.00485, -.00848, .00076, .00212, .00086, -.00036, .00014, .00014, -.00028, .00074},
    {.37589, -.14674, -.17065, .02113, .01484, .02882, .01471, .00490, .00421, .00126, -.00056, -.00080, -.00177}};

// Clenshaw's recurrence.
double evaluate(const Polynomial& coefficients, double x) {
  double b1 = 0, b2 = 0;
  for (int k = kTerms - 1; k > 0; --k) {
    const double b = coefficients[static_cast<size_t>(k)] + 2 * x * b1 - b2;
    b2 = b1;
    b1 = b;
  }
  return coefficients[0] + x * b1 - b2;
}

std::array<ColourCode, 256> make_table(const Polynomial (&channels)[3]) {
  std::array<ColourCode, 256> table;
  for (size_t i = 0; i < table.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      const double v = std::clamp(evaluate(channels[c], 2 * static_cast<double>(i) / 255 - 1), 0., 1.);
      table[i][c] = static_cast<uint8_t>(std::floor(v * 255 + .5));
    }
  return table;
}

constexpr ColourCode kGrey{128, 128, 128};
constexpr double kShare = .99;      // of the values, that a scale covers
constexpr unsigned kBinShift = 16;  // bits of a float that its bin does not see

}  // namespace

ColourMap parse_colour_map(const std::string& text) {
  if (text == "magma") return ColourMap::kMagma;
  if (text == "viridis") return ColourMap::kViridis;
  throw_usage("--colour-map '" + text + "' is neither 'magma' nor 'viridis'" +
              did_you_mean(text, {"magma", "viridis"}));
}

const char* colour_map_name(ColourMap map) { return map == ColourMap::kMagma ? "magma" : "viridis"; }

const std::array<ColourCode, 256>& colour_table(ColourMap map) {
  static const std::array<ColourCode, 256> magma = make_table(kMagma), viridis = make_table(kViridis);
  return map == ColourMap::kMagma ? magma : viridis;
}

ColourCode map_colour(const std::array<ColourCode, 256>& table, const MapScale& scale, double value) {
  if (std::isnan(value)) return kGrey;
  const double share = std::clamp((value - scale.low) / (scale.high - scale.low), 0., 1.);
  return table[static_cast<size_t>(std::floor(share * 255 + .5))];
}

ScaleFinder::ScaleFinder()
    : counts_(size_t{1} << (31 - kBinShift)),
      least_(std::numeric_limits<float>::infinity()),
      largest_(-std::numeric_limits<float>::infinity()) {}

void ScaleFinder::add(float value) {
  ++total_;
  if (std::isfinite(value)) {
    least_ = std::min(least_, value);
    largest_ = std::max(largest_, value);
  }
  if (!(value > 0)) {
    ++counts_[0];
    if (value < 0) ++below_;
    return;
  }
  ++above_;
  ++counts_[std::bit_cast<uint32_t>(value) >> kBinShift];  // positive floats are ordered as their bits are
}

bool ScaleFinder::has_signs() const {
  return below_ > 0 && least_ < 0 &&
         static_cast<double>(below_) >= (1 - kShare) * static_cast<double>(below_ + above_);
}

double ScaleFinder::low() const { return has_signs() ? -round_up_two_digits(-static_cast<double>(least_)) : 0; }

double ScaleFinder::high() const {
  if (has_signs()) {
    const double high = round_up_two_digits(static_cast<double>(largest_));
    return high > low() ? high : 0;
  }
  const double wanted = kShare * static_cast<double>(total_);
  uint64_t sum = 0;
  uint32_t bin = 0;
  for (; bin < counts_.size(); ++bin) {
    sum += counts_[bin];
    if (static_cast<double>(sum) >= wanted) break;
  }
  // The bin's upper end; never past the largest value, which infinities are not counted for.
  const float end = std::bit_cast<float>(std::min<uint32_t>(bin + 1, 0x7f80) << kBinShift),
              largest = std::max(largest_, 0.f);
  const double high = bin == 0 ? largest : std::min(end, largest);
  return round_up_two_digits(high);
}

double round_up_two_digits(double value) {
  if (!(std::abs(value) > 0)) return 0;
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value)))) - 1;
  // A negative power of ten is no double; dividing by the positive one rounds once.
  const double power = std::pow(10., std::abs(exponent));
  const double digits = std::ceil((exponent < 0 ? value * power : value / power) * (value > 0 ? 1 - 1e-9 : 1 + 1e-9));
  return exponent < 0 ? digits / power : digits * power;
}

}  // namespace triad
