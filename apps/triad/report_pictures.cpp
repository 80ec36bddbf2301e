// SPDX-License-Identifier: Apache-2.0
#include "report_pictures.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <triad/base/error.hpp>

namespace triad::app {
namespace {

// IEEE 754 binary16, if it has the value; NaN keeps no payload.
std::optional<uint16_t> half_of(float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  const auto sign = static_cast<uint16_t>(bits >> 16 & 0x8000);
  const int exponent = static_cast<int>(bits >> 23 & 0xff) - 127;
  const uint32_t fraction = bits & 0x7fffff;
  if (exponent == 128) return static_cast<uint16_t>(sign | 0x7c00 | (fraction ? 0x200 : 0));
  if (exponent == -127) return fraction ? std::nullopt : std::optional(sign);  // 0; floats' subnormals are too small
  if (exponent > 15 || exponent < -24) return std::nullopt;
  // Of a subnormal half, whose unit is 2^-24, the leading 1 is written out.
  const int dropped = exponent >= -14 ? 13 : -1 - exponent;
  const uint32_t whole = exponent >= -14 ? fraction : fraction | 0x800000;
  if (whole & ((uint32_t{1} << dropped) - 1)) return std::nullopt;
  const uint32_t biased = exponent >= -14 ? static_cast<uint32_t>(exponent + 15) << 10 : 0;
  return static_cast<uint16_t>(sign | biased | whole >> dropped);
}

uint32_t code_of(float linear) {
  const double v = linear > 0 ? std::min(static_cast<double>(linear), 1.) : 0.;  // NaN is 0
  return static_cast<uint32_t>(std::lround(255 * (v <= .0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - .055)));
}

uint32_t bits_of(float value, PackedFormat format) {
  switch (format) {
    case PackedFormat::kCodes: return code_of(value);
    case PackedFormat::kHalf: return half_of(value).value_or(0x7e00);
    case PackedFormat::kFloat: break;
  }
  return std::bit_cast<uint32_t>(value);
}

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t there = std::min<size_t>(3, bytes.size() - i);
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (k < there ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) text += k <= there ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace

const char* format_name(PackedFormat format) {
  return format == PackedFormat::kCodes ? "u8" : format == PackedFormat::kHalf ? "f16" : "f32";
}

PackedFormat exact_format(const std::vector<float>& rgb) {
  const bool fits = std::all_of(rgb.begin(), rgb.end(), [](float v) { return half_of(v).has_value(); });
  return fits ? PackedFormat::kHalf : PackedFormat::kFloat;
}

std::string pack(const std::vector<float>& rgb, PackedFormat format) {
  const size_t pixels = rgb.size() / 3;
  const size_t width = format == PackedFormat::kCodes ? 1 : format == PackedFormat::kHalf ? 2 : 4;
  std::vector<unsigned char> planes(3 * pixels * width);
  for (size_t channel = 0; channel < 3; ++channel) {
    unsigned char* plane = planes.data() + channel * width * pixels;
    uint32_t before = 0;
    for (size_t i = 0; i < pixels; ++i) {
      const uint32_t bits = bits_of(rgb[3 * i + channel], format);
      for (size_t k = 0; k < width; ++k) {
        const size_t shift = 8 * (width - 1 - k);
        plane[k * pixels + i] = static_cast<unsigned char>((bits >> shift) - (before >> shift));
      }
      before = bits;
    }
  }
  constexpr int kLevel = 4;  // the low bytes of noise do not become smaller, however long one tries
  uLongf size = compressBound(static_cast<uLong>(planes.size()));
  std::vector<unsigned char> stream(size);
  if (compress2(stream.data(), &size, planes.data(), static_cast<uLong>(planes.size()), kLevel) != Z_OK)
    throw_internal("zlib cannot compress a picture");
  stream.resize(size);
  return base64(stream);
}

}  // namespace triad::app
