// SPDX-License-Identifier: Apache-2.0
// Reading by strips: any cut gives the same rows, and no block is decoded twice.
#include <gtest/gtest.h>

#include <cstring>
#include <triad/image/reader.hpp>

#include "picture_files.hpp"

using namespace picture_files;
using OIIO::TypeDesc;
using triad::ImageReader;

namespace {

// A file whose rows are decoded in blocks, one after another or a few at a time.
struct Blocked {
  const char* name;
  const char* compression;
  int tile_width, tile_height, block_rows;
};

class ImageStrips : public testing::TestWithParam<Blocked> {};

void expect_rows(ImageReader& reader, const triad::Image& whole, int y0, int y1) {
  const size_t row = whole.row_floats();
  const size_t stride = row + 5;
  const float guard = -12345.f;
  std::vector<float> strip(stride * static_cast<size_t>(y1 - y0), guard);
  reader.read_rows(y0, y1, strip.data(), stride);
  for (int y = y0; y < y1; ++y) {
    const float* got = strip.data() + static_cast<size_t>(y - y0) * stride;
    ASSERT_EQ(std::memcmp(got, whole.row(y), row * sizeof(float)), 0) << "row " << y << " of " << y0 << ".." << y1;
    for (size_t i = row; i < stride; ++i) ASSERT_EQ(got[i], guard);
  }
}

}  // namespace

