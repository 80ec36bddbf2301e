// SPDX-License-Identifier: Apache-2.0
// Files that are broken: each is one clear error or, by luck, a complete picture; never a crash, never black rows.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <OpenImageIO/deepdata.h>

#include <chrono>
#include <triad/base/error.hpp>
#include <triad/image/reader.hpp>

#include "picture_files.hpp"

using namespace picture_files;
using namespace std::string_literals;
using OIIO::TypeDesc;
using testing::AllOf;
using testing::HasSubstr;

namespace {

// The error of reading a whole picture, "" for none; checks that it is one line that names the file.
std::string error_of(const std::string& path, triad::Image* image = nullptr) {
  try {
    triad::Image read = triad::read_image(path);
    if (image) *image = std::move(read);
    return "";
  } catch (const triad::Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.kind(), triad::ErrorKind::kInput);
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_THAT(message, HasSubstr(path));
    EXPECT_NE(message.back(), '.') << message;
    return message;
  }
}

struct Sample {
  const char* name;
  const char* compression;
  TypeDesc type;
  int tile;
};

const std::vector<Sample>& samples() {
  static const std::vector<Sample> list{
      {"none.exr", "none", TypeDesc::HALF, 0},  {"rle.exr", "rle", TypeDesc::HALF, 0},
      {"zip.exr", "zip", TypeDesc::FLOAT, 0},   {"piz.exr", "piz", TypeDesc::HALF, 0},
      {"dwaa.exr", "dwaa", TypeDesc::HALF, 0},  {"b44.exr", "b44", TypeDesc::HALF, 0},
      {"tiled.exr", "zip", TypeDesc::HALF, 16}, {"8.png", "", TypeDesc::UINT8, 0},
      {"16.png", "", TypeDesc::UINT16, 0},      {"none.tif", "none", TypeDesc::FLOAT, 0},
      {"zip.tif", "zip", TypeDesc::UINT8, 0},   {"zip16.tif", "zip", TypeDesc::UINT16, 0},
      {"lzw.tif", "lzw", TypeDesc::FLOAT, 0},   {"tiled.tif", "zip", TypeDesc::UINT8, 16},
      {"a.hdr", "", TypeDesc::FLOAT, 0},        {"a.jpg", "", TypeDesc::UINT8, 0}};
  return list;
}

class BrokenFile : public testing::TestWithParam<Sample> {
 protected:
  BrokenFile() {
    const auto& param = GetParam();
    path_ = folder_ / param.name;
    OIIO::ImageSpec spec(41, 53, 3, param.type);
    if (*param.compression) spec.attribute("compression", param.compression);
    spec.tile_width = spec.tile_height = param.tile;
    const auto values = noise<float>(41 * 53 * 3, 1.f);
    save(path_, spec, TypeDesc::FLOAT, values.data());
    bytes_ = bytes_of(path_);
    whole_ = triad::read_image(path_);
  }
  Folder folder_;
  std::string path_, bytes_;
  triad::Image whole_;
};

}  // namespace

TEST_P(BrokenFile, TruncatedAnywhereIsAnErrorOrWhole) {
  // Every length near both ends, where headers and tables are, and others between.
  size_t errors = 0, tries = 0;
  const size_t n = bytes_.size();
  for (size_t length = 0; length < n; length += length < 400 || length + 40 > n ? 7 : std::max<size_t>(1, n / 50)) {
    put_bytes(path_, bytes_.substr(0, length));
    triad::Image image;
    const std::string error = error_of(path_, &image);
    ++tries;
    if (!error.empty())
      ++errors;
    else
      ASSERT_TRUE(image.pixels == whole_.pixels) << "cut at " << length << " of " << n;
  }
  EXPECT_GE(errors + 6, tries);  // only padding and end marks may be missing without harm
}

