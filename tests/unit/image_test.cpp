// SPDX-License-Identifier: Apache-2.0
// What pictures hold, read from files that OpenImageIO wrote by itself.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/image/reader.hpp>

#include "picture_files.hpp"

using namespace picture_files;
using OIIO::TypeDesc;
using testing::ElementsAre;
using testing::HasSubstr;
using triad::ImageReader;
using triad::ReadOptions;

namespace {

using Sizes = std::vector<std::pair<int, int>>;
const Sizes kSizes{{1, 1}, {1, 7}, {13, 1}, {2, 3}, {17, 67}, {101, 37}};

std::string error_of(const std::string& path, const ReadOptions& options = {}) {
  try {
    triad::read_image(path, options);
  } catch (const triad::Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "";
}

// Writes noise in `type` and expects it back divided by `most`, to the last bit.
template <typename T>
void expect_exact(const std::string& name, const TypeDesc& type, T most, double maximum, int channels,
                  const std::string& compression = "") {
  const Folder folder;
  for (const auto& [w, h] : kSizes) {
    SCOPED_TRACE(name + " " + type.c_str() + " " + compression + " " + std::to_string(w) + "x" + std::to_string(h));
    const auto samples = noise<T>(static_cast<size_t>(w * h * channels), most);
    OIIO::ImageSpec spec(w, h, channels, type);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    if (!compression.empty()) spec.attribute("compression", compression);
    save(folder / name, spec, type, samples.data());
    ReadOptions all;
    all.all_channels = true;
    const triad::Image image = triad::read_image(folder / name, all);
    ASSERT_EQ(image.spec.width, w);
    ASSERT_EQ(image.spec.height, h);
    ASSERT_EQ(image.spec.channel_count(), channels);
    for (size_t i = 0; i < samples.size(); ++i) {
      float expected = static_cast<float>(static_cast<double>(samples[i]) / maximum);
      const size_t alpha = i / channels * channels + channels - 1;
      if (image.spec.alpha >= 0 && i != alpha && name.find(".png") != std::string::npos)
        expected *= static_cast<float>(static_cast<double>(samples[alpha]) / maximum);
      ASSERT_EQ(image.pixels[i], expected) << i;
    }
  }
}

}  // namespace

TEST(Image, IntegersAreDividedByTheirMaximum) {
  for (const int channels : {1, 2, 3, 4}) {
    expect_exact<uint8_t>("a.png", TypeDesc::UINT8, 255, 255, channels);
    expect_exact<uint16_t>("a.png", TypeDesc::UINT16, 65535, 65535, channels);
  }
  for (const char* compression : {"none", "zip", "lzw", "packbits"}) {
    expect_exact<uint8_t>("a.tif", TypeDesc::UINT8, 255, 255, 3, compression);
    expect_exact<uint16_t>("a.tif", TypeDesc::UINT16, 65535, 65535, 3, compression);
  }
  expect_exact<uint8_t>("a.tif", TypeDesc::UINT8, 255, 255, 1);
  expect_exact<uint8_t>("a.tga", TypeDesc::UINT8, 255, 255, 3);
}

TEST(Image, FloatsAreLeftAlone) {
  for (const char* compression : {"none", "zip", "lzw"})
    expect_exact<float>("a.tif", TypeDesc::FLOAT, 1e30f, 1, 3, compression);
  for (const char* compression : {"none", "rle", "zips", "zip", "piz"}) {
    expect_exact<float>("a.exr", TypeDesc::FLOAT, 1e30f, 1, 4, compression);
    expect_exact<float>("a.exr", TypeDesc::FLOAT, 1e30f, 1, 1, compression);
  }
}

TEST(Image, EveryHalfIsExact) {
  const Folder folder;
  // All 65,536 bit patterns; a table-free decoder of IEEE 754 binary16 to compare with.
  std::vector<uint16_t> codes(65536);
  for (size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<uint16_t>(i);
  save(folder / "a.exr", OIIO::ImageSpec(256, 256, 1, TypeDesc::HALF), TypeDesc::HALF, codes.data());
  const auto image = triad::read_image(folder / "a.exr");
  for (int i = 0; i < 65536; ++i) {
    const int exponent = i >> 10 & 31, fraction = i & 1023;
    double v = exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
    if (exponent == 31) v = fraction ? std::nan("") : HUGE_VAL;
    if (i & 0x8000) v = -v;
    if (std::isnan(v))
      ASSERT_TRUE(std::isnan(image.pixels[i]));
    else
      ASSERT_EQ(image.pixels[i], static_cast<float>(v)) << i;
  }
}

TEST(Image, IdentifiersOfExrKeepTheirValues) {
  const Folder folder;
  OIIO::ImageSpec spec(3, 2, 4, TypeDesc::HALF);
  spec.channelnames = {"R", "G", "B", "id"};
  spec.channelformats = {TypeDesc::HALF, TypeDesc::HALF, TypeDesc::HALF, TypeDesc::UINT32};
  struct Pixel {
    uint16_t rgb[3];
    uint32_t id;
  } __attribute__((packed));
  std::vector<Pixel> pixels(6);
  for (uint32_t i = 0; i < 6; ++i) pixels[i] = {{0x3c00, 0x4000, 0x3800}, i * 1000};
  save(folder / "a.exr", spec, TypeDesc::UNKNOWN, pixels.data());
  ReadOptions options;
  options.all_channels = true;
  const auto image = triad::read_image(folder / "a.exr", options);
  EXPECT_THAT(image.spec.channels, ElementsAre("R", "G", "B", "id"));
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(image.pixels[i * 4], 1.f);
    EXPECT_EQ(image.pixels[i * 4 + 1], 2.f);
    EXPECT_EQ(image.pixels[i * 4 + 2], .5f);
    EXPECT_EQ(image.pixels[i * 4 + 3], static_cast<float>(i * 1000));
  }
}

TEST(Image, RadianceIsWithinItsEightBits) {
  const Folder folder;
  const auto samples = noise<float>(37 * 11 * 3, 1000.f);
  save(folder / "a.hdr", OIIO::ImageSpec(37, 11, 3, TypeDesc::FLOAT), TypeDesc::FLOAT, samples.data());
  const auto image = triad::read_image(folder / "a.hdr");
  EXPECT_EQ(image.spec.colour_space, "Linear");
  for (size_t i = 0; i < samples.size(); i += 3) {
    const float most = std::max({samples[i], samples[i + 1], samples[i + 2]});
    // One step of the shared exponent is at most 1/128 of the largest component.
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(image.pixels[i + c], samples[i + c], most / 128);
  }
}

TEST(Image, JpegIsNearWhatWasStored) {
  const Folder folder;
  std::vector<uint8_t> samples(61 * 43 * 3);
  for (int y = 0; y < 43; ++y)
    for (int x = 0; x < 61; ++x)
      for (int c = 0; c < 3; ++c) samples[(y * 61 + x) * 3 + c] = static_cast<uint8_t>(x * 2 + y + c * 20);
  OIIO::ImageSpec spec(61, 43, 3, TypeDesc::UINT8);
  spec.attribute("Compression", "jpeg:100");
  save(folder / "a.jpg", spec, TypeDesc::UINT8, samples.data());
  const auto image = triad::read_image(folder / "a.jpg");
  EXPECT_EQ(image.spec.colour_space, "sRGB");
  for (size_t i = 0; i < samples.size(); ++i) ASSERT_NEAR(image.pixels[i], samples[i] / 255., 8 / 255.);
}

TEST(Image, PaletteAndBilevelAreWidened) {
  const Folder folder;
  // A PNG of 4x1 pixels with a palette of 2 bits: red, white, black, half-transparent green.
  std::string png = "\x89PNG\r\n\x1a\n";
  using namespace std::string_literals;
  png += png_chunk("IHDR", "\0\0\0\4\0\0\0\1\2\3\0\0\0"s);
  png += png_chunk("PLTE", "\xff\0\0\xff\xff\xff\0\0\0\0\xff\0"s);
  png += png_chunk("tRNS", "\xff\xff\xff\x80"s);
  // Deflate, stored block of 2 bytes: filter none, then the indices 0 1 2 3; Adler-32 of both.
  png += png_chunk("IDAT", "\x78\x01\x01\x02\0\xfd\xff\0\x1b\0\x1d\0\x1c"s);
  png += png_chunk("IEND", "");
  put_bytes(folder / "p.png", png);
  const auto image = triad::read_image(folder / "p.png");
  ASSERT_THAT(image.spec.channels, ElementsAre("R", "G", "B", "A"));
  const float a = 128.f / 255;
  EXPECT_THAT(image.pixels, ElementsAre(1, 0, 0, 1, 1, 1, 1, 1, 0, 0, 0, 1, 0, a, 0, a));

  OIIO::ImageSpec bilevel(9, 2, 1, TypeDesc::UINT8);
  bilevel.attribute("oiio:BitsPerSample", 1);
  std::vector<uint8_t> bits{255, 0, 255, 255, 0, 0, 255, 0, 255, 0, 0, 0, 255, 255, 255, 0, 255, 0};
  save(folder / "b.tif", bilevel, TypeDesc::UINT8, bits.data());
  const auto read = triad::read_image(folder / "b.tif");
  for (size_t i = 0; i < bits.size(); ++i) EXPECT_EQ(read.pixels[i], bits[i] / 255.f);
}

TEST(Image, SaysThatNoDataLieInTheDisplayWindow) {
  const Folder folder;
  const auto samples = noise<float>(20 * 15 * 3, 1.f);
  int n = 0;
  for (const auto& [dx, dy, outside] : {std::tuple{0, 0, false},
                                        {23, 10, false},
                                        {-19, -14, false},
                                        {24, 0, true},
                                        {0, 11, true},
                                        {-20, 0, true},
                                        {0, -15, true}}) {
    OIIO::ImageSpec spec(20, 15, 3, TypeDesc::FLOAT);
    spec.full_x = -3;
    spec.full_y = 5;
    spec.full_width = 24;
    spec.full_height = 11;
    spec.x = dx - 3;
    spec.y = dy + 5;
    const std::string path = folder / (std::to_string(n++) + ".exr");  // a warning is printed once
    save(path, spec, TypeDesc::FLOAT, samples.data());
    testing::internal::CaptureStderr();
    ImageReader::open(path);
    ImageReader::open(path);
    const std::string warning = "triad: warning: '" + path + "' is black: its data window, 20 x 15 at (" +
                                std::to_string(dx - 3) + ", " + std::to_string(dy + 5) +
                                "), lies outside of its display window, 24 x 11 at (-3, 5)\n";
    EXPECT_EQ(testing::internal::GetCapturedStderr(), outside ? warning : "") << dx << ", " << dy;
  }
}

TEST(Image, DataWindowIsPlacedInTheDisplayWindow) {
  const Folder folder;
  const auto samples = noise<float>(20 * 15 * 3, 1.f);
  // Where the data begin relative to the display window, and the display window's own origin.
  const int kCases[][4] = {{0, 0, 0, 0},   {3, 4, 0, 0},  {-5, -6, 0, 0},   {3, -4, 0, 0},
                           {-50, 0, 0, 0}, {0, 40, 0, 0}, {7, 2, -100, 33}, {-3, -2, 17, -9}};
  for (const char* compression : {"zip", "tiled"}) {
    for (const auto& [dx, dy, ox, oy] : kCases) {
      OIIO::ImageSpec spec(20, 15, 3, TypeDesc::FLOAT);
      if (std::string(compression) == "tiled") spec.tile_width = spec.tile_height = 8;
      spec.full_x = ox;
      spec.full_y = oy;
      spec.full_width = 24;
      spec.full_height = 11;
      spec.x = ox + dx;
      spec.y = oy + dy;
      save(folder / "a.exr", spec, TypeDesc::FLOAT, samples.data());
      const auto reader = ImageReader::open(folder / "a.exr");
      EXPECT_EQ(reader->info().data_x, dx);
      EXPECT_EQ(reader->info().data_y, dy);
      EXPECT_EQ(reader->info().data_width, 20);
      EXPECT_EQ(reader->info().data_height, 15);
      const auto image = triad::read_image(folder / "a.exr");
      ASSERT_EQ(image.spec.width, 24);
      ASSERT_EQ(image.spec.height, 11);
      for (int y = 0; y < 11; ++y)
        for (int x = 0; x < 24; ++x)
          for (int c = 0; c < 3; ++c) {
            const int sx = x - dx, sy = y - dy;
            const bool inside = sx >= 0 && sx < 20 && sy >= 0 && sy < 15;
            ASSERT_EQ(image.row(y)[x * 3 + c], inside ? samples[(sy * 20 + sx) * 3 + c] : 0.f)
                << dx << "," << dy << " at " << x << "," << y;
          }
    }
  }
}

namespace {

void save_parts(const std::string& path, const std::vector<OIIO::ImageSpec>& specs) {
  const auto out = OIIO::ImageOutput::create(path);
  const bool all_at_once = path.ends_with("exr");
  bool ok = all_at_once ? out->open(path, static_cast<int>(specs.size()), specs.data()) : out->open(path, specs[0]);
  check(ok, *out);
  for (size_t i = 0; i < specs.size(); ++i) {
    if (i > 0) check(out->open(path, specs[i], OIIO::ImageOutput::AppendSubimage), *out);
    const std::vector<float> pixels(specs[i].image_pixels() * static_cast<size_t>(specs[i].nchannels),
                                    static_cast<float>(i + 1));
    check(out->write_image(TypeDesc::FLOAT, pixels.data()), *out);
  }
  check(out->close(), *out);
}

}  // namespace

TEST(Image, PartsByNameOrNumber) {
  const Folder folder;
  std::vector<OIIO::ImageSpec> specs;
  for (const char* name : {"left", "right", "7"}) {
    OIIO::ImageSpec spec(5, 4, 3, TypeDesc::HALF);
    spec.attribute("oiio:subimagename", name);
    specs.push_back(spec);
  }
  save_parts(folder / "a.exr", specs);
  const auto first = [&](const std::string& part, const std::string& file) {
    ReadOptions options;
    options.part = part;
    return triad::read_image(folder / file, options).pixels[0];
  };
  EXPECT_EQ(first("", "a.exr"), 1);
  EXPECT_EQ(first("left", "a.exr"), 1);
  EXPECT_EQ(first("right", "a.exr"), 2);
  EXPECT_EQ(first("7", "a.exr"), 3);
  EXPECT_EQ(first("1", "a.exr"), 2);
  const auto parts = ImageReader::open(folder / "a.exr")->info().parts;
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[1].name, "right");
  EXPECT_EQ(parts[1].width, 5);
  EXPECT_EQ(parts[1].height, 4);
  ReadOptions wrong;
  wrong.part = "rihgt";
  EXPECT_THAT(error_of(folder / "a.exr", wrong),
              testing::AllOf(HasSubstr("a.exr"), HasSubstr("did you mean 'right'")));
  wrong.part = "3";
  EXPECT_THAT(error_of(folder / "a.exr", wrong), HasSubstr("no part '3'"));

