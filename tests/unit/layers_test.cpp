// SPDX-License-Identifier: Apache-2.0
// Choosing one layer of a file that holds several.
#include <gmock/gmock.h>

#include <triad/base/error.hpp>
#include <triad/image/reader.hpp>

#include "picture_files.hpp"

using namespace picture_files;
using testing::ElementsAre;
using testing::HasSubstr;
using triad::ImageReader;
using triad::ReadOptions;

namespace {

struct Part {
  std::string name;
  std::vector<std::string> channels;  // every value is 100 * part + channel
};

void save_parts(const std::string& path, const std::vector<Part>& parts) {
  std::vector<OIIO::ImageSpec> specs;
  for (const Part& part : parts) {
    OIIO::ImageSpec spec(3, 2, static_cast<int>(part.channels.size()), OIIO::TypeDesc::FLOAT);
    spec.channelnames = part.channels;
    spec.attribute("oiio:subimagename", part.name);
    specs.push_back(spec);
  }
  const auto out = OIIO::ImageOutput::create(path);
  check(out->open(path, static_cast<int>(specs.size()), specs.data()), *out);
  for (size_t p = 0; p < specs.size(); ++p) {
    if (p > 0) check(out->open(path, specs[p], OIIO::ImageOutput::AppendSubimage), *out);
    std::vector<float> values(6 * parts[p].channels.size());
    for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(100 * p + i % parts[p].channels.size());
    check(out->write_image(OIIO::TypeDesc::FLOAT, values.data()), *out);
  }
  check(out->close(), *out);
}

struct Found {
  std::vector<std::string> channels;
  std::vector<float> values;  // of a pixel
  int colour_channels = 0, alpha = -1;
  std::string space;
};
Found read(const std::string& path, const std::string& layer, const std::string& part = "") {
  ReadOptions options;
  options.layer = layer;
  options.part = part;
  const triad::Image image = triad::read_image(path, options);
  return {image.spec.channels,
          {image.pixels.begin(), image.pixels.begin() + image.spec.channel_count()},
          image.spec.colour_channels,
          image.spec.alpha,
          image.spec.colour_space};
}

std::string error_of(const std::string& path, const std::string& layer, const std::string& part = "") {
  try {
    read(path, layer, part);
  } catch (const triad::Error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST(Layers, OfOnePart) {
  const Folder folder;
  // Sorted as EXR has them.
  save_parts(folder / "a.exr", {{"",
                                 {"A", "B", "G", "R", "Z", "ao.Y", "flow.U", "flow.V", "light.key.B", "light.key.G",
                                  "light.key.R", "normal.B", "normal.G", "normal.R", "pos.x", "pos.y", "pos.z"}}});
  const Found key = read(folder / "a.exr", "light.key");
  EXPECT_THAT(key.channels, ElementsAre("light.key.R", "light.key.G", "light.key.B"));
  EXPECT_THAT(key.values, ElementsAre(10, 9, 8));
  EXPECT_EQ(key.colour_channels, 3);
  EXPECT_EQ(key.space, "Linear");
  EXPECT_EQ(read(folder / "a.exr", "KEY").channels, key.channels);
  const Found normal = read(folder / "a.exr", "normal");
  EXPECT_THAT(normal.values, ElementsAre(13, 12, 11));
  EXPECT_EQ(normal.colour_channels, 0);
  EXPECT_EQ(normal.space, "");
  EXPECT_THAT(read(folder / "a.exr", "pos").values, ElementsAre(14, 15, 16));
  EXPECT_EQ(read(folder / "a.exr", "pos").colour_channels, 0);
  EXPECT_THAT(read(folder / "a.exr", "Z").values, ElementsAre(4));
  EXPECT_EQ(read(folder / "a.exr", "Z").colour_channels, 0);
  EXPECT_EQ(read(folder / "a.exr", "ao").colour_channels, 1);
  EXPECT_THAT(error_of(folder / "a.exr", "flow"), HasSubstr("flow.U, flow.V"));
  EXPECT_THAT(error_of(folder / "a.exr", "norml"), HasSubstr("'normal'?"));
  EXPECT_THAT(error_of(folder / "a.exr", "x"), HasSubstr("'Z', 'ao', 'flow', 'light.key', 'normal', 'pos'"));
}

TEST(Layers, AcrossParts) {
  const Folder folder;
  save_parts(folder / "a.exr", {{"beauty", {"R", "G", "B", "A"}},
                                {"albedo", {"R", "G", "B"}},
                                {"depth", {"Z"}},
                                {"more", {"a.key.R", "a.key.G", "a.key.B", "b.key.R", "b.key.G", "b.key.B"}}});
  EXPECT_THAT(read(folder / "a.exr", "albedo").values, ElementsAre(100, 101, 102));
  EXPECT_EQ(read(folder / "a.exr", "albedo").colour_channels, 3);
  const Found beauty = read(folder / "a.exr", "beauty");
  EXPECT_THAT(beauty.values, ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(beauty.alpha, 3);
  for (const std::string name : {"depth", "Z"}) {
    EXPECT_THAT(read(folder / "a.exr", name).values, ElementsAre(200));
    EXPECT_EQ(read(folder / "a.exr", name).colour_channels, 0);
  }
  EXPECT_THAT(read(folder / "a.exr", "b.key").values, ElementsAre(303, 304, 305));
  EXPECT_THAT(error_of(folder / "a.exr", "key"), HasSubstr("'a.key', 'b.key'"));
  EXPECT_THAT(read(folder / "a.exr", "a.key", "more").values, ElementsAre(300, 301, 302));
  EXPECT_THAT(error_of(folder / "a.exr", "a.key", "albedo"), HasSubstr("has no layer 'a.key'"));
}

TEST(Layers, OfOneNameInSeveralParts) {
  const Folder folder;
  save_parts(folder / "a.exr",
             {{"left", {"diffuse.R", "diffuse.G", "diffuse.B"}}, {"right", {"diffuse.R", "diffuse.G", "diffuse.B"}}});
  EXPECT_THAT(error_of(folder / "a.exr", "diffuse"), HasSubstr("in several parts; choose one of them with --part"));
  EXPECT_THAT(read(folder / "a.exr", "diffuse", "right").values, ElementsAre(100, 101, 102));
}

TEST(Layers, OfAFileWithoutAny) {
  const Folder folder;
  save_parts(folder / "a.exr", {{"", {"R", "G", "B"}}});
  EXPECT_THAT(error_of(folder / "a.exr", "albedo"), HasSubstr("it has none"));
  ReadOptions both;
  both.layer = "a";
  both.channels = {"R"};
  EXPECT_THROW(ImageReader::open(folder / "a.exr", both), triad::Error);
}
