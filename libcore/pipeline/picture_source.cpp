// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <triad/colour/file_space.hpp>
#include <triad/pipeline/picture_source.hpp>

namespace triad {
namespace {

class FileSource final : public PictureSource {
 public:
  FileSource(const std::string& path, const ReadOptions& options, const ColourConfig& config)
      : reader_(ImageReader::open(path, options)), spec_(reader_->spec()) {
    spec_.colour_space = file_colour_space(*reader_, options.colour_space, config);
  }
  const ImageSpec& spec() const override { return spec_; }
  void read_rows(RowRange rows, float* out, size_t row_stride) override {
    reader_->read_rows(rows.y0, rows.y1, out, row_stride);
  }
  uint64_t memory_bytes() const override {
    // The block cache, and what the decoder holds of its own, which is about as much again.
    return reader_->decoder_bytes() + uint64_t{2} * static_cast<uint64_t>(reader_->block_rows()) * spec_.width *
                                          spec_.channels.size() * sizeof(float);
  }

 private:
  std::unique_ptr<ImageReader> reader_;
  ImageSpec spec_;
};

class MemorySource final : public PictureSource {
 public:
  explicit MemorySource(const Image& image) : image_(image) {}
  const ImageSpec& spec() const override { return image_.spec; }
  void read_rows(RowRange rows, float* out, size_t row_stride) override {
    for (int y = rows.y0; y < rows.y1; ++y)
      std::memcpy(out + static_cast<size_t>(y - rows.y0) * row_stride, image_.row(y),
                  image_.row_floats() * sizeof(float));
  }
  uint64_t memory_bytes() const override { return 0; }  // counted where the picture is held

 private:
  const Image& image_;
};

}  // namespace

std::unique_ptr<PictureSource> open_file_source(const std::string& path, const ReadOptions& options,
                                                const ColourConfig& config) {
  return std::make_unique<FileSource>(path, options, config);
}

std::unique_ptr<PictureSource> memory_source(const Image& image) { return std::make_unique<MemorySource>(image); }

}  // namespace triad
