// SPDX-License-Identifier: Apache-2.0
// The page: what the viewer reads as JSON (apps/viewer/src/data.ts), and tables for those without scripts.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/json_text.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>
#include <triad/colour/file_space.hpp>
#include <triad/display/layout.hpp>
#include <triad/display/vision.hpp>
#include <triad/evaluation/study_comparisons.hpp>

#include "report.hpp"
#include "report_pictures.hpp"
#include "viewer_page.hpp"

namespace fs = std::filesystem;

namespace triad::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kLargestPage = 100'000'000;  // bytes

std::string escaped(const std::string& text) {
  std::string html;
  for (const char c : escape_non_utf8(text)) switch (c) {
      case '&': html += "&amp;"; break;
      case '<': html += "&lt;"; break;
      case '>': html += "&gt;"; break;
      case '"': html += "&quot;"; break;
      case '\'': html += "&#39;"; break;
      default: html += c;
    }
  return html;
}

// JSON that may stand in a script element: no text in it can end that element or begin a comment.
std::string script_json(const Json& json) {
  const std::string text = json_text(json, -1);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) c == '<' ? safe += "\\u003c" : safe += c;  // outside of strings JSON has none
  return safe;
}

Json object(const StudySettings& settings) {
  Json json = Json::object();
  for (const auto& [name, value] : settings) json[name] = value;
  return json;
}

Json object(const std::map<std::string, double>& numbers) {
  Json json = Json::object();
  for (const auto& [name, value] : numbers) json[name] = value;  // nlohmann writes what is not finite as null
  return json;
}

Json layout_json(const std::string& name) {
  const Layout layout = load_layout(name);
  Json emitters = Json::array();
  for (const Emitter& emitter : layout.emitters) {
    Json cells = Json::array();
    for (const EmitterCell& cell : emitter.cells) cells.push_back({cell.x, cell.y, cell.share});
    emitters.push_back({{"name", emitter.name},
                        {"primary", emitter.primary},
                        {"pixel", {emitter.pixel_x, emitter.pixel_y}},
                        {"channel", emitter.channel},
                        {"cells", cells}});
  }
  return {{"name", layout.name},
          {"summary", layout.summary},
          {"cells", {layout.cells_x, layout.cells_y}},
          {"tile", {layout.tile_x, layout.tile_y}},
          {"derivesWhite", layout.derives_white},
          {"emitters", emitters}};
}

// The layouts that are bundled, and the one that scores belong to, should it be a file.
Json layouts_json(const std::string& own) {
  std::vector<std::string> names = layout_names();
  if (!own.empty() && std::find(names.begin(), names.end(), own) == names.end()) names.push_back(own);
  Json layouts = Json::array();
  for (const std::string& name : names) layouts.push_back(layout_json(name));
  return layouts;
}

// Opponent channels in which greys have no chroma (EyeSpace::kNeutral), and the Gaussians of each.
Json vision_json() {
  Observer observer;
  observer.rgb_to_xyz = rec709_to_xyz();
  std::array<double, 9> to_opponent = opponent_matrix(observer);
  const auto white = [&](size_t c) { return to_opponent[3 * c] + to_opponent[3 * c + 1] + to_opponent[3 * c + 2]; };
  for (size_t c = 1; c < 3; ++c) {
    const double grey = white(c) / white(0);
    for (size_t d = 0; d < 3; ++d) to_opponent[3 * c + d] -= grey * to_opponent[d];
  }
  Json gaussians = Json::array();
  for (int c = 0; c < kOpponentChannels; ++c) {
    Json terms = Json::array();
    for (int term = 0; term < 2; ++term) {
      // exp(-(pi spread f)^2) at one cycle per degree tells the spread.
      const double weight = scielab_term(c, term, 0), at_one = scielab_term(c, term, 1);
      terms.push_back({weight, std::sqrt(std::log(weight / at_one)) / std::numbers::pi});
    }
    gaussians.push_back(terms);
  }
  return {{"toOpponent", to_opponent}, {"toRgb", inverse_3x3(to_opponent)}, {"gaussians", gaussians}};
}

struct Packed {
  int width = 0, height = 0;
  Cells cells;
  PackedFormat format = PackedFormat::kFloat;
  std::string exact, codes;
};

