// SPDX-License-Identifier: Apache-2.0
// Picture files made by OpenImageIO directly, to judge our reader and writer by.
#pragma once

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <triad/image/image.hpp>
#include <vector>

namespace picture_files {

// A folder that goes away with the test.
class Folder {
 public:
  Folder()
      : path_(std::filesystem::temp_directory_path() /
              ("triad-picture-" + std::to_string(getpid()) + "-" + std::to_string(counter()++))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }
  size_t file_count() const {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  static int& counter() {
    static int value = 0;
    return value;
  }
  std::filesystem::path path_;
};

// The same numbers everywhere, run after run (SplitMix64, Steele et al. 2014).
inline uint64_t hash(uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ x >> 27) * 0x94d049bb133111ebULL;
  return x ^ x >> 31;
}

template <typename T>
std::vector<T> noise(size_t count, T most) {
  std::vector<T> values(count);
  for (size_t i = 0; i < count; ++i)
    values[i] = static_cast<T>(static_cast<double>(most) * double(hash(i) >> 11) / 9007199254740992.);
  return values;
}

inline void check(bool ok, const OIIO::ImageOutput& out) {
  if (!ok) throw std::runtime_error(out.geterror());
}

// Writes a whole scanline or tiled picture from samples of `type`, packed.
inline void save(const std::string& path, const OIIO::ImageSpec& spec, OIIO::TypeDesc type, const void* samples) {
  const auto out = OIIO::ImageOutput::create(path);
  check(out && out->open(path, spec), *out);
  check(out->write_image(type, samples), *out);
  check(out->close(), *out);
}

inline std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
inline void put_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// Length, type, data and CRC-32 (PNG specification, annex D).
inline std::string png_chunk(const std::string& type, const std::string& data) {
  const auto big = [](uint32_t v) {
    return std::string{static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
                       static_cast<char>(v)};
  };
  uint32_t crc = 0xffffffff;
  for (const char c : type + data) {
    crc ^= static_cast<uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? 0xedb88320 ^ crc >> 1 : crc >> 1;
  }
  return big(static_cast<uint32_t>(data.size())) + type + data + big(~crc);
}

}  // namespace picture_files
