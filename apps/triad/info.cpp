// SPDX-License-Identifier: Apache-2.0
// triad info FILE
#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>
#include <triad/base/json_text.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/image/reader.hpp>
#include <triad/pipeline/picture_source.hpp>

#include "options.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

struct InfoOptions {
  HostOptions host;
  std::vector<std::string> files;
  std::string part, cells, from;
  bool json = false;
};

nlohmann::ordered_json describe(const std::string& path, const InfoOptions& options, const ColourConfig& colours) {
  ReadOptions read;
  read.part = options.part;
  read.all_channels = true;
  read.colour_space = options.from;
  if (!options.cells.empty()) read.cells = parse_cells(options.cells, "--cells");
  const auto reader = ImageReader::open(path, read);
  const auto source = open_file_source(path, read, colours);
  const ImageSpec& spec = reader->spec();
  const FileInfo& info = reader->info();
  nlohmann::ordered_json object;
  object["file"] = path;
  object["format"] = info.format;
  object["width"] = spec.width;
  object["height"] = spec.height;
  object["channels"] = info.all_channels;
  object["type"] = info.pixel_type;
  object["compression"] = info.compression;
  object["tile"] = info.tiled ? nlohmann::ordered_json{info.tile_width, info.tile_height} : nlohmann::ordered_json();
  object["data_window"] = {info.data_x, info.data_y, info.data_width, info.data_height};
  object["colour_space"] = source->spec().colour_space;
  object["colour_space_from"] = info.colour_space_from;
  object["cells"] = fmt::format("{}x{}", spec.cells.x, spec.cells.y);
  object["cells_from"] = info.cells_from;
  object["pixel_aspect"] = spec.pixel_aspect;
  object["parts"] = nlohmann::ordered_json::array();
  for (const PartInfo& part : info.parts)
    object["parts"].push_back(
        {{"name", part.name}, {"width", part.width}, {"height", part.height}, {"channels", part.channels}});
  object["metadata"] = nlohmann::ordered_json::object();
  for (const auto& [key, value] : spec.metadata.entries()) object["metadata"][key] = value;
  return object;
}

void print(const nlohmann::ordered_json& o) {
  const auto text = [&](const char* key) { return printable(o[key].get<std::string>()); };
  std::cout << printable(o["file"].get<std::string>()) << "\n";
  std::cout << fmt::format("  size          {} x {}\n", o["width"].get<int>(), o["height"].get<int>());
  std::cout << fmt::format("  format        {}, {}{}\n", text("format"), text("type"),
                           text("compression").empty() ? "" : ", " + text("compression"));
  if (!o["tile"].is_null())
    std::cout << fmt::format("  tiles         {} x {}\n", o["tile"][0].get<int>(), o["tile"][1].get<int>());
  std::cout << "  channels      " << printable(join(o["channels"].get<std::vector<std::string>>(), ", ")) << "\n";
  const auto& window = o["data_window"];
  if (window[0] != 0 || window[1] != 0 || window[2] != o["width"] || window[3] != o["height"])
    std::cout << fmt::format("  data window   {} x {} at ({}, {})\n", window[2].get<int>(), window[3].get<int>(),
                             window[0].get<int>(), window[1].get<int>());
  std::cout << fmt::format("  colour space  {} (by {})\n",
                           text("colour_space").empty() ? "none" : text("colour_space"), text("colour_space_from"));
  std::cout << fmt::format("  cells         {} (by {}), pixel aspect {:.6g}\n", text("cells"), text("cells_from"),
                           o["pixel_aspect"].get<double>());
  if (o["parts"].size() > 1)
    for (size_t i = 0; i < o["parts"].size(); ++i) {
      const auto& part = o["parts"][i];
      std::cout << fmt::format("  part {:<8} '{}' {} x {}: {}\n", i, printable(part["name"].get<std::string>()),
                               part["width"].get<int>(), part["height"].get<int>(),
                               printable(join(part["channels"].get<std::vector<std::string>>(), ", ")));
    }
  for (const auto& [key, value] : o["metadata"].items())
    std::cout << "  " << printable(key) << " = " << printable(value.get<std::string>()) << "\n";
}

void info(const InfoOptions& options) {
  const ColourConfig colours = ColourConfig::load(options.host.ocio);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const std::string& path : options.files) {
    list.push_back(describe(path, options, colours));
    if (!options.json) print(list.back());
  }
  if (options.json) std::cout << json_text(nlohmann::ordered_json{{"files", list}}, 2);
}

}  // namespace

void setup_info(CLI::App& app) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App* verb = app.add_subcommand("info", "Say what a picture file holds");
  verb->add_option("files", options->files, "Pictures")->required()->type_name("FILE");
  verb->add_option("--part", options->part, "Part of a multi-part file, by name or number from 0")->type_name("PART");
  verb->add_option("--cells", options->cells, "Fine cells per display pixel, e.g. 3x1")->type_name("XxY");
  verb->add_option("--from", options->from, "Colour space, instead of what the file says")->type_name("SPACE");
  verb->add_flag("--json", options->json, "As JSON");
  options->host.add_ocio(*verb);
  verb->footer("Example:\n  triad info wide.exr --json");
  verb->callback([options] { info(*options); });
}

}  // namespace triad::app
