// SPDX-License-Identifier: Apache-2.0
// noise-spectrum against the definition written out, z-test against tables of the normal distribution.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <triad/evaluation/noise_spectrum.hpp>

#include "stage_runner.hpp"

using namespace stage_runner;
using testing::HasSubstr;
using triad::NoiseResult;
using triad::NoiseRows;
using triad::NoiseSpectrum;
using triad::NoiseSums;

namespace {

struct Difference {
  int width, height;
  std::vector<double> values, weights;  // weights may be empty
  double at(int x, int y) const { return values[static_cast<size_t>(y) * width + x] * (weight(x, y) > 0); }
  double weight(int x, int y) const { return weights.empty() ? 1 : weights[static_cast<size_t>(y) * width + x]; }
};

Difference difference(int width, int height, unsigned seed, bool masked) {
  Difference d{width, height, {}, {}};
  const auto random = triad::reference::random_cells(2 * width * height, seed);  // three each
  for (size_t i = 0; i < static_cast<size_t>(width) * height; ++i) {
    d.values.push_back(3 + static_cast<double>(random[i]) - static_cast<double>(random[i + 7]));
    if (masked) d.weights.push_back(i % 5 == 0 ? 0 : std::abs(static_cast<double>(random[i + 3])));
  }
  if (masked)
    for (size_t i = 0; i < d.values.size(); ++i)
      if (d.weights[i] == 0) d.values[i] = 0;
  return d;
}

// The power of each bin of one cycle per tile, by the sums of the definition: the mean subtracted first, a discrete
// Fourier transform of every tile term by term.
struct Expected {
  std::map<long, double> power, frequency;
  double low_share, lag_x, lag_y, variance;
};
Expected expected(const Difference& d, int tile, double cut, const std::vector<int>& begin_x,
                  const std::vector<int>& begin_y) {
  const int tx = std::min(tile, d.width), ty = std::min(tile, d.height);
  double weight = 0, mean = 0, variance = 0;
  for (int y = 0; y < d.height; ++y)
    for (int x = 0; x < d.width; ++x) {
      weight += d.weight(x, y);
      mean += d.weight(x, y) * d.at(x, y);
    }
  mean /= weight;
  double pairs[2] = {}, products[2] = {};
  for (int y = 0; y < d.height; ++y)
    for (int x = 0; x < d.width; ++x) {
      const double own = d.at(x, y) - mean;
      variance += d.weight(x, y) * own * own / weight;
      for (int k = 0; k < 2; ++k) {
        const int nx = x + (k == 0), ny = y + (k == 1);
        if (nx == d.width || ny == d.height) continue;
        const double both = d.weight(x, y) * d.weight(nx, ny);
        pairs[k] += both;
        products[k] += both * own * (d.at(nx, ny) - mean);
      }
    }
  Expected e;
  e.variance = variance;
  e.lag_x = pairs[0] > 0 ? products[0] / pairs[0] / variance : 0;
  e.lag_y = pairs[1] > 0 ? products[1] / pairs[1] / variance : 0;
  std::map<long, double> count;
  double energy = 0, low = 0, total = 0;
  const auto hann = [](int j, int n) { return std::pow(std::sin(std::numbers::pi * (j + .5) / n), 2); };
  for (const int y0 : begin_y)
    for (const int x0 : begin_x)
      for (int ky = 0; ky < ty; ++ky)
        for (int kx = 0; kx < tx; ++kx) {
          std::complex<double> sum;
          double squares = 0;
          for (int j = 0; j < ty; ++j)
            for (int i = 0; i < tx; ++i) {
              const double w = hann(i, tx) * hann(j, ty) * d.weight(x0 + i, y0 + j);
              squares += w * w;
              sum += w * (d.at(x0 + i, y0 + j) - mean) *
                     std::polar(1., -2 * std::numbers::pi * (double(kx) * i / tx + double(ky) * j / ty));
            }
          const double f = std::hypot(double(std::min(kx, tx - kx)) / tx, double(std::min(ky, ty - ky)) / ty);
          const long bin = std::lround(f * std::max(tx, ty));
          e.power[bin] += std::norm(sum);
          total += std::norm(sum);
          if (f < cut) low += std::norm(sum);
          if (y0 == begin_y[0] && x0 == begin_x[0]) {
            count[bin] += 1;
            e.frequency[bin] += f;
          }
          if (kx == 0 && ky == 0) energy += squares;
        }
  for (auto& [bin, power] : e.power) {
    power /= energy * count[bin];
    e.frequency[bin] /= count[bin];
  }
  e.low_share = low / total;
  return e;
}

NoiseResult measured(const Difference& d, int tile, double cut, int rows) {
  const NoiseSpectrum spectrum(d.width, d.height, tile, 1, cut);
  NoiseSums total{};
  for (int y = 0; y < d.height; y += rows) {
    NoiseSums own{};
    const int end = std::min(y + rows, d.height);
    NoiseRows strip{y, spectrum.last_row(y, end), {d.values.data() + static_cast<size_t>(y) * d.width}, nullptr};
    if (!d.weights.empty()) strip.weight = d.weights.data() + static_cast<size_t>(y) * d.width;
    spectrum.add(strip, y, end, own);
    NoiseSpectrum::merge(total, own);
  }
  return spectrum.finish(total);
}

TEST(NoiseSpectrumSums, AreThoseOfTheDefinition) {
  struct Case {
    int width, height, tile;
    std::vector<int> begin_x, begin_y;
  };
  // Tiles at most half a tile apart from the first pixel to the last.
  for (const Case& c : {Case{16, 8, 8, {0, 4, 8}, {0}},
                        {13, 9, 8, {0, 3, 5}, {0, 1}},
                        {7, 5, 8, {0}, {0}},
                        {1, 6, 8, {0}, {0}},
                        {2, 3, 8, {0}, {0}},
                        {11, 1, 9, {0, 2}, {0}}})
    for (const bool masked : {false, true}) {
      const Difference d = difference(c.width, c.height, 5, masked);
      const Expected e = expected(d, c.tile, .2, c.begin_x, c.begin_y);
      for (const int rows : {1, 3, 100}) {
        SCOPED_TRACE(testing::Message() << c.width << "x" << c.height << " masked " << masked << " rows " << rows);
        const NoiseResult got = measured(d, c.tile, .2, rows);
        EXPECT_NEAR(got.variance, e.variance, 1e-10);
        EXPECT_NEAR(got.lag_x, e.lag_x, 1e-9);
        EXPECT_NEAR(got.lag_y, e.lag_y, 1e-9);
        EXPECT_NEAR(got.low_share, e.low_share, 1e-9);
        ASSERT_EQ(got.power.size(), e.power.size());
        size_t i = 0;
        for (const auto& [bin, power] : e.power) {
          EXPECT_NEAR(got.power[i], power, 1e-9) << bin;
          EXPECT_NEAR(got.frequency[i], e.frequency.at(bin), 1e-12) << bin;
          ++i;
        }
      }
    }
}

TEST(NoiseSpectrumSums, KeepParsevalsTheorem) {
  // A picture of one tile: the mean over all coefficients of power is the mean square under the window's square.
  const Difference d = difference(24, 24, 9, false);
  const NoiseResult got = measured(d, 24, .125, 24);
  double mean = 0, squares = 0, energy = 0, power = 0, count = 0;
  for (const double v : d.values) mean += v / static_cast<double>(d.values.size());
  const auto hann = [](int j) { return std::pow(std::sin(std::numbers::pi * (j + .5) / 24), 2); };
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 24; ++x) {
      const double w = std::pow(hann(x) * hann(y), 2);
      squares += w * std::pow(d.at(x, y) - mean, 2);
      energy += w;
    }
  std::map<long, double> in_bin;
  for (int ky = 0; ky < 24; ++ky)
    for (int kx = 0; kx < 24; ++kx)
      in_bin[std::lround(std::hypot(std::min(kx, 24 - kx), std::min(ky, 24 - ky)))] += 1;
  size_t i = 0;
  for (const auto& [bin, n] : in_bin) {
    power += n * got.power.at(i++);
    count += n;
  }
  EXPECT_NEAR(power / count, squares / energy, 1e-12);
}

