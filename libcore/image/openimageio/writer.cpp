// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/image/internal/oiio.hpp>
#include <triad/image/internal/output_proxy.hpp>
#include <triad/image/internal/picture_library.hpp>
#include <utility>

namespace triad::image {
namespace {

OIIO::TypeDesc stored_type(Depth depth) {
  switch (depth) {
    case Depth::kUint8: return OIIO::TypeUInt8;
    case Depth::kUint16: return OIIO::TypeUInt16;
    case Depth::kHalf: return OIIO::TypeHalf;
    default: return OIIO::TypeFloat;
  }
}

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw_input("cannot write '" + path + "': " + why);
}

// Channel names as the format wants them; OpenImageIO tells R, G, B and A by their plain names.
std::vector<std::string> stored_names(const WriterFormat& format, const ImageSpec& spec) {
  if (format.name == "openexr") return spec.channels;
  std::vector<std::string> names = spec.channels;
  static const char* const kColour[] = {"R", "G", "B"};
  if (spec.colour_channels == 3)
    for (int c = 0; c < 3; ++c) names[c] = kColour[c];
  if (spec.colour_channels == 1) names[0] = "Y";
  if (spec.alpha >= 0) names[spec.alpha] = "A";
  return names;
}

void set_pixel_aspect(OIIO::ImageSpec& spec, const std::string& format, double aspect) {
  spec.attribute("PixelAspectRatio", static_cast<float>(aspect));
  if (format == "openexr" || std::abs(aspect - 1) < 1e-9) return;
  // Others store two resolutions, and OpenImageIO's own choice of them rounds 1/3 to .33.
  const double wide = 1 / aspect;
  const bool whole = std::abs(wide - std::round(wide)) < 1e-6;
  const float y = whole ? 72.f : 1000.f;  // dots per unit; only the quotient means anything here
  spec.attribute("XResolution", static_cast<float>(std::round(y * wide)));
  spec.attribute("YResolution", y);
  spec.attribute("ResolutionUnit", "none");
}

// Camera data lie in a directory of their own in a TIFF, and to write one libtiff reads back what it wrote, which
// OpenImageIO's proxies cannot do for it: the file would be unreadable.
bool is_lost(const WriterFormat& format, const std::string& name) {
  return format.name == "tiff" &&
         (name.rfind("Exif:", 0) == 0 || name.rfind("GPS:", 0) == 0 || name == "ExposureTime" || name == "FNumber");
}

OIIO::ImageSpec header(const Encoding& encoding, const WriteOptions& options) {
  const auto& [format, depth, from, tripled] = encoding;
  OIIO::ImageSpec spec(from.width, from.height, from.channel_count(), stored_type(depth));
  spec.channelnames = stored_names(format, from);
  spec.alpha_channel = from.alpha;
  for (const auto& attribute : from.metadata.impl().list) {
    const std::string name = attribute.name().string();
    if (!describes_encoding(name) && !is_lost(format, name)) spec.extra_attribs.push_back(attribute);
  }
  // Without one, OpenImageIO writes the current time, and the same pixels would give other bytes.
  if (!spec.find_attribute("DateTime")) spec.attribute("DateTime", "");
  if (format.unassociated && from.alpha >= 0) spec.attribute("oiio:UnassociatedAlpha", 1);

  set_pixel_aspect(spec, format.name, from.pixel_aspect);
  if (format.text == WriterFormat::kFields) {
    if (!(from.cells == Cells{}))
      spec.attribute("triad:cells", std::to_string(from.cells.x) + "x" + std::to_string(from.cells.y));
    if (!from.colour_space.empty()) spec.attribute("triad:colour_space", from.colour_space);
  }
  if (format.text == WriterFormat::kDescription) {
    const std::string about =
        with_carried(from.metadata.get("ImageDescription").value_or(""), to_be_said(from, depth, true));
    if (!about.empty()) spec.attribute("ImageDescription", about);
  }
  const std::string space = lower(from.colour_space);
  if (space == "srgb" && format.name == "png") spec.attribute("oiio:ColorSpace", "sRGB");
  if ((space == "linear" || space == "lin_rec709") && format.name == "png") {
    spec.attribute("oiio:ColorSpace", "Linear");
    spec.attribute("oiio:Gamma", 1.f);
  }
  if (from.chromaticities && format.name == "openexr")
    spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), from.chromaticities->data());

  if (format.name == "openexr") spec.attribute("compression", "zip");
  if (format.name == "tiff") spec.attribute("compression", "none");
  if (format.name == "jpeg") {
    spec.attribute("Compression", "jpeg:95");
    spec.attribute("jpeg:subsampling", "4:4:4");  // colour at a third of a pixel would not survive 4:2:0
  }
  if (!options.compression.empty()) {
    const bool png_level = format.name == "png" && parse_int(options.compression);
    if (png_level)
      spec.attribute("png:compressionLevel", static_cast<int>(*parse_int(options.compression)));
    else
      spec.attribute("compression", options.compression);
  }
  return spec;
}

