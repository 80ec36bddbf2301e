// SPDX-License-Identifier: Apache-2.0
// What the files of image/ share about OpenImageIO. Not installed.
#pragma once

#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <string>
#include <triad/image/image.hpp>

namespace triad {

struct Metadata::Impl {
  OIIO::ParamValueList list;
};

namespace image {

// Limits and thread counts of OpenImageIO, which are process-wide. Called before every open.
void prepare_oiio();

// Whether an attribute describes how a file stores its pixels (size, compression, tiles, colour encoding),
// so that it must not be carried into another file.
bool describes_encoding(const std::string& name);

// A library's message on one line, without the file's own name in front and without a trailing full stop.
std::string one_line(const std::string& text, const std::string& path);

// samples[i * stride] of `type` becomes out[i * out_stride] for i in [0, count): integers divided by their
// maximum (correctly rounded), or as they are if `plain_integers`. Returns false for a type unknown to it.
bool to_float(OIIO::TypeDesc type, bool plain_integers, const std::byte* samples, size_t stride, size_t count,
              float* out, size_t out_stride);

// floor(v * maximum + .5), clamped to [0, maximum]; 0 for not-a-number. In double, so that 16-bit codes that
// were read come back as they were.
unsigned quantise(float value, double maximum);

}  // namespace image
}  // namespace triad
