// SPDX-License-Identifier: Apache-2.0
// The chain as people type it: `platt:layout=rgb,ppd=40 write:mid.exr box:y=2`.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace triad {

struct ChainItem {
  bool is_write = false;  // `write:PATH`: keep the picture at this point
  std::string id;         // of the stage; "" for a write
  std::map<std::string, std::string> params;
  std::string path;   // of a write
  std::string label;  // of a metric: its results' name; the id if none was given
};

// A chain read from a file.
struct Chain {
  std::vector<ChainItem> stages;
  std::vector<ChainItem> metrics;
};

// "name", "name:key=value,key=value" or "write:PATH". Quotes ('...' or "...") protect commas, a backslash the
// next character. Throws Error(kUsage) naming the item.
ChainItem parse_stage(const std::string& text);
// "name", "name:key=value,...", "name@label", "name:key=value,...@label".
ChainItem parse_metric(const std::string& text);

// A chain in TOML:
//
//   [[stage]]
//   name = "platt"
//   layout = "rgb"
//   ppd = 40
//
//   [[stage]]
//   write = "mid.exr"
//
//   [[metric]]
//   name = "display"
//   label = "wide"
//
// Values may be strings, numbers, booleans or lists of numbers. Throws Error(kInput) with file and line.
Chain load_chain(const std::string& path);

// Gives metrics whose labels collide the suffixes -2, -3, ...
void make_labels_unique(std::vector<ChainItem>& metrics);

// Frame sequences: one run of '#' in a file name stands for the frame's number, padded with zeros to the
// run's length ("in.####.exr").
bool is_sequence(const std::string& pattern);
// The frames that exist, ascending. Throws Error(kInput) if there are none, Error(kUsage) for two runs of '#'
// or one in a folder's name.
std::vector<int> find_frames(const std::string& pattern);
// The pattern with its '#' replaced; a pattern without '#' comes back as it is.
std::string frame_path(const std::string& pattern, int frame);

}  // namespace triad
