// SPDX-License-Identifier: Apache-2.0
// Pictures as sources: which pixel a sample is, exact means, colours, geometry, and pictures that are no good.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/base/random.hpp>
#include <triad/image/writer.hpp>
#include <triad/sampling/exact.hpp>
#include <triad/sampling/image_source.hpp>
#include <triad/sampling/render.hpp>
#include <triad/sampling/strategy.hpp>

#include "picture_files.hpp"

using namespace triad;
using picture_files::Folder;

namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Random values in [0, 1).
Image noise(int width, int height, std::vector<std::string> channels = {"R", "G", "B"}) {
  Image image;
  image.spec.width = width;
  image.spec.height = height;
  image.spec.channels = std::move(channels);
  image.spec.colour_channels = image.spec.channels.size() < 3 ? 1 : 3;
  image.spec.colour_space = "lin_rec709";
  for (int i = 0; i < width * height * image.spec.channel_count(); ++i)
    image.pixels.push_back(SampleRandom(i, 0, 0, 7).uniform(SampleRandom::kFirstSourceDimension));
  return image;
}

class ImageSourceTest : public testing::Test {
 protected:
  std::string save(const Image& image, const std::string& name = "a.exr") {
    WriteOptions options;
    if (name.ends_with(".exr")) options.depth = Depth::kFloat;
    write_image(folder_ / name, image, options);
    return folder_ / name;
  }
  std::unique_ptr<Source> open(const std::string& path, int width, int height, const Cells& cells = {},
                               const ImageSourceOptions& options = {}) {
    return make_image_source(path, width, height, cells, colours_, options);
  }
  std::string error_of(const std::string& path, int width, int height, const Cells& cells = {},
                       const ImageSourceOptions& options = {}) {
    try {
      open(path, width, height, cells, options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  static Sample sample(const Source& source, double x, double y) {
    SampleRequest request;
    request.x = x;
    request.y = y;
    Sample s;
    source.eval({&request, 1}, {&s, 1});
    return s;
  }

  Folder folder_;
  ColourConfig colours_ = ColourConfig::load();
};

// The length that [a0, a1] and [b0, b1] share.
double shared(double a0, double a1, double b0, double b1) {
  return std::max(0., std::min(a1, b1) - std::max(a0, b0));
}

// The mean over a box in pixels of the picture, from all of its pixels.
double slow_mean(const Image& image, double x0, double y0, double x1, double y1, size_t channel) {
  double sum = 0;
  for (int y = 0; y < image.spec.height; ++y)
    for (int x = 0; x < image.spec.width; ++x)
      sum += shared(x, x + 1, x0, x1) * shared(y, y + 1, y0, y1) *
             static_cast<double>(image.row(y)[static_cast<size_t>(x) * image.spec.channels.size() + channel]);
  return sum / ((x1 - x0) * (y1 - y0));
}

}  // namespace

TEST_F(ImageSourceTest, IsThePictureAtItsOwnSize) {
  const Image image = noise(37, 23);
  const auto source = open(save(image), 37, 23);
  EXPECT_FALSE(source->abilities().geometry);
  EXPECT_EQ(make_strategy("control", "test")->render(*source, {}).film.image().pixels, image.pixels);
  const auto exact = exact_picture(*source);
  for (size_t p = 0; p < exact.size(); ++p)
    for (size_t c = 0; c < 3; ++c) EXPECT_EQ(exact[p][c], static_cast<double>(image.pixels[3 * p + c]));
}

TEST_F(ImageSourceTest, ScalesToSmallerFilms) {
  const Image image = noise(37, 23);
  const std::string path = save(image);
  for (const auto& [width, height, cells] :
       {std::tuple{13, 8, Cells{1, 1}}, {12, 8, Cells{3, 2}}, {1, 1, Cells{1, 1}}}) {
    const auto source = open(path, width, height, cells);
    const int w = width * cells.x, h = height * cells.y;
    ASSERT_EQ(source->width(), w);
    ASSERT_EQ(source->height(), h);
    const double sx = 37. / w, sy = 23. / h;
    const auto exact = exact_picture(*source);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        for (size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(exact[static_cast<size_t>(y * w + x)][c],
                      slow_mean(image, x * sx, y * sy, (x + 1) * sx, (y + 1) * sy, c), 1e-13);
    for (int i = 0; i < 200; ++i) {
      const double x = w * std::fmod(i * .618, 1), y = h * std::fmod(i * .755, 1);
      const size_t pixel = static_cast<size_t>(std::floor(y * sy)) * 37 + static_cast<size_t>(std::floor(x * sx));
      EXPECT_EQ(sample(*source, x, y).rgb[1], image.pixels[3 * pixel + 1]);
    }
    // A twentieth of a pixel, and boxes of all places.
    EXPECT_NEAR(source->integral(.31 * w, .4 * h, .36 * w, .41 * h).value()[2],
                slow_mean(image, .31 * 37, .4 * 23, .36 * 37, .41 * 23, 2), 1e-12);
    EXPECT_NEAR(source->integral(.01 * w, .02 * h, .97 * w, .93 * h).value()[0],
                slow_mean(image, .01 * 37, .02 * 23, .97 * 37, .93 * 23, 0), 1e-13);
    // Beyond its edges the picture goes on.
    EXPECT_EQ(sample(*source, -5, h + 7.).rgb[0], image.pixels[3 * (22 * 37)]);
    EXPECT_NEAR(source->integral(-9, -9, -3, -2).value()[0], static_cast<double>(image.pixels[0]), 1e-15);
  }
}

TEST_F(ImageSourceTest, IsInLinearLight) {
  // 8-bit sRGB, by IEC 61966-2-1; the configuration's curve is within 1e-5 of it where it is steepest.
  Image png = noise(4, 1);
  for (size_t i = 0; i < png.pixels.size(); ++i) png.pixels[i] = static_cast<float>(20 * i) / 255;
  png.spec.colour_space = "srgb";
  const auto source = open(save(png, "a.png"), 4, 1);
  for (int x = 0; x < 4; ++x)
    for (size_t c = 0; c < 3; ++c) {
      const double v = 20. * static_cast<double>(3 * static_cast<size_t>(x) + c) / 255;
      const double linear = v <= .04045 ? v / 12.92 : std::pow((v + .055) / 1.055, 2.4);
      EXPECT_NEAR(static_cast<double>(sample(*source, x + .5, .5).rgb[c]), linear, 2e-5);
    }
  // Told that it holds BT.2020: rows of the matrix of ITU-R BT.2087 in the other direction.
  const Image wide = noise(3, 2);
  const auto told = open(save(wide), 3, 2, {}, {.colour_space = "lin_rec2020"});
  for (size_t p = 0; p < 6; ++p) {
    const float* rgb = &wide.pixels[3 * p];
    const double red = 1.6605 * static_cast<double>(rgb[0]) - .5876 * static_cast<double>(rgb[1]) -
                       .0728 * static_cast<double>(rgb[2]);
    EXPECT_NEAR(static_cast<double>(sample(*told, static_cast<double>(p % 3) + .5, p < 3 ? .5 : 1.5).rgb[0]), red,
                2e-4);
  }
  EXPECT_THAT(error_of(folder_ / "a.exr", 3, 2, {}, {.colour_space = "rec2021"}), testing::HasSubstr("--from"));
}

TEST_F(ImageSourceTest, GreyAndAlphaAreLight) {
  const Image grey = noise(3, 2, {"Y"});
  const auto source = open(save(grey), 3, 2);
  EXPECT_EQ(sample(*source, 1.5, .5).rgb, (std::array{grey.pixels[1], grey.pixels[1], grey.pixels[1]}));
  Image alpha = noise(3, 2, {"R", "G", "B", "A"});
  alpha.spec.alpha = 3;
  const auto covered = open(save(alpha, "b.exr"), 3, 2);
  for (size_t c = 0; c < 3; ++c) EXPECT_EQ(sample(*covered, 2.5, 1.5).rgb[c], alpha.pixels[4 * 5 + c]);
}

TEST_F(ImageSourceTest, LeavesOutWhatIsNotFinite) {
  Image image = noise(4, 2);
  image.pixels[3 * 1 + 1] = kNan;
  image.pixels[3 * 4 + 2] = kInfinite;
  image.pixels[3 * 5 + 0] = kNan;
  const std::string path = save(image);
  const auto source = open(path, 4, 2);
  EXPECT_TRUE(sample(*source, .5, .5).valid);
  EXPECT_FALSE(sample(*source, 1.5, .5).valid);
  EXPECT_FALSE(sample(*source, .5, 1.5).valid);
  const auto mean = source->integral(0, 0, 2, 2).value();
  for (size_t c = 0; c < 3; ++c) EXPECT_EQ(mean[c], static_cast<double>(image.pixels[c]));
  EXPECT_EQ(source->integral(0, 1, 2, 2).value(), (std::array<double, 3>{0, 0, 0}));
  const RenderResult result = make_strategy("grid:n=2", "test")->render(*open(path, 2, 1), {});
  EXPECT_EQ(result.dropped, 3u);
  EXPECT_EQ(result.film.count(0), 1u);
  EXPECT_EQ(result.film.mean(0)[0], static_cast<double>(image.pixels[0]));
}

TEST_F(ImageSourceTest, HasTheGeometryOfOurRenders) {
  Image image =
      noise(2, 1, {"R", "G", "B", "Z", "P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "object_id", "material_id"});
  const std::vector<float> first{.1f, .2f, .3f, 4.5f, 1, 2, 3, 0, .6f, .8f, 7, 8};
  const std::vector<float> miss{0, 0, 0, kInfinite, 0, 0, 0, 0, 0, 0, 0, 0};
  image.pixels = first;
  image.pixels.insert(image.pixels.end(), miss.begin(), miss.end());
  const std::string path = save(image);
  const auto source = open(path, 2, 1);
  EXPECT_TRUE(source->abilities().geometry);
  const Sample hit = sample(*source, .5, .5), sky = sample(*source, 1.5, .5);
  EXPECT_EQ(hit.rgb, (std::array{.1f, .2f, .3f}));
  EXPECT_EQ(hit.distance, 4.5f);
  EXPECT_EQ(hit.position, (std::array{1.f, 2.f, 3.f}));
  EXPECT_EQ(hit.normal, (std::array{0.f, .6f, .8f}));
  EXPECT_EQ(hit.object_id, 7u);
  EXPECT_EQ(hit.material_id, 8u);
  EXPECT_EQ(sky.distance, kInfinite);
  EXPECT_EQ(sky.object_id, 0u);
  EXPECT_FALSE(open(path, 2, 1, {}, {.geometry = false, .colour_space = ""})->abilities().geometry);
}

TEST_F(ImageSourceTest, HasTheGeometryOfOtherRenderers) {
  // Blender: layers only, and 1e10 for the sky.
  Image blender = noise(2, 1,
                        {"ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B", "ViewLayer.Depth.Z",
                         "ViewLayer.IndexOB.X", "ViewLayer.Normal.X", "ViewLayer.Normal.Y", "ViewLayer.Normal.Z"});
  for (size_t i = 0; i < 2; ++i) {
    float* pixel = &blender.pixels[8 * i];
    pixel[3] = i == 0 ? 3.5f : 1e10f;
    pixel[4] = i == 0 ? 2 : 0;
    pixel[5] = 0, pixel[6] = 0, pixel[7] = 1;
  }
  const auto source = open(save(blender), 2, 1);
  const Sample hit = sample(*source, .5, .5);
  EXPECT_EQ(hit.rgb[0], blender.pixels[0]);
  EXPECT_EQ(hit.distance, 3.5f);
  EXPECT_EQ(hit.position, (std::array{0.f, 0.f, -3.5f}));
  EXPECT_EQ(hit.normal, (std::array{0.f, 0.f, 1.f}));
  EXPECT_EQ(hit.object_id, 2u);
  EXPECT_EQ(sample(*source, 1.5, .5).distance, kInfinite);
  // Ids alone: what has one is there.
  Image ids = noise(2, 1, {"R", "G", "B", "object_id"});
  ids.pixels[3] = 5;
  ids.pixels[7] = 0;
  const auto flat = open(save(ids, "b.exr"), 2, 1);
  EXPECT_EQ(sample(*flat, .5, .5).distance, 1);
  EXPECT_EQ(sample(*flat, .5, .5).object_id, 5u);
  EXPECT_EQ(sample(*flat, 1.5, .5).distance, kInfinite);
}

TEST_F(ImageSourceTest, SaysWhichGeometryTheFileHas) {
  const FilmPlanes all{.variance = true,
                       .depth = true,
                       .position = true,
                       .normal = true,
                       .albedo = true,
                       .object_id = true,
                       .material_id = true,
                       .samples = true,
                       .reasons = true};
  const auto missing = [&](std::vector<std::string> channels) {
    channels.insert(channels.begin(), {"R", "G", "B"});
    return missing_planes(all, open(save(noise(2, 1, channels)), 2, 1)->abilities());
  };
  using testing::ElementsAre;
  EXPECT_THAT(missing({"object_id"}), ElementsAre("depth", "position", "normal", "albedo", "material-id"));
  EXPECT_THAT(missing({"Z", "N.X", "N.Y", "N.Z"}), ElementsAre("position", "albedo", "object-id", "material-id"));
  EXPECT_THAT(missing({"P.X", "P.Y", "P.Z", "material_id"}), ElementsAre("depth", "normal", "albedo", "object-id"));
  EXPECT_THAT(missing({}), ElementsAre("depth", "position", "normal", "albedo", "object-id", "material-id"));
  EXPECT_THAT(missing_planes({.depth = true}, {.geometry = true}), ElementsAre());
}

TEST_F(ImageSourceTest, RefusesWhatCannotBe) {
  using testing::AllOf;
  using testing::HasSubstr;
  const std::string path = save(noise(12, 6));
  EXPECT_THAT(error_of(path, 13, 6), AllOf(HasSubstr("a.exr"), HasSubstr("12x6"), HasSubstr("13x6")));
  EXPECT_THAT(error_of(path, 6, 3, {3, 1}), HasSubstr("18x3"));
  EXPECT_EQ(error_of(path, 4, 2, {3, 3}), "");
  EXPECT_THAT(error_of(path, 6, 3, {}, {.most_bytes = 863, .colour_space = ""}),
              AllOf(HasSubstr("12x6"), HasSubstr("memory")));
  EXPECT_EQ(error_of(path, 6, 3, {}, {.most_bytes = 864, .colour_space = ""}), "");  // 12 x 6 x 3 x 4
  EXPECT_THAT(error_of(folder_ / "none.exr", 1, 1), HasSubstr("none.exr"));
  EXPECT_THAT(error_of(save(noise(3, 3, {"u", "v"}), "c.exr"), 1, 1), HasSubstr("c.exr"));
}