  for (auto& spec : specs) spec = OIIO::ImageSpec(5, 4, 3, TypeDesc::FLOAT);
  save_parts(folder / "a.tif", specs);
  EXPECT_EQ(first("2", "a.tif"), 3);
  EXPECT_EQ(ImageReader::open(folder / "a.tif")->info().parts.size(), 3u);
}

TEST(Image, MipMapsGiveTheirFinestLevel) {
  const Folder folder;
  const std::string path = folder / "a.exr";
  OIIO::ImageSpec spec(32, 32, 3, TypeDesc::FLOAT);
  spec.tile_width = spec.tile_height = 16;
  spec.attribute("textureformat", "Plain Texture");
  const auto samples = noise<float>(32 * 32 * 3, 1.f);
  const auto out = OIIO::ImageOutput::create(path);
  check(out->open(path, spec), *out);
  for (int size = 32; size >= 1; size /= 2) {
    spec.width = spec.height = spec.full_width = spec.full_height = size;
    if (size < 32) check(out->open(path, spec, OIIO::ImageOutput::AppendMIPLevel), *out);
    check(out->write_image(TypeDesc::FLOAT, samples.data()), *out);
  }
  check(out->close(), *out);
  EXPECT_EQ(triad::read_image(path).pixels, samples);
}

