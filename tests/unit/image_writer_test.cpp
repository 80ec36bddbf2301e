// SPDX-License-Identifier: Apache-2.0
// What the writer leaves in files, judged by OpenImageIO's own reading and by byte comparison.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <thread>
#include <triad/base/error.hpp>
#include <triad/image/reader.hpp>
#include <triad/image/writer.hpp>

#include "picture_files.hpp"

using namespace picture_files;
using OIIO::TypeDesc;
using testing::AllOf;
using testing::HasSubstr;
using triad::Depth;
using triad::Image;
using triad::ImageWriter;
using triad::WriteOptions;

namespace {

Image picture(int width, int height, std::vector<std::string> channels = {"R", "G", "B"}) {
  Image image;
  image.spec.width = width;
  image.spec.height = height;
  image.spec.colour_channels = channels.size() < 3 ? 1 : 3;
  image.spec.alpha = channels.back() == "A" ? static_cast<int>(channels.size()) - 1 : -1;
  image.spec.channels = std::move(channels);
  image.pixels = noise<float>(static_cast<size_t>(height) * image.row_floats(), 1.f);
  return image;
}

WriteOptions options_of(Depth depth, const std::string& compression = "") {
  WriteOptions options;
  options.depth = depth;
  options.compression = compression;
  return options;
}

template <typename T>
std::vector<T> stored(const std::string& path, TypeDesc type) {
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  const auto input = OIIO::ImageInput::open(path, &config);
  if (!input) throw std::runtime_error(OIIO::geterror());
  EXPECT_EQ(input->spec().format, type);
  std::vector<T> samples(input->spec().image_pixels() * static_cast<size_t>(input->spec().nchannels));
  EXPECT_TRUE(input->read_image(0, 0, 0, input->spec().nchannels, type, samples.data()));
  return samples;
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const triad::Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST(ImageWriter, RefusesSidesThatTheFormatCannotHold) {
  const Folder folder;
  for (const auto& [name, most] :
       {std::pair{"a.jpg", 65500}, {"a.jpeg", 65500}, {"a.tga", 65535}, {"a.png", 1000000}})
    for (const bool tall : {false, true}) {
      const auto side = [&, most = most](int px) { return tall ? picture(1, px) : picture(px, 1); };
      EXPECT_THAT(
          error_of([&, name = name, most = most] { triad::write_image(folder / name, side(most + 1)); }),
          AllOf(HasSubstr(name), HasSubstr("at most " + std::to_string(most)), HasSubstr(std::to_string(most + 1))));
      EXPECT_EQ(folder.file_count(), 0u) << name;
      triad::write_image(folder / name, side(most));
      EXPECT_EQ(stored<uint8_t>(folder / name, TypeDesc::UINT8).size(), 3u * static_cast<unsigned>(most));
      std::filesystem::remove(folder / name);
    }
}

TEST(ImageWriter, RoundsHalfUpAndClamps) {
  const Folder folder;
  Image image = picture(12, 1, {"Y"});
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  image.pixels = {0.f, 1.f, -.5f, 2.f, nan, inf, -inf, .5f, 127.5f / 255, 127.49f / 255, 1e-30f, -0.f};
  triad::write_image(folder / "a.png", image);
  EXPECT_THAT(stored<uint8_t>(folder / "a.png", TypeDesc::UINT8),
              testing::ElementsAre(0, 255, 0, 255, 0, 255, 0, 128, 128, 127, 0, 0));
  triad::write_image(folder / "a.tif", image, options_of(Depth::kUint16));
  EXPECT_THAT(stored<uint16_t>(folder / "a.tif", TypeDesc::UINT16),
              testing::ElementsAre(0, 65535, 0, 65535, 0, 65535, 0, 32768, 32768, 32765, 0, 0));
}

TEST(ImageWriter, EveryCodeSurvivesReadingAndWriting) {
  const Folder folder;
  Image image = picture(256, 256, {"Y"});
  for (int i = 0; i < 65536; ++i) image.pixels[i] = static_cast<float>(i) / 65535.f;
  for (const char* name : {"a.png", "a.tif"}) {
    triad::write_image(folder / name, image, options_of(Depth::kUint16));
    triad::write_image(folder / name, triad::read_image(folder / name), options_of(Depth::kUint16));
    const auto codes = stored<uint16_t>(folder / name, TypeDesc::UINT16);
    for (int i = 0; i < 65536; ++i) ASSERT_EQ(codes[i], i);
  }
}

TEST(ImageWriter, FloatsKeepEveryBitAndHalfClampsFiniteValues) {
  const Folder folder;
  Image image = picture(8, 1, {"Y"});
  const float inf = std::numeric_limits<float>::infinity();
  image.pixels = {1e30f, -1e30f, inf, -inf, 65504.f, 65519.f, 1e-8f, .1f};
  for (const char* name : {"a.exr", "a.tif"}) {
    triad::write_image(folder / name, image, options_of(Depth::kFloat));
    EXPECT_EQ(stored<float>(folder / name, TypeDesc::FLOAT), image.pixels);
    triad::write_image(folder / name, image, options_of(Depth::kHalf));
    const auto halves = triad::read_image(folder / name).pixels;
    // .1 as binary16 is 1638/2^14; 1e-8 is under half of the least subnormal, 2^-24.
    EXPECT_THAT(halves, testing::ElementsAre(65504.f, -65504.f, inf, -inf, 65504.f, 65504.f, 0.f, 1638.f / 16384));
  }
}

TEST(ImageWriter, AlphaIsUnassociatedForPngOnly) {
  const Folder folder;
  Image image = picture(3, 1, {"R", "G", "B", "A"});
  image.pixels = {.25f, .125f, 0.f, .5f, .75f, .3f, 0.f, 0.f, .2f, .4f, .6f, 1.f};
  triad::write_image(folder / "a.png", image);
  EXPECT_THAT(stored<uint8_t>(folder / "a.png", TypeDesc::UINT8),
              testing::ElementsAre(128, 64, 0, 128, 191, 77, 0, 0, 51, 102, 153, 255));
  triad::write_image(folder / "a.exr", image, options_of(Depth::kFloat));
  EXPECT_EQ(stored<float>(folder / "a.exr", TypeDesc::FLOAT), image.pixels);
  triad::write_image(folder / "a.tif", image);
  EXPECT_EQ(stored<float>(folder / "a.tif", TypeDesc::FLOAT), image.pixels);
}

class ImageWriterCuts : public testing::TestWithParam<std::pair<const char*, WriteOptions>> {};

TEST_P(ImageWriterCuts, SamePixelsGiveTheSameBytes) {
  const auto& [name, options] = GetParam();
  const Folder folder;
  const std::string path = folder / name;
  const bool no_alpha = path.ends_with("jpg") || path.ends_with("hdr");
  for (const int height : {1, 64, 131}) {
    Image image = no_alpha ? picture(37, height) : picture(37, height, {"R", "G", "B", "A"});
    image.spec.metadata.set("Artist", "somebody");
    triad::write_image(path, image, options);
    const std::string whole = bytes_of(path);
    for (const int strip : {1, 7, 64, 100}) {
      const auto writer = ImageWriter::open(path, image.spec, options);
      for (int y = 0; y < height; y += strip)
        writer->write_rows(y, std::min(height, y + strip), image.row(y), image.row_floats());
      writer->commit();
      EXPECT_TRUE(bytes_of(path) == whole) << "strips of " << strip;
    }
    EXPECT_EQ(triad::read_image(path).spec.height, height);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, ImageWriterCuts,
                         testing::Values(std::pair{"a.exr", options_of(Depth::kDefault)},
                                         std::pair{"b.exr", options_of(Depth::kFloat, "dwab:45")},
                                         std::pair{"c.exr", options_of(Depth::kHalf, "piz")},
                                         std::pair{"a.tif", options_of(Depth::kDefault)},
                                         std::pair{"b.tif", options_of(Depth::kUint8, "zip")},
                                         std::pair{"c.tif", options_of(Depth::kUint16, "lzw")},
                                         std::pair{"a.png", options_of(Depth::kDefault)},
                                         std::pair{"b.png", options_of(Depth::kUint16, "1")},
                                         std::pair{"a.jpg", options_of(Depth::kDefault, "jpeg:80")},
                                         std::pair{"a.hdr", options_of(Depth::kDefault)},
                                         std::pair{"a.tga", options_of(Depth::kDefault)}),
                         [](const auto& test) {
                           std::string name = test.param.first;
                           name[1] = '_';
                           return name;
                         });

TEST(ImageWriter, NoClockInTheFile) {
  const Folder folder;
  const Image image = picture(9, 5);
  const std::vector<std::string> extensions{"exr", "tif", "png", "jpg", "hdr", "tga", "bmp", "ppm"};
  for (const auto& extension : extensions) triad::write_image(folder / ("early." + extension), image);
  std::this_thread::sleep_for(std::chrono::milliseconds(1010));  // header times count seconds
  for (const auto& extension : extensions) {
    triad::write_image(folder / ("later." + extension), image);
    EXPECT_TRUE(bytes_of(folder / ("early." + extension)) == bytes_of(folder / ("later." + extension))) << extension;
  }
}

TEST(ImageWriter, CameraDataDoNotSpoilATiff) {
  const Folder folder;
  Image image = picture(9, 5);
  image.spec.colour_space = "sRGB";
  image.spec.metadata.set("Exif:FocalLength", "50");
  image.spec.metadata.set("ExposureTime", "0.01");
  image.spec.metadata.set("GPS:Altitude", "3");
  for (const Depth depth : {Depth::kUint8, Depth::kFloat}) {
    triad::write_image(folder / "a.tif", image, options_of(depth));
    EXPECT_EQ(triad::read_image(folder / "a.tif").spec.size_text(), "9x5 RGB");
  }
}

TEST(ImageWriter, HeaderSurvivesAChain) {
  const Folder folder;
  OIIO::ImageSpec spec(6, 4, 3, TypeDesc::HALF);
  spec.attribute("compression", "piz");
  spec.attribute("Artist", "somebody");
  spec.attribute("frame", 42);
  spec.attribute("exposure", .125f);
  spec.attribute("DateTime", "2020:01:02 03:04:05");
  const float matrix[16] = {1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 3, 0, 4, 5, 6, 1};
  spec.attribute("worldtocamera", TypeDesc::TypeMatrix, matrix);
  const int time_code[2] = {0x01020304, 0x05060708};
  spec.attribute("smpte:TimeCode", OIIO::TypeTimeCode, time_code);
  const float vector[3] = {1, 2, 3};
  spec.attribute("sun", TypeDesc(TypeDesc::FLOAT, TypeDesc::VEC3, TypeDesc::VECTOR), vector);
  const float xy[8] = {.713f, .293f, .165f, .83f, .128f, .044f, .32168f, .33767f};
  spec.attribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), xy);
  const std::vector<float> black(72);
  save(folder / "a.exr", spec, TypeDesc::FLOAT, black.data());

  Image image = triad::read_image(folder / "a.exr");
  EXPECT_EQ(image.spec.metadata.get("frame"), "42");
  EXPECT_EQ(image.spec.metadata.get("compression"), std::nullopt);
  image.spec.cells = {3, 1};
  image.spec.pixel_aspect = 1. / 3;
  image.spec.colour_space = "acescg";
  triad::write_image(folder / "b.exr", image);
  const auto input = OIIO::ImageInput::open(folder / "b.exr");
  ASSERT_TRUE(input);
  const auto& out = input->spec();
  EXPECT_EQ(out.get_string_attribute("Artist"), "somebody");
  EXPECT_EQ(out.get_int_attribute("frame"), 42);
  EXPECT_EQ(out.get_float_attribute("exposure"), .125f);
  EXPECT_EQ(out.get_string_attribute("DateTime"), "2020:01:02 03:04:05");
  EXPECT_EQ(out.get_string_attribute("compression"), "zip");
  float got[16];
  ASSERT_TRUE(out.getattribute("worldtocamera", TypeDesc::TypeMatrix, got));
  EXPECT_THAT(got, testing::ElementsAreArray(matrix));
  int code[2];
  ASSERT_TRUE(out.getattribute("smpte:TimeCode", OIIO::TypeTimeCode, code));
  EXPECT_THAT(code, testing::ElementsAreArray(time_code));
  ASSERT_TRUE(out.getattribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), got));
  for (int i = 0; i < 8; ++i) EXPECT_EQ(got[i], xy[i]);

  const Image again = triad::read_image(folder / "b.exr");
  EXPECT_EQ(again.spec.cells, (triad::Cells{3, 1}));
  EXPECT_EQ(again.spec.pixel_aspect, 1. / 3);
  EXPECT_EQ(again.spec.colour_space, "acescg");
  EXPECT_EQ(again.spec.metadata.entries(), image.spec.metadata.entries());

  // Colour was converted and the caller says so.
  image.spec.chromaticities.reset();
  triad::write_image(folder / "b.exr", image);
  EXPECT_FALSE(triad::read_image(folder / "b.exr").spec.chromaticities);

  triad::write_image(folder / "c.png", image, options_of(Depth::kUint16));
  const Image png = triad::read_image(folder / "c.png");
  EXPECT_EQ(png.spec.metadata.get("Artist"), "somebody");
  EXPECT_EQ(png.spec.cells, (triad::Cells{3, 1}));
  EXPECT_EQ(png.spec.colour_space, "acescg");
}

