// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <triad/image/internal/file_check.hpp>
#include <triad/image/internal/picture_library.hpp>
#include <triad/image/reader.hpp>

namespace triad {

std::unique_ptr<ImageReader> ImageReader::open(const std::string& path, const ReadOptions& options) {
  const std::string format = image::recognise_format(path);
  image::check_header(path, format);
  return image::picture_library().open_reader(path, format, options);
}

Image read_image(const std::string& path, const ReadOptions& options) {
  const auto reader = ImageReader::open(path, options);
  Image image;
  image.spec = reader->spec();
  // Only address space: pages are touched row by row, so a lying header is found out before it costs memory.
  constexpr size_t kMostReserved = size_t{1} << 30;  // floats
  image.pixels.reserve(std::min(image.row_floats() * image.spec.height, kMostReserved));
  const int strip = std::max(64, reader->block_rows());
  for (int y = 0; y < image.spec.height; y += strip) {
    const int end = std::min(image.spec.height, y + strip);
    image.pixels.resize(static_cast<size_t>(end) * image.row_floats());
    reader->read_rows(y, end, image.row(y), image.row_floats());
  }
  return image;
}

}  // namespace triad
