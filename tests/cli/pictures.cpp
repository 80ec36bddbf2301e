// SPDX-License-Identifier: Apache-2.0
#include "pictures.hpp"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <stdexcept>

namespace cli {
namespace {

template <typename Integer>
void append(std::string* bytes, Integer value) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof value);
}

// The head of a classic TIFF, little-endian: 8 bits, RGB, uncompressed, one strip after the other from its end on.
std::string tiff_claim(uint32_t width, uint32_t height) {
  constexpr uint32_t kRowsPerStrip = 4;
  const uint32_t strips = (height + kRowsPerStrip - 1) / kRowsPerStrip;
  constexpr uint16_t kShort = 3, kLong = 4;
  struct Entry {
    uint16_t tag, type;
    uint32_t count, value;
  };
  const uint32_t directory_bytes = 2 + 10 * 12 + 4;
  const uint32_t bits_at = 8 + directory_bytes, offsets_at = bits_at + 8, counts_at = offsets_at + strips * 4;
  const uint32_t pixels_at = counts_at + strips * 4;
  const Entry entries[] = {{256, kLong, 1, width},
                           {257, kLong, 1, height},
                           {258, kShort, 3, bits_at},
                           {259, kShort, 1, 1},  // no compression
                           {262, kShort, 1, 2},  // RGB
                           {273, kLong, strips, offsets_at},
                           {277, kShort, 1, 3},
                           {278, kLong, 1, kRowsPerStrip},
                           {279, kLong, strips, counts_at},
                           {284, kShort, 1, 1}};  // interleaved
  std::string bytes("II*\0\x08\0\0\0", 8);
  append<uint16_t>(&bytes, 10);
  for (const Entry& entry : entries) {
    append(&bytes, entry.tag);
    append(&bytes, entry.type);
    append(&bytes, entry.count);
    append(&bytes, entry.value);
  }
  append<uint32_t>(&bytes, 0);
  for (int i = 0; i < 4; ++i) append<uint16_t>(&bytes, 8);
  for (uint32_t i = 0; i < strips; ++i) append(&bytes, pixels_at + width * 3 * kRowsPerStrip * i);
  for (uint32_t i = 0; i < strips; ++i)
    append(&bytes, width * 3 * std::min(kRowsPerStrip, height - i * kRowsPerStrip));
  return bytes;
}

uint32_t crc32(const std::string& bytes) {  // as PNG wants it
  uint32_t crc = ~0u;
  for (const char byte : bytes) {
    crc ^= static_cast<uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

std::string png_chunk(const std::string& type, const std::string& data) {
  const auto big_endian = [](uint32_t value) {
    const char bytes[] = {static_cast<char>(value >> 24), static_cast<char>(value >> 16),
                          static_cast<char>(value >> 8), static_cast<char>(value)};
    return std::string(bytes, 4);
  };
  return big_endian(static_cast<uint32_t>(data.size())) + type + data + big_endian(crc32(type + data));
}

std::string png_claim(uint32_t width, uint32_t height) {
  std::string header;
  for (const uint32_t side : {width, height})
    for (int shift = 24; shift >= 0; shift -= 8) header += static_cast<char>(side >> shift);
  header += std::string("\x08\x02\0\0\0", 5);  // 8 bits, RGB
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) +
         png_chunk("IDAT", std::string("\x78\x9c\x03\0\0\0\0\x01", 8)) + png_chunk("IEND", "");
}

std::string exr_claim(const std::string& path, uint32_t width, uint32_t height) {
  save(path, constant(4, 4, {0, 0, 0}));
  std::string bytes = load_text(path);
  for (const std::string name : {"dataWindow", "displayWindow"}) {
    const std::string head = name + std::string("\0box2i\0\x10\0\0\0", 11);
    const size_t at = bytes.find(head);
    if (at == std::string::npos) throw std::runtime_error("no " + name);
    const int32_t corners[4] = {0, 0, static_cast<int32_t>(width - 1), static_cast<int32_t>(height - 1)};
    std::memcpy(bytes.data() + at + head.size(), corners, sizeof corners);
  }
  return bytes;
}

}  // namespace