Packed pack_picture(const ReportPicture& picture, const ColourConfig& colours) {
  check_cancel();
  const auto reader = ImageReader::open(picture.path, picture.read);
  const ImageSpec& spec = reader->spec();
  if (spec.colour_channels != 3 && spec.colour_channels != 1)
    throw_input("'" + picture.path + "': a report shows pictures with three channels of colour, or one of grey");
  const size_t channels = spec.channels.size(), colour = static_cast<size_t>(spec.colour_channels);
  const size_t pixels = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height);
  std::vector<float> all(pixels * channels), rgb(3 * pixels);
  reader->read_rows(0, spec.height, all.data(), static_cast<size_t>(spec.width) * channels);
  for (size_t i = 0; i < pixels; ++i)
    for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = all[i * channels + std::min(c, colour - 1)];
  std::vector<float>().swap(all);  // packing needs as much again
  const std::string space = file_colour_space(*reader, picture.read.colour_space, colours);
  if (!space.empty() && !colours.is_data(space))
    colours.transform(space, colours.lin_rec709()).apply(rgb.data(), pixels, 3, -1);
  Packed packed{spec.width, spec.height, spec.cells, exact_format(rgb), "", ""};
  if (spec.width % spec.cells.x != 0 || spec.height % spec.cells.y != 0) packed.cells = {};
  packed.exact = pack(rgb, packed.format);
  packed.codes = pack(rgb, PackedFormat::kCodes);
  return packed;
}

// What pack_picture() takes, at most; floats of noise do not become smaller.
struct PackedBytes {
  uint64_t exact = 0, codes = 0;  // of Packed's
  uint64_t work = 0;              // beside them, while it is at work
};

PackedBytes packed_bytes(const ReportPicture& picture, const ColourConfig& colours) {
  const auto reader = ImageReader::open(picture.path, picture.read);
  const ImageSpec& spec = reader->spec();
  const uint64_t pixels = static_cast<uint64_t>(spec.width) * static_cast<uint64_t>(spec.height);
  const std::string space = file_colour_space(*reader, picture.read.colour_space, colours);
  const bool as_it_is =
      space.empty() || colours.is_data(space) || colours.transform(space, colours.lin_rec709()).identity();
  const uint64_t width = as_it_is && reader->info().pixel_type == "half" ? 2 : 4;
  // As read, as three floats, in planes, compressed; base64 has 4 digits for 3 bytes.
  return {4 * width * pixels, 4 * pixels,
          reader->decoder_bytes() + pixels * (4 * spec.channels.size() + 12 + 6 * width)};
}

// The page is held twice while it is put together.
uint64_t page_bytes(const std::vector<PackedBytes>& pictures, ReportEmbed embed) {
  uint64_t exact = 0, codes = 0;
  for (const PackedBytes& one : pictures) {
    exact += one.exact;
    codes += one.codes;
  }
  if (embed == ReportEmbed::kAll) return 2 * exact;
  return 2 * (embed == ReportEmbed::kCodes ? codes : std::max(codes, std::min<uint64_t>(exact, kLargestPage)));
}

// How many pictures may be packed at a time, from the largest demand on. Throws Error(kInput) if not even one.
int64_t pictures_at_a_time(const std::vector<PackedBytes>& pictures, ReportEmbed embed, uint64_t max_memory) {
  constexpr uint64_t kBaseBytes = 144u << 20;  // the program and its libraries, as in a run
  uint64_t held = kBaseBytes, most = 0;
  for (const PackedBytes& one : pictures) {
    held += one.exact + one.codes;
    most = std::max(most, one.work);
  }
  const uint64_t limit = max_memory ? max_memory : machine_memory_bytes() / 2;
  const uint64_t least = std::max(held + most, kBaseBytes + page_bytes(pictures, embed));
  if (least > limit)
    throw_input(fmt::format("a report of {} pictures may need {}, but only {} may be used; --max-memory {}M would do",
                            pictures.size(), format_bytes(least), format_bytes(limit), (least >> 20) + 1));
  return most == 0 ? thread_limit()
                   : std::clamp<int64_t>(static_cast<int64_t>((limit - held) / most), 1, thread_limit());
}

Json picture_json(const ReportPicture& picture, const Packed& packed, const std::string& side) {
  return {{"name", picture.name},
          {"file", fs::path(picture.path).filename().string()},
          {"isReference", picture.is_reference},
          {"reference", picture.reference},
          {"width", packed.width},
          {"height", packed.height},
          {"cells", {packed.cells.x, packed.cells.y}},
          {"format", format_name(side.empty() ? packed.format : PackedFormat::kCodes)},
          {"side", side},
          {"sideFormat", format_name(packed.format)},
          {"settings", object(picture.settings)}};
}

