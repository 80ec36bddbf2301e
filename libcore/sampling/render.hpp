// SPDX-License-Identifier: Apache-2.0
// What surrounds a render: sizes as people type them, the picture with its header, the record of what it cost.
#pragma once

#include <string>
#include <triad/sampling/strategy.hpp>
#include <utility>
#include <vector>

namespace triad {

struct PictureSize {
  int width = 0, height = 0;  // display pixels
};
// "400x225"; each side at least 1. Throws Error(kUsage) naming `option`.
PictureSize parse_size(const std::string& text, const std::string& option);
struct CellsOfLayout {
  Cells cells;
  std::string layout;  // its name; "" where cells were given as numbers
};
// "3x1", or a layout's name or path, whose cells are taken. Throws as parse_cells() and load_layout() do.
CellsOfLayout parse_cells_or_layout(const std::string& text, const std::string& option);
// The size of the film of a render with cells. Throws Error(kUsage) if a side passes 2^31 - 1 pixels.
PictureSize film_size(const PictureSize& picture, const Cells& cells);
// "rmse=1e-3": the value, above 0. Throws Error(kUsage) naming `option`.
double parse_until(const std::string& text, const std::string& option);

// A number that says what was rendered, or how, as text: {"scene", "cornell.gltf"}.
using Facts = std::vector<std::pair<std::string, std::string>>;

// The names of those planes of geometry that a source cannot fill.
std::vector<std::string> missing_planes(const FilmPlanes& planes, const SourceAbilities& abilities);

// The header of the picture of a render: size, channels, cells, pixel aspect, scene-linear BT.709. `film` is the
// size of the film. Throws Error(kUsage) for planes.reasons of a strategy that has none.
ImageSpec render_spec(const PictureSize& film, const Cells& cells, const FilmPlanes& planes,
                      const Strategy& strategy);

// The picture with all that it took in its metadata, as "triad:NAME": the facts, strategy, seed, samples, dropped (if
// any were), rmse (the estimated one, if there is one), every kind of the source's work with _ for blanks, and
// partial = "true" where the render was ended early. Seconds are left out: they differ from run to run, and the
// same render shall give the same file.
Image render_picture(const RenderResult& result, const Strategy& strategy, const RenderOptions& options,
                     const Source& source, const Cells& cells, const Facts& facts);

}  // namespace triad
