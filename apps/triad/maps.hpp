// SPDX-License-Identifier: Apache-2.0
// The files that show where pictures differ: error maps as floats or in colours, and sheets.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <triad/base/file.hpp>
#include <triad/evaluation/ranking.hpp>
#include <vector>

#include "compare_sheet.hpp"

namespace triad::app {

// What the options ask for.
struct MapOptions {
  std::string map, format, scale, colour_map = "magma", sheet;
  double exposure_ev = 0;
};

// Maps of one call, for one picture after another:
//
//   MapFiles files(options, many);
//   for (...) files.add(test, labels);      // names, all before the work
//   files.check(inputs); files.make_folders();
//   ... request.metrics[m].map_path = files.run_path(i, m) ... files.done(i, request, result, colours) ...
//   files.finish(colours);
//
// Maps in colours are drawn from a float file that the run writes beside them, and that is gone in the end. A scale
// that all maps of a label share is known once the last of them is there: only then are they drawn.
class MapFiles {
 public:
  // Throws Error(kUsage): options that do not go together; one file for several maps (many_maps) or sheets.
  MapFiles(const MapOptions& options, bool many_maps, bool many_pictures);

  // The next picture. Files in a folder are TEST.LABEL.exr (or .png) and TEST.sheet.png, with a number where the
  // name is taken.
  void add(const std::string& test, const std::vector<std::string>& labels);
  // Throws Error(kUsage) if a file to write is one of `inputs` or of the other outputs.
  void check(const std::vector<std::string>& inputs) const;
  void make_folders() const;

  // The map's final name; "" none.
  const std::string& map_name(size_t picture, size_t metric) const { return pictures_[picture].maps[metric]; }
  // Where a run shall write the float map of a picture's metric; "" nowhere.
  std::string run_path(size_t picture, size_t metric);
  // After the run: draws what can be drawn. Throws Error.
  void done(size_t picture, const RunRequest& request, const RunResult& result, const ColourConfig& colours);
  // Drops what a picture's run left.
  void failed(size_t picture) { pictures_[picture].temporaries.clear(); }
  // Draws the rest. The files written, in the order of the pictures.
  std::vector<ShownFile> finish(const ColourConfig& colours);

 private:
  enum class ScaleFrom { kFixed, kEach, kCommon };
  struct Picture {
    std::string test, sheet;
    std::vector<std::string> labels, maps;  // maps: final names, "" none
    std::vector<std::unique_ptr<AtomicFile>> temporaries;
    std::vector<std::string> float_files;  // what the run wrote
    std::vector<MapScale> scales;
    PictureRequest test_picture, reference;
    bool waits = false;
  };
  std::string name_in(const std::string& folder, const std::string& stem, const std::string& extension);
  void draw(Picture& picture, const ColourConfig& colours);

  MapOptions options_;
  ColourMap colour_map_ = ColourMap::kMagma;
  ScaleFrom scale_from_ = ScaleFrom::kCommon;
  MapScale fixed_;
  bool map_folder_ = false, sheet_folder_ = false, coloured_ = false;
  std::set<std::string> taken_;
  std::vector<Picture> pictures_;
  std::vector<std::pair<std::string, MapScale>> common_;  // by label
};

}  // namespace triad::app
