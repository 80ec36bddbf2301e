// SPDX-License-Identifier: Apache-2.0
// Structural similarity against its definition, window by window in long double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <triad/evaluation/ms_ssim.hpp>

#include "similarity_pictures.hpp"
#include "stability/stability_table.hpp"

namespace {

using triad::SsimSamples;
using Wide = long double;

int mirrored(int i, int n) {
  const int k = ((i % (2 * n)) + 2 * n) % (2 * n);
  return k < n ? k : 2 * n - 1 - k;
}

struct Local {
  Wide ssim, structure;
};

// The definition, about the window's own means.
template <class At>
Local window(const At& test, const At& reference, int x, int y, Wide range) {
  Wide weights = 0, mx = 0, my = 0, vx = 0, vy = 0, cov = 0;
  const auto each = [&](const auto& body) {
    for (int j = -5; j <= 5; ++j)
      for (int i = -5; i <= 5; ++i)
        body(std::exp(-(i * i + j * j) / (2 * 1.5L * 1.5L)), Wide(test(x + i, y + j)), Wide(reference(x + i, y + j)));
  };
  each([&](Wide w, Wide a, Wide b) { weights += w, mx += w * a, my += w * b; });
  mx /= weights, my /= weights;
  each([&](Wide w, Wide a, Wide b) {
    vx += w / weights * (a - mx) * (a - mx);
    vy += w / weights * (b - my) * (b - my);
    cov += w / weights * (a - mx) * (b - my);
  });
  const Wide c1 = .01L * range * .01L * range, c2 = .03L * range * .03L * range;
  const Wide structure = (2 * cov + c2) / (vx + vy + c2);
  return {(2 * mx * my + c1) / (mx * mx + my * my + c1) * structure, structure};
}

// A picture with its mirror image around it, as the host gives it.
template <class Sample>
struct Padded {
  static constexpr int kPad = 5;
  int width, height, channels;
  std::vector<Sample> samples;
  template <class At>
  Padded(int w, int h, int c, const At& at) : width(w), height(h), channels(c) {
    for (int y = -kPad; y < h + kPad; ++y)
      for (int x = -kPad; x < w + kPad; ++x)
        for (int k = 0; k < c; ++k) samples.push_back(static_cast<Sample>(at(mirrored(x, w), mirrored(y, h), k)));
  }
  ptrdiff_t stride() const { return ptrdiff_t{width + 2 * kPad} * channels; }
  SsimSamples<Sample> at(int x, int y) const {
    return {samples.data() + (y + kPad) * stride() + (x + kPad) * channels, stride()};
  }
};

// Rows in bands of so many.
template <class Sample>
std::vector<double> ssim_map(const Padded<Sample>& test, const Padded<Sample>& reference, double range, int rows,
                             triad::SsimTotals* totals = nullptr, std::vector<double>* structures = nullptr) {
  const int channels = test.channels;
  std::vector<double> map(static_cast<size_t>(test.width) * test.height * channels, NAN);
  if (structures) structures->assign(map.size(), NAN);
  for (int y0 = 0; y0 < test.height; y0 += rows) {
    triad::SsimTotals part{};
    triad::local_ssim(test.at(0, y0), reference.at(0, y0),
                      {0, y0, test.width, std::min(test.height, y0 + rows), channels}, range,
                      [&](int x, int y, int pixels, const double* ssim, const double* structure) {
                        const size_t to = (static_cast<size_t>(y) * test.width + x) * channels;
                        std::copy_n(ssim, pixels * channels, &map[to]);
                        if (structures) std::copy_n(structure, pixels * channels, &(*structures)[to]);
                        part.add(x, y, pixels, test.width, test.height, channels, nullptr, ssim, structure);
                      });
    if (totals) totals->merge(part);
  }
  return map;
}

Padded<float> padded(const std::vector<float>& rgb, int width, int height) {
  return {width, height, 3, [&](int x, int y, int c) { return rgb[(static_cast<size_t>(y) * width + x) * 3 + c]; }};
}

// The largest difference from the definition over all pixels, channels and both values.
template <class Sample>
double worst_error(const Padded<Sample>& test, const Padded<Sample>& reference, double range, int rows) {
  std::vector<double> structures;
  const std::vector<double> map = ssim_map(test, reference, range, rows, nullptr, &structures);
  Wide worst = 0;
  size_t i = 0;
  for (int y = 0; y < test.height; ++y)
    for (int x = 0; x < test.width; ++x)
      for (int c = 0; c < test.channels; ++c, ++i) {
        const auto of = [&](const Padded<Sample>& picture) {
          return [&picture, c](int px, int py) {
            return picture.at(0, 0).first[py * picture.stride() + px * picture.channels + c];
          };
        };
        const std::function<Wide(int, int)> a = of(test), b = of(reference);
        const Local expected = window(a, b, x, y, range);
        const Wide error = std::max(std::abs(map[i] - expected.ssim), std::abs(structures[i] - expected.structure));
        if (!(error <= worst)) worst = error;
      }
  return static_cast<double>(worst);
}

}  // namespace