TEST(NoiseSpectrumSums, FindAWaveWhereItIs) {
  Difference d{64, 64, {}, {}};
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) d.values.push_back(10 + std::cos(2 * std::numbers::pi * (12 * x) / 64.));
  const NoiseResult got = measured(d, 64, .125, 7);
  const size_t top = static_cast<size_t>(std::max_element(got.power.begin(), got.power.end()) - got.power.begin());
  EXPECT_NEAR(got.frequency[top], 12 / 64., .5 / 64);
  EXPECT_NEAR(got.lag_y, 1, 1e-9);
  EXPECT_NEAR(got.lag_x, std::cos(2 * std::numbers::pi * 12 / 64.), .02);
  EXPECT_NEAR(got.low_share, 0, 1e-9);
}

TEST(NoiseSpectrumSums, OfAConstantAreNone) {
  const NoiseResult got = measured({9, 9, std::vector<double>(81, .1), {}}, 8, .125, 2);
  EXPECT_EQ(got.lag_x, 0);
  EXPECT_EQ(got.low_share, 0);
  for (const double p : got.power) EXPECT_EQ(p, 0);
}

TEST(NoiseSpectrumMetric, HasStripsThatFitThoseOfOtherMetrics) {
  const triad_image image = header(600, 4000, 1);
  for (const int tile : {8, 100, 127, 128, 129, 253, 254, 256, 257, 300, 511, 512}) {
    triad::StageInstance stage(host().find("noise-spectrum"), {{"tile", std::to_string(tile)}});
    const int rows = stage.plan({&image, &image, nullptr}, {nullptr, nullptr, nullptr}).plan.strip_rows;
    // Together, and with the 64 and 128 of others, at most 256 rows.
    EXPECT_TRUE(rows == 64 || rows == 128 || rows == 256) << tile << ": " << rows;
    EXPECT_GE(2 * rows, tile - 1) << tile;
    // The tiles of a strip reach beyond it.
    const triad_rect need = stage.need(0, {0, 2 * rows, 600, 3 * rows})[0];
    EXPECT_EQ(need.y0, 2 * rows);
    EXPECT_GE(need.y1, 3 * rows + 1);
    EXPECT_LE(need.y1, 3 * rows - 1 + tile + (tile == 8 ? 1 : 0));
  }
}

