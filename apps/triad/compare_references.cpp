// SPDX-License-Identifier: Apache-2.0
#include "compare_references.hpp"

#include <algorithm>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/pipeline/picture_source.hpp>

namespace triad::app {
namespace {

// Decoded; a 1920 x 1080 picture takes 25 MB. Of larger ones the metrics' own work hides the decoding.
constexpr uint64_t kMostKept_bytes = uint64_t{64} << 20;
// What is looked through for a value that is not black, and at most at a time.
constexpr uint64_t kMostSearched_bytes = uint64_t{512} << 20, kStrip_bytes = uint64_t{16} << 20;
constexpr int kStripRows = 64;

bool all_zero(const ImageSpec& spec, const float* rows, size_t pixels) {
  const size_t channels = spec.channels.size();
  const size_t colours = spec.colour_channels > 0 ? static_cast<size_t>(spec.colour_channels) : channels;
  for (size_t i = 0; i < pixels; ++i)
    for (size_t c = 0; c < colours; ++c)
      if (rows[i * channels + c] != 0) return false;
  return true;
}

// Warns if the picture is black. The picture, if `keeps` and it is small.
std::shared_ptr<const Image> look_through(const std::string& path, const ReadOptions& read,
                                          const ColourConfig& colours, bool keeps) {
  const std::unique_ptr<PictureSource> source = open_file_source(path, read, colours);
  const ImageSpec& spec = source->spec();
  const size_t stride = static_cast<size_t>(spec.width) * spec.channels.size();
  const uint64_t bytes = static_cast<uint64_t>(stride) * static_cast<uint64_t>(spec.height) * sizeof(float);
  keeps = keeps && bytes <= kMostKept_bytes;
  const uint64_t row_bytes = stride * sizeof(float);
  const int strip = static_cast<int>(std::clamp<uint64_t>(kStrip_bytes / row_bytes, 1, kStripRows));
  auto image = std::make_shared<Image>();
  image->spec = spec;
  // Most pictures show in their first rows that they are not black; then the others are not read.
  bool black = bytes <= kMostSearched_bytes;
  if (keeps || black)
    image->pixels.resize(stride * static_cast<size_t>(keeps ? spec.height : std::min(strip, spec.height)));
  for (int y = 0; y < spec.height && (keeps || black); y += strip) {
    check_cancel();
    const int end = std::min(y + strip, spec.height);
    float* rows = image->pixels.data() + (keeps ? stride * static_cast<size_t>(y) : 0);
    source->read_rows({y, end}, rows, stride);
    black = black && all_zero(spec, rows, static_cast<size_t>(end - y) * static_cast<size_t>(spec.width));
  }
  if (black) warn("the reference '" + path + "' is black: all its values are 0");
  return keeps ? image : nullptr;
}

}  // namespace

References::References(ReadOptions read, const std::vector<ComparePair>& pairs, const ColourConfig& colours)
    : read_(std::move(read)), colours_(colours) {
  if (!read_.colour_space.empty()) colours.require(read_.colour_space, "--ref-from");  // or it would be named --from
  for (const ComparePair& pair : pairs) ++uses_[pair.reference];
}

PictureRequest References::get(const std::string& path) {
  if (path == known_) return {path, read_, kept_};
  kept_ = nullptr;
  known_.clear();  // until it is known to be good
  kept_ = look_through(path, read_, colours_, uses_[path] > 1);
  known_ = path;
  return {path, read_, kept_};
}

void warn_of_black(const std::string& path, const ReadOptions& read, const ColourConfig& colours) {
  look_through(path, read, colours, false);
}

}  // namespace triad::app
