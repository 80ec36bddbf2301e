// SPDX-License-Identifier: Apache-2.0
#include "internal/file_check.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/image/internal/picture_library.hpp>

namespace triad::image {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw_input("cannot read '" + path + "': " + why);
}

// Bytes of a file in order; running out of them is the user's truncated file.
class ByteReader {
 public:
  explicit ByteReader(const std::string& path)
      : path_(path), stream_(path, std::ios::binary), size_(file_size(path)) {}
  uint64_t position() { return static_cast<uint64_t>(stream_.tellg()); }
  uint64_t size() const { return size_; }
  void read(void* out, size_t n) {
    if (!stream_.read(static_cast<char*>(out), static_cast<std::streamsize>(n))) truncated();
  }
  uint8_t byte() {
    uint8_t b = 0;
    read(&b, 1);
    return b;
  }
  uint16_t big16() {
    const int high = byte();
    return static_cast<uint16_t>(high << 8 | byte());
  }
  uint32_t big32() {
    const uint32_t high = big16();
    return high << 16 | big16();
  }
  uint32_t little32() {
    uint8_t b[4];
    read(b, 4);
    return b[0] | b[1] << 8 | b[2] << 16 | static_cast<uint32_t>(b[3]) << 24;
  }
  void skip(uint64_t n) {
    if (n > size_ - position()) truncated();
    stream_.seekg(static_cast<std::streamoff>(n), std::ios::cur);
  }
  // Up to and without the byte `end`.
  std::string text(char end, size_t longest) {
    std::string result;
    for (char c = static_cast<char>(byte()); c != end; c = static_cast<char>(byte())) {
      if (result.size() == longest) refuse(path_, "its header is corrupt");
      result += c;
    }
    return result;
  }
  [[noreturn]] void truncated() { refuse(path_, "it is cut short in the header"); }

 private:
  const std::string& path_;
  std::ifstream stream_;
  uint64_t size_;
};

// Deflate needs at least 1 bit for 258 bytes: 1032 to 1 (RFC 1951 has no shorter code).
constexpr double kDeflateRatio = 1032;

void check_png(const std::string& path) {
  ByteReader in(path);
  in.skip(8);
  const uint32_t length = in.big32();
  char type[4];
  in.read(type, 4);
  if (length != 13 || std::memcmp(type, "IHDR", 4) != 0) refuse(path, "its PNG header is corrupt");
  const uint32_t width = in.big32(), height = in.big32();
  const int bits = in.byte(), colour = in.byte();
  static constexpr int kSamples[7] = {1, 0, 3, 1, 2, 0, 4};
  if (colour > 6 || kSamples[colour] == 0) refuse(path, "its PNG header is corrupt");
  check_size(path, width, height, kSamples[colour]);
  const double row_bytes = 1 + std::floor((static_cast<double>(width) * kSamples[colour] * bits + 7) / 8);
  check_length(path, in.size(), row_bytes * height, kDeflateRatio);
  // From here on only lengths are looked at: libpng would print its complaint about a cut file by itself.
  in.skip(7);
  for (;;) {
    const uint32_t chunk = in.big32();
    in.read(type, 4);
    if (chunk > 0x7fffffff || in.size() - in.position() < uint64_t{chunk} + 4) refuse(path, "it is cut short");
    if (std::memcmp(type, "IEND", 4) == 0) return;
    in.skip(uint64_t{chunk} + 4);
  }
}

void check_jpeg(const std::string& path) {
  ByteReader in(path);
  in.skip(2);
  for (;;) {
    if (in.byte() != 0xff) refuse(path, "its JPEG header is corrupt");
    int marker = in.byte();
    while (marker == 0xff) marker = in.byte();
    if (marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8)) continue;
    const int length = in.big16();
    if (length < 2) refuse(path, "its JPEG header is corrupt");
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (!frame) {
      if (marker == 0xd9 || marker == 0xda) refuse(path, "its JPEG header is corrupt");
      in.skip(static_cast<uint64_t>(length - 2));
      continue;
    }
    in.skip(1);
    const int height = in.big16(), width = in.big16(), components = in.byte();
    check_size(path, width, height, components);
    // The largest component's 8x8 blocks take at least one bit each in the DC scan: 512 samples to a byte.
    check_length(path, in.size(), static_cast<double>(width) * height, 512);
    return;
  }
}

