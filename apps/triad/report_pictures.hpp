// SPDX-License-Identifier: Apache-2.0
// Pictures as text that the report's page unpacks (apps/viewer/src/codec.ts).
#pragma once

#include <string>
#include <triad/image/image.hpp>
#include <vector>

namespace triad::app {

enum class PackedFormat { kCodes, kHalf, kFloat };
const char* format_name(PackedFormat format);  // "u8", "f16", "f32"

// The narrowest format that keeps all bits of the values: half or float.
PackedFormat exact_format(const std::vector<float>& rgb);

// Base64 of a zlib stream of `rgb`, interleaved: for each channel, for each byte of the format from the highest to
// the lowest, that byte of all values, each as the difference (modulo 256) from the one before, the first from 0.
// kCodes takes linear light and packs sRGB codes of 8 bits (IEC 61966-2-1), clamped to [0, 1].
std::string pack(const std::vector<float>& rgb, PackedFormat format);

}  // namespace triad::app
