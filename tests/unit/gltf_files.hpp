// SPDX-License-Identifier: Apache-2.0
// Small glTF files, put together by hand: JSON that a test may bend, and one buffer.
#pragma once

#include <cstdint>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace gltf_files {

using nlohmann::json;

inline std::string base64(const std::string& bytes) {
  static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    const size_t count = std::min<size_t>(3, bytes.size() - i);
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < count ? static_cast<uint8_t>(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

template <typename T>
std::string bytes_of_list(const std::vector<T>& list) {
  std::string bytes(list.size() * sizeof(T), '\0');
  if (!list.empty()) std::memcpy(bytes.data(), list.data(), bytes.size());
  return bytes;
}

template <typename T>
constexpr int component_type() {
  if constexpr (std::is_same_v<T, int8_t>) return 5120;
  if constexpr (std::is_same_v<T, uint8_t>) return 5121;
  if constexpr (std::is_same_v<T, int16_t>) return 5122;
  if constexpr (std::is_same_v<T, uint16_t>) return 5123;
  if constexpr (std::is_same_v<T, uint32_t>) return 5125;
  return 5126;
}

struct Gltf {
  json root = {{"asset", {{"version", "2.0"}}}};
  std::string buffer;

  // Appends bytes, aligned to 4, as a buffer view; returns its index.
  int view(const std::string& bytes, int stride = 0) {
    buffer.resize((buffer.size() + 3) / 4 * 4);
    json view = {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}};
    if (stride > 0) view["byteStride"] = stride;
    buffer += bytes;
    return push("bufferViews", view);
  }
  template <typename T>
  int accessor(const std::vector<T>& list, int components, bool normalised = false) {
    json accessor = {{"bufferView", view(bytes_of_list(list))},
                     {"componentType", component_type<T>()},
                     {"count", list.size() / static_cast<size_t>(components)},
                     {"type", components == 1 ? "SCALAR" : "VEC" + std::to_string(components)}};
    if (normalised) accessor["normalized"] = true;
    return push("accessors", accessor);
  }
  int push(const char* key, const json& value) {
    root[key].push_back(value);
    return static_cast<int>(root[key].size()) - 1;
  }
  // A node of scene 0.
  int node(const json& value) {
    const int index = push("nodes", value);
    root["scenes"][0]["nodes"].push_back(index);
    return index;
  }
  std::string text() const {
    json whole = root;
    if (!buffer.empty() && !whole.contains("buffers"))
      whole["buffers"] = json::array(
          {{{"byteLength", buffer.size()}, {"uri", "data:application/octet-stream;base64," + base64(buffer)}}});
    return whole.dump();
  }
  // The binary form.
  std::string glb() const {
    json whole = root;
    whole["buffers"] = json::array({{{"byteLength", buffer.size()}}});
    std::string json_chunk = whole.dump(), binary = buffer;
    json_chunk.resize((json_chunk.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4);
    const auto word = [](size_t v) { return bytes_of_list(std::vector<uint32_t>{static_cast<uint32_t>(v)}); };
    return "glTF" + word(2) + word(28 + json_chunk.size() + binary.size()) + word(json_chunk.size()) + "JSON" +
           json_chunk + word(binary.size()) + std::string("BIN\0", 4) + binary;
  }
  std::string save(const std::string& path) const {
    std::ofstream(path, std::ios::binary) << (path.ends_with(".glb") ? glb() : text());
    return path;
  }
};

// The triangle (0,0,0) (1,0,0) (0,1,0), unlit, as mesh 0, material 0 and node 0, seen by a camera, node 1.
inline Gltf triangle() {
  Gltf gltf;
  const int positions = gltf.accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, 3);
  gltf.root["extensionsUsed"] = {"KHR_materials_unlit"};
  gltf.push("materials", {{"name", "paper"}, {"extensions", {{"KHR_materials_unlit", json::object()}}}});
  gltf.push("meshes",
            {{"name", "leaf"}, {"primitives", {{{"attributes", {{"POSITION", positions}}}, {"material", 0}}}}});
  gltf.node({{"mesh", 0}, {"name", "leaf"}});
  gltf.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", .5}, {"znear", .1}}}});
  gltf.node({{"camera", 0}, {"name", "eye"}, {"translation", {0, 0, 5}}});
  return gltf;
}

}  // namespace gltf_files
