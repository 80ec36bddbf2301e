// SPDX-License-Identifier: Apache-2.0
// What can be told about a picture file to be written before an encoder is there. Not installed.
#pragma once

#include <limits>
#include <string>
#include <triad/image/internal/carried.hpp>
#include <triad/image/writer.hpp>
#include <vector>

namespace triad::image {

struct WriterFormat {
  std::string name;  // as OpenImageIO calls it
  bool linear;       // whether its default depth holds scene-linear values
  Depth usual;
  std::vector<Depth> others;
  bool alpha = true, unassociated = false;
  enum Channels { kAny, kGreyOrRgb, kRgb, kGrey } channels = kGreyOrRgb;
  enum Text { kNone, kDescription, kFields } text = kNone;  // what there is to say a colour space in
  int most_px = std::numeric_limits<int>::max();            // of either side
};

// A picture and how a format stores it.
struct Encoding {
  const WriterFormat& format;
  Depth depth;     // never kDefault
  ImageSpec spec;  // as it is stored: grey three times for formats that know RGB only
  bool tripled;    // whether that is so
};

// Throws Error for whatever is wrong with the file's name or its extension, the depth, the picture's size and
// channels, and the compression.
Encoding choose_encoding(const std::string& path, const ImageSpec& picture, const WriteOptions& options);

bool is_integer(Depth depth);

// What a reader would not find out from the format and, if the file keeps it, the pixel aspect.
Carried to_be_said(const ImageSpec& spec, Depth depth, bool keeps_aspect);

// Warns of what the format cannot say of the picture.
void warn_of_loss(const std::string& path, const Encoding& encoding);

}  // namespace triad::image
