// SPDX-License-Identifier: Apache-2.0
// What can be told about a picture file before a decoder is let loose on it. Not installed.
#pragma once

#include <cstdint>
#include <string>

namespace triad::image {

// OpenImageIO's name of the format: by the file's first bytes ("openexr", "png", "tiff", "jpeg", "hdr"), else
// by its extension. Throws Error(kInput) when the path is missing, no regular file, empty or no picture.
std::string recognise_format(const std::string& path);

// Reads the header of EXR, PNG, JPEG and HDR files itself and throws Error(kInput) when it is cut short, holds
// deep data, or claims more pixels than a file of this length can hold in this compression. Decoders allocate
// what a header claims; after this check that is bounded by the length of the file. Other formats pass.
void check_header(const std::string& path, const std::string& format);

// Whether a PNG is interlaced or a JPEG stored in several scans, so that no row is known before the last byte.
// Only for files that passed check_header(); false for other formats.
bool is_interleaved(const std::string& path, const std::string& format);

// Throws Error(kInput) unless a file of `file_bytes` can hold a picture that is `raw_bytes` long uncompressed,
// at most `ratio` to one.
void check_length(const std::string& path, uint64_t file_bytes, double raw_bytes, double ratio);

// Throws Error(kInput) for sides outside 1 .. 2^31-1 and for more than 2^40 samples.
void check_size(const std::string& path, int64_t width, int64_t height, int64_t channels);

uint64_t file_size(const std::string& path);

}  // namespace triad::image
