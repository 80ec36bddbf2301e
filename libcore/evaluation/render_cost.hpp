// SPDX-License-Identifier: Apache-2.0
// What a picture cost to render, from whatever tells it: its name, its header, Triad's record of it, or a table.
#pragma once

#include <optional>
#include <string>
#include <triad/image/image.hpp>
#include <vector>

namespace triad {

struct RenderCost {
  std::optional<double> samples;  // per pixel, a mean where they differ
  std::optional<double> seconds;
  std::string samples_from, seconds_from;  // for messages: "its name", "its metadata samplesPerPixel" ...
};

// Numbers with a unit anywhere in the file's name, folders and extension apart: 64spp, spp64, 64-samples, samples=64;
// 12.5s, 90sec, 3min, 250ms, time-12.5. With no such samples, the last number that stands for itself (cornell-0064,
// cornell_64_12.5s) is samples. Throws Error(kInput) naming the file where two numbers claim the same, or one is 0.
RenderCost cost_from_name(const std::string& path);

// The header's: triad:samples (over width x height), samplesPerPixel and renderTimeSeconds (pbrt),
// cycles.LAYER.samples and .render_time (Blender), RenderTime as [h:]mm:ss.ff (Blender), spp, samples, seconds,
// render_time. Throws Error(kInput) naming the file, the key and its value where that is no number above 0, or where
// layers differ.
RenderCost cost_from_metadata(const std::string& path, const ImageSpec& spec);

// Triad's own record of a render (triad render --json): samples over the pixels of `spec`, seconds.render. Nothing in
// it where the text is none.
RenderCost cost_from_record(const std::string& text, const ImageSpec& spec);

// A table (RFC 4180) with a header line that names at least `file` and one of `samples` and `seconds`.
class CostTable {
 public:
  // Throws Error(kInput) naming the table and the line.
  explicit CostTable(const std::string& path);
  // By the path as it is written, relative to the table's folder or the working folder, else by the name of the file
  // alone if only one row has it. Throws Error(kInput) naming picture and table where no row fits.
  RenderCost find(const std::string& picture) const;

 private:
  struct Row {
    std::string file;
    RenderCost cost;
  };
  std::string path_;
  std::vector<Row> rows_;
};

// Both; Error(kInput) naming `path` and both numbers where they differ by more than 1 % (samples) or, as seconds are
// rounded in names, 5 %.
RenderCost combined_cost(const std::string& path, const RenderCost& first, const RenderCost& second);

}  // namespace triad
