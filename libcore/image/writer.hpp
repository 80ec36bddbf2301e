// SPDX-License-Identifier: Apache-2.0
// Writing picture files by strips, atomically.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <triad/image/image.hpp>

namespace triad {

enum class Depth { kDefault, kUint8, kUint16, kHalf, kFloat };
// "8", "16", "half", "float". Throws Error(kUsage) naming --depth.
Depth parse_depth(const std::string& text);

struct WriteOptions {
  Depth depth = Depth::kDefault;  // EXR half, HDR float, PNG and JPEG 8, TIFF float; see also `like`
  std::string compression;        // "" the format's default (EXR zip, PNG 6, TIFF none, JPEG quality 95) ...
                                  // "none", "zip", "piz", "dwaa:45", "lzw", "jpeg:95" as OpenImageIO names them
};

// Whether a file of this name stores display-encoded integers, and so wants "sRGB" values, or scene-linear
// floats. Throws Error(kUsage) for an extension that no writer knows, with the list of those that are known.
bool is_display_encoded_format(const std::string& path, Depth depth);

// A file being written. Not thread-safe: one thread at a time.
//
// Values are written as they are, clamped to the stored range where it is an integer one (not-a-number
// becomes 0) and rounded half up. Alpha is un-associated for the formats that store it so. Metadata,
// colour space, pixel aspect and "triad:cells" go into the header (EXR, PNG) or the description text (TIFF, JPEG,
// TGA, and only what a reader would not take for granted); formats that can say neither (HDR, BMP, PPM, PGM) are
// a warning that names what a reader must be told. Grey becomes RGB in HDR and PPM, which know nothing else.
// The file appears under its name at commit(); without it, nothing is left behind.
class ImageWriter {
 public:
  // Throws Error: folder missing or not writable, format unknown or unable to hold the size, channels or depth.
  static std::unique_ptr<ImageWriter> open(const std::string& path, const ImageSpec& spec,
                                           const WriteOptions& options = {});
  virtual ~ImageWriter() = default;

  // Rows [y0, y1), ascending and gapless from 0; row y begins at pixels + (y - y0) * row_stride floats.
  // Throws Error(kInput) with the file's name and the system's reason, e.g. no space left on the device.
  virtual void write_rows(int y0, int y1, const float* pixels, size_t row_stride) = 0;
  // After the last row: closes the file and gives it its name.
  virtual void commit() = 0;

  // Roughly what the writer and its encoder hold at their peak, whatever the height: 1 MB, and as measured twice a
  // group of 64 rows as stored (JPEG three times, EXR five times).
  virtual uint64_t buffer_bytes() const = 0;
};

void write_image(const std::string& path, const Image& image, const WriteOptions& options = {});

}  // namespace triad