Json report_json(const ReportData& data, const std::vector<Packed>& packed, const std::string& side_folder) {
  Json pictures = Json::array();
  for (size_t i = 0; i < packed.size(); ++i)
    pictures.push_back(picture_json(data.pictures[i], packed[i],
                                    side_folder.empty() ? "" : fmt::format("{}/{}.js", side_folder, i)));
  Json runs = Json::array();
  for (const ReportRun& run : data.runs)
    runs.push_back({{"settings", object(run.settings)},
                    {"whole", object(run.whole)},
                    {"shown", object(run.shown)},
                    {"around", object(run.around)},
                    {"values", run.values},
                    {"pareto", run.pareto ? Json(*run.pareto) : Json()},
                    {"picture", run.picture}});
  Json facts = Json::array();
  for (const auto& [name, value] : data.facts) facts.push_back({name, value});
  return {{"kind", data.kind},
          {"title", data.title},
          {"facts", facts},
          {"axes", data.axes},
          {"measures", data.measures},
          {"plain", data.plain},
          {"higherIsBetter", data.higher_is_better},
          {"pareto", {{"measures", data.pareto}, {"within", data.within}}},
          {"along", data.along},
          {"aroundIs", data.around_is},
          {"layout", data.layout},
          {"ppd", data.ppd},
          {"runs", runs},
          {"pictures", pictures},
          {"layouts", layouts_json(data.layout)},
          {"vision", vision_json()}};
}

std::string value_of(const StudySettings& settings, const std::string& name) {
  for (const auto& [key, value] : settings)
    if (key == name) return value;
  return "";
}

