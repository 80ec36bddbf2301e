// SPDX-License-Identifier: Apache-2.0
// Which picture is compared with which.
#pragma once

#include <string>
#include <vector>

namespace triad::app {

struct ComparePair {
  std::string test, reference;
  std::string sequence;  // the pattern that the test picture is a frame of, or ""
  int frame = 0;
};

// The pictures of `tests` beside their references. A test is a picture, a sequence (shot.####.exr), a pattern of a
// shell that nobody expanded ('renders/*.exr') or a folder, whose pictures are taken in the order of their names. The
// reference is one picture for all, a sequence for sequences, or a folder in which pictures are found by their name,
// or where no other extension makes it ambiguous by its stem. Of several pictures the one that is the reference
// itself is left out.
//
// Missing partners are an error that lists them; with skip_missing a warning, and the pictures are left out.
// Throws Error(kUsage) or Error(kInput).
std::vector<ComparePair> pair_pictures(const std::vector<std::string>& tests, const std::string& reference,
                                       bool skip_missing);

// "3-5, 9" of ascending numbers; at most `most` ranges, then how many numbers there are.
std::string number_ranges(const std::vector<int>& numbers, size_t most = 12);

}  // namespace triad::app
