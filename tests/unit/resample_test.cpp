// SPDX-License-Identifier: Apache-2.0
// The plugin resample against sums over every pixel, closed forms, and what must not change.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <triad/pipeline/stage_exercise.hpp>
#include <triad/sampling/reconstruction.hpp>

#include "stage_runner.hpp"

namespace {

using stage_runner::message_of;
using stage_runner::Picture;
using testing::HasSubstr;
using triad::ReconstructionFilter;

Picture picture(int width, int height, int channels, int cells_x = 1) {
  const triad::SyntheticPicture made = triad::synthetic_picture(width, height, channels, {cells_x, 1}, 5);
  return {made.image, made.pixels, {}};
}
Picture resampled(const Picture& in, const triad::ParamTexts& parameters, int rows = 3) {
  return stage_runner::run("resample", parameters, {&in}, rows).out;
}

int reflected(int i, int size) {
  while (i < 0 || i >= size) i = i < 0 ? -1 - i : 2 * size - 1 - i;
  return i;
}
int wrapped(int i, int size) { return (i % size + size) % size; }

// In two dimensions at once, over every place within the filter's reach.
double slow(const Picture& in, const ReconstructionFilter& fx, const ReconstructionFilter& fy, double cx, double cy,
            int channel, int (*edge)(int, int)) {
  double sum = 0, weights = 0;
  const int reach_x = static_cast<int>(fx.radius_px()) + 2, reach_y = static_cast<int>(fy.radius_px()) + 2;
  for (int y = static_cast<int>(cy) - reach_y; y <= cy + reach_y; ++y)
    for (int x = static_cast<int>(cx) - reach_x; x <= cx + reach_x; ++x) {
      const double w = fx.value(x + .5 - cx) * fy.value(y + .5 - cy);
      const auto at = (static_cast<size_t>(edge(y, in.image.height)) * in.image.width + edge(x, in.image.width)) *
                      in.image.channels;
      weights += w;
      sum += w * in.pixels[at + static_cast<size_t>(channel)];
    }
  return sum / weights;
}

}  // namespace

TEST(Resample, IsTheWeightedMeanUnderTheFilter) {
  struct Size {
    int from_x, from_y, to_x, to_y;
  };
  for (const auto& [from_x, from_y, to_x, to_y] :
       {Size{13, 9, 7, 5}, {7, 5, 17, 11}, {11, 3, 5, 8}, {1, 1, 4, 3}, {9, 8, 1, 1}})
    for (const int channels : {1, 3, 4})
      for (size_t i = 0; i < triad::reconstruction_names().size(); ++i)
        for (const auto& [edge, edge_name, scale] : {std::tuple{&reflected, "mirror", 1.}, {&wrapped, "wrap", 1.5}}) {
          const Picture in = picture(from_x, from_y, channels);
          const Picture out = resampled(in, {{"width", std::to_string(to_x)},
                                             {"height", std::to_string(to_y)},
                                             {"filter", triad::reconstruction_names()[i]},
                                             {"scale", std::to_string(scale)},
                                             {"edge", edge_name}});
          ASSERT_EQ(out.image.width, to_x);
          ASSERT_EQ(out.image.height, to_y);
          ASSERT_EQ(out.image.alpha, in.image.alpha);
          const auto kernel = static_cast<triad::ReconstructionKernel>(i);
          const double step_x = static_cast<double>(from_x) / to_x, step_y = static_cast<double>(from_y) / to_y;
          const ReconstructionFilter fx(kernel, scale * std::max(1., step_x)),
              fy(kernel, scale * std::max(1., step_y));
          for (int y = 0; y < to_y; ++y)
            for (int x = 0; x < to_x; ++x)
              for (int c = 0; c < channels; ++c)
                ASSERT_NEAR(out.pixels[static_cast<size_t>((y * to_x + x) * channels + c)],
                            slow(in, fx, fy, (x + .5) * step_x, (y + .5) * step_y, c, edge), 2e-6)
                    << fx.name() << " " << edge_name << " " << from_x << "x" << from_y << " to " << to_x << "x"
                    << to_y;
        }
}

TEST(Resample, ByOneChangesNothingUnderFiltersThatInterpolate) {
  const Picture in = picture(9, 5, 4);
  for (const char* filter : {"box", "tent", "lanczos2", "lanczos3"})
    EXPECT_EQ(resampled(in, {{"filter", filter}}).pixels, in.pixels) << filter;
}

TEST(Resample, KnownCases) {
  Picture line = picture(4, 1, 1);
  line.pixels = {0, 1, 4, 2};
  // Linear interpolation at quarters, and the border repeated.
  EXPECT_THAT(
      resampled(line, {{"factor", "2"}, {"filter", "tent"}, {"edge", "clamp"}}).pixels,
      testing::ElementsAre(0, .25f, .75f, 1.75f, 3.25f, 3.5f, 2.5f, 2, 0, .25f, .75f, 1.75f, 3.25f, 3.5f, 2.5f, 2));
  // Pixels repeated; blocks averaged.
  EXPECT_THAT(resampled(line, {{"width", "8"}, {"height", "1"}, {"filter", "box"}}).pixels,
              testing::ElementsAre(0, 0, 1, 1, 4, 4, 2, 2));
  EXPECT_THAT(resampled(line, {{"width", "2"}, {"height", "1"}, {"filter", "box"}}).pixels,
              testing::ElementsAre(.5f, 3));
  // A filter that misses all pixels takes the nearest.
  EXPECT_THAT(resampled(line, {{"width", "8"}, {"height", "1"}, {"filter", "box"}, {"scale", ".25"}}).pixels,
              testing::ElementsAre(0, 0, 1, 1, 4, 4, 2, 2));
}

