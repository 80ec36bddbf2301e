// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/image/internal/carried.hpp>
#include <triad/image/internal/oiio.hpp>
#include <triad/image/internal/output_proxy.hpp>
#include <triad/image/writer.hpp>

namespace triad {
namespace {

struct Format {
  std::string name;  // as OpenImageIO calls it
  bool linear;       // whether its default depth holds scene-linear values
  Depth usual;
  std::vector<Depth> others;
  bool alpha = true, unassociated = false;
  enum Channels { kAny, kGreyOrRgb, kRgb, kGrey } channels = kGreyOrRgb;
  enum Text { kNone, kDescription, kFields } text = kNone;  // what there is to say a colour space in
  int most_px = std::numeric_limits<int>::max();            // of either side
};

// The formats that report every failed write through our OutputProxy; what others lose on a full disk, they
// lose silently.
const Format* find_format(const std::string& extension) {
  using enum Depth;
  static const Format exr{"openexr", true, kHalf, {kFloat}, true, false, Format::kAny, Format::kFields};
  static const Format tiff{"tiff", true,  kFloat,       {kUint8, kUint16, kHalf},
                           true,   false, Format::kAny, Format::kDescription};
  // What libpng and libjpeg take (PNG_USER_WIDTH_MAX, JPEG_MAX_DIMENSION), of which the latter ends the process over
  // more, and what the 16 bits of a TGA can say.
  constexpr int kPngMost = 1'000'000, kJpegMost = 65'500, kTargaMost = 65'535;
  static const Format png{"png", false, kUint8, {kUint16}, true, true, Format::kGreyOrRgb, Format::kFields, kPngMost};
  static const Format jpeg{"jpeg",   false, kUint8, {}, false, false, Format::kGreyOrRgb, Format::kDescription,
                           kJpegMost};
  static const Format hdr{"hdr", true, kFloat, {}, false, false, Format::kRgb};
  static const Format bmp{"bmp", false, kUint8, {}, false};
  static const Format targa{"targa",   false, kUint8, {}, true, true, Format::kGreyOrRgb, Format::kDescription,
                            kTargaMost};
  static const Format ppm{"pnm", false, kUint8, {kUint16}, false, false, Format::kRgb};
  static const Format pgm{"pnm", false, kUint8, {kUint16}, false, false, Format::kGrey};
  static const struct {
    const char* extension;
    const Format* format;
  } kTable[] = {{"exr", &exr}, {"tif", &tiff}, {"tiff", &tiff}, {"png", &png},   {"jpg", &jpeg}, {"jpeg", &jpeg},
                {"hdr", &hdr}, {"rgbe", &hdr}, {"bmp", &bmp},   {"tga", &targa}, {"ppm", &ppm},  {"pgm", &pgm}};
  for (const auto& row : kTable)
    if (extension == row.extension) return row.format;
  return nullptr;
}

const Format& require_format(const std::string& path) {
  const std::string extension = lower(std::filesystem::path(path).extension().string());
  const Format* format = extension.empty() ? nullptr : find_format(extension.substr(1));
  if (extension == ".pfm")  // what it writes by that name are 8-bit integers
    throw_usage("cannot write '" + path + "': OpenImageIO does not write PFM; exr, tif and hdr hold floats, too");
  if (!format)
    throw_usage("cannot write '" + path + "': " +
                (extension.empty() ? "it has no extension" : "the extension '" + extension + "' is not known") +
                "; use one of exr, tif, png, jpg, hdr, bmp, tga, ppm, pgm");
  return *format;
}

const char* depth_name(Depth depth) {
  switch (depth) {
    case Depth::kDefault: return "default";
    case Depth::kUint8: return "8";
    case Depth::kUint16: return "16";
    case Depth::kHalf: return "half";
    case Depth::kFloat: return "float";
  }
  return "";
}

Depth resolve_depth(const std::string& path, const Format& format, Depth wanted) {
  if (wanted == Depth::kDefault || wanted == format.usual) return format.usual;
  if (std::find(format.others.begin(), format.others.end(), wanted) != format.others.end()) return wanted;
  std::vector<std::string> depths{depth_name(format.usual)};
  for (const Depth other : format.others) depths.push_back(depth_name(other));
  throw_usage("cannot write '" + path + "' with --depth " + depth_name(wanted) + ": this format stores " +
              join(depths, ", "));
}

OIIO::TypeDesc stored_type(Depth depth) {
  switch (depth) {
    case Depth::kUint8: return OIIO::TypeUInt8;
    case Depth::kUint16: return OIIO::TypeUInt16;
    case Depth::kHalf: return OIIO::TypeHalf;
    default: return OIIO::TypeFloat;
  }
}

bool is_integer(Depth depth) { return depth == Depth::kUint8 || depth == Depth::kUint16; }

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw_input("cannot write '" + path + "': " + why);
}

void check_size(const std::string& path, const Format& format, const ImageSpec& spec) {
  if (spec.width < 1 || spec.height < 1 || spec.channel_count() < 1) fail(path, "the picture is empty");
  if (std::max(spec.width, spec.height) > format.most_px)
    fail(path, "this format holds at most " + std::to_string(format.most_px) + " pixels a side, and the picture is " +
                   spec.size_text() + "; write .exr or .tif");
}

void check_channels(const std::string& path, const Format& format, const ImageSpec& spec) {
  const int n = spec.channel_count();
  if (format.channels == Format::kAny) return;
  const int colour = spec.alpha >= 0 ? n - 1 : n;
  if (spec.alpha >= 0 && !format.alpha)
    fail(path, "this format has no alpha channel, and the picture is " + spec.size_text() +
                   "; choose channels without it, e.g. --channels R,G,B");
  if (format.channels == Format::kGrey && colour == 3)
    fail(path, "this format holds grey, and the picture is " + spec.size_text() +
                   "; name it .ppm, or choose one channel with --channels");
  if (colour != 3 && colour != 1)
    fail(path, std::string("this format holds ") + (format.channels == Format::kGrey ? "grey" : "grey or RGB") +
                   ", and the picture is " + spec.size_text() + "; choose channels with --channels");
}

// The picture as the format holds it: grey three times for those that know RGB only.
ImageSpec stored_picture(const Format& format, const ImageSpec& from) {
  ImageSpec spec = from;
  if (format.channels == Format::kRgb && from.channel_count() == 1) {
    spec.channels = {"R", "G", "B"};
    spec.colour_channels = from.colour_channels == 1 ? 3 : 0;
  }
  return spec;
}

// Whether a reader takes the values for what they are when the file says nothing: linear light with the
// primaries of Rec.709 where it stores floats, sRGB where it stores integers.
bool is_understood(const ImageSpec& spec, Depth depth) {
  if (spec.colour_space.empty() || spec.colour_channels == 0) return true;
  const std::string name = lower(spec.colour_space);
  if (is_integer(depth)) return name.find("srgb") != std::string::npos && name.find("lin") == std::string::npos;
  if (name == "linear" || name == "lin_rec709" || name == "lin_srgb") return true;
  // A configuration of the user's has names of its own.
  static constexpr float kRec709[8] = {.64f, .33f, .3f, .6f, .15f, .06f, .3127f, .329f};  // ITU-R BT.709
  if (!spec.chromaticities) return false;
  for (int i = 0; i < 8; ++i)
    if (!(std::abs((*spec.chromaticities)[i] - kRec709[i]) < 1e-3f)) return false;
  return true;
}

// What a reader would not find out from the format and the pixel aspect.
image::Carried to_be_said(const ImageSpec& spec, Depth depth, bool keeps_aspect) {
  image::Carried say;
  if (!is_understood(spec, depth)) say.colour_space = spec.colour_space;
  const bool by_aspect = keeps_aspect && spec.cells.y == 1 && spec.cells.x >= 2 && spec.cells.x <= 16 &&
                         std::abs(spec.pixel_aspect * spec.cells.x - 1) < 1e-4;
  if (!(spec.cells == Cells{}) && !by_aspect)
    say.cells = std::to_string(spec.cells.x) + "x" + std::to_string(spec.cells.y);
  return say;
}

void warn_of_loss(const std::string& path, const Format& format, Depth depth, const ImageSpec& spec) {
  if (format.text != Format::kNone) return;
  const image::Carried lost = to_be_said(spec, depth, false);
  std::vector<std::string> what, options;
  if (!lost.colour_space.empty()) {
    what.push_back("that its colour space is '" + lost.colour_space + "'");
    options.push_back("--from " + lost.colour_space);
  }
  if (!lost.cells.empty()) {
    what.push_back("that it has " + lost.cells + " cells to a pixel");
    options.push_back("--cells " + lost.cells);
  } else if (std::abs(spec.pixel_aspect - 1) > 1e-3) {
    what.push_back("that its pixel aspect is " + format_double(spec.pixel_aspect));
  }
  if (what.empty()) return;
  warn("'" + path + "': this format cannot say " + join(what, " and ") +
       (options.empty() ? "" : "; whoever reads the file must say " + join(options, " ")));
}

// Channel names as the format wants them; OpenImageIO tells R, G, B and A by their plain names.
std::vector<std::string> stored_names(const Format& format, const ImageSpec& spec) {
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
bool is_lost(const Format& format, const std::string& name) {
  return format.name == "tiff" &&
         (name.rfind("Exif:", 0) == 0 || name.rfind("GPS:", 0) == 0 || name == "ExposureTime" || name == "FNumber");
}

OIIO::ImageSpec header(const Format& format, Depth depth, const ImageSpec& from, const WriteOptions& options) {
  OIIO::ImageSpec spec(from.width, from.height, from.channel_count(), stored_type(depth));
  spec.channelnames = stored_names(format, from);
  spec.alpha_channel = from.alpha;
  for (const auto& attribute : from.metadata.impl().list) {
    const std::string name = attribute.name().string();
    if (!image::describes_encoding(name) && !is_lost(format, name)) spec.extra_attribs.push_back(attribute);
  }
  // Without one, OpenImageIO writes the current time, and the same pixels would give other bytes.
  if (!spec.find_attribute("DateTime")) spec.attribute("DateTime", "");
  if (format.unassociated && from.alpha >= 0) spec.attribute("oiio:UnassociatedAlpha", 1);

  set_pixel_aspect(spec, format.name, from.pixel_aspect);
  if (format.text == Format::kFields) {
    if (!(from.cells == Cells{}))
      spec.attribute("triad:cells", std::to_string(from.cells.x) + "x" + std::to_string(from.cells.y));
    if (!from.colour_space.empty()) spec.attribute("triad:colour_space", from.colour_space);
  }
  if (format.text == Format::kDescription) {
    const std::string about =
        image::with_carried(from.metadata.get("ImageDescription").value_or(""), to_be_said(from, depth, true));
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

void check_compression(const std::string& path, const Format& format, const std::string& text) {
  if (text.empty()) return;
  const std::string name = text.substr(0, text.find(':'));
  std::vector<std::string> known;
  if (format.name == "openexr")
    known = {"none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"};
  else if (format.name == "tiff")
    known = {"none", "lzw", "zip", "packbits"};
  else if (format.name == "png")
    known = {"0", "1", "2", "3", "4", "5", "6", "7", "8", "9"};
  else if (format.name == "jpeg")
    known = {"jpeg"};
  else if (format.name == "targa")
    known = {"none", "rle"};
  if (std::find(known.begin(), known.end(), name) != known.end()) {
    if (name == text) return;
    const auto level = parse_double(std::string_view(text).substr(name.size() + 1));
    const bool quality = name == "jpeg" && level && *level >= 1 && *level <= 100;
    const bool dwa = name.rfind("dwa", 0) == 0 && level && *level >= 0 && *level <= 1e6;
    const bool zip = (name == "zip" || name == "zips") && level && *level >= 1 && *level <= 9;
    if (quality || dwa || zip) return;
  }
  throw_usage("cannot write '" + path + "' with the compression '" + text + "': " +
              (known.empty() ? "this format has no choice of compression"
                             : "use one of " + join(known, ", ") + did_you_mean(name, known)));
}

class OiioWriter final : public ImageWriter {
 public:
  OiioWriter(const std::string& path, const ImageSpec& spec, const WriteOptions& options)
      : format_(require_format(path)),
        depth_(resolve_depth(path, format_, options.depth)),
        spec_(stored_picture(format_, spec)),
        tripled_(spec_.channels.size() != spec.channels.size()),
        file_((check_size(path, format_, spec), check_channels(path, format_, spec),
               check_compression(path, format_, options.compression), path)),
        proxy_(file_.temporary()) {
    // A file that grows past the user's limit shall be an error of write(), which names the file.
    static const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
    static_cast<void>(ignored);
    image::prepare_oiio();
    output_ = OIIO::ImageOutput::create(format_.name);
    if (!output_) fail(path, "this OpenImageIO cannot write " + format_.name);
    output_->set_ioproxy(&proxy_);
    if (!output_->open(file_.temporary(), header(format_, depth_, spec_, options))) raise(output_->geterror());
    row_floats_ = static_cast<size_t>(spec_.width) * spec_.channels.size();
    sample_bytes_ = is_integer(depth_) ? stored_type(depth_).size() : sizeof(float);
    group_.resize(static_cast<size_t>(std::min(kGroupRows, spec.height)) * row_floats_ * sample_bytes_);
    warn_of_loss(path, format_, depth_, spec_);
  }

  ~OiioWriter() override {
    if (!committed_ && format_.name == "png") begin_png_data();
  }

  void write_rows(int y0, int y1, const float* pixels, size_t row_stride) override {
    if (y0 != next_ || y1 < y0 || y1 > spec_.height)
      throw_internal("rows " + std::to_string(y0) + " to " + std::to_string(y1) + " of '" + file_.path() +
                     "' where row " + std::to_string(next_) + " is due");
    for (int y = y0; y < y1; ++y) {
      encode(pixels + static_cast<size_t>(y - y0) * row_stride,
             group_.data() + static_cast<size_t>(next_ - group_begin_) * row_floats_ * sample_bytes_);
      ++next_;
      if (next_ - group_begin_ == kGroupRows || next_ == spec_.height) write_group();
    }
  }

  void commit() override {
    if (next_ != spec_.height)
      throw_internal("'" + file_.path() + "' lacks rows " + std::to_string(next_) + " to " +
                     std::to_string(spec_.height));
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
    const uint64_t times = format_.name == "openexr" ? 5 : format_.name == "jpeg" ? 3 : 2;
    return kProxy + times * group_.size();
  }

 private:
  // Given up before its first compressed byte, libpng jumps to where it was set up long ago, and hangs. Noise
  // makes it write some bytes at once, into the temporary file.
  void begin_png_data() noexcept try {
    uint32_t random = 1;
    for (auto& byte : group_) byte = static_cast<std::byte>((random = random * 1664525 + 1013904223) >> 24);
    const size_t before = proxy_.size();
    for (int y = group_begin_; y < spec_.height && proxy_.size() == before; ++y)
      output_->write_scanline(y, 0, stored_type(depth_), group_.data());
  } catch (const std::exception&) {
    // Only an allocation can fail here, and then there is nothing better to do.
  }

  // Encoders get the same groups of rows however the caller cuts the picture, because some of them compress
  // whole groups differently from single rows.
  static constexpr int kGroupRows = 64;

  [[noreturn]] void raise(const std::string& text) const {
    if (proxy_.error_number() != 0) fail(file_.path(), std::strerror(proxy_.error_number()));
    const std::string line = image::one_line(text, file_.temporary());
    fail(file_.path(), line.empty() ? "the encoder failed" : line);
  }

  void write_group() {
    const OIIO::TypeDesc type = is_integer(depth_) ? stored_type(depth_) : OIIO::TypeFloat;
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
    if (format_.unassociated && spec_.alpha >= 0) values = unassociate(row);
    if (tripled_) values = triple(row);
    if (depth_ == Depth::kUint8) {
      auto* codes = reinterpret_cast<uint8_t*>(out);
      for (size_t i = 0; i < row_floats_; ++i) codes[i] = static_cast<uint8_t>(image::quantise(values[i], 255));
    } else if (depth_ == Depth::kUint16) {
      auto* codes = reinterpret_cast<uint16_t*>(out);
      for (size_t i = 0; i < row_floats_; ++i) codes[i] = static_cast<uint16_t>(image::quantise(values[i], 65535));
    } else {
      std::memcpy(out, values, row_floats_ * sizeof(float));
      if (depth_ == Depth::kHalf) clamp_to_half(reinterpret_cast<float*>(out));
    }
  }

  const float* unassociate(const float* row) {
    scratch_.assign(row, row + row_floats_);
    const size_t n = spec_.channels.size(), alpha = static_cast<size_t>(spec_.alpha);
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

  const Format& format_;
  Depth depth_;
  ImageSpec spec_;  // as it is stored
  bool tripled_;    // the pixels given are grey, those stored RGB
  AtomicFile file_;
  image::OutputProxy proxy_;
  std::unique_ptr<OIIO::ImageOutput> output_;
  size_t row_floats_ = 0, sample_bytes_ = 0;
  std::vector<std::byte> group_;
  std::vector<float> scratch_;
  int group_begin_ = 0, next_ = 0;
  bool committed_ = false;
};

}  // namespace

Depth parse_depth(const std::string& text) {
  for (const Depth depth : {Depth::kUint8, Depth::kUint16, Depth::kHalf, Depth::kFloat})
    if (text == depth_name(depth)) return depth;
  throw_usage("--depth: '" + text + "' is not one of 8, 16, half, float");
}

bool is_display_encoded_format(const std::string& path, Depth depth) {
  const Format& format = require_format(path);
  if (format.name == "tiff") return is_integer(depth);
  return !format.linear;
}

std::unique_ptr<ImageWriter> ImageWriter::open(const std::string& path, const ImageSpec& spec,
                                               const WriteOptions& options) {
  return std::make_unique<OiioWriter>(path, spec, options);
}

void write_image(const std::string& path, const Image& image, const WriteOptions& options) {
  const auto writer = ImageWriter::open(path, image.spec, options);
  writer->write_rows(0, image.spec.height, image.pixels.data(), image.row_floats());
  writer->commit();
}

}  // namespace triad
