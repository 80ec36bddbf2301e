// SPDX-License-Identifier: Apache-2.0
// A large picture as a source: strategies tried on what any renderer has drawn.
#pragma once

#include <memory>
#include <string>
#include <triad/colour/colour.hpp>
#include <triad/image/image.hpp>
#include <triad/sampling/source.hpp>

namespace triad {

struct ImageSourceOptions {
  bool geometry = true;      // keep depth, positions, normals and ids where the file has them
  uint64_t most_bytes = 0;   // of memory for the picture; 0: half of the machine's
  std::string colour_space;  // what its values mean, where the file says nothing or the wrong thing
};

// The film of width_px * cells.x by height_px * cells.y pixels shows the whole picture, whose pixels are the finest
// detail there is: a sample is the pixel that it lies in, in linear light with BT.709 primaries. Values that are in
// no known space are taken as they are, and so is light without coverage; alpha is left out. Samples of pixels that
// are not finite are not valid. integral() is the mean of the box's pixels by the areas that they have in it, without
// those that are not finite; 0 if none is. Beyond the picture its edge goes on.
//
// Geometry, by the channels' names in any case, in a layer or not ("ViewLayer.Depth.Z"): distance Z, depth, depth.Z,
// depth.V or zdepth, a miss from 1e9 on (what renderers write for the sky); position P.X P.Y P.Z or position.X ...;
// normal N.X N.Y N.Z or normal.X ...; object_id or indexob.X, and material_id or indexma.X. Without a position, it is
// (0, 0, -distance). Without a distance, it is 1 where there is an object or position. abilities().known says what
// the file has itself.
//
// Reads the whole picture, by strips, which Ctrl-C ends. Thread-safe as Source asks. Throws what ImageReader::open()
// does; Error(kInput) if the film has more pixels than the picture along a side, or the picture does not fit into
// memory; Error(kUsage) for an unknown colour_space. Pixels that are not finite, and a film of another shape than the
// picture's, are warnings.
std::unique_ptr<Source> make_image_source(const std::string& path, int width_px, int height_px, const Cells& cells,
                                          const ColourConfig& colours, const ImageSourceOptions& options = {});

}  // namespace triad