Picture constant(int width, int height, std::vector<float> colour) {
  return from_function(width, height, static_cast<int>(colour.size()),
                       [&](int, int, int c) { return colour[static_cast<size_t>(c)]; });
}

Picture from_function(int width, int height, int channels, const std::function<double(int, int, int)>& value) {
  Picture picture;
  picture.width = width;
  picture.height = height;
  picture.channels = channels;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c) picture.values.push_back(static_cast<float>(value(x, y, c)));
  return picture;
}

Picture noise(int width, int height, int channels, uint32_t seed) {
  std::mt19937 random(seed);
  return from_function(width, height, channels,
                       [&](int, int, int) { return static_cast<double>(random()) * 0x1p-32; });
}

void save(const std::string& path, const Picture& picture, const std::string& type) {
  OIIO::ImageSpec spec(picture.width, picture.height, picture.channels,
                       type.empty() ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc(type));
  if (!picture.channel_names.empty()) spec.channelnames = picture.channel_names;
  for (const auto& [key, value] : picture.text) spec.attribute(key, value);
  if (picture.pixel_aspect != 1) spec.attribute("PixelAspectRatio", static_cast<float>(picture.pixel_aspect));
  const auto output = OIIO::ImageOutput::create(path);
  if (!output || !output->open(path, spec) || !output->write_image(OIIO::TypeDesc::FLOAT, picture.values.data()) ||
      !output->close())
    throw std::runtime_error("cannot write " + path + ": " + (output ? output->geterror() : OIIO::geterror()));
}

Picture load(const std::string& path) {
  const auto input = OIIO::ImageInput::open(path);
  if (!input) throw std::runtime_error("cannot read " + path + ": " + OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  Picture picture;
  picture.width = spec.width;
  picture.height = spec.height;
  picture.channels = spec.nchannels;
  picture.channel_names = spec.channelnames;
  picture.pixel_aspect = spec.get_float_attribute("PixelAspectRatio", 1);
  picture.pixel_type = spec.format.c_str();
  for (const auto& attribute : spec.extra_attribs) picture.text[attribute.name().string()] = attribute.get_string();
  picture.values.resize(static_cast<size_t>(spec.width) * spec.height * spec.nchannels);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, picture.values.data()))
    throw std::runtime_error("cannot read " + path + ": " + input->geterror());
  return picture;
}

void save_text(const std::string& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  if (!(stream << text).flush()) throw std::runtime_error("cannot write " + path);
}

std::string load_text(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw std::runtime_error("cannot read " + path);
  return text.str();
}

void truncate_copy(const std::string& from, const std::string& to, double share) {
  const std::string bytes = load_text(from);
  save_text(to, bytes.substr(0, static_cast<size_t>(share * static_cast<double>(bytes.size()))));
}

void save_claim(const std::string& path, uint32_t width, uint32_t height) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".exr") return save_text(path, exr_claim(path, width, height));
  if (extension == ".png") return save_text(path, png_claim(width, height));
  if (extension == ".tif") {
    const std::string head = tiff_claim(width, height);
    save_text(path, head);
    const uint64_t bytes = head.size() + uint64_t{width} * height * 3;
    if (bytes <= UINT32_MAX) std::filesystem::resize_file(path, bytes);
    return;
  }
  if (extension == ".hdr")
    return save_text(path, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) + " +X " +
                               std::to_string(width) + "\n\1\2\3\4");
  throw std::runtime_error("no such claim: " + path);
}

double srgb_encode(double linear) {
  return linear <= .0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - .055;
}

double srgb_decode(double encoded) {
  return encoded <= .04045 ? encoded / 12.92 : std::pow((encoded + .055) / 1.055, 2.4);
}

}  // namespace cli