TEST(ImageWriter, PixelAspectReachesFormatsWithoutFreeText) {
  const Folder folder;
  Image image = picture(6, 4);
  for (const int n : {2, 3, 4, 12}) {
    image.spec.cells = {n, 1};
    image.spec.pixel_aspect = 1. / n;
    for (const char* name : {"a.tif", "a.jpg", "a.png", "a.exr"}) {
      triad::write_image(folder / name, image);
      EXPECT_EQ(triad::read_image(folder / name).spec.cells, image.spec.cells) << name;
      EXPECT_EQ(triad::read_image(folder / name).spec.pixel_aspect, 1. / n) << name;
    }
  }
}

TEST(ImageWriter, LinearPngSaysSo) {
  const Folder folder;
  Image image = picture(6, 4);
  image.spec.colour_space = "Linear";
  triad::write_image(folder / "a.png", image);
  EXPECT_EQ(triad::read_image(folder / "a.png").spec.colour_space, "Linear");
  const auto input = OIIO::ImageInput::open(folder / "a.png");
  EXPECT_EQ(input->spec().get_float_attribute("oiio:Gamma"), 1.f);
}

TEST(ImageWriter, NothingIsLeftWithoutCommit) {
  const Folder folder;
  const Image image = picture(100, 200);
  for (const char* name : {"a.exr", "a.tif", "a.png", "a.jpg", "a.hdr"}) {
    put_bytes(folder / name, "precious");
    {
      const auto writer = ImageWriter::open(folder / name, image.spec);
      writer->write_rows(0, 150, image.pixels.data(), image.row_floats());
    }
    EXPECT_EQ(bytes_of(folder / name), "precious");
    { const auto untouched = ImageWriter::open(folder / name, image.spec); }
    EXPECT_EQ(bytes_of(folder / name), "precious");
    EXPECT_EQ(folder.file_count(), 1u) << name;
    std::filesystem::remove(folder / name);
  }
  const auto writer = ImageWriter::open(folder / "a.exr", image.spec);
  EXPECT_THROW(writer->write_rows(1, 2, image.pixels.data(), image.row_floats()), triad::Error);
  EXPECT_THROW(writer->commit(), triad::Error);
}