TEST(SsimTest, AgreesWithScikitImage) {
  for (const auto& row : similarity_pictures::kSsim) {
    const auto pair = similarity_pictures::make(row.kind, row.width, row.height);
    triad::SsimTotals totals{};
    ssim_map(padded(pair.test, row.width, row.height), padded(pair.reference, row.width, row.height), 1, 64, &totals);
    EXPECT_EQ(totals.weight.value(), (row.width - 10.) * (row.height - 10.));
    const double mean = (totals.ssim[0].value() + totals.ssim[1].value() + totals.ssim[2].value()) / 3;
    EXPECT_NEAR(mean / totals.weight.value(), row.rgb, 1e-11) << row.kind << ' ' << row.width;
  }
}

TEST(SsimTest, EveryPixelIsAsDefined) {
  // Widths on both sides of a tile, and bands that leave a rest.
  for (const auto& [kind, width, height] : {std::tuple{"noise", 11, 11}, {"shifted", 129, 13}, {"faint", 140, 12}}) {
    const auto pair = similarity_pictures::make(kind, width, height);
    for (const int rows : {64, 5})
      EXPECT_LT(worst_error(padded(pair.test, width, height), padded(pair.reference, width, height), 1, rows), 1e-12)
          << kind << ' ' << width << ' ' << rows;
  }
}

TEST(SsimTest, TakesDoublesAndAnyDataRange) {
  const auto at = [](int seed) {
    return [seed](int x, int y, int c) { return 595 * std::sqrt(similarity_pictures::unit(x, y, c, seed)); };
  };
  EXPECT_LT(worst_error(Padded<double>(23, 19, 1, at(1)), Padded<double>(23, 19, 1, at(2)), 256, 64), 1e-12);
}

TEST(SsimTest, EqualPicturesAreExactlyOne) {
  const auto pair = similarity_pictures::make("noise", 150, 20);
  for (const float scale : {1.f, 1e-30f, 1e12f}) {
    std::vector<float> values = pair.test;
    for (float& v : values) v *= scale;
    const auto picture = padded(values, 150, 20);
    for (const double v : ssim_map(picture, picture, 1, 64)) ASSERT_EQ(v, 1.0) << scale;
  }
}

TEST(SsimTest, ConstantPicturesAreTheirLuminanceTerm) {
  const Padded<float> a(12, 12, 1, [](int, int, int) { return .25f; }),
      b(12, 12, 1, [](int, int, int) { return .75f; });
  for (const double v : ssim_map(a, b, 1, 64)) EXPECT_NEAR(v, (2 * .1875 + 1e-4) / (.0625 + .5625 + 1e-4), 1e-15);
}

namespace {

// E[x^2] - E[x]^2 in double, as most programs do it: the largest error of the structure term.
double naive_error(const Padded<double>& test, const Padded<double>& reference, double range) {
  double worst = 0;
  for (int y = 0; y < test.height; ++y)
    for (int x = 0; x < test.width; ++x) {
      double weights = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
      for (int j = -5; j <= 5; ++j)
        for (int i = -5; i <= 5; ++i) {
          const double w = std::exp(-(i * i + j * j) / 4.5), a = *test.at(x + i, y + j).first,
                       b = *reference.at(x + i, y + j).first;
          weights += w, sx += w * a, sy += w * b, sxx += w * a * a, syy += w * b * b, sxy += w * a * b;
        }
      const double mx = sx / weights, my = sy / weights, c2 = .03 * range * .03 * range;
      const double structure =
          (2 * (sxy / weights - mx * my) + c2) / (sxx / weights - mx * mx + syy / weights - my * my + c2);
      const auto of = [](const Padded<double>& picture) {
        return [&picture](int px, int py) { return static_cast<Wide>(*picture.at(px, py).first); };
      };
      const std::function<Wide(int, int)> a = of(test), b = of(reference);
      worst = std::max(worst, std::abs(structure - static_cast<double>(window(a, b, x, y, range).structure)));
    }
  return worst;
}

}  // namespace