void check_hdr(const std::string& path) {
  ByteReader in(path);
  constexpr size_t kLongestLine = 4096;
  while (!in.text('\n', kLongestLine).empty()) {
  }
  const std::string line = in.text('\n', kLongestLine);
  char sign[2], axis[2];
  long long size[2];
  if (std::sscanf(line.c_str(), "%c%c %lld %c%c %lld", &sign[0], &axis[0], &size[0], &sign[1], &axis[1], &size[1]) !=
      6)
    refuse(path, "its Radiance header has no resolution line such as '-Y 225 +X 400'");
  const bool rows_first = axis[0] == 'Y';
  check_size(path, size[rows_first ? 1 : 0], size[rows_first ? 0 : 1], 3);
  // Run lengths of at most 127 pixels for two bytes in each of four planes; the older scheme shifts its
  // counts, and so reaches further for pixels that do not change at all.
  check_length(path, in.size(), static_cast<double>(size[0]) * static_cast<double>(size[1]), 4096);
}

struct ExrPart {
  int compression = -1;
  int64_t data[4] = {0, 0, -1, -1}, display[4] = {0, 0, -1, -1};  // x0 y0 x1 y1, inclusive
  uint32_t tile_x = 0, tile_y = 0;
  bool tiled = false;
  int64_t channels = 0;
  double pixel_bytes = 0;
  std::string type;
};

