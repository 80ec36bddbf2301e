// SPDX-License-Identifier: Apache-2.0
// How a panel turns pixel values into light: which emitter lies where and what drives it.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace triad {

// A share of an emitter's light, in one fine cell. Cells are counted from the tile's top left corner and may
// lie outside the tile: such light falls on a neighbour's ground.
struct EmitterCell {
  int x = 0, y = 0;
  double share = 0;
};

// The channel of emitters that the panel drives itself, see Layout::derives_white.
inline constexpr int kWhiteChannel = 3;

inline constexpr int kMaxEmitters = 64;  // of a tile; far above PenTile's 8 on 2 x 2 pixels

// One single-coloured emitter of a tile, a subpixel.
struct Emitter {
  std::string name;
  std::array<double, 3> primary{};  // its light at full drive, linear RGB of the panel; (1, 0, 0) a plain red
  int pixel_x = 0, pixel_y = 0;     // the pixel of the tile that drives it
  int channel = 0;                  // and that pixel's channel: 0 red, 1 green, 2 blue, kWhiteChannel
  std::vector<EmitterCell> cells;   // shares sum to 1

  // Centre of its light, in cells from the tile's left (top) edge; the middle of cell 0 is .5.
  double centre_x() const;
  double centre_y() const;
};

// A tile of the panel. A pixel is cut into cells_x * cells_y fine cells; a tile has tile_x * tile_y pixels.
// A white picture gives white light: the primaries sum to tile_x * tile_y * (1, 1, 1), those of derived white
// emitters apart. No two emitters have the same pixel and channel. A pixel's channel without an emitter lights
// nothing.
//
// The light of a picture, per fine cell: sum over emitters of drive * primary * share * cells_x * cells_y.
// Cell k covers the picture's ground from k / cells_x to (k + 1) / cells_x pixels.
struct Layout {
  std::string name, summary;
  int cells_x = 1, cells_y = 1;
  int tile_x = 1, tile_y = 1;
  // The rule w = min(r, g, b) of white OLED panels: the emitter of kWhiteChannel shows the smallest of its pixel's
  // three values, and the emitters r, g and b show what is left of theirs. Then each pixel has all four, and
  // white's light is that of the three together, so that the rule keeps every pixel's colour.
  bool derives_white = false;
  std::vector<Emitter> emitters;

  // Cells of a pixel (G) and of a tile (S).
  int pixel_cells() const { return cells_x * cells_y; }
  int tile_cells() const { return pixel_cells() * tile_x * tile_y; }
  // Whether rows of a picture are independent and every pixel is alike: one row of cells, tiles of one
  // pixel, all light within the pixel, each channel driving exactly one emitter. Stripes are.
  bool is_rows() const;
  // Whether light stays within the row of pixels that drives it, in one row of cells, on any such panel: rows can
  // then be solved one by one.
  bool has_independent_rows() const;
  // For layouts with is_rows(): the index of the emitter that `channel` drives.
  int emitter_of(int channel) const;
};

// Reads a layout from TOML text (format: data/layouts/rgb.toml) and checks everything Layout promises, sizes
// (1..16 cells and pixels a side, at most 64 emitters), that each colour has an emitter and that no key is unknown.
// `origin` names the text in messages. Throws Error(kInput).
Layout parse_layout(const std::string& text, const std::string& origin);

// By name, from data_folder()/layouts; or from a file, if the argument contains "/" or ends in ".toml".
// Throws Error(kUsage) for an unknown name, with the nearest one and the list; Error(kInput) for a bad file.
Layout load_layout(const std::string& name_or_path);

// The names that load_layout knows, sorted.
std::vector<std::string> layout_names();

// For what works on rows only. Throws Error(kUsage) naming the layout unless is_rows().
void require_rows(const Layout& layout);

}  // namespace triad
