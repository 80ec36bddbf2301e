// SPDX-License-Identifier: Apache-2.0
// Writes the bundled scenes into the folder named: make_scenes data/scenes
#include <cstdio>
#include <exception>

#include "shapes.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: make_scenes FOLDER\n", stderr);
    return 2;
  }
  try {
    const std::string folder = std::string(argv[1]) + "/";
    make_scenes::make_flat_scenes(folder);
    make_scenes::make_solid_scenes(folder);
    make_scenes::make_room(folder);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_scenes: %s\n", error.what());
    return 1;
  }
  return 0;
}
