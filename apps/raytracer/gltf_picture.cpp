// SPDX-License-Identifier: Apache-2.0
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/image/reader.hpp>

#include "gltf.hpp"

namespace triad::raytracer::gltf {
namespace {

// Bytes under a file name, without touching the disk.
class MemoryFile {
 public:
  MemoryFile(const unsigned char* data, size_t size) : descriptor_(memfd_create("triad-picture", MFD_CLOEXEC)) {
    size_t done = 0;
    while (descriptor_ >= 0 && done < size) {
      const ssize_t count = write(descriptor_, data + done, size - done);
      if (count <= 0) break;
      done += static_cast<size_t>(count);
    }
    if (descriptor_ < 0 || done < size) {
      if (descriptor_ >= 0) close(descriptor_);
      throw_input("there is no memory for an embedded picture of " + std::to_string(size) + " bytes");
    }
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

// IEC 61966-2-1, the sRGB transfer function.
float srgb_to_linear(float v) { return v <= .04045f ? v / 12.92f : std::pow((v + .055f) / 1.055f, 2.4f); }

void decode_srgb(Texture& texture, bool eight_bits) {
  std::array<float, 256> table;
  for (size_t i = 0; i < table.size(); ++i) table[i] = srgb_to_linear(static_cast<float>(i) / 255.f);
  const auto channels = static_cast<size_t>(texture.channels);
  for (size_t i = 0; i < texture.texels.size(); i += channels)
    for (size_t c = 0; c < 3; ++c) {
      float& v = texture.texels[i + c];
      v = eight_bits ? table[static_cast<size_t>(std::lround(std::clamp(v, 0.f, 1.f) * 255.f))] : srgb_to_linear(v);
    }
}

// Throws Error(kInput) in the reader's words.
Texture decode(const std::string& path, bool colour) {
  ReadOptions options;
  options.straight_alpha = true;
  const auto reader = ImageReader::open(path, options);
  const ImageSpec& spec = reader->spec();
  if (spec.colour_channels != 1 && spec.colour_channels != 3)
    throw_input("cannot read '" + path + "': it is neither grey nor RGB");
  const auto width = static_cast<size_t>(spec.width), height = static_cast<size_t>(spec.height);
  const size_t from_channels = spec.channels.size();
  const bool grey = spec.colour_channels == 1, alpha = colour && spec.alpha >= 0;
  constexpr size_t kMostTexels = size_t{1} << 28;  // 16384 x 16384; 4 GB
  if (width * height > kMostTexels)
    throw_input("cannot read '" + path + "': " + spec.size_text() + " is too large for a texture (at most " +
                std::to_string(kMostTexels) + " pixels)");

  Texture texture;
  texture.width = spec.width;
  texture.height = spec.height;
  texture.channels = alpha ? 4 : 3;
  const auto to_channels = static_cast<size_t>(texture.channels);
  const int strip = std::min(std::max(64, reader->block_rows()), spec.height);
  std::vector<float> rows(static_cast<size_t>(strip) * width * from_channels);
  for (int y = 0; y < spec.height; y += strip) {
    const int end = std::min(spec.height, y + strip);
    reader->read_rows(y, end, rows.data(), width * from_channels);
    const size_t pixels = static_cast<size_t>(end - y) * width;
    texture.texels.reserve(texture.texels.size() + pixels * to_channels);
    for (size_t i = 0; i < pixels; ++i) {
      const float* from = rows.data() + i * from_channels;
      for (size_t c = 0; c < 3; ++c) texture.texels.push_back(from[grey ? 0 : c]);
      if (alpha) texture.texels.push_back(from[spec.alpha]);
    }
  }
  for (const float v : texture.texels)
    if (!std::isfinite(v)) throw_input("cannot read '" + path + "': it has pixels that are not finite");
  const std::string& type = reader->info().pixel_type;
  if (colour && type.rfind("uint", 0) == 0) decode_srgb(texture, type == "uint8");
  return texture;
}

}  // namespace

Texture read_picture_file(const File& file, const std::string& uri, bool colour, const std::string& user) {
  const std::string path = file.resolve(uri);
  try {
    Texture texture = decode(path, colour);
    texture.name = path;
    return texture;
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kInput) throw;
    file.fail(user + ": " + error.what());
  }
}

Texture read_picture(const File& file, int index, bool colour) {
  const auto& image = file.model.images[static_cast<size_t>(index)];
  const std::string user = describe("image", static_cast<size_t>(index), image.name);
  if (image.bufferView < 0 && image.image.empty()) return read_picture_file(file, image.uri, colour, user);
  const unsigned char* data = image.image.data();
  size_t size = image.image.size();
  if (image.bufferView >= 0) {
    const auto& view = file.at(file.model.bufferViews, image.bufferView, "buffer view", user);
    const auto& buffer = file.at(file.model.buffers, view.buffer, "buffer", user);
    if (view.byteOffset > buffer.data.size() || view.byteLength > buffer.data.size() - view.byteOffset)
      file.fail(user + " is out of bounds: its buffer view reaches past the end of its buffer");
    data = buffer.data.data() + view.byteOffset;
    size = view.byteLength;
  }
  const MemoryFile memory(data, size);
  try {
    Texture texture = decode(memory.path(), colour);
    texture.name = image.name.empty() ? user : image.name;
    return texture;
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kInput) throw;
    std::string why = error.what();  // names a file that nobody knows
    if (const std::string known = "cannot read '" + memory.path() + "': "; why.rfind(known, 0) == 0)
      why.erase(0, known.size());
    file.fail(user + " cannot be decoded: " + why);
  }
}

}  // namespace triad::raytracer::gltf
