// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <sstream>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/display/layout.hpp>

#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>

namespace fs = std::filesystem;

namespace triad {
namespace {

constexpr int kMaxSide = 16;  // cells of a pixel and pixels of a tile, each way
// Shares and primaries are typed by people: "0.333333" must do, a forgotten emitter must not.
constexpr double kSumTolerance = 1e-5;
constexpr const char* kDeriveWhite = "w = min(r, g, b)";

// Reads one file's values and names the file and key in every complaint.
class Checker {
 public:
  explicit Checker(std::string origin) : origin_(std::move(origin)) {}

  [[noreturn]] void fail(const std::string& what) const { throw_input("layout '" + origin_ + "': " + what); }

  void only(const toml::table& table, const std::string& where, std::initializer_list<const char*> keys) const {
    const std::vector<std::string> known(keys.begin(), keys.end());
    for (const auto& [key, value] : table) {
      const std::string name(key.str());
      if (std::find(known.begin(), known.end(), name) == known.end())
        fail(where + "unknown key '" + printable(name) + "'" + did_you_mean(name, known) + "; known are " +
             join(known, ", "));
    }
  }
  std::string text(const toml::table& table, const std::string& where, const char* key) const {
    const auto value = table[key].value<std::string>();
    if (!value || value->empty()) fail(where + key + " must be a text, as in " + key + " = \"rgb\"");
    return printable(*value);
  }
  std::vector<double> numbers(const toml::array* list, const std::string& where, size_t count) const {
    const std::string expected = where + " must be a list of " + std::to_string(count) + " finite numbers";
    if (!list || list->size() != count) fail(expected);
    std::vector<double> values;
    for (const toml::node& node : *list) {
      const auto value = node.value<double>();
      if (!value || !std::isfinite(*value)) fail(expected);
      values.push_back(*value);
    }
    return values;
  }
  int whole(double value, const std::string& where, int low, int high) const {
    if (value != std::floor(value) || value < low || value > high)
      fail(where + " is " + format_double(value) + ": a whole number from " + std::to_string(low) + " to " +
           std::to_string(high) + " is needed");
    return static_cast<int>(value);
  }