// Contrast of a millionth on what is bright: E[x^2] - E[x]^2 has no right digit here where C2 is as small.
TEST(SsimTest, StaysRightOnAPedestal) {
  for (const double pedestal : {0., 1., 1e3, 1e6}) {
    const auto at = [&](int seed) {
      return [&, seed](int x, int y, int c) { return pedestal + 1e-6 * similarity_pictures::unit(x, y, c, seed); };
    };
    const Padded<double> test(20, 20, 1, at(1)), reference(20, 20, 1, at(2));
    EXPECT_LT(worst_error(test, reference, 1e-5, 64), 1e-12) << pedestal;
    EXPECT_LT(worst_error(test, reference, 1, 64), 1e-12) << pedestal;
    if (pedestal != 1e3) continue;
    triad::stability::at_most("metrics", "ssim: contrast 1e-6 on a level of 1000, data range 1e-5, error",
                              worst_error(test, reference, 1e-5, 64), 1e-12);
    triad::stability::naive_fails("metrics", "the same by E[x^2] - E[x]^2 in double",
                                  naive_error(test, reference, 1e-5), .1);
  }
  // A pedestal under one picture only, as of an exposure that is off; codes near white.
  const auto pair = similarity_pictures::make("bright", 40, 12);
  std::vector<float> off = pair.test;
  for (float& v : off) v = 1000 + v;
  EXPECT_LT(worst_error(padded(off, 40, 12), padded(pair.reference, 40, 12), 1, 64), 1e-12);
  EXPECT_LT(worst_error(padded(pair.test, 40, 12), padded(pair.reference, 40, 12), 1e-4, 64), 1e-9);
}

TEST(SsimTest, AFireflyInACornerHarmsNoOther) {
  auto pair = similarity_pictures::make("faint", 60, 12);
  for (int c = 0; c < 3; ++c) pair.test[c] = pair.reference[c] = 1e6f;
  const auto test = padded(pair.test, 60, 12), reference = padded(pair.reference, 60, 12);
  EXPECT_LT(worst_error(test, reference, 1, 64), 1e-3);  // windows that hold it: 1e-16 of its square
  const auto map = ssim_map(test, reference, 1, 64);
  const auto clean = similarity_pictures::make("faint", 60, 12);
  const auto expected = ssim_map(padded(clean.test, 60, 12), padded(clean.reference, 60, 12), 1, 64);
  for (int y = 0; y < 12; ++y)
    for (int x = 6; x < 60; ++x)
      for (int c = 0; c < 3; ++c) {
        const size_t i = (static_cast<size_t>(y) * 60 + x) * 3 + c;
        ASSERT_NEAR(map[i], expected[i], 1e-12) << x << ' ' << y;
      }
}

namespace {

using Plane = std::vector<std::vector<double>>;

Plane halved(const Plane& in) {
  const size_t height = in.size(), width = in[0].size();
  Plane out((height + 1) / 2, std::vector<double>((width + 1) / 2));
  for (size_t y = 0; y < out.size(); ++y)
    for (size_t x = 0; x < out[0].size(); ++x)
      for (const size_t v : {2 * y, 2 * y + 1})
        for (const size_t u : {2 * x, 2 * x + 1})
          out[y][x] += in[std::min(v, height - 1)][std::min(u, width - 1)] / 4;
  return out;
}

struct MsReference {
  double score = 1;
  Plane map;
};
// One channel, straight from the definition. weights: of the pixels.
MsReference ms_reference(Plane test, Plane reference, Plane weights) {
  MsReference out;
  out.map.assign(test.size(), std::vector<double>(test[0].size(), 1));
  for (int k = 0; k < 5; ++k) {
    const int height = static_cast<int>(test.size()), width = static_cast<int>(test[0].size());
    const auto of = [&](const Plane& plane) {
      return [&plane, width, height](int x, int y) { return plane[mirrored(y, height)][mirrored(x, width)]; };
    };
    const std::function<Wide(int, int)> a = of(test), b = of(reference);
    Wide sum = 0, total = 0;
    Plane values(height, std::vector<double>(width));
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const Local local = window(a, b, x, y, 1);
        const Wide value = k == 4 ? local.ssim : local.structure;
        values[y][x] = static_cast<double>(std::max<Wide>(value, 0));
        if (x < 5 || y < 5 || x >= width - 5 || y >= height - 5) continue;
        sum += weights[y][x] * value;
        total += weights[y][x];
      }
    const double power = triad::kMsSsimWeights[k];
    out.score *= static_cast<double>(std::pow(std::max<Wide>(sum / total, 0), static_cast<Wide>(power)));
    for (size_t y = 0; y < out.map.size(); ++y)
      for (size_t x = 0; x < out.map[0].size(); ++x) out.map[y][x] *= std::pow(values[y >> k][x >> k], power);
    test = halved(test), reference = halved(reference), weights = halved(weights);
  }
  return out;
}

