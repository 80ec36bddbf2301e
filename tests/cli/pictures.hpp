// SPDX-License-Identifier: Apache-2.0
// Pictures for the tests, made and read by OpenImageIO alone, so that a mistake in Triad's own reading and
// writing cannot hide itself; and files that only pretend to be pictures.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace cli {

struct Picture {
  int width = 0, height = 0, channels = 3;
  std::vector<float> values;                // interleaved, top row first
  std::map<std::string, std::string> text;  // header attributes
  double pixel_aspect = 1;
  std::string pixel_type;                  // as read: "half", "uint8" ...
  std::vector<std::string> channel_names;  // R, G, B, A if empty

  float at(int x, int y, int c) const { return values[static_cast<size_t>((y * width + x) * channels + c)]; }
};

Picture constant(int width, int height, std::vector<float> colour);
// value(x, y, c)
Picture from_function(int width, int height, int channels, const std::function<double(int, int, int)>& value);
// Values in [0, 1] without a pattern, the same on every run.
Picture noise(int width, int height, int channels = 3, uint32_t seed = 1);

// type: "uint8", "uint16", "half", "float"; "" what the format likes best. Values are stored as they are.
void save(const std::string& path, const Picture& picture, const std::string& type = "float");
// Integers become value / maximum.
Picture load(const std::string& path);

void save_text(const std::string& path, const std::string& text);
std::string load_text(const std::string& path);
// The first `share` of a file's bytes, to another.
void truncate_copy(const std::string& from, const std::string& to, double share);
// A file whose header says width x height, in the format that the extension names (exr, png, tif, hdr), with
// next to no pixels behind it. The TIFF, where its 32-bit offsets reach, is whole and black: a file with holes,
// that takes no room on the disk.
void save_claim(const std::string& path, uint32_t width, uint32_t height);

// IEC 61966-2-1, from linear light and back.
double srgb_encode(double linear);
double srgb_decode(double encoded);

}  // namespace cli
