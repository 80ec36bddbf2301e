// SPDX-License-Identifier: Apache-2.0
// Pictures of strokes: where the bars lie, the same on every grid of cells, and what the bundled ones look like.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <triad/base/error.hpp>
#include <triad/sampling/strategy.hpp>
#include <triad/sampling/strokes.hpp>

using namespace triad;

namespace {

constexpr Rgb kBlack{0, 0, 0}, kWhite{1, 1, 1};

Rgb value_at(const Source& source, double x, double y) {
  const SampleRequest request{x, y};
  Sample sample;
  source.eval({&request, 1}, {&sample, 1});
  return sample.rgb;
}

Image render(const Source& source, const std::string& strategy) {
  return make_strategy(strategy, "test")->render(source, {}).film.image();
}

// A whole picture's mean of each channel.
std::array<double, 3> mean_of(const Image& image) {
  std::array<double, 3> sum{};
  const size_t pixels = image.pixels.size() / 3;
  for (size_t i = 0; i < image.pixels.size(); ++i) sum[i % 3] += static_cast<double>(image.pixels[i]);
  for (double& s : sum) s /= static_cast<double>(pixels);
  return sum;
}

}  // namespace

TEST(Strokes, CoverTheirBarAndNoMore) {
  // From (10, 10), 20 pixels along (.6, .8), 2 wide, over three buckets; distances from the axis along (.8, -.6).
  const StrokesSource source(64, 48, {}, kBlack, {{10, 10, 22, 26, 2, kWhite}});
  const auto at = [&](double along, double across) {
    return value_at(source, 10 + .6 * along + .8 * across, 10 + .8 * along - .6 * across)[0];
  };
  for (const double along : {.01, 5., 12.5, 19.99})
    for (const double across : {-.99, -.3, 0., .99}) EXPECT_EQ(at(along, across), 1) << along << " " << across;
  for (const double along : {.01, 10., 19.99})
    for (const double across : {-1.01, 1.01, 5.}) EXPECT_EQ(at(along, across), 0) << along << " " << across;
  for (const double along : {-.01, 20.01}) EXPECT_EQ(at(along, 0), 0) << along;
}

TEST(Strokes, HaveTheirAreaAndLieOverEarlierOnes) {
  // 20 x 2 pixels of white inside, a red bar of 2 x 2 over it: 40 px2 and 4 px2 of 64 x 48.
  const StrokesSource source(64, 48, {}, kBlack, {{10, 10, 22, 26, 2, kWhite}, {16, 17, 16, 19, 2, {1, 0, 0}}});
  const auto mean = mean_of(render(source, "grid:n=16"));
  EXPECT_EQ(value_at(source, 16, 18), (Rgb{1, 0, 0}));
  // The red square about the bar's middle has 4 px2, of which the bar leaves out two corners. It stretches from -1.4
  // to 1.4 across the bar; each corner beyond 1 is a triangle of height .4 with the angle's 3:4:5 sides: .4^2 / 2 *
  // (.75 + 1 / .75) = .1667 px2.
  const double corners = 2 * .08 * (.75 + 1 / .75), pixels = 64 * 48;
  EXPECT_NEAR(mean[0] * pixels, 40 + corners, .08);
  EXPECT_NEAR(mean[1] * pixels, 36 + corners, .08);
}

TEST(Strokes, LieWhereTheyLieWhateverTheCells) {
  const auto plain = make_strokes("colours", 40, 30, {}), wide = make_strokes("colours", 40, 30, {3, 2});
  EXPECT_EQ(wide->width(), 120);
  EXPECT_EQ(wide->height(), 60);
  for (int i = 0; i < 500; ++i) {
    const double x = 40 * std::fmod(i * .618, 1), y = 30 * std::fmod(i * .755, 1);
    EXPECT_EQ(value_at(*plain, x, y), value_at(*wide, 3 * x, 2 * y));
  }
}

TEST(Strokes, FillTheBundledPictures) {
  for (const std::string& name : stroke_picture_names()) {
    const auto source = make_strokes(name, 160, 96, {});
    const Image picture = render(*source, "grid:n=4");
    EXPECT_EQ(render(*make_strokes(name, 160, 96, {}), "grid:n=4").pixels, picture.pixels) << name;
    EXPECT_NE(render(*make_strokes(name, 160, 96, {}, 1), "grid:n=4").pixels, picture.pixels) << name;
    const auto mean = mean_of(picture);
    if (name == "strokes") {
      // 55 strokes of 35 x 1.25 px on average on 160 x 96 cover 1 - exp(-.157) = .145 if they fell independently;
      // their widths and lengths spread by a third each.
      EXPECT_NEAR(mean[0], .145, .04);
      EXPECT_EQ(mean[0], mean[2]);
    } else if (name == "colours") {
      for (const double m : mean) EXPECT_NEAR(m, .0725, .03);
      EXPECT_NE(mean[0], mean[2]);
    } else {
      EXPECT_GT(mean[0], .6);
      EXPECT_LT(mean[0], .85);
      EXPECT_EQ(mean[0], mean[2]);
    }
  }
  EXPECT_THROW(make_strokes("stroke", 8, 8, {}), Error);
}
