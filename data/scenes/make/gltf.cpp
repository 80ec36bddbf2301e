// SPDX-License-Identifier: Apache-2.0
// The file format: JSON with one buffer inside, and PNG pictures without compression.
#include <algorithm>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "shapes.hpp"

namespace make_scenes {
namespace {

std::string base64(const std::string& bytes) {
  static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    const size_t count = std::min<size_t>(3, bytes.size() - i);
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < count ? static_cast<uint8_t>(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; ++k) out += k <= count ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::string big32(uint32_t v) {
  return {static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8), static_cast<char>(v)};
}

// PNG specification, section 5.3 and annex D.
std::string chunk(const std::string& type, const std::string& data) {
  uint32_t crc = 0xffffffff;
  for (const char c : type + data) {
    crc ^= static_cast<uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? 0xedb88320 ^ crc >> 1 : crc >> 1;
  }
  return big32(static_cast<uint32_t>(data.size())) + type + data + big32(~crc);
}

std::string png(int width, int height, int channels, const std::string& pixels) {
  const size_t row = static_cast<size_t>(width) * static_cast<size_t>(channels);
  std::string raw;
  for (size_t y = 0; y < static_cast<size_t>(height); ++y) raw += std::string(1, '\0') + pixels.substr(y * row, row);
  uint32_t a = 1, b = 0;  // Adler-32, RFC 1950
  for (const char c : raw) {
    a = (a + static_cast<uint8_t>(c)) % 65521;
    b = (b + a) % 65521;
  }
  std::string zlib = "\x78\x01";
  for (size_t at = 0; at < raw.size();) {  // stored blocks, RFC 1951
    const auto size = static_cast<uint16_t>(std::min<size_t>(65535, raw.size() - at));
    const auto inverse = static_cast<uint16_t>(~size);
    zlib += at + size == raw.size() ? '\1' : '\0';
    zlib += {static_cast<char>(size), static_cast<char>(size >> 8), static_cast<char>(inverse),
             static_cast<char>(inverse >> 8)};
    zlib += raw.substr(at, size);
    at += size;
  }
  zlib += big32(b << 16 | a);
  const char colour_type = channels == 4 ? 6 : 2;
  const std::string header = big32(static_cast<uint32_t>(width)) + big32(static_cast<uint32_t>(height)) +
                             std::string{8, colour_type, 0, 0, 0};
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("IDAT", zlib) + chunk("IEND", "");
}

json list(Vec v) { return {v.x, v.y, v.z}; }

}  // namespace

Gltf::Gltf(const std::string& about) {
  root_ = {{"asset", {{"version", "2.0"}, {"generator", "data/scenes/make of Triad"}, {"copyright", "Apache-2.0"}}},
           {"scene", 0},
           {"scenes", {{{"nodes", json::array()}, {"extras", {{"about", about}}}}}}};
}

int Gltf::push(const char* key, json value) {
  root_[key].push_back(std::move(value));
  return static_cast<int>(root_[key].size()) - 1;
}

void Gltf::require(const std::string& extension) {
  auto& used = root_["extensionsUsed"];
  if (std::find(used.begin(), used.end(), json(extension)) == used.end()) used.push_back(extension);
}

int Gltf::view(const std::string& bytes) {
  const auto [found, fresh] = views_.try_emplace(bytes, static_cast<int>(views_.size()));
  if (!fresh) return found->second;  // the same ball twice is kept once
  buffer_.resize((buffer_.size() + 3) / 4 * 4);
  const json value = {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes.size()}};
  buffer_ += bytes;
  return push("bufferViews", value);
}

int Gltf::floats(const std::vector<double>& values, int components, bool bounds) {
  std::string bytes(values.size() * sizeof(float), '\0');
  std::vector<float> low(static_cast<size_t>(components), 1e30f), high(static_cast<size_t>(components), -1e30f);
  for (size_t i = 0; i < values.size(); ++i) {
    const auto value = static_cast<float>(values[i]);
    std::memcpy(bytes.data() + i * sizeof value, &value, sizeof value);
    const size_t c = i % static_cast<size_t>(components);
    low[c] = std::min(low[c], value);
    high[c] = std::max(high[c], value);
  }
  json accessor = {{"bufferView", view(bytes)},
                   {"componentType", 5126},
                   {"count", values.size() / static_cast<size_t>(components)},
                   {"type", components == 1 ? "SCALAR" : "VEC" + std::to_string(components)}};
  if (bounds) {
    accessor["min"] = low;
    accessor["max"] = high;
  }
  return push("accessors", accessor);
}

int Gltf::material(const std::string& name, json value) {
  value["name"] = name;
  if (value.contains("extensions"))
    for (const auto& [extension, unused] : value["extensions"].items()) require(extension);
  return push("materials", value);
}

int Gltf::unlit(const std::string& name, Vec colour) {
  return material(name, {{"pbrMetallicRoughness", {{"baseColorFactor", {colour.x, colour.y, colour.z, 1}}}},
                         {"extensions", {{"KHR_materials_unlit", json::object()}}}});
}