TEST(Resample, KeepsConstantsAndTheMean) {
  Picture flat = picture(11, 7, 3);
  std::fill(flat.pixels.begin(), flat.pixels.end(), .3f);
  const Picture noise = picture(12, 10, 1);
  double before = 0;
  for (const float v : noise.pixels) before += static_cast<double>(v) / 120;
  for (const std::string& filter : triad::reconstruction_names()) {
    for (const char* factor : {".13", ".5", ".77", "1.9", "3"})
      for (const float v : resampled(flat, {{"factor", factor}, {"filter", filter}}).pixels)
        ASSERT_NEAR(v, .3f, 1e-7f) << filter << factor;
    // To half the size of a picture that repeats: even and odd pixels see the centres of the new ones as mirror
    // images of one another, so that all of them count alike.
    const Picture half = resampled(noise, {{"factor", ".5"}, {"filter", filter}, {"edge", "wrap"}});
    double after = 0;
    for (const float v : half.pixels) after += static_cast<double>(v) / 30;
    EXPECT_NEAR(after, before, 1e-6) << filter;
  }
}

TEST(Resample, SizesAndCells) {
  const auto size = [](const Picture& in, const triad::ParamTexts& parameters) {
    const triad_image out = resampled(in, parameters).image;
    return std::array<int, 4>{out.width, out.height, out.cells_x, out.cells_y};
  };
  using Sizes = std::array<int, 4>;
  const Picture plain = picture(12, 8, 3), wide = picture(12, 4, 3, 3);
  EXPECT_EQ(size(plain, {{"factor", ".5"}}), (Sizes{6, 4, 1, 1}));
  EXPECT_EQ(size(plain, {{"factor", ".01"}}), (Sizes{1, 1, 1, 1}));
  EXPECT_EQ(size(plain, {{"width", "24"}}), (Sizes{24, 16, 1, 1}));
  EXPECT_EQ(size(plain, {{"height", "2"}}), (Sizes{3, 2, 1, 1}));
  EXPECT_EQ(size(wide, {{"factor", ".5"}}), (Sizes{6, 2, 3, 1}));
  EXPECT_EQ(size(wide, {{"width", "24"}}), (Sizes{24, 8, 3, 1}));
  EXPECT_EQ(size(wide, {{"cells", "one"}}), (Sizes{4, 4, 1, 1}));
  EXPECT_EQ(size(wide, {{"cells", "one"}, {"width", "8"}}), (Sizes{8, 8, 1, 1}));
  EXPECT_DOUBLE_EQ(resampled(wide, {{"factor", ".5"}}).image.pixel_aspect, 1. / 3);
  EXPECT_DOUBLE_EQ(resampled(wide, {{"cells", "one"}}).image.pixel_aspect, 1);
  EXPECT_DOUBLE_EQ(resampled(plain, {{"width", "12"}, {"height", "2"}}).image.pixel_aspect, .25);
  EXPECT_THAT(message_of([&] {
                resampled(wide, {{"width", "8"}});
              }),
              HasSubstr("width=8 cuts through a display pixel"));
  EXPECT_THAT(message_of([&] {
                resampled(plain, {{"width", "8"}, {"factor", "2"}});
              }),
              HasSubstr("factor and width both say the size"));
  EXPECT_THAT(message_of([&] { resampled(plain, {{"factor", "1e9"}}); }), HasSubstr("above 2^31 - 1"));
  EXPECT_THAT(message_of([&] { resampled(plain, {{"filter", "lanczos"}}); }), HasSubstr("lanczos2"));
}

TEST(Resample, ForgetsWhereOnItsPanelAResizedPictureBegan) {
  Picture in = picture(6, 4, 3);
  in.metadata.set("triad:origin", "1,0");
  in.metadata.set("triad:layout", "rgb");
  EXPECT_EQ(resampled(in, {}).metadata.get("triad:origin"), "1,0");
  const Picture half = resampled(in, {{"factor", ".5"}});
  EXPECT_FALSE(half.metadata.get("triad:origin"));
  EXPECT_EQ(half.metadata.get("triad:layout"), "rgb");
}

TEST(Resample, NamesTheFiltersAsTheLibraryDoes) {
  const triad_desc& desc = *stage_runner::host().find("resample").desc;
  std::vector<std::string> names;
  for (uint32_t i = 0; i < desc.n_params; ++i)
    if (std::string(desc.params[i]->name) == "filter")
      for (const char* const* choice = desc.params[i]->choices; *choice; ++choice) names.emplace_back(*choice);
  EXPECT_EQ(names, triad::reconstruction_names());
}

TEST(Resample, LetsTheHostReplaceWhatIsNotANumber) {
  triad::StageInstance stage(stage_runner::host().find("resample"), {{"factor", "2"}});
  const Picture in = picture(16, 1, 1);
  EXPECT_EQ(stage.plan({&in.image}, {nullptr}).plan.nonfinite, TRIAD_NONFINITE_ZERO);
}