TEST(Image, ChannelsByNameAndLayer) {
  const Folder folder;
  const std::vector<std::string> names{"R",         "G",         "B",         "A",         "Z",
                                       "diffuse.R", "diffuse.G", "diffuse.B", "diffuse.A", "N.x"};
  OIIO::ImageSpec spec(3, 2, static_cast<int>(names.size()), TypeDesc::FLOAT);
  spec.channelnames = names;
  std::vector<float> samples(6 * names.size());
  for (size_t i = 0; i < samples.size(); ++i) samples[i] = static_cast<float>(i % names.size());
  save(folder / "a.exr", spec, TypeDesc::FLOAT, samples.data());
  const auto read = [&](std::vector<std::string> channels, bool all = false) {
    ReadOptions options;
    options.channels = std::move(channels);
    options.all_channels = all;
    const auto image = triad::read_image(folder / "a.exr", options);
    // Whatever was asked for comes from the channel of that name.
    for (size_t i = 0; i < image.pixels.size(); ++i) {
      const auto& name = image.spec.channels[i % image.spec.channels.size()];
      EXPECT_EQ(names[static_cast<size_t>(image.pixels[i])], name);
    }
    return image.spec;
  };
  auto got = read({});
  EXPECT_THAT(got.channels, ElementsAre("R", "G", "B", "A"));
  EXPECT_EQ(got.colour_channels, 3);
  EXPECT_EQ(got.alpha, 3);
  EXPECT_EQ(got.size_text(), "3x2 RGBA");
  got = read({}, true);
  EXPECT_EQ(got.channels.size(), names.size());
  EXPECT_EQ(got.channels[0] + got.channels[3], "RA");
  EXPECT_EQ(got.colour_channels, 3);
  got = read({"diffuse.R", "diffuse.G", "diffuse.B"});
  EXPECT_EQ(got.colour_channels, 3);
  EXPECT_EQ(got.alpha, -1);
  got = read({"diffuse"});
  EXPECT_THAT(got.channels, ElementsAre("diffuse.R", "diffuse.G", "diffuse.B", "diffuse.A"));
  EXPECT_EQ(got.colour_channels, 3);
  EXPECT_EQ(got.alpha, 3);
  got = read({"B", "R"});
  EXPECT_THAT(got.channels, ElementsAre("B", "R"));
  EXPECT_EQ(got.colour_channels, 0);
  EXPECT_EQ(got.colour_space, "");
  got = read({"Z"});
  EXPECT_EQ(got.colour_channels, 1);
  got = read({"r", "g", "b"});
  EXPECT_THAT(got.channels, ElementsAre("R", "G", "B"));
  ReadOptions wrong;
  wrong.channels = {"difuse"};
  EXPECT_THAT(error_of(folder / "a.exr", wrong),
              testing::AllOf(HasSubstr("no channel or layer 'difuse'"), HasSubstr("N.x")));
}