// Rows of a scanline block, and the bound on raw over stored bytes, for the header's compression byte: none,
// RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB. PXR24 halves floats before it deflates; PIZ has runs of
// up to 255 16-bit values for about 10 bits; DWA keeps one deflated number of an 8x8 block.
constexpr int kExrRows[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
constexpr double kExrRatio[] = {1, 128, 1032, 1032, 1032, 2064, 16, 32, 264192, 264192};

void read_exr_attribute(ByteReader& in, const std::string& path, const std::string& name, const std::string& type,
                        uint32_t size, ExrPart& part) {
  const uint64_t end = in.position() + size;
  if (size > in.size() || end > in.size()) in.truncated();
  if (name == "compression" && type == "compression" && size == 1) {
    part.compression = in.byte();
  } else if ((name == "dataWindow" || name == "displayWindow") && type == "box2i" && size == 16) {
    for (auto& side : name == "dataWindow" ? part.data : part.display) side = static_cast<int32_t>(in.little32());
  } else if (name == "tiles" && type == "tiledesc" && size == 9) {
    part.tiled = true;
    part.tile_x = in.little32();
    part.tile_y = in.little32();
  } else if (name == "type" && type == "string" && size < 64) {
    part.type.resize(size);
    in.read(part.type.data(), size);
  } else if (name == "channels" && type == "chlist") {
    while (in.position() < end && !in.text('\0', 255).empty()) {
      part.pixel_bytes += in.little32() == 1 ? 2 : 4;
      in.skip(4);
      if (in.little32() != 1 || in.little32() != 1)
        refuse(path, "it has subsampled channels, which Triad does not read");
      ++part.channels;
    }
  }
  if (in.position() > end) refuse(path, "its EXR header is corrupt");
  in.skip(end - in.position());
}

void check_exr_part(const std::string& path, uint64_t file_bytes, const ExrPart& part) {
  if (part.compression < 0 || part.compression > 9 || part.channels == 0) refuse(path, "its EXR header is corrupt");
  const int64_t width = part.data[2] - part.data[0] + 1, height = part.data[3] - part.data[1] + 1;
  const int64_t full_width = part.display[2] - part.display[0] + 1,
                full_height = part.display[3] - part.display[1] + 1;
  check_size(path, width, height, part.channels);
  check_size(path, full_width, full_height, part.channels);
  const double pixels = static_cast<double>(width) * static_cast<double>(height);
  const double full_pixels = static_cast<double>(full_width) * static_cast<double>(full_height);
  // A display window is free to be larger than the data, but not out of all proportion: rows of zeros would
  // otherwise be produced without end from a file of a few bytes.
  constexpr double kMostDisplay = 1 << 28;  // pixels; an 8K film frame has 2^25
  if (full_pixels > kMostDisplay && full_pixels > 64 * pixels)
    refuse(path, "its display window of " + std::to_string(full_width) + "x" + std::to_string(full_height) +
                     " pixels is absurd for a data window of " + std::to_string(width) + "x" +
                     std::to_string(height));
  double blocks = std::ceil(static_cast<double>(height) / kExrRows[part.compression]);
  if (part.tiled) {
    constexpr double kMostTile = 1 << 28;  // bytes; 4096 x 4096 RGBA in float
    if (part.tile_x == 0 || part.tile_y == 0 ||
        static_cast<double>(part.tile_x) * part.tile_y * part.pixel_bytes > kMostTile)
      refuse(path, "its tiles of " + std::to_string(part.tile_x) + "x" + std::to_string(part.tile_y) +
                       " pixels are absurd");
    blocks =
        std::ceil(static_cast<double>(width) / part.tile_x) * std::ceil(static_cast<double>(height) / part.tile_y);
  }
  check_length(path, file_bytes, blocks * 8, 1);  // the table of offsets, one of 8 bytes for each block
  check_length(path, file_bytes, pixels * part.pixel_bytes, kExrRatio[part.compression]);
}

void check_exr(const std::string& path) {
  ByteReader in(path);
  in.skip(4);
  const uint32_t version = in.little32();
  const bool single_tiled = version & 0x200, deep = version & 0x800, multi_part = version & 0x1000;
  if ((version & 0xff) != 2) refuse(path, "it is not of EXR version 2");
  if (deep) refuse(path, "it holds deep data, which Triad does not read; flatten it first");
  for (;;) {
    ExrPart part;
    std::string name = in.text('\0', 255);
    if (name.empty() && multi_part) return;  // the empty header after the last part
    while (!name.empty()) {
      const std::string type = in.text('\0', 255);
      const uint32_t size = in.little32();
      read_exr_attribute(in, path, name, type, size, part);
      name = in.text('\0', 255);
    }
    part.tiled = part.type.empty() ? single_tiled : part.type == "tiledimage";
    if (part.type.rfind("deep", 0) == 0)
      refuse(path, "it holds deep data, which Triad does not read; flatten it first");
    check_exr_part(path, in.size(), part);
    if (!multi_part) return;
  }
}

// OpenImageIO's name of the format that has this extension; "" if none has.
std::string format_of_extension(const std::string& path) {
  const std::string extension = lower(std::filesystem::path(path).extension().string());
  if (extension.size() < 2) return "";
  // The common ones need not wait for the library that knows them all.
  static constexpr struct {
    const char *extension, *format;
  } kCommon[] = {{".exr", "openexr"}, {".png", "png"},   {".tif", "tiff"}, {".tiff", "tiff"},
                 {".jpg", "jpeg"},    {".jpeg", "jpeg"}, {".hdr", "hdr"}};
  for (const auto& common : kCommon)
    if (extension == common.extension) return common.format;
  return picture_library().format_of_extension(extension.substr(1));
}

// A still picture of pixels.
bool is_still(const std::string& format) {
  for (const char* other : {"", "null", "term", "raw", "ffmpeg", "openvdb"})
    if (format == other) return false;
  return true;
}

}  // namespace

uint64_t file_size(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 ? static_cast<uint64_t>(info.st_size) : 0;
}

