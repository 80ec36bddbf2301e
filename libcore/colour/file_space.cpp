// SPDX-License-Identifier: Apache-2.0
#include <triad/base/log.hpp>
#include <triad/colour/file_space.hpp>

namespace triad {

std::string file_colour_space(const ImageReader& reader, const std::string& wanted, const ColourConfig& config) {
  if (!wanted.empty()) return config.require(wanted, "--from");
  if (reader.spec().colour_channels == 0) return "";
  if (const auto& xy = reader.info().chromaticities) {
    const std::string matched = config.match_chromaticities(*xy);
    if (!matched.empty()) return matched;
    warn("'" + reader.path() + "': its chromaticities fit no linear space of the colour configuration; taken for '" +
         config.lin_rec709() + "', name another with --from");
    return config.lin_rec709();
  }
  const std::string& said = reader.spec().colour_space;
  if (said.empty()) return "";
  const std::string known = config.resolve(said);
  if (!known.empty()) return known;
  warn("'" + reader.path() + "': its colour space '" + said + "' is not in the colour configuration; taken for '" +
       config.lin_rec709() + "', name another with --from");
  return config.lin_rec709();
}

}  // namespace triad
