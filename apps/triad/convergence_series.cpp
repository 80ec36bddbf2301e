// SPDX-License-Identifier: Apache-2.0
#include "convergence_series.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>

namespace fs = std::filesystem;

namespace triad::app {
namespace {

std::vector<std::string> pictures_in(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (entry->is_regular_file() && has_picture_extension(entry->path().string()))
      files.push_back(entry->path().string());
  if (error) throw_input(folder + ": " + error.message());
  if (files.empty()) throw_input(folder + ": no picture lies in this folder; name one with renders, or files");
  std::sort(files.begin(), files.end());
  return files;
}

std::string real_name(const std::string& path) {
  std::error_code error;
  const fs::path found = fs::canonical(path, error);
  return error ? path : found.string();
}

RenderCost told_by_header(const std::string& file, const ImageSpec& spec) {
  RenderCost cost = cost_from_metadata(file, spec);
  const std::string record = fs::path(file).replace_extension(".json").string();
  std::error_code error;
  if (!fs::is_regular_file(record, error)) return cost;
  return combined_cost(file, cost, cost_from_record(read_text_file(record), spec));
}

}  // namespace

std::vector<Series> collect_series(const std::vector<std::string>& paths, const std::string& files_name) {
  std::vector<Series> series;
  Series files{files_name, {}};
  for (const std::string& path : paths) {
    if (!fs::is_directory(path)) {
      files.pictures.push_back({path, {}});
      continue;
    }
    Series folder{path, {}};
    for (const std::string& file : pictures_in(path)) folder.pictures.push_back({file, {}});
    series.push_back(std::move(folder));
  }
  if (!files.pictures.empty()) series.insert(series.begin(), std::move(files));
  return series;
}

void check_distinct(const std::vector<Series>& series, const std::string& reference) {
  const std::string judge = real_name(reference);
  std::map<std::string, std::string> seen;
  for (const Series& one : series)
    for (const SeriesPicture& picture : one.pictures) {
      const std::string name = real_name(picture.file);
      if (name == judge)
        throw_input(picture.file + ": this is the reference, and one of the pictures of '" + one.name +
                    "'; keep it elsewhere, or name the pictures without it");
      const auto [other, is_new] = seen.emplace(name, picture.file);
      if (!is_new)
        throw_input(picture.file + ": this picture is there twice" +
                    (other->second == picture.file ? "" : ", also as '" + other->second + "'") +
                    "; each render counts once");
    }
}

void find_costs(std::vector<Series>& series, const std::string& from, const ReadOptions& read) {
  std::optional<CostTable> table;
  if (from != "auto" && from != "name" && from != "metadata") {
    if (!fs::exists(from))
      throw_usage("--samples-from '" + from +
                  "' is none of 'auto', 'name' and 'metadata', and no table of that name "
                  "exists; write the table's path, as in costs.csv");
    table.emplace(from);
  }
  for (Series& one : series) {
    std::string size;
    size_t with_samples = 0, with_seconds = 0;
    const SeriesPicture *no_samples = nullptr, *no_seconds = nullptr;
    for (SeriesPicture& picture : one.pictures) {
      const ImageSpec spec = ImageReader::open(picture.file, read)->spec();
      const std::string own = std::to_string(spec.width) + "x" + std::to_string(spec.height);
      if (size.empty()) size = own;
      if (own != size)
        throw_input(picture.file + ": " + own + " pixels, and '" + one.pictures[0].file +
                    "' of the same series has " + size + "; all must be of one size");
      if (table)
        picture.cost = table->find(picture.file);
      else if (from == "name")
        picture.cost = cost_from_name(picture.file);
      else if (from == "metadata")
        picture.cost = told_by_header(picture.file, spec);
      else
        picture.cost = combined_cost(picture.file, cost_from_name(picture.file), told_by_header(picture.file, spec));
      with_samples += picture.cost.samples.has_value();
      with_seconds += picture.cost.seconds.has_value();
      if (!picture.cost.samples && !no_samples) no_samples = &picture;
      if (!picture.cost.seconds && !no_seconds) no_seconds = &picture;
    }
    const auto where = [&] {
      return from == "auto"                         ? std::string("its name and its metadata")
             : from == "name" || from == "metadata" ? "its " + from
                                                    : "'" + from + "'";
    };
    // Some pictures with and some without is a mistake in names or tables, not a wish.
    if (no_samples && (with_samples > 0 || with_seconds == 0))
      throw_input(no_samples->file + ": " + where() + " tells no samples" +
                  (with_seconds == 0 ? " and no seconds" : "") +
                  "; name it as in scene_64spp.exr, or write file,samples,seconds into a table for --samples-from");
    if (no_seconds && with_seconds > 0)
      throw_input(no_seconds->file + ": " + where() + " tells no seconds, and those of others of '" + one.name +
                  "' do; give all of them or none");
    std::stable_sort(one.pictures.begin(), one.pictures.end(), [](const SeriesPicture& a, const SeriesPicture& b) {
      return a.cost.samples ? *a.cost.samples < *b.cost.samples : *a.cost.seconds < *b.cost.seconds;
    });
  }
}

}  // namespace triad::app
