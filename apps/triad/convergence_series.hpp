// SPDX-License-Identifier: Apache-2.0
// The pictures that triad convergence judges: which belong together, and what each cost to render.
#pragma once

#include <optional>
#include <string>
#include <triad/evaluation/render_cost.hpp>
#include <triad/image/reader.hpp>
#include <vector>

namespace triad::app {

struct SeriesPicture {
  std::string file;
  RenderCost cost;
  double score = 0, squared_error = 0;  // filled by who judges it
};

struct Series {
  std::string name;
  std::vector<SeriesPicture> pictures;
};

// Each folder's pictures (by name; what is in folders below is left out) are a series of their own, all other files
// together one that is called `files_name`. Throws Error(kInput) for a folder without pictures.
std::vector<Series> collect_series(const std::vector<std::string>& paths, const std::string& files_name);

// Throws Error(kInput) where the reference is one of the pictures, or a picture is named twice.
void check_distinct(const std::vector<Series>& series, const std::string& reference);

// Opens every header: what it tells of the cost, and its size, which must be one for all of a series.
// from: "auto" (name, then header and Triad's record beside it; they must agree), "name", "metadata", or a table's
// path. Throws Error, also for a series that has neither samples nor seconds for all of its pictures.
void find_costs(std::vector<Series>& series, const std::string& from, const ReadOptions& read);

}  // namespace triad::app
