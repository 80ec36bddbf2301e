// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <triad/base/error.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/image/internal/header.hpp>

namespace triad::image {

std::string layer_of(const std::string& name) {
  const size_t dot = name.rfind('.');
  return dot == std::string::npos ? "" : name.substr(0, dot);
}
std::string base_of(const std::string& name) {
  const size_t dot = name.rfind('.');
  return lower(dot == std::string::npos ? name : name.substr(dot + 1));
}
bool is_alpha(const std::string& name) { return base_of(name) == "a" || base_of(name) == "alpha"; }
int component(const std::string& name) {
  static const std::vector<std::string> kShort{"r", "g", "b"}, kLong{"red", "green", "blue"};
  const std::string base = base_of(name);
  for (int c = 0; c < 3; ++c)
    if (base == kShort[c] || base == kLong[c]) return c;
  return -1;
}

namespace {

using Names = std::vector<std::string>;

// R, G, B and perhaps A of a layer ("" the top level): indices, or {} without all three of R, G and B.
std::vector<int> colour_of_layer(const Names& names, const std::string& layer) {
  int found[4] = {-1, -1, -1, -1};
  for (size_t i = 0; i < names.size(); ++i) {
    if (layer_of(names[i]) != layer) continue;
    const int c = is_alpha(names[i]) ? 3 : component(names[i]);
    if (c >= 0 && found[c] < 0) found[c] = static_cast<int>(i);
  }
  if (found[0] < 0 || found[1] < 0 || found[2] < 0) return {};
  std::vector<int> result(found, found + 3);
  if (found[3] >= 0) result.push_back(found[3]);
  return result;
}

int find_name(const Names& names, const std::string& wanted) {
  for (size_t i = 0; i < names.size(); ++i)
    if (names[i] == wanted) return static_cast<int>(i);
  for (size_t i = 0; i < names.size(); ++i)
    if (lower(names[i]) == lower(wanted)) return static_cast<int>(i);
  return -1;
}

// Whether the first three chosen are R, G and B of one layer, in whatever order.
bool begins_with_rgb(const Names& chosen) {
  if (chosen.size() < 3) return false;
  bool found[3] = {};
  for (size_t i = 0; i < 3; ++i) {
    if (component(chosen[i]) < 0 || layer_of(chosen[i]) != layer_of(chosen[0])) return false;
    found[component(chosen[i])] = true;
  }
  return found[0] && found[1] && found[2];
}

// Says which of the chosen channels are colour, which one is alpha, and what they are called.
void classify(const Names& names, ChannelChoice& choice) {
  const auto name = [&](size_t i) -> const std::string& { return names[choice.file_indices[i]]; };
  const size_t n = choice.file_indices.size();
  for (size_t i = 0; i < n; ++i) choice.names.push_back(name(i));
  if (begins_with_rgb(choice.names)) {
    choice.colour_channels = 3;
    // The first is the red of the new picture, and so on: what was asked for is a swap, in every format.
    std::sort(choice.names.begin(), choice.names.begin() + 3,
              [](const std::string& a, const std::string& b) { return component(a) < component(b); });
  } else if (n >= 1 && !is_alpha(name(0)) && (n == 1 || (n == 2 && is_alpha(name(1))))) {
    choice.colour_channels = 1;
  }
  const size_t next = static_cast<size_t>(choice.colour_channels);
  if (next > 0 && next < n && is_alpha(name(next)) && layer_of(name(next)) == layer_of(name(0)))
    choice.alpha = choice.colour_channels;
}

ChannelChoice choose_named(const std::string& path, const Names& in_file, const Names& wanted) {
  ChannelChoice choice;
  const auto add = [&choice](int index) {
    auto& list = choice.file_indices;
    if (std::find(list.begin(), list.end(), index) == list.end()) list.push_back(index);
  };
  for (const auto& name : wanted) {
    const int index = find_name(in_file, name);
    if (index >= 0) {
      add(index);
      continue;
    }
    const size_t before = choice.file_indices.size();
    for (const int colour : colour_of_layer(in_file, name)) add(colour);
    for (size_t i = 0; i < in_file.size(); ++i)
      if (lower(in_file[i]).rfind(lower(name) + ".", 0) == 0) add(static_cast<int>(i));
    if (choice.file_indices.size() == before)
      throw_input("'" + path + "' has no channel or layer '" + name + "'" + did_you_mean(name, in_file) +
                  "; it has " + join(in_file, ", "));
  }
  classify(in_file, choice);
  if (choice.colour_channels == 0)
    for (const std::string& name : choice.names)
      if (!colour_of_layer(choice.names, layer_of(name)).empty()) {
        warn("'" + path + "': of the channels " + join(choice.names, ", ") +
             " none is taken as colour; for that, R, G and B must come first");
        break;
      }
  return choice;
}

}  // namespace

int find_alpha(const Names& in_file) {
  for (size_t i = 0; i < in_file.size(); ++i)
    if (layer_of(in_file[i]).empty() && is_alpha(in_file[i])) return static_cast<int>(i);
  return -1;
}

ChannelChoice choose_channels(const std::string& path, const Names& in_file, const ReadOptions& options) {
  if (!options.channels.empty()) return choose_named(path, in_file, options.channels);
  ChannelChoice choice;
  choice.file_indices = colour_of_layer(in_file, "");
  const int alpha = find_alpha(in_file);
  if (choice.file_indices.empty()) {
    std::vector<int> top;  // without layers and alpha
    for (size_t i = 0; i < in_file.size(); ++i)
      if (layer_of(in_file[i]).empty() && !is_alpha(in_file[i])) top.push_back(static_cast<int>(i));
    const int grey = find_name(in_file, "Y");
    if (grey >= 0 && find_name(in_file, "X") < 0) {  // with an X beside it, Y is a coordinate
      choice.file_indices = {grey};
      if (alpha >= 0) choice.file_indices.push_back(alpha);
    } else if (!top.empty() || in_file.size() == 1) {
      choice.file_indices = top.empty() ? std::vector<int>{0} : top;
      if (alpha >= 0 && !top.empty()) choice.file_indices.push_back(alpha);
    }
  }
  if (choice.file_indices.empty()) {
    // Only layers, as Blender writes them. One of them with R, G and B leaves no doubt.
    Names layers;
    for (const auto& name : in_file) {
      const std::string layer = layer_of(name);
      if (std::find(layers.begin(), layers.end(), layer) == layers.end() && !colour_of_layer(in_file, layer).empty())
        layers.push_back(layer);
    }
    if (layers.size() == 1) choice.file_indices = colour_of_layer(in_file, layers[0]);
  }
  if (choice.file_indices.empty())
    throw_input("'" + path + "' has no channels R, G, B or Y outside its layers; choose some with --channels among " +
                join(in_file, ", "));
  classify(in_file, choice);
  if (options.all_channels)
    for (size_t i = 0; i < in_file.size(); ++i)
      if (std::find(choice.file_indices.begin(), choice.file_indices.end(), static_cast<int>(i)) ==
          choice.file_indices.end()) {
        choice.file_indices.push_back(static_cast<int>(i));
        choice.names.push_back(in_file[i]);
      }
  return choice;
}

}  // namespace triad::image
