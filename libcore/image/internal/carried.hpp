// SPDX-License-Identifier: Apache-2.0
// What a format without fields of one's own can still say of a picture: in its description text. Not installed.
#pragma once

#include <string>

namespace triad::image {

// Each "" where there is nothing to say.
struct Carried {
  std::string colour_space, cells;  // as ImageSpec has the one, as parse_cells() reads the other
};

// `description` with the statements of `carried` before it, as in: triad:cells="3x2" a picture. In front,
// because some formats cut long descriptions off. Quotes in a name become "'".
std::string with_carried(const std::string& description, const Carried& carried);

// The statements in `description`, which loses them.
Carried take_carried(std::string& description);

}  // namespace triad::image
