// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>
#include <string>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/display/vision.hpp>

namespace triad {
namespace {

// XYZ (CIE 1931, 2 degrees) to luminance, red-green and blue-yellow. Poirson and Wandell (1993) as S-CIELAB's
// authors use it in their code; the .0771569 is negative in the 1997 paper, which would colour white.
constexpr std::array<double, 9> kXyzToOpponent{.2787336,  .7218031,  -.1065520,  //
                                               -.4487736, .2898056,  .0771569,   //
                                               .0859513,  -.5899859, .5011089};

constexpr double kGains[3] = {1, 7.5, 2.5};

// Zhang and Wandell (1997): weights, and spreads of exp(-(r / spread)^2) in degrees.
struct TwoGaussians {
  double weight[2], spread_deg[2];
};
constexpr TwoGaussians kScielab[3] = {
    {{1.00327, .114416}, {.0283, .133}},
    {{.6167, .3833}, {.0392, .494}},
    {{.5681, .4319}, {.0536, .386}},
};

// The luminance kernel's third Gaussian, as published; the weight is what the other two leave of 1.
constexpr double kScielabThirdSpread_deg = 4.336;
constexpr double kScielabThirdWeight = 1 - 1.00327 - .114416;

double determinant_of(const std::array<double, 9>& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
}

}  // namespace

const char* opponent_name(int channel) {
  static constexpr const char* kNames[] = {"luminance", "red-green", "blue-yellow"};
  return kNames[channel];
}

std::array<double, 9> opponent_matrix(const Observer& observer) {
  std::array<double, 9> matrix{};
  for (int c = 0; c < 3; ++c) {
    const double gain = observer.gains == ChannelGains::kRaw ? 1 : kGains[c];
    for (int d = 0; d < 3; ++d) {
      double sum = 0;
      for (int i = 0; i < 3; ++i) sum += kXyzToOpponent[3 * c + i] * observer.rgb_to_xyz[3 * i + d];
      matrix[3 * c + d] = gain * sum;
    }
  }
  return matrix;
}

double scielab_term(int channel, int term, double frequency_cpd) {
  const double x = std::numbers::pi * kScielab[channel].spread_deg[term] * frequency_cpd;
  return kScielab[channel].weight[term] * std::exp(-x * x);
}

double mtf(const Observer& observer, int channel, double frequency_cpd) {
  if (observer.csf == Csf::kKolpatzikBouman) {
    // Slopes per cpd: Nasanen's .525 ln L + 3.91 (L in cd/m^2) in cpd, Mullen's .419 degrees.
    return channel == 0 ? std::exp(-frequency_cpd / (.525 * std::log(observer.luminance_nits) + 3.91))
                        : std::exp(-.419 * frequency_cpd);
  }
  return scielab_term(channel, 0, frequency_cpd) + scielab_term(channel, 1, frequency_cpd);
}

double scielab_metric_mtf(int channel, double frequency_cpd) {
  const double value = scielab_term(channel, 0, frequency_cpd) + scielab_term(channel, 1, frequency_cpd);
  if (channel != 0) return value;
  const double x = std::numbers::pi * kScielabThirdSpread_deg * frequency_cpd;
  return value + kScielabThirdWeight * std::exp(-x * x);
}

const std::array<double, 9>& xyz_to_opponent() { return kXyzToOpponent; }

std::array<double, 9> inverse_3x3(const std::array<double, 9>& m) {
  const double d = determinant_of(m);
  return {(m[4] * m[8] - m[5] * m[7]) / d, (m[2] * m[7] - m[1] * m[8]) / d, (m[1] * m[5] - m[2] * m[4]) / d,
          (m[5] * m[6] - m[3] * m[8]) / d, (m[0] * m[8] - m[2] * m[6]) / d, (m[2] * m[3] - m[0] * m[5]) / d,
          (m[3] * m[7] - m[4] * m[6]) / d, (m[1] * m[6] - m[0] * m[7]) / d, (m[0] * m[4] - m[1] * m[3]) / d};
}

void check_observer(const Observer& observer) {
  if (!(observer.ppd >= 1 && observer.ppd <= 10000))
    throw_usage("ppd is " + format_double(observer.ppd) + ": 1 to 10000 pixels per degree are possible");
  // Below 6e-4 cd/m^2 the luminance curve would rise with frequency.
  if (!(observer.luminance_nits >= .01 && observer.luminance_nits <= 1e6))
    throw_usage("luminance is " + format_double(observer.luminance_nits) + ": .01 to 1e6 cd/m^2 are possible");
  const double determinant = determinant_of(observer.rgb_to_xyz);
  if (!std::isfinite(determinant) || !(std::abs(determinant) > 1e-6))
    throw_usage("the primaries of the picture's colour space do not span a colour space");
}

}  // namespace triad
