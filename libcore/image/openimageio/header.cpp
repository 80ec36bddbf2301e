// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/image/internal/carried.hpp>
#include <triad/image/internal/header.hpp>

namespace triad::image {
namespace {

std::string text_attribute(const OIIO::ImageSpec& spec, const char* name) {
  return spec.get_string_attribute(name).c_str();
}

// What the file says of its colour, and where it says so.
void find_colour_space(const std::string& path, const std::string& format, const OIIO::ImageSpec& from,
                       const Carried& carried, ImageSpec& spec, FileInfo& info) {
  const bool integer = !from.format.is_floating_point();
  const bool display_format = integer && (from.format.size() <= 2);
  spec.colour_space = display_format && format != "openexr" && format != "hdr" ? "sRGB" : "Linear";
  info.colour_space_from = "format";
  const auto from_metadata = [&](const std::string& name) {
    spec.colour_space = name;
    info.colour_space_from = "metadata";
  };
  if (const std::string own = text_attribute(from, "triad:colour_space"); !own.empty()) return from_metadata(own);
  if (!carried.colour_space.empty()) return from_metadata(carried.colour_space);
  if (format == "openexr" || format == "hdr") return;

  const std::string profile = lower(text_attribute(from, "ICCProfile:profile_description"));
  const auto profile_has = [&profile](const char* word) { return profile.find(word) != std::string::npos; };
  if (!profile.empty()) {
    if (profile_has("linear")) return from_metadata("Linear");
    if (profile_has("display p3")) return from_metadata("display_p3");
    if (!profile_has("srgb") && display_format)
      warn("'" + path + "' has the colour profile '" + text_attribute(from, "ICCProfile:profile_description") +
           "', which is taken as sRGB; say --from if that is wrong");
  }
  const std::string stated = text_attribute(from, "oiio:ColorSpace");
  if (lower(stated) == "linear") return from_metadata("Linear");
  if (lower(stated) == "srgb" && !display_format && format == "png") return from_metadata("sRGB");
  const float gamma = from.get_float_attribute("oiio:Gamma", 0.f);
  if (std::abs(gamma - 1.f) < 1e-3f) return from_metadata("Linear");
}

void find_cells(const std::string& path, const OIIO::ImageSpec& from, const Carried& carried,
                const ReadOptions& options, ImageSpec& spec, FileInfo& info) {
  const float aspect = from.get_float_attribute("PixelAspectRatio", 1.f);
  spec.pixel_aspect = std::isfinite(aspect) && aspect > 1e-3f && aspect < 1e3f ? aspect : 1;
  info.cells_from = "default";
  const int n = static_cast<int>(std::lround(1 / spec.pixel_aspect));
  if (n >= 2 && n <= 16 && std::abs(spec.pixel_aspect * n - 1) <= 1e-3) {
    spec.cells = {n, 1};
    info.cells_from = "pixel aspect";
  }
  std::string own = text_attribute(from, "triad:cells");
  if (own.empty()) own = carried.cells;
  if (!own.empty()) try {
      spec.cells = parse_cells(own, "triad:cells");
      info.cells_from = "metadata";
    } catch (const Error& error) {
      warn("'" + path + "': " + error.what());
    }
  if (options.cells) {
    spec.cells = *options.cells;
    info.cells_from = "option";
  }
  // A number of cells that the user or we stated is exact, a stored aspect rounded or (Blender's) not set.
  if (spec.cells.x != spec.cells.y || info.cells_from == "option")
    spec.pixel_aspect = static_cast<double>(spec.cells.y) / spec.cells.x;
}

}  // namespace

void describe(const std::string& path, const std::string& format, const OIIO::ImageSpec& from,
              const ReadOptions& options, const ChannelChoice& choice, ImageSpec& spec, FileInfo& info) {
  info.format = format;
  info.pixel_type = from.format.c_str();
  info.compression = text_attribute(from, "compression");
  info.tiled = from.tile_width > 0;
  info.tile_width = from.tile_width;
  info.tile_height = from.tile_height;
  info.all_channels = from.channelnames;
  // Only EXR means its windows; PNG's offset and TIFF's position place a picture on paper.
  const bool windows = format == "openexr" && from.full_width > 0 && from.full_height > 0;
  spec.width = windows ? from.full_width : from.width;
  spec.height = windows ? from.full_height : from.height;
  info.data_x = windows ? from.x - from.full_x : 0;
  info.data_y = windows ? from.y - from.full_y : 0;
  info.data_width = from.width;
  info.data_height = from.height;

  spec.channels = choice.names;
  spec.alpha = choice.alpha;
  spec.colour_channels = choice.colour_channels;

  std::string description = text_attribute(from, "ImageDescription");
  const Carried carried = take_carried(description);
  find_cells(path, from, carried, options, spec, info);
  find_colour_space(path, format, from, carried, spec, info);
  if (choice.colour_channels == 0) spec.colour_space.clear();
  if (!options.colour_space.empty()) {
    spec.colour_space = options.colour_space;
    info.colour_space_from = "option";
  }
  const OIIO::ParamValue* xy = from.find_attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8));
  if (xy) {
    std::array<float, 8> values;
    for (int i = 0; i < 8; ++i) values[i] = xy->get_float_indexed(i);
    info.chromaticities = spec.chromaticities = values;
  }
  for (const auto& attribute : from.extra_attribs) {
    const std::string name = attribute.name().string();
    const bool empty_text = attribute.type() == OIIO::TypeString && attribute.get_string().empty();
    if (describes_encoding(name) || empty_text) continue;
    std::string text = attribute.type() == OIIO::TypeString ? attribute.get_string() : "";
    const std::string whole = text;
    take_carried(text);
    if (text == whole)
      spec.metadata.impl().list.push_back(attribute);
    else if (name == "ImageDescription" && !text.empty())  // others (IPTC's caption) are OpenImageIO's copies of it
      spec.metadata.set(name, text);
  }
}

int block_rows(const std::string& format, const OIIO::ImageSpec& spec) {
  if (spec.tile_width > 0) return spec.tile_height;
  const std::string compression = spec.get_string_attribute("compression").c_str();
  if (format == "openexr") {
    if (compression == "zip" || compression == "pxr24") return 16;
    if (compression == "piz" || compression == "b44" || compression == "b44a") return 32;
    if (compression.rfind("dwaa", 0) == 0) return 32;
    if (compression.rfind("dwab", 0) == 0) return 256;
  }
  if (format == "tiff") {
    const int rows = spec.get_int_attribute("tiff:RowsPerStrip", 1);
    const bool separate = spec.get_string_attribute("planarconfig") == "separate";
    // Long strips are read a row at a time, which libtiff can do for ascending rows without starting again.
    constexpr double kMostStrip = 64 << 20;  // bytes
    if ((compression != "none" && !compression.empty()) || separate) {
      const int64_t used = std::min<int64_t>(rows, spec.height);
      if (used > 0 && static_cast<double>(used) * static_cast<double>(spec.scanline_bytes(true)) <= kMostStrip)
        return static_cast<int>(used);
    }
  }
  return 1;
}

}  // namespace triad::image
