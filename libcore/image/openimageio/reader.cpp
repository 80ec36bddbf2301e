// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <triad/base/error.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/image/internal/file_check.hpp>
#include <triad/image/internal/header.hpp>
#include <triad/image/internal/picture_library.hpp>

namespace triad::image {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& what, const std::string& detail) {
  throw_input("cannot read '" + path + "': " + what + (detail.empty() ? "" : ": " + one_line(detail, path)));
}

class OiioReader final : public ImageReader {
 public:
  OiioReader(const std::string& path, const std::string& format, const ReadOptions& options) : path_(path) {
    prepare_oiio();
    input_ = OIIO::ImageInput::create(format);
    if (!input_) fail(path, "this OpenImageIO cannot read " + format, OIIO::geterror());
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);  // or else integers lose bits by being associated in 8 bits
    OIIO::ImageSpec first;
    if (!input_->open(path, first, config)) refuse_header(input_->geterror());
    const ChannelChoice choice = choose(options, format);
    check(format);
    describe(path, format, native_, options, choice, spec_, info_);
    warn_of_windows();
    plan_channels(options, choice);
    block_rows_ = image::block_rows(format, native_);
    decoder_bytes_ = count_decoder_bytes(format);
  }

  const ImageSpec& spec() const override { return spec_; }
  const FileInfo& info() const override { return info_; }
  const std::string& path() const override { return path_; }
  int block_rows() const override { return block_rows_; }
  uint64_t decoder_bytes() const override { return decoder_bytes_; }

  void read_rows(int y0, int y1, float* out, size_t row_stride) override {
    if (y0 < 0 || y1 < y0 || y1 > spec_.height)
      throw_internal("rows " + std::to_string(y0) + " to " + std::to_string(y1) + " of '" + path_ + "', which has " +
                     std::to_string(spec_.height));
    // Strips that overlap come back for the rows that they share.
    if (y0 > last_y0_ && y0 < last_y1_) keep_rows_ = std::max(keep_rows_, last_y1_ - y0);
    last_y0_ = y0, last_y1_ = y1;
    for (int y = y0; y < y1; ++y) {
      float* row = out + static_cast<size_t>(y - y0) * row_stride;
      const int64_t line = int64_t{y} - info_.data_y;
      const size_t floats = static_cast<size_t>(spec_.width) * spec_.channels.size();
      if (line < 0 || line >= native_.height) {
        std::fill_n(row, floats, 0.f);
        continue;
      }
      const int data_line = static_cast<int>(line);
      if (data_line < cached_begin_ || data_line >= cached_end_)
        decode(data_line, static_cast<int>(std::min<int64_t>(native_.height, int64_t{data_line} + (y1 - y))));
      convert_row(data_line, row);
    }
  }

 private:
  [[noreturn]] void refuse_header(const std::string& detail) const {
    // What OpenImageIO says of TIFF files that are whole but of a kind that libtiff does not convert.
    if (detail.find("No support for this flavor") != std::string::npos)
      fail(path_, "its colour model is not supported in this sample type; convert it to RGB first", detail);
    fail(path_, "its header is corrupt or cut short", detail);
  }

  uint64_t count_decoder_bytes(const std::string& format) const {
    if (format == "openexr" || format == "tiff" || format == "hdr") return 0;
    const bool whole = (format != "png" && format != "jpeg") || is_interleaved(path_, format);
    if (!whole) return 0;
    // JPEG: 8x8 blocks of 16-bit coefficients; components at full size, the most there can be.
    const auto padded = [](int side) { return static_cast<uint64_t>((int64_t{side} + 7) / 8 * 8); };
    if (format == "jpeg")
      return padded(native_.width) * padded(native_.height) * static_cast<uint64_t>(native_.nchannels) * 2;
    return native_.image_bytes(true);
  }

  // Opens the part and says which of its channels are wanted.
  ChannelChoice choose(const ReadOptions& options, const std::string& format) {
    if (!options.layer.empty() && !options.channels.empty())
      throw_usage("'" + path_ + "': a layer ('" + options.layer + "') and channels cannot be chosen both");
    part_ = find_part(options.part, format);
    std::optional<LayerChoice> layer;
    if (!options.layer.empty()) {
      layer = choose_layer(path_, info_.parts, options.part.empty() ? -1 : part_, options.layer);
      part_ = layer->part;
    }
    if (!input_->seek_subimage(part_, 0))
      fail(path_, "cannot go to part " + std::to_string(part_), input_->geterror());
    native_ = input_->spec();
    return layer ? layer->channels : choose_channels(path_, native_.channelnames, options);
  }

  int find_part(const std::string& wanted, const std::string& format) {
    int chosen = -1;
    std::vector<std::string> names;
    // Only these two have parts of equal standing; GIF's and WebP's are frames that must be decoded in order.
    const int most_parts = format == "openexr" || format == "tiff" ? 10000 : 1;
    for (int part = 0; part < most_parts; ++part) {
      const OIIO::ImageSpec spec = input_->spec(part, 0);
      if (spec.undefined()) break;
      PartInfo about;
      about.name = spec.get_string_attribute("oiio:subimagename").c_str();
      if (about.name.empty() && format == "openexr") about.name = spec.get_string_attribute("name").c_str();
      about.width = format == "openexr" && spec.full_width > 0 ? spec.full_width : spec.width;
      about.height = format == "openexr" && spec.full_height > 0 ? spec.full_height : spec.height;
      about.channels = spec.channelnames;
      if (chosen < 0 && !wanted.empty() && about.name == wanted) chosen = part;
      names.push_back(about.name.empty() ? std::to_string(part) : about.name);
      info_.parts.push_back(std::move(about));
    }
    input_->geterror();  // asking for the part after the last one is how their number is found
    if (info_.parts.empty()) fail(path_, "its header is corrupt or cut short", "");
    if (wanted.empty()) chosen = 0;
    if (chosen < 0)
      if (const auto number = parse_int(wanted); number && *number >= 0 && *number < std::ssize(info_.parts))
        chosen = static_cast<int>(*number);
    if (chosen < 0)
      throw_input("'" + path_ + "' has no part '" + wanted + "'" + did_you_mean(wanted, names) + "; it has " +
                  join(names, ", ") + " (or by number, 0 to " + std::to_string(info_.parts.size() - 1) + ")");
    return chosen;
  }

  // What only the decoder's own view of the header tells.
  void check(const std::string& format) const {
    if (native_.deep) fail(path_, "it holds deep data, which Triad does not read; flatten it first", "");
    check_size(path_, native_.width, native_.height, native_.nchannels);
    if (native_.depth > 1) fail(path_, "it is a volume, not a picture", "");
    if (format == "openexr" || format == "png" || format == "jpeg" || format == "hdr") return;
    constexpr int kSeparated = 5;  // TIFF 6.0: CMYK, which the decoder turns to RGB from integers only
    if (native_.get_int_attribute("tiff:PhotometricInterpretation", 2) == kSeparated &&
        native_.format.is_floating_point())
      fail(path_, "its colour model is not supported in this sample type; convert it to RGB first", "CMYK in floats");
    // TIFF: stored as it is, 1; LZW, deflate, PackBits stay under 4096; newer codecs and bilevel fax do not.
    const std::string compression = native_.get_string_attribute("compression").c_str();
    double ratio = 1 << 18;
    if (format == "tiff" && compression == "none") ratio = 1;
    if (format != "tiff" || compression == "lzw" || compression == "zip" || compression == "packbits") ratio = 4096;
    if (ratio == 1 && native_.get_int_attribute("oiio:BitsPerSample", 8) < 8) ratio = 8;  // widened by the decoder
    if (ratio == 1 && native_.get_int_attribute("tiff:PhotometricInterpretation", 2) == 3) ratio = 8;  // palette
    if (ratio == 1 && native_.get_int_attribute("oiio:BitsPerSample", 8) % 8 != 0) ratio = 2;
    if (ratio == 1 && native_.nchannels == 3 && native_.get_int_attribute("tiff:PhotometricInterpretation", 2) == 6)
      ratio = 2;  // subsampled chroma
    check_length(path_, file_size(path_), static_cast<double>(native_.image_bytes(true)), ratio);
  }

  // A crop may leave nothing of what was rendered, and a wrong origin of the display window shows nothing of it.
  void warn_of_windows() const {
    const auto apart = [](int64_t begin, int64_t size, int64_t whole) { return begin >= whole || begin + size <= 0; };
    if (!apart(info_.data_x, native_.width, spec_.width) && !apart(info_.data_y, native_.height, spec_.height))
      return;
    const auto window = [](int width, int height, int x, int y) {
      return std::to_string(width) + " x " + std::to_string(height) + " at (" + std::to_string(x) + ", " +
             std::to_string(y) + ")";
    };
    warn("'" + path_ + "' is black: its data window, " + window(native_.width, native_.height, native_.x, native_.y) +
         ", lies outside of its display window, " +
         window(spec_.width, spec_.height, native_.full_x, native_.full_y));
  }

  void plan_channels(const ReadOptions& options, const ChannelChoice& choice) {
    indices_ = choice.file_indices;
    const bool straight = native_.get_int_attribute("oiio:UnassociatedAlpha", 0) != 0;
    if (straight != options.straight_alpha) {
      convert_alpha_ = native_.alpha_channel >= 0 ? native_.alpha_channel : find_alpha(native_.channelnames);
      divide_by_alpha_ = options.straight_alpha;
    }
    first_ = *std::min_element(indices_.begin(), indices_.end());
    last_ = *std::max_element(indices_.begin(), indices_.end()) + 1;
    if (convert_alpha_ >= 0) {
      first_ = std::min(first_, convert_alpha_);
      last_ = std::max(last_, convert_alpha_ + 1);
    }
    pixel_bytes_ = native_.pixel_bytes(first_, last_, true);
    const int64_t tile = std::max(1, native_.tile_width);
    const int64_t padded = (native_.width + tile - 1) / tile * tile;
    if (padded > std::numeric_limits<int>::max()) fail(path_, "its tiles are absurd", "");
    row_pixels_ = static_cast<int>(padded);
    row_bytes_ = pixel_bytes_ * static_cast<size_t>(row_pixels_);
    for (int c = first_; c < last_; ++c)
      offsets_.push_back(c == first_ ? 0 : offsets_.back() + native_.channelformat(c - 1).size());
  }

  // Decodes whole blocks: the one that holds data_line and those that follow, until the rows wanted or the
  // size of a buffer are reached. They stay until another decode, so that a strip may begin where the last
  // one ended in the middle of a block.
  void decode(int data_line, int wanted_end) {
    constexpr int64_t kBuffer = 4 << 20;  // bytes; enough for several blocks to be decoded in parallel
    const int64_t block = block_rows_;
    const int64_t begin = data_line / block * block;
    const int64_t blocks_wanted = (wanted_end - begin + block - 1) / block;
    const int64_t blocks_fitting = std::max<int64_t>(1, kBuffer / static_cast<int64_t>(row_bytes_) * block);
    const int64_t end = std::min<int64_t>(native_.height, begin + std::min(blocks_wanted, blocks_fitting) * block);
    // To go back, some decoders begin anew at the top of the picture.
    constexpr int64_t kMostKept = 16 << 20;  // bytes
    int64_t kept = 0;
    if (begin == cached_end_ && native_.tile_width == 0)
      kept = std::min({int64_t{keep_rows_}, kMostKept / static_cast<int64_t>(row_bytes_), begin - cached_begin_});
    if (kept > 0)
      std::memmove(buffer_.data(), buffer_.data() + static_cast<size_t>(begin - kept - cached_begin_) * row_bytes_,
                   static_cast<size_t>(kept) * row_bytes_);
    cached_begin_ = cached_end_ = 0;
    // Whole tiles, also where they reach past the picture: asked for less, the EXR decoder of OpenImageIO 2.4
    // writes past the end of the buffer.
    const int64_t rows = native_.tile_width > 0 ? (end - begin + block - 1) / block * block : end - begin;
    buffer_.resize(static_cast<size_t>(kept + rows) * row_bytes_);
    std::byte* const fresh = buffer_.data() + static_cast<size_t>(kept) * row_bytes_;
    const int y0 = native_.y + static_cast<int>(begin), y1 = native_.y + static_cast<int>(begin + rows);
    bool ok = false;
    std::string thrown;
    try {
      ok = native_.tile_width > 0 ? input_->read_native_tiles(part_, 0, native_.x, native_.x + row_pixels_, y0, y1,
                                                              native_.z, native_.z + 1, first_, last_, fresh)
                                  : input_->read_native_scanlines(part_, 0, y0, y1, native_.z, first_, last_, fresh);
    } catch (const std::exception& error) {
      thrown = error.what();
    }
    // Some decoders report what they could not read and still return true.
    if (!ok || input_->has_error())
      fail(path_, "it is cut short or corrupt", thrown.empty() ? input_->geterror() : thrown);
    cached_begin_ = static_cast<int>(begin - kept);
    cached_end_ = static_cast<int>(end);
  }

  void convert_row(int data_line, float* row) const {
    const size_t channels = indices_.size();
    // The part of the display window that the data window covers.
    const int64_t x0 = std::clamp<int64_t>(info_.data_x, 0, spec_.width);
    const int64_t x1 = std::clamp<int64_t>(int64_t{info_.data_x} + native_.width, 0, spec_.width);
    if (x0 >= x1) {
      std::fill_n(row, static_cast<size_t>(spec_.width) * channels, 0.f);
      return;
    }
    std::fill_n(row, static_cast<size_t>(x0) * channels, 0.f);
    std::fill_n(row + x1 * channels, static_cast<size_t>(spec_.width - x1) * channels, 0.f);
    const std::byte* in = buffer_.data() + static_cast<size_t>(data_line - cached_begin_) * row_bytes_ +
                          static_cast<size_t>(x0 - info_.data_x) * pixel_bytes_;
    float* out = row + x0 * channels;
    const size_t count = static_cast<size_t>(x1 - x0);
    if (plain_floats()) {
      std::memcpy(out, in, count * pixel_bytes_);
    } else {
      for (size_t c = 0; c < channels; ++c) convert_channel(indices_[c], in, count, out + c, channels);
    }
    if (convert_alpha_ >= 0) associate(in, count, out);
  }

  bool plain_floats() const {
    if (native_.format != OIIO::TypeFloat || !native_.channelformats.empty()) return false;
    for (size_t c = 0; c < indices_.size(); ++c)
      if (indices_[c] != first_ + static_cast<int>(c)) return false;
    return static_cast<size_t>(last_ - first_) == indices_.size();
  }

  void convert_channel(int index, const std::byte* in, size_t count, float* out, size_t stride) const {
    const bool identifiers = info_.format == "openexr";  // EXR's integers count things, they are not light
    if (!to_float(native_.channelformat(index), identifiers, in + offsets_[index - first_], pixel_bytes_, count, out,
                  stride))
      fail(path_, "its samples are of type " + std::string(native_.channelformat(index).c_str()), "");
  }

  void associate(const std::byte* in, size_t count, float* out) const {
    alpha_row_.resize(count);
    convert_channel(convert_alpha_, in, count, alpha_row_.data(), 1);
    const size_t channels = indices_.size();
    if (divide_by_alpha_)  // where nothing is covered there is no colour to find
      for (float& a : alpha_row_) a = a > 0 ? 1 / a : 1;
    for (size_t c = 0; c < channels; ++c) {
      if (indices_[c] == convert_alpha_) continue;
      for (size_t i = 0; i < count; ++i) out[i * channels + c] *= alpha_row_[i];
    }
  }

  std::string path_;
  std::unique_ptr<OIIO::ImageInput> input_;
  OIIO::ImageSpec native_;
  ImageSpec spec_;
  FileInfo info_;
  int part_ = 0;
  int block_rows_ = 1;
  uint64_t decoder_bytes_ = 0;
  std::vector<int> indices_;  // of the channels of spec_, in the file
  int first_ = 0, last_ = 0;  // the range of file channels that is decoded
  int convert_alpha_ = -1;    // file channel to multiply or divide colour by, or -1
  bool divide_by_alpha_ = false;
  std::vector<size_t> offsets_;  // bytes from a pixel's start, of channels first_ ... last_
  size_t pixel_bytes_ = 0;       // of those channels
  int row_pixels_ = 0;           // in buffer_: the data window's width, or that of its row of whole tiles
  size_t row_bytes_ = 0;
  std::vector<std::byte> buffer_;
  int cached_begin_ = 0, cached_end_ = 0;  // the rows of the data window that buffer_ holds
  int last_y0_ = 0, last_y1_ = 0;          // what was asked for last
  int keep_rows_ = 0;                      // how far back callers came for more
  mutable std::vector<float> alpha_row_;
};

}  // namespace

std::unique_ptr<ImageReader> open_reader(const std::string& path, const std::string& format,
                                         const ReadOptions& options) {
  try {
    return std::make_unique<OiioReader>(path, format, options);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {  // what a decoder lets through, of which there are many
    fail(path, "its header is corrupt or cut short", error.what());
  }
}

}  // namespace triad::image