TEST(ImageWriter, RefusesWhatAFormatCannotHold) {
  const Folder folder;
  const auto refuse = [&](const std::string& name, const Image& image, const WriteOptions& options = {}) {
    const std::string message = error_of([&] { triad::write_image(folder / name, image, options); });
    EXPECT_THAT(message, HasSubstr(name));
    EXPECT_EQ(folder.file_count(), 0u) << name;
    return message;
  };
  const Image rgba = picture(3, 2, {"R", "G", "B", "A"}), rgb = picture(3, 2), two = picture(3, 2, {"u", "v"});
  EXPECT_THAT(refuse("a.jpg", rgba), HasSubstr("no alpha"));
  EXPECT_THAT(refuse("a.hdr", rgba), HasSubstr("no alpha"));
  EXPECT_THAT(refuse("a.png", two), HasSubstr("--channels"));
  EXPECT_THAT(refuse("a.png", rgb, options_of(Depth::kHalf)), AllOf(HasSubstr("--depth half"), HasSubstr("8, 16")));
  EXPECT_THAT(refuse("a.exr", rgb, options_of(Depth::kUint8)), HasSubstr("half, float"));
  EXPECT_THAT(refuse("a.xyz", rgb), HasSubstr("'.xyz' is not known"));
  EXPECT_THAT(refuse("a", rgb), HasSubstr("no extension"));
  EXPECT_THAT(refuse("a.exr", rgb, options_of(Depth::kDefault, "pizz")), HasSubstr("did you mean 'piz'?"));
  EXPECT_THAT(refuse("a.jpg", rgb, options_of(Depth::kDefault, "jpeg:200")), HasSubstr("compression"));
  EXPECT_THAT(refuse("a.pfm", rgb), HasSubstr("exr, tif and hdr"));
  EXPECT_THAT(refuse("a.pgm", rgb), AllOf(HasSubstr("holds grey"), HasSubstr(".ppm")));
  EXPECT_THAT(error_of([&] { triad::write_image(folder / "none/a.exr", rgb); }), HasSubstr("folder"));
  EXPECT_THAT(error_of([&] { triad::parse_depth("12"); }), HasSubstr("8, 16, half, float"));
  EXPECT_EQ(triad::parse_depth("half"), Depth::kHalf);
  EXPECT_TRUE(triad::is_display_encoded_format("a.PNG", Depth::kDefault));
  EXPECT_TRUE(triad::is_display_encoded_format("a.tif", Depth::kUint16));
  EXPECT_FALSE(triad::is_display_encoded_format("a.tif", Depth::kDefault));
  EXPECT_FALSE(triad::is_display_encoded_format("a.exr", Depth::kDefault));
}