TEST_P(BrokenFile, FlippedBytesDoNotCrash) {
  for (uint64_t i = 0; i < 150; ++i) {
    std::string broken = bytes_;
    // Half of them in the first 300 bytes: the header.
    const size_t within = i % 2 ? std::min<size_t>(300, broken.size()) : broken.size();
    for (uint64_t k = 0; k < 1 + i % 3; ++k)
      broken[hash(i * 10 + k) % within] = static_cast<char>(hash(i * 10 + k + 5) & 0xff);
    put_bytes(path_, broken);
    triad::Image image;
    if (error_of(path_, &image).empty()) {
      EXPECT_EQ(image.pixels.size(), image.row_floats() * static_cast<size_t>(image.spec.height));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, BrokenFile, testing::ValuesIn(samples()), [](const auto& test) {
  std::string name = test.param.name;
  name[name.find('.')] = '_';
  return name;
});

TEST(ImageErrors, NotAPicture) {
  const Folder folder;
  EXPECT_THAT(error_of(folder / "none.png"), HasSubstr("No such file"));
  EXPECT_THAT(error_of(folder.path()), HasSubstr("is a folder"));
  mkfifo((folder / "pipe.png").c_str(), 0600);
  EXPECT_THAT(error_of(folder / "pipe.png"), HasSubstr("not a regular file"));
  for (const char* extension : {"exr", "png", "tif", "hdr", "jpg", "tga", "bmp", "ppm", "txt", "psd", "gif", "sgi"}) {
    const std::string path = folder / ("a."s + extension);
    put_bytes(path, "");
    EXPECT_THAT(error_of(path), HasSubstr("it is empty"));
    put_bytes(path, "It was a dark and stormy night; the rain fell in torrents, except at intervals\n");
    EXPECT_NE(error_of(path), "") << extension;
    put_bytes(path, std::string(5000, '\0'));
    EXPECT_NE(error_of(path), "") << extension;
  }
  put_bytes(folder / "none", "text");
  EXPECT_THAT(error_of(folder / "none"), HasSubstr("not a picture"));
  EXPECT_THAT(error_of(folder / "a.png"), HasSubstr("not those of a png picture"));
}

TEST(ImageErrors, ContentsCountMoreThanTheExtension) {
  const Folder folder;
  const std::vector<float> half(12, .5f);
  save(folder / "a.exr", OIIO::ImageSpec(2, 2, 3, TypeDesc::HALF), TypeDesc::FLOAT, half.data());
  std::filesystem::rename(folder / "a.exr", folder / "a.png");
  EXPECT_EQ(triad::read_image(folder / "a.png").pixels, half);
}

namespace {

std::string little32(uint32_t v) {
  return {static_cast<char>(v), static_cast<char>(v >> 8), static_cast<char>(v >> 16), static_cast<char>(v >> 24)};
}
std::string big32(uint32_t v) {
  const std::string little = little32(v);
  return {little.rbegin(), little.rend()};
}

std::string exr_attribute(const std::string& name, const std::string& type, const std::string& value) {
  return name + '\0' + type + '\0' + little32(static_cast<uint32_t>(value.size())) + value;
}

std::string exr_header(uint32_t width, uint32_t height, char compression, uint32_t tile = 0) {
  const std::string box = little32(0) + little32(0) + little32(width - 1) + little32(height - 1);
  std::string channels;
  for (const char* name : {"B", "G", "R"})
    channels += std::string(name) + '\0' + little32(2) + little32(0) + little32(1) + little32(1);
  std::string header = little32(20000630) + little32(tile ? 0x202 : 2);
  header += exr_attribute("channels", "chlist", channels + '\0');
  header += exr_attribute("compression", "compression", std::string(1, compression));
  header += exr_attribute("dataWindow", "box2i", box) + exr_attribute("displayWindow", "box2i", box);
  header += exr_attribute("lineOrder", "lineOrder", "\0"s) +
            exr_attribute("pixelAspectRatio", "float", little32(0x3f800000));
  header += exr_attribute("screenWindowCenter", "v2f", std::string(8, '\0'));
  header += exr_attribute("screenWindowWidth", "float", little32(0x3f800000));
  if (tile) header += exr_attribute("tiles", "tiledesc", little32(tile) + little32(tile) + '\0');
  return header + '\0';
}

std::string tiff_header(uint32_t width, uint32_t height, uint16_t compression) {
  const uint16_t fields[][2] = {{256, 0}, {257, 0}, {258, 8}, {259, compression}, {262, 1}, {273, 200},
                                {277, 1}, {278, 0}, {279, 0}};
  std::string file = "II*\0"s + little32(8) + std::string("\x09\0", 2);
  for (const auto& [tag, value] : fields) {
    const uint32_t stored = tag == 256 ? width : tag == 257 || tag == 278 ? height : tag == 279 ? 1000u : value;
    file += little32(tag).substr(0, 2) + "\4\0"s + little32(1) + little32(stored);
  }
  return file + little32(0) + std::string(2000, 'x');
}

int64_t peak_kb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

}  // namespace

TEST(ImageErrors, AMillionSquaredIsRefusedAtOnce) {
  const Folder folder;
  constexpr uint32_t kMillion = 1000000;
  const std::string tail(2000, 'x');
  std::vector<std::pair<std::string, std::string>> files;
  for (char compression = 0; compression < 10; ++compression) {
    files.emplace_back("a" + std::to_string(compression) + ".exr",
                       exr_header(kMillion, kMillion, compression) + tail);
    files.emplace_back("w" + std::to_string(compression) + ".exr", exr_header(2000000000, 1, compression) + tail);
  }
  files.emplace_back("t.exr", exr_header(kMillion, kMillion, 3, 64) + tail);
  files.emplace_back("u.exr", exr_header(10, 10, 3, kMillion) + tail);
  for (const char interlaced : {'\0', '\1'})
    files.emplace_back("a"s + (interlaced ? "i" : "p") + ".png",
                       "\x89PNG\r\n\x1a\n" +
                           png_chunk("IHDR", big32(kMillion) + big32(kMillion) + "\x10\x06\0\0"s + interlaced) +
                           png_chunk("IDAT", tail) + png_chunk("IEND", ""));
  files.emplace_back("a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 1000000\n" + tail);
  // A baseline and a progressive JPEG of 65535 x 65535, the most that format can claim.
  for (const char marker : {'\xc0', '\xc2'})
    files.emplace_back("a"s + (marker == '\xc0' ? "b" : "p") + ".jpg",
                       "\xff\xd8\xff"s + marker + "\0\x11\x08\xff\xff\xff\xff\3\1\x11\0\2\x11\0\3\x11\0"s + tail);
  for (const uint16_t compression : std::initializer_list<uint16_t>{1, 5, 8, 32773})
    files.emplace_back("a" + std::to_string(compression) + ".tif", tiff_header(kMillion, kMillion, compression));
  files.emplace_back("a.pfm", "PF\n1000000 1000000\n-1.0\n" + tail);
  files.emplace_back("a.ppm", "P6\n1000000 1000000\n255\n" + tail);
  files.emplace_back("a.tga", "\0\0\2\0\0\0\0\0\0\0\0\0\xff\xff\xff\xff\x20\x08"s + tail);
  const int64_t before = peak_kb();
  const auto start = std::chrono::steady_clock::now();
  for (const auto& [name, bytes] : files) {
    put_bytes(folder / name, bytes);
    const std::string error = error_of(folder / name);
    EXPECT_NE(error, "") << name;
    if (name.ends_with("exr") || name.ends_with("png") || name.ends_with("hdr") || name.ends_with("tif")) {
      EXPECT_THAT(error, testing::AnyOf(HasSubstr("absurd"), HasSubstr("claimed in a file of"))) << name;
    }
  }
  // Reading what is claimed would take hours; a busy machine gets its time.
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
  EXPECT_LT(peak_kb() - before, 100000);  // a sanitizer keeps freed memory, too
}

TEST(ImageErrors, DeepDataSayWhatToDo) {
  const Folder folder;
  OIIO::ImageSpec spec(2, 2, 2, TypeDesc::FLOAT);
  spec.channelnames = {"A", "Z"};
  spec.deep = true;
  OIIO::DeepData deep;
  deep.init(spec);
  for (int64_t i = 0; i < 4; ++i) deep.set_samples(i, 1);
  const auto out = OIIO::ImageOutput::create("a.exr");
  check(out->open(folder / "a.exr", spec), *out);
  check(out->write_deep_scanlines(0, 2, 0, deep), *out);
  check(out->close(), *out);
  EXPECT_THAT(error_of(folder / "a.exr"), AllOf(HasSubstr("deep"), HasSubstr("flatten")));
}

TEST(ImageErrors, DamageIsFoundWhereItIs) {
  // Rows before the damage are right; the damage is an error each time, not only the first.
  const Folder folder;
  OIIO::ImageSpec spec(64, 64, 3, TypeDesc::FLOAT);
  spec.attribute("compression", "zip");
  const auto values = noise<float>(64 * 64 * 3, 1.f);
  save(folder / "a.exr", spec, TypeDesc::FLOAT, values.data());
  std::string bytes = bytes_of(folder / "a.exr");
  put_bytes(folder / "a.exr", bytes.substr(0, bytes.size() - 100));  // within the last block of 16 rows
  const auto reader = triad::ImageReader::open(folder / "a.exr");
  std::vector<float> rows(64 * 16 * 3);
  reader->read_rows(0, 16, rows.data(), 64 * 3);
  EXPECT_TRUE(std::equal(rows.begin(), rows.end(), values.begin()));
  for (int i = 0; i < 2; ++i) EXPECT_THROW(reader->read_rows(48, 64, rows.data(), 64 * 3), triad::Error);
}

namespace {

// 4x4 pixels of zeros, uncompressed: `photometric` as TIFF 6.0 numbers it, `format` 1 for integers, 3 for floats.
std::string tiff_of(uint16_t photometric, uint16_t samples, uint16_t bits, uint16_t format) {
  const auto little16 = [](uint16_t v) { return little32(v).substr(0, 2); };
  const uint32_t lists = 8 + 2 + 11 * 12 + 4, data = lists + 4u * samples, length = 16u * samples * bits / 8;
  const uint32_t fields[][3] = {{256, 1, 4},
                                {257, 1, 4},
                                {258, samples, lists},
                                {259, 1, 1},
                                {262, 1, photometric},
                                {273, 1, data},
                                {277, 1, samples},
                                {278, 1, 4},
                                {279, 1, length},
                                {284, 1, 1},
                                {339, samples, lists + 2u * samples}};
  std::string file = "II*\0"s + little32(8) + little16(11);
  for (const auto& [tag, count, value] : fields)
    file += little16(static_cast<uint16_t>(tag)) + (tag == 273 || tag == 279 ? "\4\0"s : "\3\0"s) + little32(count) +
            little32(value);
  file += little32(0);
  for (int i = 0; i < samples; ++i) file += little16(bits);
  for (int i = 0; i < samples; ++i) file += little16(format);
  return file + std::string(length, '\0');
}

}  // namespace

TEST(ImageErrors, AColourModelThatIsNotReadIsNoCorruptFile) {
  const Folder folder;
  constexpr uint16_t kRgb = 2, kCmyk = 5, kYcc = 6, kLab = 8, kIntegers = 1, kFloats = 3;
  put_bytes(folder / "rgb.tif", tiff_of(kRgb, 3, 32, kFloats));
  EXPECT_EQ(error_of(folder / "rgb.tif"), "");
  put_bytes(folder / "cmyk8.tif", tiff_of(kCmyk, 4, 8, kIntegers));
  EXPECT_EQ(error_of(folder / "cmyk8.tif"), "");
  for (const auto& [photometric, samples] : {std::pair{kCmyk, 4}, {kYcc, 3}, {kLab, 3}}) {
    put_bytes(folder / "a.tif", tiff_of(photometric, static_cast<uint16_t>(samples), 32, kFloats));
    const std::string error = error_of(folder / "a.tif");
    EXPECT_THAT(error, AllOf(HasSubstr("colour model is not supported"), HasSubstr("convert it to RGB")));
    EXPECT_THAT(error, testing::Not(HasSubstr("corrupt")));
  }
}