 private:
  std::string origin_;
};

Emitter read_emitter(const Checker& check, const toml::table& table, const std::string& where, const Layout& layout) {
  check.only(table, where, {"name", "primary", "pixel", "channel", "cells"});
  Emitter emitter;
  emitter.name = check.text(table, where, "name");
  const auto primary = check.numbers(table["primary"].as_array(), where + "primary", 3);
  for (size_t i = 0; i < 3; ++i) {
    if (primary[i] < 0) check.fail(where + "primary must not be negative");
    emitter.primary[i] = primary[i];
  }
  if (primary[0] + primary[1] + primary[2] <= 0) check.fail(where + "primary is black: an emitter gives light");
  const auto pixel = check.numbers(table["pixel"].as_array(), where + "pixel", 2);
  emitter.pixel_x = check.whole(pixel[0], where + "pixel", 0, layout.tile_x - 1);
  emitter.pixel_y = check.whole(pixel[1], where + "pixel", 0, layout.tile_y - 1);
  const std::string channel = check.text(table, where, "channel");
  const std::string channels = layout.derives_white ? "rgbw" : "rgb";
  const size_t index = channel.size() == 1 ? channels.find(channel) : std::string::npos;
  if (index == std::string::npos)
    check.fail(where + "channel is '" + channel + "': \"r\", \"g\" or \"b\" is needed, or \"w\" with derive = \"" +
               kDeriveWhite + "\"");
  emitter.channel = static_cast<int>(index);
  for (size_t i = 0; i < layout.emitters.size(); ++i) {
    const Emitter& other = layout.emitters[i];
    if (other.channel == emitter.channel && other.pixel_x == emitter.pixel_x && other.pixel_y == emitter.pixel_y)
      check.fail(where + "emitter " + std::to_string(i + 1) +
                 " has the same pixel and channel; write one emitter with " + "the cells of both");
  }

  const toml::array* cells = table["cells"].as_array();
  if (!cells || cells->empty()) check.fail(where + "cells must be a list of [x, y, share]");
  double sum = 0;
  for (const toml::node& node : *cells) {
    const auto values = check.numbers(node.as_array(), where + "each of cells", 3);
    EmitterCell cell;
    // Within one tile to either side: farther is a slip of the pen.
    const int width = layout.cells_x * layout.tile_x, height = layout.cells_y * layout.tile_y;
    cell.x = check.whole(values[0], where + "a cell's x", -width, 2 * width - 1);
    cell.y = check.whole(values[1], where + "a cell's y", -height, 2 * height - 1);
    cell.share = values[2];
    if (!(cell.share > 0)) check.fail(where + "a cell's share is " + format_double(cell.share) + ": must be above 0");
    for (const EmitterCell& other : emitter.cells)
      if ((other.x - cell.x) % width == 0 && (other.y - cell.y) % height == 0)
        check.fail(where + "cell [" + std::to_string(cell.x) + ", " + std::to_string(cell.y) +
                   "] appears twice, or overlaps the same emitter of the next tile");
    sum += cell.share;
    emitter.cells.push_back(cell);
  }
  if (std::abs(sum - 1) > kSumTolerance)
    check.fail(where + "the shares of its cells sum to " + format_double(sum) + " and must sum to 1");
  for (EmitterCell& cell : emitter.cells) cell.share /= sum;
  return emitter;
}

// That each colour is there, and that a white picture gives white light.
void check_white(const Checker& check, const Layout& layout) {
  static constexpr const char* kColours[] = {"red", "green", "blue"};
  std::array<double, 3> white{};
  for (const Emitter& emitter : layout.emitters)
    for (size_t i = 0; i < 3; ++i)
      if (emitter.channel != kWhiteChannel) white[i] += emitter.primary[i];
  const double pixels = layout.tile_x * layout.tile_y;
  for (size_t i = 0; i < 3; ++i)
    if (white[i] <= 0) check.fail(std::string("no emitter gives ") + kColours[i] + " light");
  for (const double sum : white)
    if (std::abs(sum - pixels) > kSumTolerance * pixels)
      check.fail("the primaries sum to (" + format_double(white[0]) + ", " + format_double(white[1]) + ", " +
                 format_double(white[2]) + "): each must be " + format_double(pixels) +
                 ", the pixels of a tile, so that all emitters together are white");
  // A picture of one colour can only come out as that colour if each channel drives all of its own light.
  for (int channel = 0; channel < 3; ++channel) {
    std::array<double, 3> light{};
    for (const Emitter& emitter : layout.emitters)
      for (size_t i = 0; i < 3; ++i)
        if (emitter.channel == channel) light[i] += emitter.primary[i];
    for (size_t i = 0; i < 3; ++i) {
      const double wanted = static_cast<int>(i) == channel ? pixels : 0;
      if (std::abs(light[i] - wanted) > kSumTolerance * pixels)
        check.fail(std::string("channel \"") + "rgb"[channel] + "\" drives emitters whose primaries sum to (" +
                   format_double(light[0]) + ", " + format_double(light[1]) + ", " + format_double(light[2]) +
                   "): it must drive all " + kColours[channel] + " light and no other");
    }
  }
}

// That every pixel has what the rule of Layout::derives_white needs.
void check_derived(const Checker& check, const Layout& layout) {
  for (int y = 0; y < layout.tile_y; ++y)
    for (int x = 0; x < layout.tile_x; ++x) {
      std::array<double, 3> missing{};
      int found = 0;
      for (const Emitter& emitter : layout.emitters) {
        if (emitter.pixel_x != x || emitter.pixel_y != y) continue;
        ++found;
        for (size_t i = 0; i < 3; ++i)
          missing[i] += emitter.channel == kWhiteChannel ? -emitter.primary[i] : emitter.primary[i];
      }
      const std::string pixel = "pixel [" + std::to_string(x) + ", " + std::to_string(y) + "]: ";
      if (found != 4) check.fail(pixel + "emitters of the channels r, g, b and w are needed to derive w");
      for (const double light : missing)
        if (std::abs(light) > kSumTolerance)
          check.fail(pixel + "the primary of w must be the sum of those of r, g and b, which it stands in for");
    }
}

std::string layouts_folder() { return (fs::path(data_folder()) / "layouts").string(); }

}  // namespace

double Emitter::centre_x() const {
  double sum = 0;
  for (const EmitterCell& cell : cells) sum += cell.share * (cell.x + .5);
  return sum;
}

double Emitter::centre_y() const {
  double sum = 0;
  for (const EmitterCell& cell : cells) sum += cell.share * (cell.y + .5);
  return sum;
}

bool Layout::has_independent_rows() const {
  if (cells_y != 1 || tile_y != 1) return false;
  for (const Emitter& emitter : emitters)
    for (const EmitterCell& cell : emitter.cells)
      if (cell.y != 0) return false;
  return true;
}

bool Layout::is_rows() const {
  if (!has_independent_rows() || tile_x != 1 || emitters.size() != 3) return false;
  unsigned driven = 0;
  for (const Emitter& emitter : emitters) {
    driven |= 1u << emitter.channel;
    for (const EmitterCell& cell : emitter.cells)
      if (cell.x < 0 || cell.x >= cells_x) return false;
  }
  return driven == 7;
}

int Layout::emitter_of(int channel) const {
  for (size_t e = 0; e < emitters.size(); ++e)
    if (emitters[e].channel == channel) return static_cast<int>(e);
  throw_internal("layout '" + name + "' drives nothing by channel " + std::to_string(channel));
}

Layout parse_layout(const std::string& text, const std::string& origin) {
  const Checker check(printable(origin));
  toml::table table;
  try {
    table = toml::parse(text);
  } catch (const toml::parse_error& error) {
    check.fail("line " + std::to_string(error.source().begin.line) + ": " +
               printable(std::string(error.description())));
  }
  check.only(table, "", {"name", "summary", "pixel_cells", "tile_pixels", "derive", "emitter"});
  Layout layout;
  layout.name = check.text(table, "", "name");
  layout.summary = check.text(table, "", "summary");
  const auto cells = check.numbers(table["pixel_cells"].as_array(), "pixel_cells", 2);
  const auto tile = check.numbers(table["tile_pixels"].as_array(), "tile_pixels", 2);
  layout.cells_x = check.whole(cells[0], "pixel_cells", 1, kMaxSide);
  layout.cells_y = check.whole(cells[1], "pixel_cells", 1, kMaxSide);
  layout.tile_x = check.whole(tile[0], "tile_pixels", 1, kMaxSide);
  layout.tile_y = check.whole(tile[1], "tile_pixels", 1, kMaxSide);

  if (table.contains("derive")) {
    std::string rule = check.text(table, "", "derive");
    std::string wanted = kDeriveWhite;
    for (std::string* words : {&rule, &wanted}) std::erase(*words, ' ');
    if (rule != wanted) check.fail("derive is '" + rule + "': \"" + kDeriveWhite + "\" is the rule that is known");
    layout.derives_white = true;
  }

  const toml::array* emitters = table["emitter"].as_array();
  if (!emitters || emitters->empty() || emitters->size() > kMaxEmitters)
    check.fail("1 to " + std::to_string(kMaxEmitters) + " [[emitter]] tables are needed");
  for (const toml::node& node : *emitters) {
    const std::string where = "emitter " + std::to_string(layout.emitters.size() + 1) + ": ";
    if (!node.is_table()) check.fail(where + "must be a table, written [[emitter]]");
    layout.emitters.push_back(read_emitter(check, *node.as_table(), where, layout));
  }
  check_white(check, layout);
  if (layout.derives_white) check_derived(check, layout);
  return layout;
}

Layout load_layout(const std::string& name_or_path) {
  if (name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".toml"))
    return parse_layout(read_text_file(name_or_path), name_or_path);
  const auto names = layout_names();
  if (std::find(names.begin(), names.end(), name_or_path) == names.end())
    throw_usage("unknown layout '" + printable(name_or_path) + "'" + did_you_mean(name_or_path, names) +
                "; known are " + join(names, ", ") + ", and paths of .toml files");
  const std::string path = (fs::path(layouts_folder()) / (name_or_path + ".toml")).string();
  Layout layout = parse_layout(read_text_file(path), path);
  if (layout.name != name_or_path)
    throw_input("layout '" + path + "': its name is '" + layout.name + "' and must be that of the file");
  return layout;
}

std::vector<std::string> layout_names() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(layouts_folder(), error))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  if (error) throw_input("cannot read the folder of layouts '" + layouts_folder() + "': " + error.message());
  std::sort(names.begin(), names.end());
  return names;
}

void require_rows(const Layout& layout) {
  if (!layout.is_rows())
    throw_usage("layout '" + layout.name +
                "' does not consist of vertical stripes, one per channel: filtering row by row needs such a layout, "
                "for example rgb or bgr");
}

}  // namespace triad