void check_size(const std::string& path, int64_t width, int64_t height, int64_t channels) {
  constexpr int64_t kMostSide = 2147483647;       // int
  constexpr double kMostSamples = 1099511627776;  // 2^40
  if (width < 1 || height < 1 || width > kMostSide || height > kMostSide ||
      static_cast<double>(width) * static_cast<double>(height) * static_cast<double>(channels) > kMostSamples)
    refuse(path, "its header claims an absurd size: " + std::to_string(width) + "x" + std::to_string(height) +
                     " pixels of " + std::to_string(channels) + " channels");
}

void check_length(const std::string& path, uint64_t file_bytes, double raw_bytes, double ratio) {
  constexpr double kSlack = 4096;  // bytes: what is stored of a tiny picture may round down to nothing
  if (raw_bytes > static_cast<double>(file_bytes) * ratio + (ratio > 1 ? kSlack : 0))
    refuse(path, "it is cut short or its header is corrupt: " + format_bytes(static_cast<uint64_t>(raw_bytes)) +
                     " of pixels are claimed in a file of " + format_bytes(file_bytes));
}

std::string recognise_format(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) refuse(path, std::strerror(errno));
  if (S_ISDIR(info.st_mode)) refuse(path, "it is a folder");
  if (!S_ISREG(info.st_mode)) refuse(path, "it is not a regular file");
  if (info.st_size == 0) refuse(path, "it is empty");
  std::ifstream stream(path, std::ios::binary);
  char bytes[12] = {};
  stream.read(bytes, sizeof bytes);
  if (!stream.is_open() || stream.gcount() == 0) refuse(path, std::strerror(errno));
  const std::string start(bytes, static_cast<size_t>(stream.gcount()));
  const auto begins = [&start](std::string_view magic) {
    return std::string_view(start).substr(0, magic.size()) == magic;
  };
  using namespace std::string_view_literals;
  if (begins("\x76\x2f\x31\x01"sv)) return "openexr";
  if (begins("\x89PNG\r\n\x1a\n"sv)) return "png";
  if (begins("II*\0"sv) || begins("MM\0*"sv) || begins("II+\0"sv) || begins("MM\0+"sv)) return "tiff";
  if (begins("\xff\xd8"sv)) return "jpeg";
  if (begins("#?RADIANCE"sv) || begins("#?RGBE"sv)) return "hdr";

  const std::string format = format_of_extension(path);
  const std::string extension = std::filesystem::path(path).extension().string();
  for (const char* strict : {"openexr", "png", "tiff", "jpeg", "hdr"})
    if (format == strict) refuse(path, "its contents are not those of a " + lower(extension).substr(1) + " picture");
  if (is_still(format)) return format;
  if (!format.empty()) refuse(path, "it is not a picture that Triad reads");
  refuse(path, "it is not a picture that Triad reads (EXR, PNG, TIFF, HDR, JPEG ...)");
}

bool is_interleaved(const std::string& path, const std::string& format) {
  ByteReader in(path);
  if (format == "png") {
    in.skip(28);  // signature, length and name of the chunk IHDR, and all of it but the interlace method
    return in.byte() != 0;
  }
  if (format != "jpeg") return false;
  in.skip(2);
  int components = 0;
  for (;;) {  // segments, until the first scan
    int marker = in.byte();
    while (marker == 0xff) marker = in.byte();
    if (marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8)) continue;
    const int length = in.big16();
    if (length < 3) return false;
    if (marker == 0xda) return in.byte() < components;
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    // ITU-T T.81, table B.1: progressive are SOF 2, 6, 10 and 14.
    if (frame && (marker & 3) == 2) return true;
    if (frame && length >= 8) {
      in.skip(5);
      components = in.byte();
      in.skip(static_cast<uint64_t>(length - 8));
    } else {
      in.skip(static_cast<uint64_t>(length - 2));
    }
  }
}

void check_header(const std::string& path, const std::string& format) {
  if (format == "png") check_png(path);
  if (format == "jpeg") check_jpeg(path);
  if (format == "hdr") check_hdr(path);
  if (format == "openexr") check_exr(path);
}

}  // namespace triad::image

namespace triad {

bool has_picture_extension(const std::string& path) { return image::is_still(image::format_of_extension(path)); }

}  // namespace triad
