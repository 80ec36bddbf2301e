// SPDX-License-Identifier: Apache-2.0
// What the plugins that look at a panel share: which panel it is, who looks, and the memory of whole pictures.
#pragma once

#include "display_parameters.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <triad/base/text.hpp>
#include <triad/display/panel_torus.hpp>

namespace seeing_parameters {

namespace tp = triad_plugin;

inline constexpr const char* kLayoutDoc =
    "how the subpixels lie: a name of `triad list layouts` or the path of a layout's TOML file; auto takes the one "
    "that the pictures name, else rgb";
inline constexpr const char* kOriginKey = "triad:origin";  // and the pixel of that panel where it begins: "1,0"
inline constexpr const char* kLayoutKey = "triad:layout";  // in a picture's metadata: the layout it was made for

// The panel that `layout` names. auto: what `named` (the pictures' own words, none or several) agree on.
inline triad::Layout choose_panel(const std::string& layout, const std::vector<std::optional<std::string>>& named) {
  if (layout != "auto") return display_parameters::in_library([&] { return triad::load_layout(layout); });
  std::string name;
  for (const auto& one : named) {
    if (!one) continue;
    if (!name.empty() && *one != name)
      throw tp::Error(TRIAD_E_INPUT, "one picture was made for layout '" + name + "', the other for '" + *one +
                                         "'; say with layout= which panel shows them");
    name = *one;
  }
  if (name.empty()) name = "rgb";
  return display_parameters::in_library([&] {
    // A name out of a file: never a path.
    const auto known = triad::layout_names();
    if (std::find(known.begin(), known.end(), name) == known.end())
      triad::throw_input("the picture was made for a layout '" + name +
                         "', which is not known here; give its file, layout=PATH.toml");
    return triad::load_layout(name);
  });
}

struct Origin {
  int x_px = 0, y_px = 0;
};
// In plan, after display_parameters::check_origin: `origin` counted from where crop has moved the first input to,
// both modulo the tile, so that any whole numbers do.
inline Origin origin_on(tp::PlanCall& call, const std::vector<double>& origin, const triad::Layout& panel) {
  const auto modulo = [](double value, int tile) {
    return static_cast<int>(value - tile * std::floor(value / tile));
  };
  std::array<double, 2> moved{};
  if (const auto text = call.get_meta(0, kOriginKey)) {
    const size_t comma = std::min(text->find(','), text->size());
    const auto x = triad::parse_int(text->substr(0, comma));
    const auto y = triad::parse_int(text->substr(std::min(comma + 1, text->size())));
    if (!x || !y)
      throw tp::Error(TRIAD_E_INPUT, std::string(kOriginKey) + " of the picture is '" + *text +
                                         "': two whole numbers of pixels are needed, as in 1,0");
    moved = {static_cast<double>(*x), static_cast<double>(*y)};
  }
  return {modulo(origin[0] + moved[0], panel.tile_x), modulo(origin[1] + moved[1], panel.tile_y)};
}

inline std::string cells_text(int x, int y) { return std::to_string(x) + "x" + std::to_string(y); }

// The rows of an input from row y on, as the library takes them.
inline triad::PictureView rows_from(const tp::View<const float>& in, int y) {
  return {in.row(y), in.height() > 1 ? in.row(in.r.y0 + 1) - in.row(in.r.y0) : in.row_floats()};
}

}  // namespace seeing_parameters
