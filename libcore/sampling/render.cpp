// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/display/layout.hpp>
#include <triad/sampling/render.hpp>

namespace triad {

PictureSize parse_size(const std::string& text, const std::string& option) {
  const size_t cross = text.find('x');
  if (cross != std::string::npos) {
    const auto width = parse_int(std::string_view(text).substr(0, cross));
    const auto height = parse_int(std::string_view(text).substr(cross + 1));
    constexpr int kMost = std::numeric_limits<int>::max();
    if (width && height && *width >= 1 && *height >= 1 && *width <= kMost && *height <= kMost)
      return {static_cast<int>(*width), static_cast<int>(*height)};
  }
  throw_usage(option + ": '" + text + "' is not a size in pixels; write width x height, as in 400x225");
}

CellsOfLayout parse_cells_or_layout(const std::string& text, const std::string& option) {
  if (!text.empty() && text[0] >= '0' && text[0] <= '9') return {parse_cells(text, option), ""};
  const Layout layout = load_layout(text);
  return {{layout.cells_x, layout.cells_y}, layout.name};
}

PictureSize film_size(const PictureSize& picture, const Cells& cells) {
  const int64_t width = int64_t{picture.width} * cells.x, height = int64_t{picture.height} * cells.y;
  if (std::max(width, height) > std::numeric_limits<int>::max())
    throw_usage("--size " + std::to_string(picture.width) + "x" + std::to_string(picture.height) + " with --cells " +
                std::to_string(cells.x) + "x" + std::to_string(cells.y) +
                " has a side of more than 2^31 - 1 pixels; ask for fewer");
  return {static_cast<int>(width), static_cast<int>(height)};
}

double parse_until(const std::string& text, const std::string& option) {
  constexpr std::string_view kName = "rmse=";
  if (text.rfind(kName, 0) == 0) {
    const auto value = parse_double(std::string_view(text).substr(kName.size()));
    if (value && std::isfinite(*value) && *value > 0) return *value;
  }
  throw_usage(option + ": '" + text + "' is not an error to stop at; write rmse=V with V above 0, as in rmse=1e-3");
}

std::vector<std::string> missing_planes(const FilmPlanes& planes, const SourceAbilities& abilities) {
  const KnownGeometry& known = abilities.known;
  std::vector<std::string> missing;
  const auto check = [&](const char* name, bool wanted, bool told) {
    if (wanted && !(abilities.geometry && told)) missing.emplace_back(name);
  };
  check("depth", planes.depth, known.distance);
  check("position", planes.position, known.position);
  check("normal", planes.normal, known.normal);
  check("albedo", planes.albedo, known.albedo);
  check("object-id", planes.object_id, known.object_id);
  check("material-id", planes.material_id, known.material_id);
  return missing;
}

ImageSpec render_spec(const PictureSize& film, const Cells& cells, const FilmPlanes& planes,
                      const Strategy& strategy) {
  const std::vector<std::string> reasons = strategy.reason_channels();
  if (planes.reasons && reasons.empty())
    throw_usage("the strategy '" + strategy.info().name + "' has no reasons to tell; leave them out of the planes");
  ImageSpec spec;
  spec.width = film.width;
  spec.height = film.height;
  spec.channels = film_channels(planes);
  if (planes.reasons) spec.channels.insert(spec.channels.end(), reasons.begin(), reasons.end());
  spec.colour_channels = 3;
  spec.cells = cells;
  spec.pixel_aspect = static_cast<double>(cells.y) / cells.x;
  spec.colour_space = "lin_rec709";
  // ITU-R BT.709: the primaries of red, green, blue, and D65.
  spec.chromaticities = {{.64f, .33f, .3f, .6f, .15f, .06f, .3127f, .329f}};
  return spec;
}

Image render_picture(const RenderResult& result, const Strategy& strategy, const RenderOptions& options,
                     const Source& source, const Cells& cells, const Facts& facts) {
  const FilmPlanes& planes = result.film.planes();
  Image image = result.image(planes.reasons ? strategy.reason_channels() : std::vector<std::string>{});
  image.spec = render_spec({result.film.width(), result.film.height()}, cells, planes, strategy);
  const auto put = [&](const std::string& name, const std::string& value) {
    image.spec.metadata.set("triad:" + name, value);
  };
  for (const auto& [name, value] : facts) put(name, value);
  put("strategy", strategy.text());
  put("seed", std::to_string(options.seed));
  put("samples", std::to_string(result.samples));
  if (result.dropped > 0) put("dropped", std::to_string(result.dropped));
  const double rmse = result.passes.empty() ? NAN : result.passes.back().rmse;
  if (std::isfinite(rmse)) put("rmse", format_double(rmse));
  for (WorkCount work : source.work()) {
    std::replace(work.kind.begin(), work.kind.end(), ' ', '_');
    put(work.kind, std::to_string(work.count));
  }
  if (!result.complete) put("partial", "true");
  return image;
}

}  // namespace triad