int Gltf::diffuse(const std::string& name, Vec colour) {
  return material(
      name,
      {{"pbrMetallicRoughness",
        {{"baseColorFactor", {colour.x, colour.y, colour.z, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}},
       {"extensions", {{"KHR_materials_ior", {{"ior", 1}}}}}});
}

int Gltf::metal(const std::string& name, Vec colour, double roughness) {
  return material(name, {{"pbrMetallicRoughness",
                          {{"baseColorFactor", {colour.x, colour.y, colour.z, 1}},
                           {"metallicFactor", 1},
                           {"roughnessFactor", roughness}}}});
}

int Gltf::lamp(const std::string& name, Vec radiance) {
  const double most = std::max({radiance.x, radiance.y, radiance.z});
  return material(
      name,
      {{"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}},
       {"emissiveFactor", list(1 / most * radiance)},
       {"extensions",
        {{"KHR_materials_emissive_strength", {{"emissiveStrength", most}}}, {"KHR_materials_ior", {{"ior", 1}}}}}});
}

int Gltf::mesh(const std::string& name, const Shape& shape, int material) {
  std::vector<double> positions, normals, uvs;
  bool flat = true;  // facing +z all over: needs no normals
  for (size_t i = 0; i < shape.positions.size(); ++i) {
    const Vec &p = shape.positions[i], &n = shape.normals[i];
    positions.insert(positions.end(), {p.x, p.y, p.z});
    normals.insert(normals.end(), {n.x, n.y, n.z});
    uvs.insert(uvs.end(), {shape.uvs[i][0], shape.uvs[i][1]});
    flat = flat && n.z == 1;
  }
  json attributes = {{"POSITION", floats(positions, 3, true)}};
  if (!flat) attributes["NORMAL"] = floats(normals, 3, false);
  if (shape.has_uv) attributes["TEXCOORD_0"] = floats(uvs, 2, false);
  const bool small = shape.positions.size() < 65536;
  std::string bytes;
  for (const uint32_t i : shape.indices)
    for (int k = 0; k < (small ? 2 : 4); ++k) bytes += static_cast<char>(i >> 8 * k);
  const int indices = push("accessors", {{"bufferView", view(bytes)},
                                         {"componentType", small ? 5123 : 5125},
                                         {"count", shape.indices.size()},
                                         {"type", "SCALAR"}});
  const json primitive = {{"attributes", attributes}, {"indices", indices}, {"material", material}};
  return push("meshes", {{"name", name}, {"primitives", json::array({primitive})}});
}

int Gltf::node(const std::string& name, int mesh, json more) {
  more["name"] = name;
  if (mesh >= 0) more["mesh"] = mesh;
  const int index = push("nodes", more);
  root_["scenes"][0]["nodes"].push_back(index);
  return index;
}

int Gltf::place(const std::string& name, const Shape& shape, int material, json more) {
  return node(name, mesh(name, shape, material), std::move(more));
}

int Gltf::texture(int width, int height, const std::string& pixels, bool nearest, int wrap) {
  const int channels = static_cast<int>(pixels.size()) / (width * height);
  const int image =
      push("images", {{"bufferView", view(png(width, height, channels, pixels))}, {"mimeType", "image/png"}});
  const int filter = nearest ? 9728 : 9729;
  const int sampler =
      push("samplers", {{"magFilter", filter}, {"minFilter", filter}, {"wrapS", wrap}, {"wrapT", wrap}});
  return push("textures", {{"source", image}, {"sampler", sampler}});
}

void Gltf::perspective(Vec eye, Vec target, double yfov_rad, json extras) {
  json camera = {{"type", "perspective"}, {"perspective", {{"yfov", yfov_rad}, {"znear", .01}}}};
  if (!extras.empty()) camera["extras"] = std::move(extras);
  const Vec back = unit(eye - target), right = unit(cross({0, 1, 0}, back)), up = cross(back, right);
  node("camera", -1,
       {{"camera", push("cameras", camera)},
        {"matrix",
         {right.x, right.y, right.z, 0, up.x, up.y, up.z, 0, back.x, back.y, back.z, 0, eye.x, eye.y, eye.z, 1}}});
}

void Gltf::orthographic(double half_height, double half_width) {
  const json camera = {
      {"type", "orthographic"},
      {"orthographic", {{"xmag", half_width}, {"ymag", half_height}, {"znear", .01}, {"zfar", 1000}}}};
  node("camera", -1, {{"camera", push("cameras", camera)}, {"translation", {0, 0, 100}}});
}

void Gltf::background(Vec radiance) { root_["scenes"][0]["extras"]["background"] = list(radiance); }

void Gltf::light(const std::string& name, json light, json more) {
  require("KHR_lights_punctual");
  auto& lights = root_["extensions"]["KHR_lights_punctual"]["lights"];
  light["name"] = name;
  lights.push_back(std::move(light));
  more["extensions"]["KHR_lights_punctual"]["light"] = lights.size() - 1;
  node(name, -1, std::move(more));
}

void Gltf::animate(int node, const std::string& path, const std::vector<double>& times_s,
                   const std::vector<double>& values, int components) {
  if (!root_.contains("animations")) push("animations", {{"channels", json::array()}, {"samplers", json::array()}});
  json& animation = root_["animations"][0];
  const int input = floats(times_s, 1, true), output = floats(values, components, false);
  json& samplers = root_["animations"][0]["samplers"];
  samplers.push_back({{"input", input}, {"output", output}});
  animation["channels"].push_back({{"sampler", samplers.size() - 1}, {"target", {{"node", node}, {"path", path}}}});
}

void Gltf::save(const std::string& path) const {
  json root = root_;
  root["buffers"] = json::array(
      {{{"byteLength", buffer_.size()}, {"uri", "data:application/octet-stream;base64," + base64(buffer_)}}});
  std::ofstream file(path, std::ios::binary);
  file << root.dump(1, ' ') << "\n";
  file.close();
  if (!file) throw std::runtime_error("cannot write '" + path + "'");
}

}  // namespace make_scenes