TEST(NoiseSpectrumSums, AreTheSameWhateverTheStrips) {
  const Difference d = difference(40, 301, 3, true);
  const NoiseResult whole = measured(d, 50, .125, 301);
  for (const int rows : {25, 64, 128}) {
    const NoiseResult got = measured(d, 50, .125, rows);
    ASSERT_EQ(got.power.size(), whole.power.size());
    for (size_t i = 0; i < got.power.size(); ++i) EXPECT_NEAR(got.power[i] / whole.power[i], 1, 1e-11);
    EXPECT_NEAR(got.low_share, whole.low_share, 1e-12);
    EXPECT_NEAR(got.lag_y, whole.lag_y, 1e-12);
  }
}

TEST(NoiseSpectrumMetric, IsOfTheLuminanceOrOfAllChannels) {
  Picture reference = noise(40, 24, 1, 3), test = reference;
  const Picture other = noise(40, 24, 1, 4);
  for (size_t i = 1; i < test.pixels.size(); i += 3) test.pixels[i] += other.pixels[i];  // green only
  double mean = 0, variance = 0;
  const double n = 40 * 24;
  for (size_t i = 1; i < test.pixels.size(); i += 3)
    mean += (double(test.pixels[i]) - double(reference.pixels[i])) / n;
  for (size_t i = 1; i < test.pixels.size(); i += 3)
    variance += std::pow(double(test.pixels[i]) - double(reference.pixels[i]) - mean, 2) / n;
  const Outcome luminance = run("noise-spectrum", {{"tile", "16"}}, {&test, &reference, nullptr}, 8),
                channels = run("noise-spectrum", {{"tile", "16"}, {"of", "channels"}, {"ppd", "40"}},
                               {&test, &reference, nullptr}, 8);
  EXPECT_NEAR(luminance.reports.at("variance"), .7152 * .7152 * variance, 1e-12);
  EXPECT_NEAR(channels.reports.at("variance"), variance / 3, 1e-12);
  EXPECT_NEAR(luminance.scores[0], channels.scores[0], 1e-9);
  EXPECT_NEAR(luminance.scores[2], channels.scores[2], 1e-9);
  const auto &a = luminance.all_reports.series.at("spectrum"), &b = channels.all_reports.series.at("spectrum");
  ASSERT_EQ(a.x.size(), b.x.size());
  EXPECT_NEAR(b.x.back(), 40 * a.x.back(), 1e-9);
  EXPECT_NEAR(a.x.back(), std::sqrt(.5), 1 / 16.);
}

