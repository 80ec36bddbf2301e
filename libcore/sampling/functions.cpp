// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/function_base.hpp>
#include <triad/sampling/strokes.hpp>

namespace triad {
namespace {

const StrategyParam kSeed{"seed", "another seed, other strokes", 0, 1e9, 0};
const FunctionInfo kStrokes{"strokes",
                            "white strokes at random angles on black",
                            "Half a pixel to two pixels wide: what subpixels can show better than pixels. It has no "
                            "exact picture.",
                            {kSeed}};
const FunctionInfo kColours{
    "colours",
    "strokes, each in a random colour",
    "As the strokes, in all the colours that a display has: what subpixels are bad at. It has "
    "no exact picture.",
    {kSeed}};
const FunctionInfo kStems{"stems",
                          "black upright and level stems on white",
                          "Of about a pixel, as letters are made of, on lines as text is. It has no exact picture.",
                          {kSeed}};

std::unique_ptr<Source> strokes(const FunctionInfo& info, const StrategyValues& values, const View& view) {
  return make_strokes(info.name, view.width_px, view.height_px, view.cells, static_cast<uint64_t>(values.at("seed")));
}

const std::vector<FunctionEntry>& entries() {
  static const std::vector<FunctionEntry> list{
      flat_function(),
      ramp_function(),
      half_plane_function(),
      thin_line_function(),
      stripes_function(),
      checker_function(),
      horizon_function(),
      zone_plate_function(),
      chirp_function(),
      discs_function(),
      {kStrokes, [](const auto& values, const View& view, const auto&) { return strokes(kStrokes, values, view); }},
      {kColours, [](const auto& values, const View& view, const auto&) { return strokes(kColours, values, view); }},
      {kStems, [](const auto& values, const View& view, const auto&) { return strokes(kStems, values, view); }},
      white_on_white_function(),
      small_object_function(),
      speck_function()};
  return list;
}

}  // namespace

std::vector<const FunctionInfo*> function_list() {
  std::vector<const FunctionInfo*> list;
  for (const FunctionEntry& entry : entries()) list.push_back(&entry.info);
  return list;
}

std::unique_ptr<Source> make_function(const std::string& text, int width_px, int height_px, const Cells& cells,
                                      const std::string& option) {
  const Chosen chosen = choose_named("function", function_list(), text, option);
  return entries()[chosen.place].make(chosen.values, {width_px, height_px, cells}, option);
}

std::string function_text(const std::string& text, const std::string& option) {
  const Chosen chosen = choose_named("function", function_list(), text, option);
  return named_text(entries()[chosen.place].info, chosen.values);
}

}  // namespace triad
