// SPDX-License-Identifier: Apache-2.0
// The references of many comparisons.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <triad/colour/colour.hpp>
#include <triad/pipeline/run.hpp>
#include <vector>

#include "compare_pairs.hpp"

namespace triad::app {

// Decodes a reference that several pictures share once, if it is small; warns of a black one.
class References {
 public:
  // Throws Error(kUsage) naming --ref-from for a colour space that there is not.
  References(ReadOptions read, const std::vector<ComparePair>& pairs, const ColourConfig& colours);
  // Throws Error(kInput) as reading does.
  PictureRequest get(const std::string& path);

 private:
  ReadOptions read_;
  const ColourConfig& colours_;
  std::map<std::string, size_t> uses_;
  std::string known_;  // the last path that was asked for
  std::shared_ptr<const Image> kept_;
};

// Warns of a reference whose values are all 0; most pictures show in their first rows that they are not. Throws
// Error(kInput) as reading does.
void warn_of_black(const std::string& path, const ReadOptions& read, const ColourConfig& colours);

}  // namespace triad::app
