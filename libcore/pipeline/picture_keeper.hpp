// SPDX-License-Identifier: Apache-2.0
// Pictures that a Run holds in memory; for run_execute.cpp only.
#pragma once

#include <cstring>
#include <new>
#include <string>
#include <triad/base/error.hpp>
#include <triad/image/writer.hpp>

namespace triad {

// A picture to hold rows of what is made of the input `path`.
inline Image blank_image(const ImageSpec& spec, const std::string& path) {
  Image image{spec, {}};
  try {
    image.pixels.resize(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height) * spec.channels.size());
  } catch (const std::bad_alloc&) {
    throw_input("out of memory: '" + path + "' could not be held whole; see --max-memory");
  }
  return image;
}

// Fills a picture in memory.
class PictureKeeper final : public ImageWriter {
 public:
  explicit PictureKeeper(Image& image) : image_(image) {}
  void write_rows(int y0, int y1, const float* pixels, size_t row_stride) override {
    for (int y = y0; y < y1; ++y)
      std::memcpy(image_.row(y), pixels + static_cast<size_t>(y - y0) * row_stride,
                  image_.row_floats() * sizeof(float));
  }
  void commit() override {}
  uint64_t buffer_bytes() const override { return 0; }

 private:
  Image& image_;
};

}  // namespace triad
