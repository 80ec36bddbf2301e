// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <triad/base/error.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/image/internal/picture_library.hpp>
#include <triad/image/internal/writer_format.hpp>

namespace triad {
namespace image {
namespace {

// The formats that report every failed write through our OutputProxy; what others lose on a full disk, they
// lose silently.
const WriterFormat* find_format(const std::string& extension) {
  using enum Depth;
  static const WriterFormat exr{
      "openexr", true, kHalf, {kFloat}, true, false, WriterFormat::kAny, WriterFormat::kFields};
  static const WriterFormat tiff{
      "tiff", true, kFloat, {kUint8, kUint16, kHalf}, true, false, WriterFormat::kAny, WriterFormat::kDescription};
  // What libpng and libjpeg take (PNG_USER_WIDTH_MAX, JPEG_MAX_DIMENSION), of which the latter ends the process over
  // more, and what the 16 bits of a TGA can say.
  constexpr int kPngMost = 1'000'000, kJpegMost = 65'500, kTargaMost = 65'535;
  static const WriterFormat png{
      "png", false, kUint8, {kUint16}, true, true, WriterFormat::kGreyOrRgb, WriterFormat::kFields, kPngMost};
  static const WriterFormat jpeg{
      "jpeg", false, kUint8, {}, false, false, WriterFormat::kGreyOrRgb, WriterFormat::kDescription, kJpegMost};
  static const WriterFormat hdr{"hdr", true, kFloat, {}, false, false, WriterFormat::kRgb};
  static const WriterFormat bmp{"bmp", false, kUint8, {}, false};
  static const WriterFormat targa{
      "targa", false, kUint8, {}, true, true, WriterFormat::kGreyOrRgb, WriterFormat::kDescription, kTargaMost};
  static const WriterFormat ppm{"pnm", false, kUint8, {kUint16}, false, false, WriterFormat::kRgb};
  static const WriterFormat pgm{"pnm", false, kUint8, {kUint16}, false, false, WriterFormat::kGrey};
  static const struct {
    const char* extension;
    const WriterFormat* format;
  } kTable[] = {{"exr", &exr}, {"tif", &tiff}, {"tiff", &tiff}, {"png", &png},   {"jpg", &jpeg}, {"jpeg", &jpeg},
                {"hdr", &hdr}, {"rgbe", &hdr}, {"bmp", &bmp},   {"tga", &targa}, {"ppm", &ppm},  {"pgm", &pgm}};
  for (const auto& row : kTable)
    if (extension == row.extension) return row.format;
  return nullptr;
}

const WriterFormat& require_format(const std::string& path) {
  const std::string extension = lower(std::filesystem::path(path).extension().string());
  const WriterFormat* format = extension.empty() ? nullptr : find_format(extension.substr(1));
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

Depth resolve_depth(const std::string& path, const WriterFormat& format, Depth wanted) {
  if (wanted == Depth::kDefault || wanted == format.usual) return format.usual;
  if (std::find(format.others.begin(), format.others.end(), wanted) != format.others.end()) return wanted;
  std::vector<std::string> depths{depth_name(format.usual)};
  for (const Depth other : format.others) depths.push_back(depth_name(other));
  throw_usage("cannot write '" + path + "' with --depth " + depth_name(wanted) + ": this format stores " +
              join(depths, ", "));
}

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw_input("cannot write '" + path + "': " + why);
}

void check_size(const std::string& path, const WriterFormat& format, const ImageSpec& spec) {
  if (spec.width < 1 || spec.height < 1 || spec.channel_count() < 1) fail(path, "the picture is empty");
  if (std::max(spec.width, spec.height) > format.most_px)
    fail(path, "this format holds at most " + std::to_string(format.most_px) + " pixels a side, and the picture is " +
                   spec.size_text() + "; write .exr or .tif");
}

void check_channels(const std::string& path, const WriterFormat& format, const ImageSpec& spec) {
  const int n = spec.channel_count();
  if (format.channels == WriterFormat::kAny) return;
  const int colour = spec.alpha >= 0 ? n - 1 : n;
  if (spec.alpha >= 0 && !format.alpha)
    fail(path, "this format has no alpha channel, and the picture is " + spec.size_text() +
                   "; choose channels without it, e.g. --channels R,G,B");
  if (format.channels == WriterFormat::kGrey && colour == 3)
    fail(path, "this format holds grey, and the picture is " + spec.size_text() +
                   "; name it .ppm, or choose one channel with --channels");
  if (colour != 3 && colour != 1)
    fail(path, std::string("this format holds ") + (format.channels == WriterFormat::kGrey ? "grey" : "grey or RGB") +
                   ", and the picture is " + spec.size_text() + "; choose channels with --channels");
}

// The picture as the format holds it: grey three times for those that know RGB only.
ImageSpec stored_picture(const WriterFormat& format, const ImageSpec& from) {
  ImageSpec spec = from;
  if (format.channels == WriterFormat::kRgb && from.channel_count() == 1) {
    spec.channels = {"R", "G", "B"};
    spec.colour_channels = from.colour_channels == 1 ? 3 : 0;
  }
  return spec;
}

void check_compression(const std::string& path, const WriterFormat& format, const std::string& text) {
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

}  // namespace

bool is_integer(Depth depth) { return depth == Depth::kUint8 || depth == Depth::kUint16; }

Carried to_be_said(const ImageSpec& spec, Depth depth, bool keeps_aspect) {
  Carried say;
  if (!is_understood(spec, depth)) say.colour_space = spec.colour_space;
  const bool by_aspect = keeps_aspect && spec.cells.y == 1 && spec.cells.x >= 2 && spec.cells.x <= 16 &&
                         std::abs(spec.pixel_aspect * spec.cells.x - 1) < 1e-4;
  if (!(spec.cells == Cells{}) && !by_aspect)
    say.cells = std::to_string(spec.cells.x) + "x" + std::to_string(spec.cells.y);
  return say;
}

void warn_of_loss(const std::string& path, const Encoding& encoding) {
  if (encoding.format.text != WriterFormat::kNone) return;
  const ImageSpec& spec = encoding.spec;
  const Carried lost = to_be_said(spec, encoding.depth, false);
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

Encoding choose_encoding(const std::string& path, const ImageSpec& picture, const WriteOptions& options) {
  const WriterFormat& format = require_format(path);
  const Depth depth = resolve_depth(path, format, options.depth);
  Encoding encoding{format, depth, stored_picture(format, picture), false};
  encoding.tripled = encoding.spec.channels.size() != picture.channels.size();
  check_size(path, format, encoding.spec);
  check_channels(path, format, encoding.spec);
  check_compression(path, format, options.compression);
  return encoding;
}

}  // namespace image

Depth parse_depth(const std::string& text) {
  for (const Depth depth : {Depth::kUint8, Depth::kUint16, Depth::kHalf, Depth::kFloat})
    if (text == image::depth_name(depth)) return depth;
  throw_usage("--depth: '" + text + "' is not one of 8, 16, half, float");
}

bool is_display_encoded_format(const std::string& path, Depth depth) {
  const image::WriterFormat& format = image::require_format(path);
  if (format.name == "tiff") return image::is_integer(depth);
  return !format.linear;
}

std::unique_ptr<ImageWriter> ImageWriter::open(const std::string& path, const ImageSpec& spec,
                                               const WriteOptions& options) {
  return image::picture_library().open_writer(path, image::choose_encoding(path, spec, options), options);
}

void write_image(const std::string& path, const Image& image, const WriteOptions& options) {
  const auto writer = ImageWriter::open(path, image.spec, options);
  writer->write_rows(0, image.spec.height, image.pixels.data(), image.row_floats());
  writer->commit();
}

}  // namespace triad