TEST(Image, FilesWithoutPlainColour) {
  const Folder folder;
  const auto make = [&](const std::vector<std::string>& names) {
    OIIO::ImageSpec spec(2, 2, static_cast<int>(names.size()), TypeDesc::FLOAT);
    spec.channelnames = names;
    const auto samples = noise<float>(4 * names.size(), 1.f);
    save(folder / "a.exr", spec, TypeDesc::FLOAT, samples.data());
    return triad::read_image(folder / "a.exr").spec;
  };
  EXPECT_EQ(make({"Y"}).colour_channels, 1);
  EXPECT_EQ(make({"Z"}).colour_channels, 1);
  auto grey = make({"Y", "A"});
  EXPECT_EQ(grey.colour_channels, 1);
  EXPECT_EQ(grey.alpha, 1);
  EXPECT_EQ(make({"X", "Y", "Z"}).colour_channels, 0);
  // As Blender writes its layers.
  const auto layered =
      make({"View.Combined.R", "View.Combined.G", "View.Combined.B", "View.Combined.A", "View.Depth.Z"});
  EXPECT_EQ(layered.colour_channels, 3);
  EXPECT_EQ(layered.alpha, 3);
  EXPECT_THROW(make({"a.R", "a.G", "a.B", "b.R", "b.G", "b.B"}), triad::Error);
}

