// SPDX-License-Identifier: Apache-2.0
// What a picture is, apart from its pixels, and pictures small enough to hold whole.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace triad {

// Fine cells per display pixel. {1,1}: a standard picture. {3,1}: a wide render for RGB stripes.
struct Cells {
  int x = 1, y = 1;
  bool operator==(const Cells&) const = default;
};
// "3x1". Throws Error(kUsage) naming `option`; each side is in 1..64.
Cells parse_cells(const std::string& text, const std::string& option);

// Header attributes that travel with a picture from file to file (camera, author, time code ...), typed as
// the file had them. Copies share nothing. What describes the pixels themselves (size, channels, encoding,
// compression) is in ImageSpec or belongs to the file, and is not kept here.
class Metadata {
 public:
  Metadata();
  ~Metadata();
  Metadata(const Metadata&);
  Metadata(Metadata&&) noexcept;
  Metadata& operator=(const Metadata&);
  Metadata& operator=(Metadata&&) noexcept;

  // The value as text, whatever its type.
  std::optional<std::string> get(const std::string& key) const;
  void set(const std::string& key, const std::string& value);
  void erase(const std::string& key);
  // All entries as (key, text), in file order.
  std::vector<std::pair<std::string, std::string>> entries() const;

  struct Impl;  // an OpenImageIO::ParamValueList, known to image/ only
  const Impl& impl() const { return *impl_; }
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

struct ImageSpec {
  int width = 0, height = 0;          // pixels of the display window
  std::vector<std::string> channels;  // names, in interleaving order: "R" "G" "B" "A" "Z" "diffuse.R" ...
  int alpha = -1;                     // index of the alpha channel, or -1. Colour is associated (premultiplied)
  int colour_channels = 0;            // the first this many are colour: 3 (RGB), 1 (grey), 0 (data only)
  Cells cells;
  double pixel_aspect = 1;  // width of a pixel over its height; a wide render's is 1/3
  // What the values mean: a name for ColourConfig::resolve(), or "" for unknown or not colour. A reader puts
  // the file's own statement here ("sRGB", "Linear", a name).
  std::string colour_space;
  // rx ry gx gy bx by wx wy, as EXR stores them: of a file that says so, and for a file that shall say so.
  // Whoever converts the colour of the pixels changes or clears it.
  std::optional<std::array<float, 8>> chromaticities;
  Metadata metadata;

  int channel_count() const { return static_cast<int>(channels.size()); }
  // "1200x225 RGBA", for messages.
  std::string size_text() const;
};

// A whole picture in memory: float32, interleaved, top row first.
struct Image {
  ImageSpec spec;
  std::vector<float> pixels;  // width * height * channel_count()

  float* row(int y) { return pixels.data() + static_cast<size_t>(y) * row_floats(); }
  const float* row(int y) const { return pixels.data() + static_cast<size_t>(y) * row_floats(); }
  size_t row_floats() const { return static_cast<size_t>(spec.width) * spec.channels.size(); }
};

}  // namespace triad
