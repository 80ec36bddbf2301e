// SPDX-License-Identifier: Apache-2.0
// What an eye makes of light: opponent channels and how finely each is seen.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace triad {

// How the visibility of a pattern falls with its frequency.
enum class Csf {
  // Sums of Gaussians after Zhang and Wandell (S-CIELAB, 1997). The published luminance kernel's third,
  // negative Gaussian of 4.336 degrees is left out: it would let one pixel act on others hundreds of pixels
  // away, and changes nothing above .2 cpd.
  kScielab,
  // Exponentials: luminance by Nasanen (1984), chrominance by Mullen (1985), as Kolpatzik and Bouman use them
  // ("Optimized error diffusion for image display", 1992). Its cusp at frequency 0 gives long tails.
  kKolpatzikBouman
};

enum class ChannelGains {
  kComparable,  // red-green times 7.5, blue-yellow times 2.5: about what CIELAB's gradient at white asks for
  kRaw          // all 1
};

// Who looks, from where, at which primaries.
struct Observer {
  std::array<double, 9> rgb_to_xyz{};  // of the linear picture, row-major, white at Y = 1
  double ppd = 40;                     // pixels per degree of visual angle; 40 is 96 dpi at about 60 cm
  Csf csf = Csf::kScielab;
  ChannelGains gains = ChannelGains::kComparable;
  double luminance_nits = 11;  // mean luminance of the display, used by kKolpatzikBouman only
};

inline constexpr int kOpponentChannels = 3;
// "luminance", "red-green", "blue-yellow".
const char* opponent_name(int channel);

// Linear RGB to opponent space with the gains in it: C[3 * channel + rgb].
std::array<double, 9> opponent_matrix(const Observer& observer);

// Modulation transfer of an opponent channel, without gain. frequency_cpd >= 0, in cycles per degree. About 1
// at frequency 0, falls with it, underflows to 0. An error's weight is its square.
double mtf(const Observer& observer, int channel, double frequency_cpd);

// One of the two Gaussians that mtf() sums for Csf::kScielab, term 0 or 1. They are products: its value at
// f = sqrt(fx^2 + fy^2), times that at 0, is that at fx times that at fy.
double scielab_term(int channel, int term, double frequency_cpd);

// The transfer of S-CIELAB's published kernels, third Gaussian included: what the metric of that name uses. 1 at
// frequency 0 for every channel.
double scielab_metric_mtf(int channel, double frequency_cpd);

// XYZ (CIE 1931, 2 degrees) to the opponent channels without gains: M[3 * channel + i].
const std::array<double, 9>& xyz_to_opponent();

// The inverse of a 3 x 3 matrix, row-major, which must have one.
std::array<double, 9> inverse_3x3(const std::array<double, 9>& matrix);

// Throws Error(kUsage) unless ppd is in 1 .. 10000, the luminance in .01 .. 1e6 and the matrix is finite and
// invertible.
void check_observer(const Observer& observer);

}  // namespace triad
