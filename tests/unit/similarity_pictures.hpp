// SPDX-License-Identifier: Apache-2.0
// Pairs of pictures out of integers, the same in any language, so that other programs can be asked about them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <triad/base/random.hpp>
#include <vector>

namespace similarity_pictures {

// 16 bits of a hash of the place: a multiple of 2^-16.
inline double unit(int x, int y, int channel, int seed) {
  const uint64_t key = uint64_t(seed) << 48 | uint64_t(channel) << 40 | uint64_t(y) << 20 | uint64_t(x);
  return static_cast<double>(triad::mix_bits(key) >> 48) / 65536;
}
// A ramp up and down, of period 2n.
inline double ramp(int k, int n) {
  k %= 2 * n;
  return static_cast<double>(k < n ? k : 2 * n - k) / n;
}

struct Pair {
  int width = 0, height = 0;
  std::vector<float> test, reference;  // RGB; all values are exact in float
};

inline Pair make(const std::string& kind, int width, int height) {
  Pair pair{width, height, {}, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double a = unit(x, y, c, 1), b = unit(x, y, c, 2);
        double r = a, t = b;  // "noise"
        if (kind == "faint") {
          r = ramp(x + 2 * y + 8 * c, 32);
          t = r + (b - .5) / 16;
        } else if (kind == "shifted") {
          r = ramp(3 * x + y + 4 * c, 64) / 2 + a / 4;
          t = ramp(3 * (x + 1) + y + 4 * c, 64) / 2 + unit(x + 1, y, c, 1) / 4;
        } else if (kind == "bright") {
          r = .75 + a / 256;
          t = .765625 + b / 256;
        } else if (kind == "negative") {
          t = 1 - a;
        } else if (kind == "blocks") {
          r = unit(x / 8, y / 8, c, 1);
          t = r * .75 + unit(x / 16, y / 16, c, 2) / 8 + unit(x, y, c, 3) / 16;
        }
        pair.reference.push_back(static_cast<float>(r));
        pair.test.push_back(static_cast<float>(t));
      }
  return pair;
}

struct Expected {
  const char* kind;
  int width, height;
  double rgb, luma;
};

// skimage.metrics.structural_similarity(test, reference, channel_axis=2, gaussian_weights=True, sigma=1.5,
// use_sample_covariance=False, data_range=1) of scikit-image 0.19.3 (SciPy 1.10.1, NumPy 1.24.2) on these values as
// float64; luma: without channel_axis, of .2126 R + .7152 G + .0722 B.
inline constexpr Expected kSsim[] = {
    {"noise", 11, 11, -0.071927342777, -0.262899137645},    {"noise", 37, 29, -0.001214644818, -0.013421281220},
    {"faint", 64, 48, 0.982373827710, 0.986030704621},      {"faint", 133, 17, 0.982260386511, 0.985655163045},
    {"shifted", 50, 41, 0.219553475948, 0.316893693507},    {"bright", 40, 33, 0.997113290724, 0.998273164692},
    {"negative", 31, 45, -0.964949810560, -0.969019402133},
};

// The formula of ms_ssim.hpp in NumPy: structure from scipy.ndimage.gaussian_filter(v, 1.5, truncate=3.5), mean over
// [5:-5, 5:-5], the coarsest scale by structural_similarity as above, odd sides by numpy.pad(mode="symmetric");
// the mean over three channels, and that of luma. The same versions.
inline constexpr Expected kMsSsim[] = {
    {"noise", 176, 176, 0.067658355732, 0.140593740759},
    {"faint", 181, 203, 0.998749408759, 0.999039142756},
    {"shifted", 240, 177, 0.886658033037, 0.917508695976},
    {"blocks", 203, 190, 0.947594554248, 0.951594913032},
    {"negative", 176, 176, 0, 0},
};

}  // namespace similarity_pictures
