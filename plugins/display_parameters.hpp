// SPDX-License-Identifier: Apache-2.0
// What the plugins that know about displays share: the library's errors and checks of the pictures.
#pragma once

#include <triad/abi/triad_plugin.hpp>

#include <cmath>
#include <string>
#include <triad/base/error.hpp>
#include <triad/display/layout.hpp>
#include <triad/display/vision.hpp>
#include <vector>

namespace display_parameters {

namespace tp = triad_plugin;

inline constexpr const char* kOriginDoc =
    "the panel's pixel on which the picture's first lies; counts for layouts whose tile is larger than a pixel";
inline constexpr double kOrigin[] = {0, 0};

// Calls the library and passes its errors on as the plugin's.
template <class F>
auto in_library(F&& body) {
  try {
    return body();
  } catch (const triad::Error& error) {
    switch (error.kind()) {
      case triad::ErrorKind::kUsage: throw tp::Error(TRIAD_E_PARAM, error.what());
      case triad::ErrorKind::kInput: throw tp::Error(TRIAD_E_INPUT, error.what());
      default: throw;
    }
  }
}

// The picture's phase on the panel, "x,y". It counts modulo the tile.
inline void check_origin(const std::vector<double>& origin) {
  const auto whole = [](double v) { return v == std::floor(v) && std::abs(v) <= 1e9; };
  if (origin.size() != 2 || !whole(origin[0]) || !whole(origin[1]))
    throw tp::Error(TRIAD_E_PARAM, "origin must be two whole numbers of pixels, x and y, as in origin=\"0,0\"");
}

inline std::string size_text(const triad_image& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height);
}

// Turns the header of a wide picture into that of the picture on the display. Refuses what is not wide.
inline void narrow(const triad_image& in, const triad::Layout& layout, triad_image& out) {
  const std::string needed = std::to_string(layout.cells_x) + "x" + std::to_string(layout.cells_y);
  if (in.cells_x == 1 && in.cells_y == 1 && layout.pixel_cells() != 1)
    throw tp::Error(TRIAD_E_INPUT, "the picture of " + size_text(in) + " has one cell a pixel, and layout " +
                                       layout.name + " needs a wide render of " + needed +
                                       " cells a pixel; if it is one, say --cells " + needed);
  if (in.cells_x != layout.cells_x || in.cells_y != layout.cells_y)
    throw tp::Error(TRIAD_E_INPUT, "the picture has " + std::to_string(in.cells_x) + "x" +
                                       std::to_string(in.cells_y) + " cells a pixel, and layout " + layout.name +
                                       " needs " + needed);
  const auto pixels = [](const char* side, int size, int cells) {
    if (size % cells != 0) {
      const int below = size - size % cells;
      throw tp::Error(TRIAD_E_INPUT, std::string("the ") + side + " " + std::to_string(size) +
                                         " is not a multiple of " + std::to_string(cells) + " cells; " +
                                         (below > 0 ? std::to_string(below) + " or " : "") +
                                         std::to_string(int64_t{below} + cells) + " would do");
    }
    return size / cells;
  };
  out.width = pixels("width", in.width, layout.cells_x);
  out.height = pixels("height", in.height, layout.cells_y);
  out.cells_x = out.cells_y = 1;
  out.pixel_aspect = in.pixel_aspect * layout.cells_x / layout.cells_y;
}

}  // namespace display_parameters
