// SPDX-License-Identifier: Apache-2.0
// From OpenImageIO's description of a file to ours. Not installed.
#pragma once

#include <string>
#include <triad/image/internal/oiio.hpp>
#include <triad/image/reader.hpp>
#include <vector>

namespace triad::image {

// The channels a picture is made of: indices into the file's, colour first, as ImageReader documents them.
struct ChannelChoice {
  std::vector<int> file_indices;
  std::vector<std::string> names;       // of the picture's channels; the file's, but see ImageReader on R, G, B
  int alpha = -1, colour_channels = 0;  // as in ImageSpec
};

// Throws Error(kInput) that lists what there is when a name is unknown or nothing can be colour.
ChannelChoice choose_channels(const std::string& path, const std::vector<std::string>& in_file,
                              const ReadOptions& options);

// The part of the file that holds ReadOptions::layer, and which of its channels that is. only_part: look there only,
// unless it is -1. Throws Error(kInput) that lists the layers there are, or the channels of a layer that is no
// picture.
struct LayerChoice {
  int part = 0;
  ChannelChoice channels;
};
LayerChoice choose_layer(const std::string& path, const std::vector<PartInfo>& parts, int only_part,
                         const std::string& layer);

// A channel's name up to its last dot, "" without one; and what is behind it, in lower case.
std::string layer_of(const std::string& channel);
std::string base_of(const std::string& channel);
bool is_alpha(const std::string& channel);
int component(const std::string& channel);  // 0 1 2 for R G B, else -1

// The index of the alpha channel that belongs to the file's top-level colour, or -1.
int find_alpha(const std::vector<std::string>& in_file);

// Fills everything of `spec` and `info` that does not depend on other parts of the file.
void describe(const std::string& path, const std::string& format, const OIIO::ImageSpec& from,
              const ReadOptions& options, const ChannelChoice& choice, ImageSpec& spec, FileInfo& info);

// Rows that the file decodes together, and what they are aligned to is the data window's first row.
int block_rows(const std::string& format, const OIIO::ImageSpec& spec);

}  // namespace triad::image