TEST(ImageWriter, AFullDiskIsOneClearError) {
  const Folder folder;
  const Image image = picture(200, 300);
  for (const char* name : {"a.exr", "a.tif", "a.png", "a.jpg", "a.hdr", "a.tga", "a.ppm", "b.tif"}) {
    const auto options = *name == 'b' ? options_of(Depth::kFloat, "zip") : WriteOptions{};
    triad::write_image(folder / name, image, options);
    const auto size = std::filesystem::file_size(folder / name);
    std::filesystem::remove(folder / name);
    // Limits that strike in the header, in the middle, and in the last byte.
    for (const auto limit : {uintmax_t{0}, uintmax_t{100}, size / 2, size - 1}) {
      rlimit before{};
      getrlimit(RLIMIT_FSIZE, &before);
      const rlimit most{limit, before.rlim_max};
      setrlimit(RLIMIT_FSIZE, &most);
      const std::string message = error_of([&] { triad::write_image(folder / name, image, options); });
      setrlimit(RLIMIT_FSIZE, &before);
      EXPECT_THAT(message, AllOf(HasSubstr("File too large"), HasSubstr(name))) << "with a limit of " << limit;
      EXPECT_EQ(folder.file_count(), 0u) << name << " with a limit of " << limit;
    }
    triad::write_image(folder / name, image, options);
    EXPECT_EQ(std::filesystem::file_size(folder / name), size);
    std::filesystem::remove(folder / name);
  }
}

