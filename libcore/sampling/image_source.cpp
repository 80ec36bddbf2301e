// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>
#include <triad/colour/file_space.hpp>
#include <triad/image/reader.hpp>
#include <triad/sampling/image_source.hpp>
#include <vector>

namespace triad {
namespace {

constexpr float kSky = 1e9f;  // distances from here on are misses

// The places of geometry among a picture's channels; -1: not there.
struct GeometryChannels {
  int distance = -1, object_id = -1, material_id = -1;
  std::array<int, 3> position{-1, -1, -1}, normal{-1, -1, -1};

  bool any() const { return distance >= 0 || object_id >= 0 || material_id >= 0 || position[0] >= 0; }
  KnownGeometry known() const {
    return {.distance = distance >= 0,
            .position = position[0] >= 0,
            .normal = normal[0] >= 0,
            .albedo = false,
            .object_id = object_id >= 0,
            .material_id = material_id >= 0};
  }
};

// The first channel with one of these names, in any case: at the top level, else in a layer.
int find_channel(const std::vector<std::string>& channels, const std::vector<std::string>& names) {
  for (const bool in_layer : {false, true})
    for (const std::string& name : names)
      for (size_t i = 0; i < channels.size(); ++i) {
        const std::string channel = lower(channels[i]);
        if (in_layer ? channel.ends_with("." + name) : channel == name) return static_cast<int>(i);
      }
  return -1;
}

std::array<int, 3> find_vector(const std::vector<std::string>& channels, const std::vector<std::string>& names) {
  std::array<int, 3> found{};
  for (size_t axis = 0; axis < 3; ++axis) {
    std::vector<std::string> wanted;
    for (const std::string& name : names) wanted.push_back(name + "." + "xyz"[axis]);
    found[axis] = find_channel(channels, wanted);
    if (found[axis] < 0) return {-1, -1, -1};
  }
  return found;
}

GeometryChannels find_geometry(const std::vector<std::string>& channels) {
  GeometryChannels found;
  const int z = find_channel(channels, {"depth.z", "depth.v", "depth", "zdepth"});
  const auto top =
      std::find_if(channels.begin(), channels.end(), [](const auto& name) { return lower(name) == "z"; });
  found.distance = top != channels.end() ? static_cast<int>(top - channels.begin()) : z;
  found.position = find_vector(channels, {"p", "position"});
  found.normal = find_vector(channels, {"n", "normal"});
  found.object_id = find_channel(channels, {"object_id", "indexob.x"});
  found.material_id = find_channel(channels, {"material_id", "indexma.x"});
  return found;
}

struct Geometry {
  float distance;
  std::array<float, 3> position, normal;
  float object_id, material_id;
};

struct Pixels {
  int width = 0, height = 0;
  std::vector<std::array<float, 3>> colour;
  std::vector<Geometry> geometry;  // empty: none

