// SPDX-License-Identifier: Apache-2.0
// What a picture file says about its colours, in the words of a colour configuration.
#pragma once

#include <string>
#include <triad/colour/colour.hpp>
#include <triad/image/reader.hpp>

namespace triad {

// The space of the configuration that the picture's values are in; "" for values that are not colour or of which
// nothing is said. `wanted` is the user's own word for it (--from), or "". Chromaticities in the header win over
// names. A statement that the configuration does not know is a warning, and lin_rec709 is taken.
// Throws Error(kUsage) if `wanted` is no space.
std::string file_colour_space(const ImageReader& reader, const std::string& wanted, const ColourConfig& config);

}  // namespace triad