TEST(ImageWriter, AReadOnlyFolderIsOneClearError) {
  const Folder folder;
  const Image image = picture(2, 2);
  chmod(folder.path().c_str(), 0555);
  const bool root = geteuid() == 0;
  if (root) {
    ASSERT_EQ(seteuid(65534), 0);  // "nobody": root may write anywhere
  }
  const std::string message = error_of([&] { triad::write_image(folder / "a.png", image); });
  if (root) {
    ASSERT_EQ(seteuid(0), 0);
  }
  EXPECT_THAT(message, AllOf(HasSubstr("Permission denied"), HasSubstr("a.png")));
  chmod(folder.path().c_str(), 0755);
  EXPECT_EQ(folder.file_count(), 0u);
}

namespace {

// What writing says on stderr.
std::string warnings_of(const std::string& path, const Image& image, Depth depth = Depth::kDefault) {
  testing::internal::CaptureStderr();
  triad::write_image(path, image, options_of(depth));
  return testing::internal::GetCapturedStderr();
}

}  // namespace

TEST(ImageWriter, ColourSpaceAndCellsSurviveOrAreMissedAloud) {
  const Folder folder;
  Image image = picture(6, 4);
  const struct {
    const char* name;
    Depth depth;
    std::string default_space;
    bool keeps;
  } files[] = {{"a.exr", Depth::kDefault, "Linear", true},  {"a.png", Depth::kUint8, "sRGB", true},
               {"b.png", Depth::kUint16, "sRGB", true},     {"a.tif", Depth::kFloat, "Linear", true},
               {"b.tif", Depth::kUint16, "sRGB", true},     {"c.tif", Depth::kUint8, "sRGB", true},
               {"a.jpg", Depth::kDefault, "sRGB", true},    {"a.tga", Depth::kDefault, "sRGB", true},
               {"a.hdr", Depth::kDefault, "Linear", false}, {"a.bmp", Depth::kDefault, "sRGB", false},
               {"a.ppm", Depth::kUint16, "sRGB", false}};
  for (const auto& [name, depth, default_space, keeps] : files) {
    for (const std::string space : {"acescg", "display_p3", "lin_rec709", "srgb", "Utility - Linear - P3"}) {
      for (const triad::Cells cells : {triad::Cells{1, 1}, triad::Cells{3, 1}, triad::Cells{3, 2}}) {
        image.spec.colour_space = space;
        image.spec.cells = cells;
        image.spec.pixel_aspect = static_cast<double>(cells.y) / cells.x;
        image.spec.metadata.set("ImageDescription", "strokes on black");
        const std::string path = folder / (std::to_string(cells.x * cells.y) + space.substr(0, 8) + name);
        const std::string said = warnings_of(path, image, depth);
        const auto read = triad::read_image(path).spec;
        const bool usual = space == (default_space == "sRGB" ? "srgb" : "lin_rec709");
        EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), keeps || (usual && cells.x == 1) ? 0 : 1) << path;
        if (keeps) {
          EXPECT_EQ(read.cells, cells) << path;
          EXPECT_EQ(read.metadata.get("ImageDescription"), "strokes on black") << path;
        } else if (cells.x != 1) {
          EXPECT_THAT(said, AllOf(HasSubstr(path), HasSubstr("--cells 3x" + std::to_string(cells.y))));
        }
        if (keeps && !usual) {
          EXPECT_EQ(read.colour_space, space) << path;
        }
        if (!keeps && !usual) {
          EXPECT_THAT(said, AllOf(HasSubstr(path), HasSubstr("--from " + space)));
        }
        if (usual) {
          EXPECT_THAT(read.colour_space, testing::AnyOf(default_space, space)) << path;
        }
        // Again and again through the same format: nothing piles up.
        if (!keeps) continue;
        const Image again = triad::read_image(path);
        triad::write_image(path, again, options_of(depth));
        EXPECT_EQ(triad::read_image(path).spec.metadata.entries(), again.spec.metadata.entries()) << path;
        EXPECT_EQ(triad::read_image(path).spec.colour_space, again.spec.colour_space) << path;
      }
    }
  }
  // A user's own name for the usual space, told by its primaries.
  image = picture(6, 4);
  image.spec.colour_space = "scene";
  image.spec.chromaticities = {.64f, .33f, .3f, .6f, .15f, .06f, .3127f, .329f};
  EXPECT_EQ(warnings_of(folder / "own.hdr", image), "");
  image.spec.chromaticities->front() = .68f;
  EXPECT_THAT(warnings_of(folder / "other.hdr", image), HasSubstr("--from scene"));
}