  size_t at(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  }
};

bool finite(const std::array<float, 3>& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

uint32_t id(float value) { return value >= .5f && value < 0x1p32f ? static_cast<uint32_t>(value + .5f) : 0; }

class ImageSource final : public Source {
 public:
  ImageSource(Pixels pixels, const KnownGeometry& known, int width, int height)
      : pixels_(std::move(pixels)),
        known_(known),
        width_(width),
        height_(height),
        scale_x_(static_cast<double>(pixels_.width) / width),
        scale_y_(static_cast<double>(pixels_.height) / height) {}
  int width() const override { return width_; }
  int height() const override { return height_; }
  SourceAbilities abilities() const override {
    return {.geometry = !pixels_.geometry.empty(), .exact_integral = true, .deterministic = true, .known = known_};
  }

  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const override {
    for (size_t i = 0; i < requests.size(); ++i) {
      const size_t pixel = pixels_.at(nearest(requests[i].x * scale_x_, pixels_.width),
                                      nearest(requests[i].y * scale_y_, pixels_.height));
      samples[i].rgb = pixels_.colour[pixel];
      samples[i].valid = finite(samples[i].rgb);
      if (pixels_.geometry.empty()) continue;
      const Geometry& geometry = pixels_.geometry[pixel];
      samples[i].distance = geometry.distance;
      samples[i].position = geometry.position;
      samples[i].normal = geometry.normal;
      samples[i].object_id = id(geometry.object_id);
      samples[i].material_id = id(geometry.material_id);
    }
  }

  std::optional<std::array<double, 3>> integral(double x0, double y0, double x1, double y1) const override {
    x0 *= scale_x_, x1 *= scale_x_, y0 *= scale_y_, y1 *= scale_y_;
    std::array<double, 3> sum{};
    double area = 0;
    for (double top = std::floor(y0); top < y1; ++top) {
      const double down = std::min(top + 1, y1) - std::max(top, y0);
      const int y = nearest(top, pixels_.height);
      for (double left = std::floor(x0); left < x1; ++left) {
        const std::array<float, 3>& rgb = pixels_.colour[pixels_.at(nearest(left, pixels_.width), y)];
        if (!finite(rgb)) continue;
        const double part = down * (std::min(left + 1, x1) - std::max(left, x0));
        for (size_t c = 0; c < 3; ++c) sum[c] += part * rgb[c];
        area += part;
      }
    }
    if (area > 0)
      for (double& s : sum) s /= area;
    return sum;
  }

 private:
  static int nearest(double t, int size) { return static_cast<int>(std::clamp(std::floor(t), 0., size - 1.)); }

  Pixels pixels_;
  KnownGeometry known_;
  int width_, height_;
  double scale_x_, scale_y_;
};

Geometry geometry_of(const float* channels, const GeometryChannels& places) {
  const auto get = [&](int place, float other) { return place >= 0 ? channels[place] : other; };
  Geometry g{.distance = std::numeric_limits<float>::infinity(),
             .position = {},
             .normal = {},
             .object_id = get(places.object_id, 0),
             .material_id = get(places.material_id, 0)};
  const bool has_position = places.position[0] >= 0;
  for (size_t c = 0; c < 3; ++c) {
    g.position[c] = get(places.position[c], 0);
    g.normal[c] = get(places.normal[c], 0);
  }
  if (places.distance >= 0) {
    g.distance = channels[places.distance];
    if (!(g.distance < kSky)) g.distance = std::numeric_limits<float>::infinity();
    if (!has_position && std::isfinite(g.distance)) g.position = {0, 0, -g.distance};
  } else if (has_position || id(g.object_id) > 0 || id(g.material_id) > 0) {
    g.distance = 1;
  }
  return g;
}

// Its colour in linear light, and its geometry if any is wanted.
Pixels read_pixels(ImageReader& reader, const ColourConfig& colours, const ImageSourceOptions& options,
                   const GeometryChannels& places) {
  const ImageSpec& spec = reader.spec();
  const std::string space = file_colour_space(reader, options.colour_space, colours);
  if (spec.colour_channels == 0)
    throw_input("'" + reader.path() + "' has no colour: its channels are " + join(spec.channels, ", "));
  Pixels pixels{.width = spec.width, .height = spec.height, .colour = {}, .geometry = {}};
  const size_t width = static_cast<size_t>(spec.width), count = width * static_cast<size_t>(spec.height);
  const size_t each = sizeof(pixels.colour[0]) + (places.any() ? sizeof(Geometry) : 0);
  const double bytes =
      static_cast<double>(count) * static_cast<double>(each) + static_cast<double>(reader.decoder_bytes());
  const uint64_t most = options.most_bytes > 0 ? options.most_bytes : machine_memory_bytes() / 2;
  if (bytes > static_cast<double>(most))
    throw_input("'" + reader.path() + "' of " + spec.size_text() + " takes " +
                format_bytes(static_cast<uint64_t>(std::min(bytes, 1e18))) + " of memory as a source, and " +
                format_bytes(most) + " are allowed; take a smaller picture");
  pixels.colour.resize(count);
  if (places.any()) pixels.geometry.resize(count);

  const ColourTransform transform =
      space.empty() || colours.is_data(space) ? ColourTransform{} : colours.transform(space, colours.lin_rec709());
  const int channels = spec.channel_count(), rows = std::max(reader.block_rows(), 16);
  const bool grey = spec.colour_channels == 1;
  std::vector<float> strip(static_cast<size_t>(rows) * width * static_cast<size_t>(channels)), rgba;
  for (int y0 = 0; y0 < spec.height; y0 += rows) {
    check_cancel();
    const int y1 = std::min(y0 + rows, spec.height);
    reader.read_rows(y0, y1, strip.data(), width * static_cast<size_t>(channels));
    const size_t in_strip = static_cast<size_t>(y1 - y0) * width, first = static_cast<size_t>(y0) * width;
    rgba.resize(in_strip * 4);
    for (size_t i = 0; i < in_strip; ++i) {
      const float* from = &strip[i * static_cast<size_t>(channels)];
      for (size_t c = 0; c < 3; ++c) rgba[4 * i + c] = from[grey ? 0 : c];
      rgba[4 * i + 3] = spec.alpha >= 0 ? from[spec.alpha] : 1;
      if (places.any()) pixels.geometry[first + i] = geometry_of(from, places);
    }
    if (!transform.identity()) transform.apply(rgba.data(), in_strip, 4, 3);
    for (size_t i = 0; i < in_strip; ++i) pixels.colour[first + i] = {rgba[4 * i], rgba[4 * i + 1], rgba[4 * i + 2]};
  }
  return pixels;
}

void warn_of_holes(const std::string& path, const Pixels& pixels) {
  size_t holes = 0, first = 0;
  for (size_t i = pixels.colour.size(); i-- > 0;)
    if (!finite(pixels.colour[i])) {
      ++holes;
      first = i;
    }
  if (holes == 0) return;
  const auto width = static_cast<size_t>(pixels.width);
  warn("'" + path + "': " + std::to_string(holes) + " of its pixels are not finite and are left out, the first " +
       std::to_string(first % width) + "," + std::to_string(first / width));
}

}  // namespace

std::unique_ptr<Source> make_image_source(const std::string& path, int width_px, int height_px, const Cells& cells,
                                          const ColourConfig& colours, const ImageSourceOptions& options) {
  std::unique_ptr<ImageReader> reader = ImageReader::open(path);
  const int width = width_px * cells.x, height = height_px * cells.y;
  const ImageSpec& spec = reader->spec();
  if (width > spec.width || height > spec.height)
    throw_input("'" + path + "' is " + std::to_string(spec.width) + "x" + std::to_string(spec.height) +
                " pixels, too few for a film of " + std::to_string(width) + "x" + std::to_string(height) +
                "; ask for a smaller size, or take a larger picture");
  // Sizes are whole, so a shape is only right to about a pixel.
  const double shape = spec.pixel_aspect * spec.width / spec.height,
               asked = static_cast<double>(width_px) / height_px;
  if (std::abs(shape / asked - 1) > std::max(.01, 1. / std::min(width_px, height_px)))
    warn("'" + path + "' is " + format_double(std::round(100 * shape) / 100) +
         " times as wide as high, and the film " + format_double(std::round(100 * asked) / 100) +
         " times; it will look stretched");

  GeometryChannels places;
  if (options.geometry && find_geometry(reader->info().all_channels).any()) {
    reader =
        ImageReader::open(path, {.part = "", .channels = {}, .colour_space = "", .cells = {}, .all_channels = true});
    places = find_geometry(reader->spec().channels);
  }
  Pixels pixels = read_pixels(*reader, colours, options, places);
  warn_of_holes(path, pixels);
  return std::make_unique<ImageSource>(std::move(pixels), places.known(), width, height);
}

}  // namespace triad