// A render that is `z` standard errors off everywhere, of variance of one sample `sample_variance` with n samples.
struct Render {
  Picture test, reference, variance;
};
Render off_by(double z, int width, int height, double sample_variance, double n, bool of_mean = true) {
  Render r{
      {header(width, height, 1), {}, {}}, {header(width, height, 1), {}, {}}, {header(width, height, 1), {}, {}}};
  for (int i = 0; i < width * height * 3; ++i) {
    r.reference.pixels.push_back(0);
    r.test.pixels.push_back(static_cast<float>((i % 2 == 0 ? z : -z) * std::sqrt(sample_variance / n)));
    r.variance.pixels.push_back(static_cast<float>(of_mean ? sample_variance / n : sample_variance));
  }
  r.test.metadata.set("triad:samples", std::to_string(static_cast<int64_t>(n) * width * height));
  return r;
}
Outcome z_test(const Render& r, const triad::ParamTexts& parameters = {}, const Picture* mask = nullptr) {
  return run("z-test", parameters, {&r.test, &r.reference, &r.variance, mask});
}

TEST(ZTestMetric, HasTheTablesOfTheNormalDistribution) {
  // z, and both tails beyond it.
  for (const auto& [z, p] :
       {std::pair{.674490, .5}, {1.644854, .1}, {1.959964, .05}, {2.575829, .01}, {3.290527, .001}})
    for (const bool of_mean : {true, false}) {
      const Outcome got = z_test(off_by(z, 5, 3, .04, 16, of_mean), {{"variance", of_mean ? "mean" : "sample"}});
      EXPECT_NEAR(got.scores[2], p, 1e-5) << z;
      EXPECT_NEAR(got.reports.at("z-rms"), z, 1e-5);
      EXPECT_NEAR(got.reports.at("max-z"), z, 1e-5);
      EXPECT_NEAR(got.out.pixels[7], z, 1e-5);
    }
}

TEST(ZTestMetric, CorrectsItsLevelForTheNumberOfTests) {
  const Outcome got = z_test(off_by(2, 5, 3, .04, 16), {{"significance", ".05"}});
  EXPECT_EQ(got.reports.at("tests"), 45);
  EXPECT_NEAR(got.reports.at("level"), 1 - std::pow(.95, 1 / 45.), 1e-12);
  EXPECT_EQ(got.scores[0], 1);
  EXPECT_EQ(got.scores[1], 1);
  // The level of 45 tests is p = .00113919, z = 3.2546.
  EXPECT_EQ(z_test(off_by(3.2, 5, 3, .04, 16), {{"significance", ".05"}}).scores[0], 1);
  EXPECT_EQ(z_test(off_by(3.3, 5, 3, .04, 16), {{"significance", ".05"}}).scores[0], 0);
  EXPECT_EQ(z_test(off_by(3.3, 5, 3, .04, 16), {{"significance", ".05"}}).scores[1], 0);
}