TEST(Image, CellsComeFromMetadataAspectOrOption) {
  const Folder folder;
  const auto spec_of = [&](const char* name, float aspect, const char* cells, const ReadOptions& options = {}) {
    OIIO::ImageSpec spec(6, 2, 3, std::string(name).ends_with("exr") ? TypeDesc::HALF : TypeDesc::UINT8);
    if (aspect != 0) spec.attribute("PixelAspectRatio", aspect);
    if (*cells) spec.attribute("triad:cells", cells);
    const std::vector<float> black(36);
    save(folder / name, spec, TypeDesc::FLOAT, black.data());
    const auto reader = ImageReader::open(folder / name, options);
    return std::make_pair(reader->spec(), reader->info().cells_from);
  };
  auto [plain, from] = spec_of("a.exr", 0, "");
  EXPECT_EQ(plain.cells, (triad::Cells{1, 1}));
  EXPECT_EQ(from, "default");
  std::tie(plain, from) = spec_of("a.exr", 1.f / 3, "");
  EXPECT_EQ(plain.cells, (triad::Cells{3, 1}));
  EXPECT_EQ(plain.pixel_aspect, 1. / 3);
  EXPECT_EQ(from, "pixel aspect");
  std::tie(plain, from) = spec_of("a.exr", 1.f / 3, "2x2");
  EXPECT_EQ(plain.cells, (triad::Cells{2, 2}));
  EXPECT_EQ(from, "metadata");
  std::tie(plain, from) = spec_of("a.exr", .34f, "");
  EXPECT_EQ(plain.cells, (triad::Cells{1, 1}));
  EXPECT_NEAR(plain.pixel_aspect, .34, 1e-6);
  ReadOptions six;
  six.cells = triad::Cells{6, 1};
  std::tie(plain, from) = spec_of("a.exr", 1.f / 3, "2x2", six);
  EXPECT_EQ(plain.cells, (triad::Cells{6, 1}));
  EXPECT_EQ(plain.pixel_aspect, 1. / 6);
  EXPECT_EQ(from, "option");
  std::tie(plain, from) = spec_of("a.tif", 1.f / 3, "");
  EXPECT_EQ(plain.cells, (triad::Cells{3, 1}));
}

