// SPDX-License-Identifier: Apache-2.0
// What reads and writes picture files, and OpenImageIO with it: a library of its own that is loaded with the first
// picture, because loading takes a tenth of a second (OpenImageIO brings some 260 libraries), which help, errors of
// options, lists and renders to nowhere need not wait for. Not installed.
#pragma once

#include <memory>
#include <string>
#include <triad/image/internal/writer_format.hpp>
#include <triad/image/reader.hpp>

namespace triad::image {

struct PictureLibrary {
  // `format` as recognise_format() says it, of a file that passed check_header(). Throws as ImageReader::open does.
  std::unique_ptr<ImageReader> (*open_reader)(const std::string& path, const std::string& format,
                                              const ReadOptions& options);
  // Throws as ImageWriter::open does.
  std::unique_ptr<ImageWriter> (*open_writer)(const std::string& path, Encoding&& encoding,
                                              const WriteOptions& options);
  // OpenImageIO's name of the format that has this extension (in lower case, without a dot); "" if none has.
  std::string (*format_of_extension)(const std::string& extension);
};

// Loads it if it is not there yet. Thread-safe. Throws Error(kInput) if it cannot be loaded.
const PictureLibrary& picture_library();

}  // namespace triad::image

// The one symbol that picture_library() looks up.
extern "C" const triad::image::PictureLibrary* triad_picture_library();