class OiioWriter final : public ImageWriter {
 public:
  OiioWriter(const std::string& path, Encoding&& encoding, const WriteOptions& options)
      : encoding_(std::move(encoding)), file_(path), proxy_(file_.temporary()) {
    // A file that grows past the user's limit shall be an error of write(), which names the file.
    static const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
    static_cast<void>(ignored);
    prepare_oiio();
    output_ = OIIO::ImageOutput::create(encoding_.format.name);
    if (!output_) fail(path, "this OpenImageIO cannot write " + encoding_.format.name);
    output_->set_ioproxy(&proxy_);
    if (!output_->open(file_.temporary(), header(encoding_, options))) raise(output_->geterror());
    row_floats_ = static_cast<size_t>(encoding_.spec.width) * encoding_.spec.channels.size();
    sample_bytes_ = is_integer(encoding_.depth) ? stored_type(encoding_.depth).size() : sizeof(float);
    group_.resize(static_cast<size_t>(std::min(kGroupRows, encoding_.spec.height)) * row_floats_ * sample_bytes_);
    warn_of_loss(path, encoding_);
  }

  ~OiioWriter() override {
    if (!committed_ && encoding_.format.name == "png") begin_png_data();
  }

  void write_rows(int y0, int y1, const float* pixels, size_t row_stride) override {
    if (y0 != next_ || y1 < y0 || y1 > encoding_.spec.height)
      throw_internal("rows " + std::to_string(y0) + " to " + std::to_string(y1) + " of '" + file_.path() +
                     "' where row " + std::to_string(next_) + " is due");
    for (int y = y0; y < y1; ++y) {
      encode(pixels + static_cast<size_t>(y - y0) * row_stride,
             group_.data() + static_cast<size_t>(next_ - group_begin_) * row_floats_ * sample_bytes_);
      ++next_;
      if (next_ - group_begin_ == kGroupRows || next_ == encoding_.spec.height) write_group();
    }
  }

  void commit() override {
    if (next_ != encoding_.spec.height)
      throw_internal("'" + file_.path() + "' lacks rows " + std::to_string(next_) + " to " +
                     std::to_string(encoding_.spec.height));
    bool closed = false;
    std::string thrown;
    try {
      closed = output_->close();
    } catch (const std::exception& error) {
      thrown = error.what();
    }
    proxy_.finish();
    // Not has_error(): the TIFF encoder always says that it could not store camera data, of which there is none.
    if (!closed || proxy_.error_number() != 0) raise(thrown.empty() ? output_->geterror() : thrown);
    file_.commit();
    committed_ = true;
  }

  uint64_t buffer_bytes() const override {
    constexpr uint64_t kProxy = 1 << 20;  // bytes, OutputProxy's buffer
    // Growth of the resident size while 256 rows of 4000 and 12000 pixels of noise were written: EXR 3.9 (zip) to
    // 5.1 (piz) times group_, TIFF 2.0, JPEG 3.0 with the buffer, PNG, HDR, TGA, BMP and PPM at most 1.7 with it.
    const uint64_t times = encoding_.format.name == "openexr" ? 5 : encoding_.format.name == "jpeg" ? 3 : 2;
    return kProxy + times * group_.size();
  }

