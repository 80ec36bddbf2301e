// SPDX-License-Identifier: Apache-2.0
// Pictures for people: error maps in colours, and sheets that show reference, test and maps next to each other.
#pragma once

#include <string>
#include <triad/colour/colour.hpp>
#include <triad/image/colour_map.hpp>
#include <triad/pipeline/run.hpp>
#include <vector>

namespace triad::app {

// An error map in a float file, and how it is to be shown. A map of several channels is shown by their mean.
struct ShownMap {
  std::string file, label;
  ColourMap colours = ColourMap::kMagma;
  MapScale scale;
};

// The scale that a map's values ask for: ScaleFinder's over the means of its pixels' channels, {0, 0} where there
// are none but 0. Reads the file by strips. Throws Error(kInput).
MapScale find_map_scale(const std::string& file);

// Writes an 8-bit picture of the map. Strips of 64 rows are in memory. Throws Error.
void draw_map(const ShownMap& map, const std::string& path);

struct SheetOptions {
  double exposure_ev = 0;
};

// Writes an 8-bit picture with, from left to right, the reference, the test picture and each map, each whole and at
// its own size, but for a reference of n x m cells for each pixel of the test, whose cells are averaged. Below each
// map is its scale. Strips of 64 rows of each are in memory. Throws Error.
//
// Light is multiplied by 2^exposure_ev. Unless both pictures are display-encoded, it then passes a curve that leaves
// values up to .75 as they are and bends those above towards 1, which nothing reaches: y = .75 + .25 t / (t + .25)
// with t = x - .75.
void draw_sheet(const PictureRequest& reference, const PictureRequest& test, const std::vector<ShownMap>& maps,
                const SheetOptions& options, const ColourConfig& colours, const std::string& path);

}  // namespace triad::app