TEST(Image, CellsAreParsedStrictly) {
  EXPECT_EQ(triad::parse_cells("3x1", "--cells"), (triad::Cells{3, 1}));
  EXPECT_EQ(triad::parse_cells("64x64", "--cells"), (triad::Cells{64, 64}));
  for (const char* bad : {"", "3", "x", "3x", "x1", "0x1", "65x1", "3x1x1", "-3x1", "3 x1", "3X1"})
    EXPECT_THROW(triad::parse_cells(bad, "--cells"), triad::Error) << bad;
}

TEST(Image, ColourSpaceIsWhatTheFileSays) {
  const Folder folder;
  const auto space = [&](const std::string& name, TypeDesc type, const char* stated = "") {
    OIIO::ImageSpec spec(2, 2, 3, type);
    if (*stated) spec.attribute("oiio:ColorSpace", stated);
    const std::vector<float> black(12);
    save(folder / name, spec, TypeDesc::FLOAT, black.data());
    return ImageReader::open(folder / name)->spec().colour_space;
  };
  EXPECT_EQ(space("a.png", TypeDesc::UINT8), "sRGB");
  EXPECT_EQ(space("a.png", TypeDesc::UINT16), "sRGB");
  EXPECT_EQ(space("a.png", TypeDesc::UINT16, "Linear"), "Linear");
  EXPECT_EQ(space("a.jpg", TypeDesc::UINT8), "sRGB");
  EXPECT_EQ(space("a.tif", TypeDesc::UINT8), "sRGB");
  EXPECT_EQ(space("a.tif", TypeDesc::UINT16), "sRGB");
  EXPECT_EQ(space("a.tif", TypeDesc::FLOAT), "Linear");
  EXPECT_EQ(space("a.exr", TypeDesc::HALF), "Linear");
  EXPECT_EQ(space("a.hdr", TypeDesc::FLOAT), "Linear");
  ReadOptions options;
  options.colour_space = "acescg";
  EXPECT_EQ(ImageReader::open(folder / "a.png", options)->spec().colour_space, "acescg");

  OIIO::ImageSpec aces(2, 2, 3, TypeDesc::HALF);
  const float ap1[8] = {.713f, .293f, .165f, .83f, .128f, .044f, .32168f, .33767f};
  aces.attribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), ap1);
  const std::vector<float> black(12);
  save(folder / "c.exr", aces, TypeDesc::FLOAT, black.data());
  const auto reader = ImageReader::open(folder / "c.exr");
  ASSERT_TRUE(reader->info().chromaticities);
  EXPECT_THAT(*reader->info().chromaticities, testing::ElementsAreArray(ap1));
  EXPECT_EQ(reader->spec().chromaticities, reader->info().chromaticities);
}

TEST(Image, UnassociatedAlphaMultipliesColourEvenWhenItIsNotAskedFor) {
  const Folder folder;
  OIIO::ImageSpec spec(1, 1, 4, TypeDesc::UINT16);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  const uint16_t pixel[4] = {65535, 40000, 1, 20000};
  const float a = 20000.f / 65535;
  for (const char* name : {"a.png", "a.tif"}) {
    save(folder / name, spec, TypeDesc::UINT16, pixel);
    EXPECT_THAT(triad::read_image(folder / name).pixels, ElementsAre(a, 40000.f / 65535 * a, 1.f / 65535 * a, a));
    ReadOptions green;
    green.channels = {"G"};
    EXPECT_THAT(triad::read_image(folder / name, green).pixels, ElementsAre(40000.f / 65535 * a));
  }
}