std::string runs_table(const ReportData& data) {
  const auto& columns = data.plain.empty() ? data.measures : data.plain;
  std::string html =
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Results\"><table class=\"data\" "
      "id=\"runs\">\n<thead><tr>";
  for (const std::string& axis : data.axes) html += "<th scope=\"col\" class=\"text\">" + escaped(axis) + "</th>";
  for (const std::string& column : columns) html += "<th scope=\"col\">" + escaped(column) + "</th>";
  if (!data.pareto.empty()) html += "<th scope=\"col\">best</th>";
  html += "</tr></thead>\n<tbody>\n";
  for (const ReportRun& run : data.runs) {
    html +=
        fmt::format("<tr data-picture=\"{}\"{}>", run.picture, run.pareto.value_or(false) ? " class=\"best\"" : "");
    for (const std::string& axis : data.axes)
      html += "<td class=\"text\">" + escaped(value_of(run.settings, axis)) + "</td>";
    for (const std::string& column : columns) {
      const auto found = run.shown.find(column), around = run.around.find(column);
      if (found == run.shown.end() || !std::isfinite(found->second)) {
        html += "<td data-value=\"NaN\">–</td>";
        continue;
      }
      html += fmt::format("<td data-value=\"{}\">{}", found->second, short_number(found->second));
      if (around != run.around.end() && around->second > 0) html += " ±" + short_number(around->second);
      html += "</td>";
    }
    if (!data.pareto.empty()) html += run.pareto.value_or(false) ? "<td>*</td>" : "<td></td>";
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string other_table(const ReportTable& table) {
  std::string html = "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"" + escaped(table.caption) +
                     "\"><table class=\"data\">\n<caption>" + escaped(table.caption) + "</caption>\n<thead><tr>";
  for (const std::string& head : table.head) html += "<th scope=\"col\">" + escaped(head) + "</th>";
  html += "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (const std::string& cell : row)
      html +=
          (parse_double(cell) ? "<td data-value=\"" + cell + "\">" : "<td class=\"text\">") + escaped(cell) + "</td>";
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string tables_html(const ReportData& data) {
  std::string html = data.runs.empty() ? "" : runs_table(data);
  if (!data.pareto.empty())
    html +=
        "<p class=\"note\">* no other has both less " +
        escaped(fmt::format("{}", fmt::join(data.pareto, " and less "))) +
        (data.within.empty() ? "" : " within the same " + escaped(fmt::format("{}", fmt::join(data.within, ", ")))) +
        ".</p>\n";
  if (!data.around_is.empty()) html += "<p class=\"note\">" + escaped(data.around_is) + "</p>\n";
  for (const ReportTable& table : data.tables) html += other_table(table);
  return html;
}

// `page` with each %triad-NAME% replaced. Only the page's own places are looked for, not those in what is put in.
std::string filled(std::string_view page, const std::map<std::string, std::string>& values) {
  size_t length = page.size();
  for (const auto& [name, value] : values) length += value.size();
  std::string html;
  html.reserve(length);
  for (size_t at = 0;;) {
    const size_t begin = page.find("%triad-", at);
    if (begin == std::string_view::npos) {
      html.append(page.substr(at));
      return html;
    }
    const size_t end = page.find('%', begin + 1);
    const auto found = values.find(std::string(page.substr(begin, end + 1 - begin)));
    if (found == values.end()) throw_internal("the report's page has an unknown place");
    html.append(page.substr(at, begin - at)).append(found->second);
    at = end + 1;
  }
}

}  // namespace

void require_viewer() {
  if (viewer_page().empty())
    throw_usage(
        "this build has no viewer, so it writes no reports; one configured with -DTRIAD_VIEWER=ON has it (that takes "
        "Node.js 18 or later, and npm)");
}

void check_report_memory(const std::vector<ReportPicture>& pictures, const ColourConfig& colours, ReportEmbed embed,
                         uint64_t max_memory) {
  std::vector<PackedBytes> bytes;
  for (const ReportPicture& picture : pictures) try {
      bytes.push_back(packed_bytes(picture, colours));
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kInput) throw;
    }
  pictures_at_a_time(bytes, embed, max_memory);
}

void write_report(const ReportData& data, const ColourConfig& colours, const std::string& path, ReportEmbed embed,
                  uint64_t max_memory) {
  require_viewer();
  check_text_file(path);
  std::vector<PackedBytes> most;
  for (const ReportPicture& picture : data.pictures) most.push_back(packed_bytes(picture, colours));
  const int64_t together = pictures_at_a_time(most, embed, max_memory), count = std::ssize(data.pictures);
  std::vector<Packed> packed(data.pictures.size());
  for (int64_t first = 0; first < count; first += together)
    parallel_for(std::min(together, count - first), [&](int64_t i) {
      const auto index = static_cast<size_t>(first + i);
      packed[index] = pack_picture(data.pictures[index], colours);
    });
  size_t bytes = viewer_page().size();
  for (const Packed& one : packed) bytes += one.exact.size();

  std::string side_folder;
  if (embed == ReportEmbed::kCodes || (embed == ReportEmbed::kAuto && bytes > kLargestPage)) {
    side_folder = fs::path(path).stem().string() + "_data";
    const fs::path folder = fs::path(path).parent_path() / side_folder;
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
      throw_input("cannot make the folder '" + folder.string() + "' for the report's data: " + error.message());
    for (size_t i = 0; i < packed.size(); ++i) {
      check_cancel();
      write_text_file(folder / fmt::format("{}.js", i), fmt::format("triadPicture({},\"{}\")\n", i, packed[i].exact));
      std::string().swap(packed[i].exact);
    }
  }
  std::string scripts = "<script type=\"application/json\" id=\"triad-report\">" +
                        script_json(report_json(data, packed, side_folder)) + "</script>\n";
  size_t length = scripts.size();
  for (const Packed& one : packed) length += (side_folder.empty() ? one.exact : one.codes).size() + 80;
  scripts.reserve(length);
  for (size_t i = 0; i < packed.size(); ++i) {
    scripts += fmt::format("<script type=\"text/plain\" id=\"triad-picture-{}\">", i);
    scripts += side_folder.empty() ? packed[i].exact : packed[i].codes;
    scripts += "</script>\n";
    std::string().swap(packed[i].exact);
    std::string().swap(packed[i].codes);
  }
  std::string facts;
  for (const auto& [name, value] : data.facts)
    facts += (facts.empty() ? "" : " · ") + escaped(name) + " " + escaped(value);
  std::map<std::string, std::string> values{
      {"%triad-title%", escaped(data.title)}, {"%triad-facts%", facts}, {"%triad-tables%", tables_html(data)}};
  values.emplace("%triad-data%", std::move(scripts));
  write_text_file(path, filled(viewer_page(), values));
}

}  // namespace triad::app