struct MsResult {
  triad::MsSsimTotals totals{};
  std::vector<float> map;
};
MsResult ms_ssim(const Padded<float>& test, const Padded<float>& reference, int rows, const float* weights) {
  MsResult out;
  out.map.assign(static_cast<size_t>(test.width) * test.height, NAN);
  for (int y = 0; y < test.height; y += rows) {
    const size_t begin = static_cast<size_t>(y) * test.width;
    triad::MsSsimTotals part{};
    triad::add_ms_ssim(test.at(0, y), reference.at(0, y),
                       {test.width, test.height, y, std::min(test.height, y + rows), test.channels,
                        weights ? weights + begin : nullptr, test.width},
                       1, part, out.map.data() + begin, test.width);
    out.totals.merge(part);
  }
  return out;
}

}  // namespace

TEST(MsSsimTest, AgreesWithSciPy) {
  for (const auto& row : similarity_pictures::kMsSsim) {
    const auto pair = similarity_pictures::make(row.kind, row.width, row.height);
    const auto test = padded(pair.test, row.width, row.height),
               reference = padded(pair.reference, row.width, row.height);
    EXPECT_NEAR(ms_ssim(test, reference, 128, nullptr).totals.ms_ssim(3), row.rgb, 1e-11) << row.kind;
  }
}

TEST(MsSsimTest, ScoreMapAndMaskAreAsDefined) {
  // Odd at every scale or nearly so: 183, 92, 46, 23, 12 by 179, 90, 45, 23, 12.
  const int width = 183, height = 179;
  const auto pair = similarity_pictures::make("blocks", width, height);
  const auto channel = [&](const std::vector<float>& rgb) {
    return [&, width](int x, int y, int) { return rgb[(static_cast<size_t>(y) * width + x) * 3 + 1]; };
  };
  const Padded<float> test(width, height, 1, channel(pair.test)),
      reference(width, height, 1, channel(pair.reference));
  std::vector<float> weights;
  Plane a(height, std::vector<double>(width)), b = a, w = a;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      a[y][x] = channel(pair.test)(x, y, 0);
      b[y][x] = channel(pair.reference)(x, y, 0);
      weights.push_back(x < 60 ? 0.f : static_cast<float>(x % 4) / 4);
      w[y][x] = weights.back();
    }
  const MsReference expected = ms_reference(a, b, w);
  for (const int rows : {256, 128, 64, 16}) {
    const MsResult got = ms_ssim(test, reference, rows, weights.data());
    EXPECT_NEAR(got.totals.ms_ssim(1), expected.score, 1e-12) << rows;
    double worst = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double d = std::abs(got.map[static_cast<size_t>(y) * width + x] - expected.map[y][x]);
        if (!(d <= worst)) worst = d;
      }
    EXPECT_LT(worst, 1e-7) << rows;
  }
}

TEST(MsSsimTest, EqualPicturesAreOne) {
  const auto pair = similarity_pictures::make("noise", 177, 176);
  const auto picture = padded(pair.test, 177, 176);
  const MsResult got = ms_ssim(picture, picture, 128, nullptr);
  EXPECT_EQ(got.totals.ms_ssim(3), 1.0);
  for (const float v : got.map) ASSERT_EQ(v, 1.f);
}
