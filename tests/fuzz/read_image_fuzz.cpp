// SPDX-License-Identifier: Apache-2.0
// libFuzzer over ImageReader: any bytes are a picture or one Error. The first byte chooses the extension, which
// decides for formats that have no unmistakable first bytes.
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <triad/base/error.hpp>
#include <triad/base/log.hpp>
#include <triad/image/reader.hpp>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  static const char* const kExtensions[] = {"exr", "png", "tif", "hdr", "jpg"};
  static const std::string folder =
      std::filesystem::temp_directory_path().string() + "/triad-fuzz-" + std::to_string(getpid());
  std::filesystem::create_directories(folder);
  const std::string path = folder + "/a." + kExtensions[data[0] % std::size(kExtensions)];
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data + 1), static_cast<std::streamsize>(size - 1));
  try {
    triad::ReadOptions options;
    options.all_channels = true;
    const auto reader = triad::ImageReader::open(path, options);
    const auto& spec = reader->spec();
    const size_t row = static_cast<size_t>(spec.width) * spec.channels.size();
    constexpr size_t kMostRow = 1 << 22;  // floats; the claim may be true of a file that compresses well
    if (row > kMostRow) return 0;
    std::vector<float> rows(row * 8);
    // The first rows, then some from the middle: both directions of travel.
    for (const int y : {0, 8, 4, spec.height / 2})
      if (y < spec.height) reader->read_rows(y, std::min(spec.height, y + 8), rows.data(), row);
  } catch (const triad::Error& error) {
    if (std::string(error.what()).find('\n') != std::string::npos) std::abort();
  }
  return 0;
}