TEST(ImageWriter, GreyIsWrittenThreeTimesWhereOnlyRgbIs) {
  const Folder folder;
  Image image = picture(3, 2, {"Y"});
  image.pixels = {0, .25f, .5f, 1, 2, .125f};  // exact in Radiance's 8-bit mantissas
  triad::write_image(folder / "a.hdr", image);
  Image read = triad::read_image(folder / "a.hdr");
  EXPECT_EQ(read.spec.size_text(), "3x2 RGB");
  for (size_t i = 0; i < 18; ++i) EXPECT_EQ(read.pixels[i], image.pixels[i / 3]);
  triad::write_image(folder / "a.ppm", image);
  EXPECT_THAT(bytes_of(folder / "a.ppm"), testing::StartsWith("P6"));
  triad::write_image(folder / "a.pgm", image);
  EXPECT_THAT(bytes_of(folder / "a.pgm"), testing::StartsWith("P5"));
  read = triad::read_image(folder / "a.ppm");
  ASSERT_EQ(read.spec.channels.size(), 3u);
  EXPECT_EQ(read.pixels[3], 64.f / 255);
  EXPECT_EQ(read.pixels[5], 64.f / 255);
}

TEST(ImageWriter, BuffersGrowWithTheWidthAndNotTheHeight) {
  const Folder folder;
  const auto held = [&](const std::string& name, int width, int height, Depth depth = Depth::kDefault) {
    triad::ImageSpec spec = picture(1, 1).spec;
    spec.width = width;
    spec.height = height;
    return ImageWriter::open(folder / name, spec, options_of(depth))->buffer_bytes();
  };
  constexpr uint64_t kMega = 1 << 20, kGroup = uint64_t{64} * 1000 * 3 * sizeof(float);
  EXPECT_EQ(held("a.tif", 1000, 64), kMega + 2 * kGroup);
  EXPECT_EQ(held("a.tif", 1000, 5000), kMega + 2 * kGroup);
  EXPECT_EQ(held("a.tif", 3000, 64), kMega + 6 * kGroup);
  EXPECT_EQ(held("a.tif", 1000, 64, Depth::kUint8), kMega + kGroup / 2);
  EXPECT_EQ(held("a.exr", 1000, 64), kMega + 5 * kGroup);
  EXPECT_EQ(held("a.jpg", 1000, 64), kMega + 3 * kGroup / 4);
  EXPECT_EQ(folder.file_count(), 0u);
}
