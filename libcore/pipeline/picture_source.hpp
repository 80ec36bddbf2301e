// SPDX-License-Identifier: Apache-2.0
// Where rows come from: a file, or a picture held in memory between two parts of a chain.
#pragma once

#include <memory>
#include <string>
#include <triad/colour/colour.hpp>
#include <triad/image/reader.hpp>
#include <triad/pipeline/strip_buffer.hpp>

namespace triad {

// Not thread-safe: one thread at a time.
class PictureSource {
 public:
  virtual ~PictureSource() = default;
  // colour_space is a name of the colour configuration, or "" for values that are not colour.
  virtual const ImageSpec& spec() const = 0;
  virtual void read_rows(RowRange rows, float* out, size_t row_stride) = 0;
  virtual uint64_t memory_bytes() const = 0;  // held while the source is open
};

// Opens a file. What it says about its colours is looked up in `config`; a statement that the configuration
// does not know is a warning, and the format's usual space is taken. Throws as ImageReader::open does.
std::unique_ptr<PictureSource> open_file_source(const std::string& path, const ReadOptions& options,
                                                const ColourConfig& config);

// Rows of `image`, which must outlive the source.
std::unique_ptr<PictureSource> memory_source(const Image& image);

}  // namespace triad
