// SPDX-License-Identifier: Apache-2.0
#include "maps.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/image/writer.hpp>

namespace fs = std::filesystem;

namespace triad::app {
namespace {

// What a metric reports as the largest value that its map can have.
constexpr const char* kNaturalHigh = "map-max";

// Of a map that waits for the others.
constexpr MapScale kUnknown{0, 0};

MapScale with_two_ends(const MapScale& scale) {
  return scale.low < scale.high ? scale : MapScale{scale.low, scale.low + 1};
}

bool names_folder(const std::string& path) {
  std::error_code error;
  return !path.empty() && (path.back() == '/' || fs::is_directory(path, error));
}

fs::path real_path(const std::string& path) {
  std::error_code error;
  const fs::path found = fs::weakly_canonical(fs::absolute(path, error), error);
  return error ? fs::path(path) : found;
}

}  // namespace

MapFiles::MapFiles(const MapOptions& options, bool many_maps, bool many_pictures)
    : options_(options),
      colour_map_(parse_colour_map(options.colour_map)),
      map_folder_(names_folder(options.map)),
      sheet_folder_(names_folder(options.sheet)) {
  const std::string &map = options_.map, &format = options_.format, &scale = options_.scale;
  if (many_maps && !map.empty() && !map_folder_)
    throw_usage("--map '" + map + "' is one file, but there are several maps; name a folder, with / at its end");
  if (many_pictures && !options_.sheet.empty() && !sheet_folder_)
    throw_usage("--sheet '" + options_.sheet +
                "' is one file, but there are several pictures; name a folder, with / at its end");
  if (!format.empty() && format != "exr" && format != "png")
    throw_usage("--map-format '" + format + "' is neither 'exr' nor 'png'" + did_you_mean(format, {"exr", "png"}));
  if (!format.empty() && map.empty()) throw_usage("--map-format '" + format + "' without --map");
  if (map_folder_) {
    coloured_ = format == "png";
  } else if (!map.empty()) {
    coloured_ = is_display_encoded_format(map, Depth::kDefault);
    if (!format.empty() && !lower(map).ends_with("." + format))
      throw_usage("--map '" + map + "' and --map-format " + format + " are of two minds; leave one out");
  }
  if (!options_.sheet.empty() && !sheet_folder_ && !is_display_encoded_format(options_.sheet, Depth::kDefault))
    throw_usage("--sheet '" + options_.sheet + "' is for people to look at; name a .png");
  if (scale.empty() || scale == "common") return;
  if (scale == "each") {
    scale_from_ = ScaleFrom::kEach;
    return;
  }
  const size_t colon = scale.find(':');
  const auto low = colon == std::string::npos ? std::nullopt : parse_double(scale.substr(0, colon));
  const auto high = colon == std::string::npos ? std::nullopt : parse_double(scale.substr(colon + 1));
  if (!low || !high || !std::isfinite(*low) || !std::isfinite(*high) || !(*low < *high))
    throw_usage("--map-scale '" + scale + "' is neither LOW:HIGH, as in 0:0.5, nor 'common' nor 'each'");
  scale_from_ = ScaleFrom::kFixed;
  fixed_ = {*low, *high};
}

std::string MapFiles::name_in(const std::string& folder, const std::string& stem, const std::string& extension) {
  std::string name = stem + extension;
  for (int n = 2; !taken_.insert((fs::path(folder) / name).string()).second; ++n)
    name = stem + "-" + std::to_string(n) + extension;
  return (fs::path(folder) / name).string();
}

void MapFiles::add(const std::string& test, const std::vector<std::string>& labels) {
  Picture picture;
  picture.test = test;
  picture.labels = labels;
  picture.temporaries.resize(labels.size());
  picture.float_files.resize(labels.size());
  const std::string stem = fs::path(test).stem().string();
  for (const std::string& label : labels)
    picture.maps.push_back(!map_folder_ ? options_.map
                                        : name_in(options_.map, stem + "." + label, coloured_ ? ".png" : ".exr"));
  picture.sheet = !sheet_folder_ ? options_.sheet : name_in(options_.sheet, stem + ".sheet", ".png");
  pictures_.push_back(std::move(picture));
}

void MapFiles::check(const std::vector<std::string>& inputs) const {
  std::map<fs::path, std::string> taken;
  for (const std::string& input : inputs)
    if (!input.empty() && input != "-") taken.emplace(real_path(input), input);
  const auto claim = [&](const char* what, const std::string& path) {
    if (path.empty()) return;
    const auto [entry, fresh] = taken.emplace(real_path(path), path);
    if (!fresh)
      throw_usage(std::string("the ") + what + " '" + path + "' would overwrite '" + entry->second +
                  "', which this call reads or writes");
  };
  for (const Picture& picture : pictures_) {
    for (const std::string& map : picture.maps) claim("map", map);
    claim("sheet", picture.sheet);
  }
}

void MapFiles::make_folders() const {
  const auto make = [](const char* option, const std::string& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw_input(std::string(option) + " '" + folder + "': " + error.message());
  };
  if (map_folder_) make("--map", options_.map);
  if (sheet_folder_) make("--sheet", options_.sheet);
}

std::string MapFiles::run_path(size_t index, size_t metric) {
  Picture& picture = pictures_[index];
  const std::string& map = picture.maps[metric];
  if (map.empty() && picture.sheet.empty()) return "";
  if (!map.empty() && !coloured_) return picture.float_files[metric] = map;
  picture.temporaries[metric] = std::make_unique<AtomicFile>((map.empty() ? picture.sheet : map) + ".exr");
  return picture.float_files[metric] = picture.temporaries[metric]->temporary();
}

void MapFiles::done(size_t index, const RunRequest& request, const RunResult& result, const ColourConfig& colours) {
  Picture& picture = pictures_[index];
  const size_t count = picture.labels.size();
  if (count == 0 || picture.float_files[0].empty()) return;
  picture.scales.assign(count, fixed_);
  picture.test_picture = request.input;
  picture.reference = request.metrics[0].reference;
  const bool shows = coloured_ || !picture.sheet.empty();
  for (size_t m = 0; shows && scale_from_ != ScaleFrom::kFixed && m < count; ++m) {
    const auto& reports = result.metrics[m].reports.values;
    const auto natural =
        std::find_if(reports.begin(), reports.end(), [](const auto& entry) { return entry.first == kNaturalHigh; });
    if (natural != reports.end() && natural->second > 0 && std::isfinite(natural->second)) {
      picture.scales[m] = {0, natural->second};
      continue;
    }
    const MapScale own = find_map_scale(picture.float_files[m]);
    if (scale_from_ == ScaleFrom::kEach) {
      picture.scales[m] = with_two_ends(own);
      continue;
    }
    picture.scales[m] = kUnknown;
    picture.waits = true;
    const auto known =
        std::find_if(common_.begin(), common_.end(), [&](const auto& c) { return c.first == picture.labels[m]; });
    if (known == common_.end())
      common_.emplace_back(picture.labels[m], own);
    else
      known->second = {std::min(known->second.low, own.low), std::max(known->second.high, own.high)};
  }
  if (!picture.waits) draw(picture, colours);
}

void MapFiles::draw(Picture& picture, const ColourConfig& colours) {
  std::vector<ShownMap> maps;
  for (size_t m = 0; m < picture.labels.size(); ++m)
    maps.push_back({picture.float_files[m], picture.labels[m], colour_map_, picture.scales[m]});
  if (coloured_)
    for (size_t m = 0; m < maps.size(); ++m) draw_map(maps[m], picture.maps[m]);
  if (!picture.sheet.empty())
    draw_sheet(picture.reference, picture.test_picture, maps, {options_.exposure_ev}, colours, picture.sheet);
  picture.temporaries.clear();
  picture.waits = false;
}

std::vector<ShownFile> MapFiles::finish(const ColourConfig& colours) {
  std::vector<ShownFile> files;
  for (Picture& picture : pictures_) {
    if (picture.scales.empty()) continue;  // its run failed, or nothing was asked for
    for (size_t m = 0; m < picture.labels.size(); ++m)
      if (picture.scales[m].low == kUnknown.low && picture.scales[m].high == kUnknown.high)
        for (const auto& [label, common] : common_)
          if (label == picture.labels[m]) picture.scales[m] = with_two_ends(common);
    if (picture.waits) draw(picture, colours);
    ShownFile sheet{"sheet", picture.test, "", picture.sheet, {}, colour_map_name(colour_map_)};
    for (size_t m = 0; m < picture.labels.size(); ++m) {
      const ShownFile::Scale scale{picture.labels[m], picture.scales[m].low, picture.scales[m].high};
      sheet.scales.push_back(scale);
      if (picture.maps[m].empty()) continue;
      ShownFile file{"map", picture.test, picture.labels[m], picture.maps[m], {}, ""};
      if (coloured_) {
        file.scales.push_back(scale);
        file.colour_map = sheet.colour_map;
      }
      files.push_back(std::move(file));
    }
    if (!picture.sheet.empty()) files.push_back(std::move(sheet));
  }
  return files;
}

}  // namespace triad::app