TEST(ZTestMetric, CountsOnlyWhatTheMaskLetsThrough) {
  Render r = off_by(1, 6, 4, .04, 16);
  Picture mask{header(6, 4, 1), std::vector<float>(24, 0), {}};
  mask.image.channels = 1;
  mask.pixels[8] = 1;
  mask.pixels[9] = .5f;
  r.test.pixels[0] = 100;         // left out
  r.test.pixels[9 * 3 + 1] = 10;  // one channel of three, in a pixel of half the weight
  const Outcome got = z_test(r, {}, &mask);
  EXPECT_EQ(got.reports.at("tests"), 6);
  EXPECT_NEAR(got.reports.at("level"), 1 - std::pow(.99, 1 / 6.), 1e-12);
  EXPECT_NEAR(got.scores[0], 1 - .5 / 4.5, 1e-12);
  EXPECT_EQ(got.reports.at("max-x"), 3);
  EXPECT_EQ(got.reports.at("max-y"), 1);
  EXPECT_EQ(got.reports.at("max-channel"), 1);
}

TEST(ZTestMetric, HasAFloorUnderTheVarianceOfASample) {
  // s^2 = 1e-6, 16 samples: counted as 1e-4, z = d sqrt(16 / 1e-4).
  Render r = off_by(1, 2, 2, 1e-6, 16);
  const double d = std::sqrt(1e-6 / 16);
  EXPECT_NEAR(z_test(r).reports.at("max-z"), d * std::sqrt(16 / 1e-4), 1e-6);
  EXPECT_EQ(z_test(r).reports.at("at-floor"), 1);
  EXPECT_NEAR(z_test(r, {{"floor", "1e-9"}}).reports.at("max-z"), 1, 1e-5);
}

TEST(ZTestMetric, RefusesSamplesThatCannotBe) {
  const auto message = [](const std::string& samples, const triad::ParamTexts& parameters) {
    Render r = off_by(1, 4, 4, .04, 16);
    r.test.metadata = {};
    if (!samples.empty()) r.test.metadata.set("triad:samples", samples);
    return message_of([&] { z_test(r, parameters); });
  };
  EXPECT_THAT(message("", {{"variance", "mean"}}), HasSubstr("say spp=N"));
  EXPECT_THAT(message("", {{"spp", "16"}}), HasSubstr("say variance=mean or variance=sample"));
  EXPECT_EQ(message("", {{"spp", "16"}, {"variance", "sample"}}), "nothing was thrown");
  for (const std::string bad : {"many", "-16", "0", "1e999", "16 per pixel"})
    EXPECT_THAT(message(bad, {}), testing::AllOf(HasSubstr("triad:samples"), HasSubstr("'" + bad + "'")));
  EXPECT_EQ(message("many", {{"spp", "16"}}), "nothing was thrown");
  EXPECT_THAT(message("16", {}), HasSubstr("has 1 samples per pixel by its triad:samples"));
  EXPECT_THAT(message("256", {{"spp", "1.5"}}), HasSubstr("has 1.5 samples per pixel"));
  EXPECT_EQ(message("256", {}), "nothing was thrown");
}

TEST(ZTestMetric, RefusesVariancesThatAreNone) {
  Render r = off_by(1, 4, 4, .04, 16);
  r.variance.pixels[5] = -.01f;
  EXPECT_THAT(message_of([&] { z_test(r); }), HasSubstr("1 values of the variance are below 0"));
  r.variance.pixels[5] = NAN;
  EXPECT_THAT(message_of([&] { z_test(r); }), HasSubstr("not a number"));
  r = off_by(1, 4, 4, .04, 16);
  r.reference.image.rgb_to_xyz[0] = .6;
  EXPECT_THAT(message_of([&] { z_test(r); }), HasSubstr("primaries"));
}

}  // namespace
