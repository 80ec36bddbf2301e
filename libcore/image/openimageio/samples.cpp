// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <mutex>
#include <triad/base/log.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>
#include <triad/image/internal/oiio.hpp>

namespace triad::image {
namespace {

template <typename T>
T load(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

template <typename T, typename Convert>
void convert(const std::byte* in, size_t stride, size_t count, float* out, size_t out_stride, Convert to_value) {
  for (size_t i = 0; i < count; ++i) out[i * out_stride] = to_value(load<T>(in + i * stride));
}

// v / maximum for every code, correctly rounded: multiplying by the reciprocal would miss some by one ulp.
template <size_t kCodes>
const std::array<float, kCodes>& code_table() {
  static const auto table = [] {
    std::array<float, kCodes> t{};
    for (size_t v = 0; v < kCodes; ++v) t[v] = static_cast<float>(v) / static_cast<float>(kCodes - 1);
    return t;
  }();
  return table;
}

// Every IEEE 754 binary16 value.
const std::array<float, 65536>& half_table() {
  static const auto table = [] {
    std::array<float, 65536> t{};
    for (uint32_t bits = 0; bits < 65536; ++bits) {
      const uint32_t sign = (bits & 0x8000) << 16, exponent = bits >> 10 & 31, fraction = bits & 1023;
      if (exponent == 0)  // zero or subnormal, in steps of 2^-24
        t[bits] = std::bit_cast<float>(std::bit_cast<uint32_t>(static_cast<float>(fraction) * 0x1p-24f) | sign);
      else  // the bias grows from 15 to 127; infinite and not-a-number keep all exponent bits set
        t[bits] = std::bit_cast<float>(sign | (exponent == 31 ? 255 : exponent + 112) << 23 | fraction << 13);
    }
    return t;
  }();
  return table;
}

}  // namespace

void prepare_oiio() {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  static int threads = -1;
  if (threads < 0) {
    // Our own checks compare the header with the file's length before this could matter; a fixed limit would
    // only refuse large pictures that go through in strips.
    OIIO::attribute("limits:imagesize_MB", 1 << 22);
    OIIO::attribute("tiff:half", 1);
  }
  if (threads != thread_limit()) {
    threads = thread_limit();
    OIIO::attribute("threads", threads);
    OIIO::attribute("exr_threads", threads);
  }
}

bool describes_encoding(const std::string& name) {
  static const char* const kPrefixes[] = {
      "oiio:", "openexr:", "tiff:", "jpeg:", "png:", "thumbnail_", "ICCProfile", "bmp:", "targa:"};
  for (const char* prefix : kPrefixes)
    if (name.rfind(prefix, 0) == 0) return true;
  static const char* const kNames[] = {"compression",
                                       "triad:cells",
                                       "triad:colour_space",
                                       "planarconfig",
                                       "PixelAspectRatio",
                                       "XResolution",
                                       "YResolution",
                                       "ResolutionUnit",
                                       "chromaticities",
                                       "Exif:ColorSpace",
                                       "Exif:PixelXDimension",
                                       "Exif:PixelYDimension",
                                       "textureformat",
                                       "tileDescription",
                                       "CompressionQuality",
                                       "thumbnail_image",
                                       "Exif:Gamma",
                                       "name",
                                       "type",
                                       "chunkCount",
                                       "version",
                                       "Exif:ComponentsConfiguration",
                                       "Exif:CompressedBitsPerPixel"};
  for (const char* known : kNames)
    if (name == known) return true;
  return false;
}

std::string one_line(const std::string& text, const std::string& path) {
  std::string out;
  for (const char c : text) {
    if (c == '\r') continue;
    if (c == '\n') {
      if (!out.empty() && out.back() != ' ') out += "; ";
    } else {
      out += c;
    }
  }
  // Libraries like to repeat the file's name, in quotes or before a colon.
  for (const std::string& repeated : {" \"" + path + "\"", " '" + path + "'", path + ": ", " " + path}) {
    for (size_t at = out.find(repeated); at != std::string::npos && !path.empty(); at = out.find(repeated))
      out.erase(at, repeated.size());
  }
  while (!out.empty() && (out.back() == '.' || out.back() == ' ' || out.back() == ';')) out.pop_back();
  constexpr size_t kLongest = 300;  // characters; the rest of such a message is a dump of the header
  if (out.size() > kLongest) out.resize(kLongest);
  return printable(out);
}

bool to_float(OIIO::TypeDesc type, bool plain_integers, const std::byte* in, size_t stride, size_t count, float* out,
              size_t out_stride) {
  const auto scale = [plain_integers](double maximum) { return plain_integers ? 1. : maximum; };
  switch (type.basetype) {
    case OIIO::TypeDesc::UINT8: {
      const auto& table = code_table<256>();
      convert<uint8_t>(in, stride, count, out, out_stride, [&table](uint8_t v) { return table[v]; });
      return true;
    }
    case OIIO::TypeDesc::UINT16: {
      const auto& table = code_table<65536>();
      convert<uint16_t>(in, stride, count, out, out_stride, [&table](uint16_t v) { return table[v]; });
      return true;
    }
    case OIIO::TypeDesc::INT8:
      convert<int8_t>(in, stride, count, out, out_stride,
                      [](int8_t v) { return std::max(-1.f, static_cast<float>(v) / 127.f); });
      return true;
    case OIIO::TypeDesc::INT16:
      convert<int16_t>(in, stride, count, out, out_stride,
                       [](int16_t v) { return std::max(-1.f, static_cast<float>(v) / 32767.f); });
      return true;
    case OIIO::TypeDesc::UINT32: {
      const double maximum = scale(4294967295.);
      convert<uint32_t>(in, stride, count, out, out_stride,
                        [maximum](uint32_t v) { return static_cast<float>(v / maximum); });
      return true;
    }
    case OIIO::TypeDesc::INT32: {
      const double maximum = scale(2147483647.);
      convert<int32_t>(in, stride, count, out, out_stride,
                       [maximum](int32_t v) { return static_cast<float>(v / maximum); });
      return true;
    }
    case OIIO::TypeDesc::HALF: {
      const auto& table = half_table();
      convert<uint16_t>(in, stride, count, out, out_stride, [&table](uint16_t v) { return table[v]; });
      return true;
    }
    case OIIO::TypeDesc::FLOAT:
      convert<float>(in, stride, count, out, out_stride, [](float v) { return v; });
      return true;
    case OIIO::TypeDesc::DOUBLE:
      convert<double>(in, stride, count, out, out_stride, [](double v) { return static_cast<float>(v); });
      return true;
    default: return false;
  }
}

unsigned quantise(float value, double maximum) {
  const double scaled = std::floor(static_cast<double>(value) * maximum + .5);
  if (!(scaled > 0)) return 0;  // also not-a-number
  return static_cast<unsigned>(std::min(scaled, maximum));
}

}  // namespace triad::image
