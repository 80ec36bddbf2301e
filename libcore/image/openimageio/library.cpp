// SPDX-License-Identifier: Apache-2.0
#include <OpenImageIO/imageio.h>

#include <triad/base/text.hpp>
#include <triad/image/internal/picture_library.hpp>

namespace triad::image {

// reader.cpp, writer.cpp
std::unique_ptr<ImageReader> open_reader(const std::string& path, const std::string& format,
                                         const ReadOptions& options);
std::unique_ptr<ImageWriter> open_writer(const std::string& path, Encoding&& encoding, const WriteOptions& options);

namespace {

std::string format_of_extension(const std::string& extension) {
  std::string table;
  OIIO::getattribute("extension_list", table);
  for (const auto& entry : split_quoted(table, ';')) {
    const size_t colon = entry.find(':');
    if (colon == std::string::npos) continue;
    for (const auto& known : split_quoted(entry.substr(colon + 1), ','))
      if (known == extension) return entry.substr(0, colon);
  }
  return "";
}

}  // namespace
}  // namespace triad::image

const triad::image::PictureLibrary* triad_picture_library() {
  using namespace triad::image;
  static const PictureLibrary library{open_reader, open_writer, format_of_extension};
  return &library;
}
