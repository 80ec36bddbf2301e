// SPDX-License-Identifier: Apache-2.0
// What surrounds a render: texts that become sizes, and the picture's header, in the file too.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <triad/base/error.hpp>
#include <triad/image/reader.hpp>
#include <triad/image/writer.hpp>
#include <triad/sampling/analytic.hpp>
#include <triad/sampling/render.hpp>

#include "picture_files.hpp"
#include "sampling_sources.hpp"

using namespace triad;
using testing::Optional;

namespace {

// Counts what it did.
class BusySource final : public Source {
 public:
  int width() const override { return 6; }
  int height() const override { return 2; }
  SourceAbilities abilities() const override { return {}; }
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const override {
    for (size_t i = 0; i < requests.size(); ++i) {
      samples[i] = test::grey(requests[i].pixel_x + .5 * (requests[i].index & 1));
      samples[i].valid = requests[i].pixel_x != 5;
    }
  }
  std::vector<WorkCount> work() const override { return {{"camera rays", 24}, {"shadow rays", 0}}; }
};

}  // namespace

TEST(RenderText, Sizes) {
  EXPECT_EQ(parse_size("400x225", "--size").width, 400);
  EXPECT_EQ(parse_size("1x100000", "--size").height, 100000);
  for (const char* text : {"", "400", "x", "0x5", "5x0", "-1x5", "4x5x6", "4.5x5", "2147483648x1", " 4x5", "4 x 5"})
    EXPECT_THROW(parse_size(text, "--size"), Error) << text;
  EXPECT_EQ(film_size({400, 225}, {3, 1}).width, 1200);
  EXPECT_EQ(film_size({400, 225}, {3, 2}).height, 450);
  EXPECT_THROW(film_size({2147483647, 1}, {2, 1}), Error);
  EXPECT_EQ(parse_cells_or_layout("3x2", "--cells").cells, (Cells{3, 2}));
  EXPECT_EQ(parse_cells_or_layout("3x2", "--cells").layout, "");
  EXPECT_EQ(parse_cells_or_layout("bgr", "--cells").cells, (Cells{3, 1}));
  EXPECT_EQ(parse_cells_or_layout("bgr", "--cells").layout, "bgr");
  EXPECT_THROW(parse_cells_or_layout("", "--cells"), Error);
  EXPECT_THROW(parse_cells_or_layout("3", "--cells"), Error);
  EXPECT_EQ(parse_until("rmse=1e-3", "--until"), 1e-3);
  for (const char* text : {"", "rmse", "rmse=", "rmse=0", "rmse=-1", "rmse=nan", "rmse=inf", "mse=1", "1e-3"})
    EXPECT_THROW(parse_until(text, "--until"), Error) << text;
}

TEST(RenderPicture, SaysHowItWasMade) {
  const BusySource source;
  RenderOptions options;
  options.seed = 12;
  options.planes.error = true;
  const auto strategy = make_strategy("sobol-owen:spp=4", "--strategy");
  RenderResult result = strategy->render(source, options);
  const Image image = render_picture(result, *strategy, options, source, {3, 1}, {{"scene", "a b.gltf"}});
  const Metadata& facts = image.spec.metadata;
  EXPECT_THAT(facts.get("triad:scene"), Optional(std::string("a b.gltf")));
  EXPECT_THAT(facts.get("triad:strategy"), Optional(std::string("sobol-owen:spp=4")));
  EXPECT_THAT(facts.get("triad:seed"), Optional(std::string("12")));
  EXPECT_THAT(facts.get("triad:samples"), Optional(std::string("48")));
  EXPECT_THAT(facts.get("triad:dropped"), Optional(std::string("8")));
  EXPECT_THAT(facts.get("triad:camera_rays"), Optional(std::string("24")));
  EXPECT_THAT(facts.get("triad:shadow_rays"), Optional(std::string("0")));
  EXPECT_EQ(facts.get("triad:partial"), std::nullopt);
  // The two pixels that lost all four samples are given up; in each other two samples are .5 brighter than two: a
  // variance of 1/12, and of the mean of four 1/48.
  EXPECT_NEAR(std::stod(facts.get("triad:rmse").value_or("0")), std::sqrt(1. / 48), 1e-12);
  const auto three = make_strategy("sobol-owen:spp=3", "--strategy");
  const Image unknown = render_picture(three->render(source, options), *three, options, source, {3, 1}, {});
  EXPECT_EQ(unknown.spec.metadata.get("triad:rmse"), std::nullopt);  // three lost samples are too few to give up
  result.complete = false;
  const Image partial = render_picture(result, *strategy, options, source, {3, 1}, {});
  EXPECT_THAT(partial.spec.metadata.get("triad:partial"), Optional(std::string("true")));
}

TEST(RenderPicture, ComesBackFromAFileAsItWas) {
  const picture_files::Folder folder;
  const RampSource source(6, 2, {.1f, .2f, .3f}, {1, 2, 3}, {.01f, .02f, .03f});
  RenderOptions options;
  options.planes = parse_planes("variance,samples", "--aov");
  options.planes.error = true;
  const auto strategy = make_strategy("sobol-owen", "--strategy");
  const RenderResult result = strategy->render(source, options);
  const Image image = render_picture(result, *strategy, options, source, {3, 1}, {{"scene", "s.glb"}});
  WriteOptions write;
  write.depth = Depth::kFloat;
  write_image(folder / "a.exr", image, write);
  ReadOptions everything;
  everything.all_channels = true;
  const Image back = read_image(folder / "a.exr", everything);
  EXPECT_EQ(back.spec.cells, (Cells{3, 1}));
  EXPECT_DOUBLE_EQ(back.spec.pixel_aspect, 1. / 3);
  EXPECT_EQ(back.spec.colour_space, "lin_rec709");
  EXPECT_EQ(back.spec.colour_channels, 3);
  EXPECT_THAT(back.spec.metadata.get("triad:scene"), Optional(std::string("s.glb")));
  EXPECT_THAT(back.spec.metadata.get("triad:strategy"), Optional(std::string("sobol-owen:spp=16")));
  EXPECT_NE(back.spec.metadata.get("triad:rmse"), std::nullopt);
  // What Triad states about the pixels is not carried on as if it were somebody's note.
  EXPECT_EQ(back.spec.metadata.get("triad:cells"), std::nullopt);
  EXPECT_EQ(back.spec.metadata.get("triad:colour_space"), std::nullopt);
  const Image colour = read_image(folder / "a.exr");
  for (size_t p = 0; p < 12; ++p)
    EXPECT_EQ(std::memcmp(&colour.pixels[3 * p], &image.pixels[image.spec.channels.size() * p], 3 * sizeof(float)),
              0);
}
