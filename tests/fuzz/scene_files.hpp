// SPDX-License-Identifier: Apache-2.0
// What lies beside a fuzzed scene, so that names of files in it can mean something.
#pragma once

#include <fstream>
#include <string>
#include <triad/image/writer.hpp>

namespace scene_files {

inline constexpr const char* kPictures[] = {"picture.png", "picture.exr", "grey.png"};
inline constexpr const char* kBuffer = "buffer.bin";

// 4 x 4 pixels with alpha in PNG and EXR, 2 x 2 grey ones, and a buffer whose first 36 bytes are the triangle
// (0,0,0) (1,0,0) (0,1,0).
inline void put(const std::string& folder) {
  triad::Image image;
  image.spec.width = image.spec.height = 4;
  image.spec.channels = {"R", "G", "B", "A"};
  image.spec.colour_channels = 3;
  image.spec.alpha = 3;
  for (int i = 0; i < 16; ++i) {
    const float v = static_cast<float>(i) / 15, alpha = i % 3 == 0 ? 0.f : 1.f;
    image.pixels.insert(image.pixels.end(), {alpha * v, alpha * (1 - v), alpha * .5f, alpha});
  }
  triad::write_image(folder + "/" + kPictures[0], image);
  triad::write_image(folder + "/" + kPictures[1], image);
  triad::Image grey;
  grey.spec.width = grey.spec.height = 2;
  grey.spec.channels = {"Y"};
  grey.spec.colour_channels = 1;
  grey.pixels = {0, 1, .25f, .5f};
  triad::write_image(folder + "/" + kPictures[2], grey);
  const float corners[64] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::ofstream(folder + "/" + kBuffer, std::ios::binary)
      .write(reinterpret_cast<const char*>(corners), sizeof corners);
}

}  // namespace scene_files
