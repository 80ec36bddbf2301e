// SPDX-License-Identifier: Apache-2.0
// Reading picture files by strips: EXR, PNG, TIFF, Radiance HDR, JPEG and whatever else OpenImageIO reads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <triad/image/image.hpp>
#include <vector>

namespace triad {

struct ReadOptions {
  std::string part;                   // of a multi-part file, by name or number from 0; "" the first
  std::string layer = {};             // of a multi-layer file, see ImageReader; "" what is outside its layers
  std::vector<std::string> channels;  // which, in this order, by name as in the file; {} see ImageReader::open
  std::string colour_space;           // overrides what the file says (--from)
  std::optional<Cells> cells;         // overrides what the file says (--cells)
  bool all_channels = false;          // keep AOVs beside colour and alpha
  bool straight_alpha = false;        // colour not multiplied by alpha, whichever way the file has it
};

// One thing in a file that can be chosen by ReadOptions::part.
struct PartInfo {
  std::string name;  // may be ""
  int width = 0, height = 0;
  std::vector<std::string> channels;
};

struct FileInfo {
  std::string format;       // "openexr", "png", ... as OpenImageIO names them
  std::string pixel_type;   // "half", "float", "uint8", "uint16", ...
  std::string compression;  // "" if none or unknown
  bool tiled = false;
  int tile_width = 0, tile_height = 0;
  int data_x = 0, data_y = 0, data_width = 0, data_height = 0;  // the data window, relative to the display window
  std::vector<PartInfo> parts;
  std::vector<std::string> all_channels;               // of the chosen part, as in the file
  std::optional<std::array<float, 8>> chromaticities;  // rx ry gx gy bx by wx wy, if the header states them
  std::string cells_from;  // why ImageSpec::cells is what it is: "metadata", "pixel aspect", "option", "default"
  std::string colour_space_from;  // "option", "metadata", "format"
};

// A file that is open for reading, one part of it. Not thread-safe: one thread at a time.
//
// The picture is the display window. Where the data window does not cover it, pixels are 0; data outside
// the display window is left out. Integer samples become value / maximum. Unassociated alpha is associated
// on reading (unless ReadOptions::straight_alpha asks for the opposite). Nothing is colour-converted:
// ImageSpec::colour_space says what the values mean.
//
// Channels: colour first ("R","G","B" in any case, or a single "Y" or other single channel as grey), then
// alpha ("A"), then, with all_channels, the others by their names. A layer's channels ("diffuse.R") count as
// others unless asked for by name; asking for exactly "x.R","x.G","x.B"[,"x.A"] makes them the colour.
// In another order, they are still the colour, and their order is a swap: channels = {"B","G","R"} is the picture
// with red and blue exchanged, its channels called R, G and B (position decides, in every format it is written
// to). channels = {"diffuse"} asks for all channels of that layer. Names unknown to the file are an error that
// lists what there is.
//
// Layers: with ReadOptions::layer, the channels of one layer, in whichever part it lies (of ReadOptions::part, where
// that is given): "NAME.R", "NAME.G", "NAME.B" and "NAME.A" as colour, where NAME may itself have dots; "NAME.X",
// "NAME.Y", "NAME.Z", or a single channel, called NAME or NAME and anything, as data, which has no colour space (but
// "NAME.Y" is grey); in a file of several parts also what the part called NAME holds outside its layers. Layers whose
// names say that they are no colour (normal, position, depth, uv, motion, velocity, variance) are data also as R, G
// and B. NAME may be in another case, or the end of one layer's name after a dot. ReadOptions::channels must be empty
// then.
//
// Cells: the metadata "triad:cells" ("3x1") wins over the pixel aspect (1/n is taken as n x 1 for n = 2..16,
// within 1e-3); ReadOptions::cells wins over both.
class ImageReader {
 public:
  // Throws Error(kInput) that names the file: missing, a folder, empty, not a picture, truncated header,
  // absurd size (more than 2^31-1 pixels on a side, or more than 2^40 samples), unknown part or channel, deep.
  static std::unique_ptr<ImageReader> open(const std::string& path, const ReadOptions& options = {});
  virtual ~ImageReader() = default;

  virtual const ImageSpec& spec() const = 0;
  virtual const FileInfo& info() const = 0;
  virtual const std::string& path() const = 0;

  // Rows [y0, y1), all channels of spec(), interleaved; row y goes to out + (y - y0) * row_stride floats.
  // Any order is allowed, ascending is cheap: blocks (tiles, compressed row groups) are decoded once when
  // strips ascend, and a strip that begins inside a block already decoded does not decode it again.
  // Throws Error(kInput) with the file's name on truncated or corrupt data.
  virtual void read_rows(int y0, int y1, float* out, size_t row_stride) = 0;

  // Rows per block that the file decodes together: 1, a tile's height, or a compression block's.
  virtual int block_rows() const = 0;

  // What the decoder itself holds beyond blocks of rows, once the first row was read: the whole picture as stored
  // for an interlaced PNG and for formats that OpenImageIO reads whole (all but EXR, PNG, TIFF, JPEG and HDR), its
  // coefficients for a JPEG of several scans (progressive ones are); else 0.
  virtual uint64_t decoder_bytes() const = 0;
};

// Whether the name ends as those of pictures do that can be read; the file need not exist.
bool has_picture_extension(const std::string& path);

// The whole picture. Throws as the reader does.
Image read_image(const std::string& path, const ReadOptions& options = {});

}  // namespace triad