TEST_P(ImageStrips, AnyCutGivesTheSameRows) {
  const auto& param = GetParam();
  const Folder folder;
  const std::string path = folder / param.name;
  const int w = 53, h = 307;
  const bool integer = path.ends_with("png") || path.ends_with("jpg");
  OIIO::ImageSpec spec(w, h, 3, integer ? TypeDesc::UINT8 : TypeDesc::HALF);
  if (path.ends_with("tif") || path.ends_with("hdr")) spec.set_format(TypeDesc::FLOAT);
  if (*param.compression) spec.attribute("compression", param.compression);
  spec.tile_width = param.tile_width;
  spec.tile_height = param.tile_height;
  const auto samples = noise<float>(static_cast<size_t>(w * h * 3), 1.f);
  save(path, spec, TypeDesc::FLOAT, samples.data());

  // The judge: OpenImageIO reads the whole picture at once.
  const auto input = OIIO::ImageInput::open(path);
  ASSERT_TRUE(input);
  std::vector<float> judge(samples.size());
  ASSERT_TRUE(input->read_image(0, 0, 0, 3, TypeDesc::FLOAT, judge.data()));
  const triad::Image whole = triad::read_image(path);
  for (size_t i = 0; i < judge.size(); ++i) ASSERT_NEAR(whole.pixels[i], judge[i], 1.3e-7 * judge[i]);

  const auto reader = ImageReader::open(path);
  EXPECT_EQ(reader->block_rows(), param.block_rows);
  for (const int strip : {1, 7, 16, 64, 100, 306, 307})
    for (int y = 0; y < h; y += strip) expect_rows(*reader, whole, y, std::min(h, y + strip));
  // Overlapping strips, as filters with a vertical extent ask for, then any order.
  for (int y = 0; y < h; y += 20) expect_rows(*reader, whole, std::max(0, y - 9), std::min(h, y + 29));
  for (uint64_t i = 0; i < 25; ++i) {
    const int y0 = static_cast<int>(hash(i) % h), y1 = y0 + static_cast<int>(hash(i + 100) % 40);
    expect_rows(*reader, whole, y0, std::min(h, y1));
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, ImageStrips,
                         testing::Values(Blocked{"a.exr", "none", 0, 0, 1}, Blocked{"a.exr", "rle", 0, 0, 1},
                                         Blocked{"a.exr", "zips", 0, 0, 1}, Blocked{"a.exr", "zip", 0, 0, 16},
                                         Blocked{"a.exr", "piz", 0, 0, 32}, Blocked{"a.exr", "pxr24", 0, 0, 16},
                                         Blocked{"a.exr", "b44", 0, 0, 32}, Blocked{"a.exr", "b44a", 0, 0, 32},
                                         Blocked{"a.exr", "dwaa", 0, 0, 32}, Blocked{"a.exr", "dwab", 0, 0, 256},
                                         Blocked{"a.exr", "zip", 16, 32, 32}, Blocked{"a.exr", "none", 64, 64, 64},
                                         Blocked{"a.exr", "piz", 7, 5, 5}, Blocked{"a.tif", "none", 0, 0, 1},
                                         Blocked{"a.tif", "zip", 0, 0, 32}, Blocked{"a.tif", "lzw", 0, 0, 32},
                                         Blocked{"a.tif", "none", 32, 16, 16}, Blocked{"a.tif", "zip", 16, 48, 48},
                                         Blocked{"a.png", "", 0, 0, 1}, Blocked{"a.jpg", "", 0, 0, 1},
                                         Blocked{"a.hdr", "", 0, 0, 1}),
                         [](const auto& test) {
                           const auto& p = test.param;
                           return std::string(p.name + 2) + "_" + p.compression +
                                  (p.tile_width ? "_tiled" + std::to_string(p.tile_width) : "");
                         });

TEST(ImageStripsOnce, AscendingStripsDecodeABlockOnce) {
  const Folder folder;
  const int w = 200, h = 512;
  const auto samples = noise<float>(static_cast<size_t>(w * h * 3), 1.f);
  const auto bytes_read = [] {  // by this process, whatever the source
    std::ifstream io("/proc/self/io");
    std::string key;
    int64_t value = 0;
    io >> key >> value;
    return value;
  };
  for (const char* compression : {"zip", "piz", "dwab", "tiled"}) {
    const bool tiled = std::string(compression) == "tiled";
    const std::string path = folder / (std::string(compression) + ".exr");
    OIIO::ImageSpec spec(w, h, 3, TypeDesc::FLOAT);
    spec.attribute("compression", tiled ? "zip" : compression);
    if (tiled) spec.tile_width = spec.tile_height = 64;
    save(path, spec, TypeDesc::FLOAT, samples.data());
    const auto size = static_cast<double>(std::filesystem::file_size(path));
    const auto reader = ImageReader::open(path);
    std::vector<float> rows(static_cast<size_t>(w * 9 * 3));
    const int64_t before = bytes_read();
    for (int y = 0; y < h; y += 9) reader->read_rows(y, std::min(h, y + 9), rows.data(), static_cast<size_t>(w * 3));
    EXPECT_LT(static_cast<double>(bytes_read() - before), 1.3 * size) << compression;
  }
}

// As windows over several scales ask for them: each strip shares most of its rows with the one before. A decoder that
// began at the top for each would read the file many times.
TEST(ImageStripsOnce, OverlappingStripsDecodeARowOnce) {
  const Folder folder;
  const int w = 700, h = 1200, new_rows = 40, shared_rows = 100;
  const auto samples = noise<float>(static_cast<size_t>(w * h * 3), 1.f);
  const auto bytes_read = [] {
    std::ifstream io("/proc/self/io");
    std::string key;
    int64_t value = 0;
    io >> key >> value;
    return value;
  };
  for (const char* name : {"a.png", "a.tif"}) {
    const std::string path = folder / name;
    save(path, OIIO::ImageSpec(w, h, 3, TypeDesc::UINT16), TypeDesc::FLOAT, samples.data());
    const auto size = static_cast<double>(std::filesystem::file_size(path));
    const triad::Image whole = triad::read_image(path);
    const auto reader = ImageReader::open(path);
    const int64_t before = bytes_read();
    for (int y = 0; y < h; y += new_rows)
      expect_rows(*reader, whole, std::max(0, y - shared_rows), std::min(h, y + new_rows));
    EXPECT_LT(static_cast<double>(bytes_read() - before), 1.3 * size) << name;
    expect_rows(*reader, whole, 0, h);  // a second pass
  }
}