TEST(Image, ReorderedColourIsASwap) {
  const Folder folder;
  OIIO::ImageSpec spec(1, 1, 5, TypeDesc::FLOAT);
  spec.channelnames = {"R", "G", "B", "A", "Z"};
  const float pixel[5] = {.25f, .5f, .75f, 1.f, 9.f};
  save(folder / "a.exr", spec, TypeDesc::FLOAT, pixel);
  ReadOptions options;
  options.channels = {"R", "B", "G", "A"};
  const auto image = triad::read_image(folder / "a.exr", options);
  EXPECT_THAT(image.spec.channels, ElementsAre("R", "G", "B", "A"));
  EXPECT_THAT(image.pixels, ElementsAre(.25f, .75f, .5f, 1.f));
  EXPECT_EQ(image.spec.colour_channels, 3);
  EXPECT_EQ(image.spec.alpha, 3);
  EXPECT_EQ(image.spec.colour_space, "Linear");
  options.channels = {"B", "G", "R"};
  EXPECT_THAT(triad::read_image(folder / "a.exr", options).pixels, ElementsAre(.75f, .5f, .25f));

  // Where they are not first, they are data, and that is said.
  options.channels = {"Z", "R", "G", "B"};
  testing::internal::CaptureStderr();
  EXPECT_EQ(ImageReader::open(folder / "a.exr", options)->spec().colour_channels, 0);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("must come first"));
  options.channels = {"B", "R"};
  testing::internal::CaptureStderr();
  EXPECT_EQ(ImageReader::open(folder / "a.exr", options)->spec().colour_channels, 0);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(Image, DecodersThatHoldThePictureSaySo) {
  const Folder folder;
  const auto bytes_held = [&](const std::string& name, int channels, TypeDesc type, bool progressive = false) {
    OIIO::ImageSpec spec(33, 17, channels, type);
    spec.attribute("jpeg:subsampling", "4:4:4");
    if (progressive) spec.attribute("jpeg:progressive", 1);
    const auto values = noise<float>(33 * 17 * 4, 1.f);
    save(folder / name, spec, TypeDesc::FLOAT, values.data());
    return ImageReader::open(folder / name)->decoder_bytes();
  };
  for (const char* name : {"a.exr", "a.tif", "a.hdr"}) EXPECT_EQ(bytes_held(name, 3, TypeDesc::FLOAT), 0u) << name;
  EXPECT_EQ(bytes_held("a.png", 4, TypeDesc::UINT16), 0u);
  EXPECT_EQ(bytes_held("a.jpg", 3, TypeDesc::UINT8), 0u);
  EXPECT_EQ(bytes_held("p.jpg", 3, TypeDesc::UINT8, true), 40u * 24 * 3 * 2);
  EXPECT_EQ(bytes_held("g.jpg", 1, TypeDesc::UINT8, true), 40u * 24 * 2);
  EXPECT_EQ(bytes_held("a.ppm", 3, TypeDesc::UINT8), 33u * 17 * 3);

  // The same PNG with the interlace method set: its pixels are then nonsense, its header is not.
  std::string png = bytes_of(folder / "a.png");
  std::string header = png.substr(16, 13);
  header[12] = 1;
  put_bytes(folder / "i.png", png.substr(0, 8) + png_chunk("IHDR", header) + png.substr(33));
  EXPECT_EQ(ImageReader::open(folder / "i.png")->decoder_bytes(), 33u * 17 * 4 * 2);

  // A sequential JPEG whose components come one after the other.
  std::string jpeg = bytes_of(folder / "a.jpg");
  const size_t scan = jpeg.find("\xff\xda");
  ASSERT_NE(scan, std::string::npos);
  ASSERT_EQ(jpeg[scan + 4], 3);
  jpeg.replace(scan, 14, std::string("\xff\xda\0\x08\1\1\0\0\x3f\0", 10));
  put_bytes(folder / "s.jpg", jpeg);
  EXPECT_EQ(ImageReader::open(folder / "s.jpg")->decoder_bytes(), 40u * 24 * 3 * 2);
}
