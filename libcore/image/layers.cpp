// SPDX-License-Identifier: Apache-2.0
// Layers (AOVs) of files that hold several pictures' channels.
#include <algorithm>
#include <array>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/image/internal/header.hpp>

namespace triad::image {
namespace {

struct Layer {
  std::string name;
  int part = 0;
  std::vector<int> channels;  // indices into the part's
};

std::vector<Layer> layers_of(const std::vector<PartInfo>& parts, int only_part) {
  std::vector<Layer> layers;
  for (int p = 0; p < std::ssize(parts); ++p) {
    if (only_part >= 0 && p != only_part) continue;
    const PartInfo& part = parts[static_cast<size_t>(p)];
    const auto add = [&](const std::string& name, int channel) {
      const auto known = std::find_if(layers.begin(), layers.end(),
                                      [&](const Layer& layer) { return layer.part == p && layer.name == name; });
      if (known != layers.end())
        known->channels.push_back(channel);
      else
        layers.push_back({name, p, {channel}});
    };
    for (int c = 0; c < std::ssize(part.channels); ++c) {
      const std::string& channel = part.channels[static_cast<size_t>(c)];
      const std::string name = layer_of(channel);
      if (!name.empty()) {
        add(name, c);
        continue;
      }
      if (parts.size() > 1 && !part.name.empty()) add(part.name, c);
      // Z, object_id and the like are layers by themselves; the picture's own channels are none.
      if (component(channel) < 0 && !is_alpha(channel) && lower(channel) != "y" && channel != part.name)
        add(channel, c);
    }
  }
  return layers;
}

std::vector<std::string> names_of(const std::vector<Layer>& layers) {
  std::vector<std::string> names;
  for (const Layer& layer : layers)
    if (std::find(names.begin(), names.end(), layer.name) == names.end()) names.push_back(layer.name);
  return names;
}

const Layer& find_layer(const std::string& path, const std::vector<Layer>& layers, const std::string& wanted) {
  const std::string small = lower(wanted);
  const auto fits = [&](const Layer& layer, int how) {
    const std::string name = lower(layer.name);
    return how == 0 ? layer.name == wanted : how == 1 ? name == small : name.ends_with("." + small);
  };
  for (int how = 0; how < 3; ++how) {
    std::vector<Layer> found;
    std::copy_if(layers.begin(), layers.end(), std::back_inserter(found),
                 [&](const Layer& layer) { return fits(layer, how); });
    const std::vector<std::string> names = names_of(found);
    if (names.size() > 1)
      throw_input("'" + path + "' has several layers '" + wanted + "': '" + join(names, "', '") +
                  "'; name one in full");
    const auto [first, last] = std::minmax_element(found.begin(), found.end(),
                                                   [](const Layer& a, const Layer& b) { return a.part < b.part; });
    if (found.size() > 1 && first->part != last->part)
      throw_input("'" + path + "' has the layer '" + names[0] + "' in several parts; choose one of them with --part");
    if (!names.empty())
      return *std::find_if(layers.begin(), layers.end(), [&](const Layer& layer) { return fits(layer, how); });
  }
  const std::vector<std::string> names = names_of(layers);
  throw_input("'" + path + "' has no layer '" + wanted + "'" + did_you_mean(wanted, names) + "; it has " +
              (names.empty() ? "none" : "'" + join(names, "', '") + "'"));
}

// Renderers that store directions and the like as R, G and B say so in the layer's name only.
bool says_data(const std::string& layer) {
  static const std::vector<std::string> kNames{"n",     "ng", "ns",     "normal",   "normals", "p",        "position",
                                               "depth", "z",  "motion", "velocity", "uv",      "variance", "vector"};
  return std::find(kNames.begin(), kNames.end(), base_of(layer)) != kNames.end();
}

}  // namespace

LayerChoice choose_layer(const std::string& path, const std::vector<PartInfo>& parts, int only_part,
                         const std::string& wanted) {
  const std::vector<Layer> layers = layers_of(parts, only_part);
  const Layer& layer = find_layer(path, layers, wanted);
  const std::vector<std::string>& in_file = parts[static_cast<size_t>(layer.part)].channels;
  std::array<int, 4> rgba{-1, -1, -1, -1};
  std::array<int, 3> xyz{-1, -1, -1};
  std::vector<int> others;  // without alpha
  std::vector<std::string> names;
  for (const int index : layer.channels) {
    const std::string& name = in_file[static_cast<size_t>(index)];
    const std::string base = base_of(name);
    names.push_back(name);
    if (is_alpha(name)) {
      rgba[3] = index;
      continue;
    }
    others.push_back(index);
    if (const int c = component(name); c >= 0) rgba[static_cast<size_t>(c)] = index;
    if (base == "x" || base == "y" || base == "z") xyz[static_cast<size_t>(base[0] - 'x')] = index;
  }
  LayerChoice choice;
  choice.part = layer.part;
  ChannelChoice& channels = choice.channels;
  const bool data = says_data(layer.name);
  if (rgba[0] >= 0 && rgba[1] >= 0 && rgba[2] >= 0) {
    channels.file_indices = {rgba[0], rgba[1], rgba[2]};
    channels.colour_channels = data ? 0 : 3;
  } else if (xyz[0] >= 0 && xyz[1] >= 0 && xyz[2] >= 0) {
    channels.file_indices = {xyz[0], xyz[1], xyz[2]};
  } else if (others.size() == 1) {
    channels.file_indices = others;
    channels.colour_channels = xyz[1] >= 0 && !data ? 1 : 0;
  } else {
    throw_input("'" + path + "': the layer '" + layer.name + "' has the channels " + join(names, ", ") +
                ", which are neither R, G, B nor X, Y, Z nor a single one; choose some with --channels");
  }
  if (channels.colour_channels > 0 && rgba[3] >= 0) {
    channels.alpha = channels.colour_channels;
    channels.file_indices.push_back(rgba[3]);
  }
  for (const int index : channels.file_indices) channels.names.push_back(in_file[static_cast<size_t>(index)]);
  return choice;
}

}  // namespace triad::image