 private:
  // Given up before its first compressed byte, libpng jumps to where it was set up long ago, and hangs. Noise
  // makes it write some bytes at once, into the temporary file.
  void begin_png_data() noexcept try {
    uint32_t random = 1;
    for (auto& byte : group_) byte = static_cast<std::byte>((random = random * 1664525 + 1013904223) >> 24);
    const size_t before = proxy_.size();
    for (int y = group_begin_; y < encoding_.spec.height && proxy_.size() == before; ++y)
      output_->write_scanline(y, 0, stored_type(encoding_.depth), group_.data());
  } catch (const std::exception&) {
    // Only an allocation can fail here, and then there is nothing better to do.
  }

  // Encoders get the same groups of rows however the caller cuts the picture, because some of them compress
  // whole groups differently from single rows.
  static constexpr int kGroupRows = 64;

  [[noreturn]] void raise(const std::string& text) const {
    if (proxy_.error_number() != 0) fail(file_.path(), std::strerror(proxy_.error_number()));
    const std::string line = one_line(text, file_.temporary());
    fail(file_.path(), line.empty() ? "the encoder failed" : line);
  }

  void write_group() {
    const OIIO::TypeDesc type = is_integer(encoding_.depth) ? stored_type(encoding_.depth) : OIIO::TypeFloat;
    bool ok = false;
    std::string thrown;
    try {
      ok = output_->write_scanlines(group_begin_, next_, 0, type, group_.data());
    } catch (const std::exception& error) {
      thrown = error.what();
    }
    if (!ok || proxy_.error_number() != 0) raise(thrown.empty() ? output_->geterror() : thrown);
    group_begin_ = next_;
  }

  void encode(const float* row, std::byte* out) {
    const float* values = row;
    if (encoding_.format.unassociated && encoding_.spec.alpha >= 0) values = unassociate(row);
    if (encoding_.tripled) values = triple(row);
    if (encoding_.depth == Depth::kUint8) {
      auto* codes = reinterpret_cast<uint8_t*>(out);
      for (size_t i = 0; i < row_floats_; ++i) codes[i] = static_cast<uint8_t>(quantise(values[i], 255));
    } else if (encoding_.depth == Depth::kUint16) {
      auto* codes = reinterpret_cast<uint16_t*>(out);
      for (size_t i = 0; i < row_floats_; ++i) codes[i] = static_cast<uint16_t>(quantise(values[i], 65535));
    } else {
      std::memcpy(out, values, row_floats_ * sizeof(float));
      if (encoding_.depth == Depth::kHalf) clamp_to_half(reinterpret_cast<float*>(out));
    }
  }

  const float* unassociate(const float* row) {
    scratch_.assign(row, row + row_floats_);
    const size_t n = encoding_.spec.channels.size(), alpha = static_cast<size_t>(encoding_.spec.alpha);
    for (size_t i = 0; i < row_floats_; i += n) {
      const float a = scratch_[i + alpha];
      if (!(a > 0)) continue;  // light without coverage has no colour of its own; it stays as it is
      for (size_t c = 0; c < n; ++c)
        if (c != alpha) scratch_[i + c] /= a;
    }
    return scratch_.data();
  }

  const float* triple(const float* row) {
    scratch_.resize(row_floats_);
    for (size_t i = 0; i < row_floats_; ++i) scratch_[i] = row[i / 3];
    return scratch_.data();
  }

  void clamp_to_half(float* values) const {
    constexpr float kMost = 65504;  // the largest finite half, IEEE 754 binary16
    bool clamped = false;
    for (size_t i = 0; i < row_floats_; ++i) {
      if (std::abs(values[i]) > kMost && !std::isinf(values[i])) {
        values[i] = std::copysign(kMost, values[i]);
        clamped = true;
      }
    }
    if (clamped)
      warn("'" + file_.path() +
           "': values beyond 65504 do not fit into half and were clamped; --depth float keeps them");
  }

  Encoding encoding_;
  AtomicFile file_;
  OutputProxy proxy_;
  std::unique_ptr<OIIO::ImageOutput> output_;
  size_t row_floats_ = 0, sample_bytes_ = 0;
  std::vector<std::byte> group_;
  std::vector<float> scratch_;
  int group_begin_ = 0, next_ = 0;
  bool committed_ = false;
};

}  // namespace

std::unique_ptr<ImageWriter> open_writer(const std::string& path, Encoding&& encoding, const WriteOptions& options) {
  return std::make_unique<OiioWriter>(path, std::move(encoding), options);
}

}  // namespace triad::image
