// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>

#include "gltf.hpp"

namespace triad::raytracer::gltf {
namespace {

const std::vector<std::string>& known_extensions() {
  static const std::vector<std::string> list{
      "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_ior",    "KHR_materials_transmission",
      "KHR_materials_unlit", "KHR_mesh_quantization",           "KHR_texture_transform"};
  return list;
}

bool known(const std::string& extension) {
  const auto& list = known_extensions();
  return std::find(list.begin(), list.end(), extension) != list.end();
}

// A library's complaint as one line without a full stop, and without the megabytes of a data URI that it may quote.
std::string one_line(std::string text) {
  constexpr size_t kMostBytes = 300;
  if (text.size() > kMostBytes) text = text.substr(0, kMostBytes) + " ...";
  while (!text.empty() && (text.back() == '\n' || text.back() == '.' || text.back() == ' ')) text.pop_back();
  for (size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at)) text.replace(at, 1, "; ");
  return text;
}

// The parser's extras and extensions are read by recursion: deep nesting would overflow the stack.
bool nested_too_deeply(std::string_view json) {
  constexpr int kMost = 100;
  int depth = 0;
  bool in_string = false;
  for (size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
      continue;
    }
    if (c == '"') in_string = true;
    if ((c == '{' || c == '[') && ++depth > kMost) return true;
    if (c == '}' || c == ']') --depth;
  }
  return false;
}

uint32_t little32(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value |= static_cast<uint32_t>(static_cast<uint8_t>(bytes[at + i])) << 8 * i;
  return value;
}

// The JSON inside a file of either kind; checks the frame of a binary one.
std::string_view json_of(const File& file, const std::string& bytes, bool binary) {
  if (!binary) return bytes;
  constexpr size_t kHeader = 12, kChunkHeader = 8;  // bytes: glTF 2.0, section 4.4
  if (bytes.size() < kHeader + kChunkHeader) file.fail("it is cut short: a .glb has a header of 20 bytes");
  if (const uint32_t version = little32(bytes, 4); version != 2)
    file.fail("it is of glTF version " + std::to_string(version) + "; Triad reads version 2");
  if (const uint32_t length = little32(bytes, 8); length > bytes.size())
    file.fail("it is cut short: its header says " + std::to_string(length) + " bytes, it has " +
              std::to_string(bytes.size()));
  const size_t json_bytes = little32(bytes, kHeader);
  if (json_bytes > bytes.size() - kHeader - kChunkHeader) file.fail("it is cut short within its JSON");
  return std::string_view(bytes).substr(kHeader + kChunkHeader, json_bytes);
}

// Keeps the bytes of pictures inside data URIs; those in buffers are looked up later, with bounds checked.
bool keep_bytes(tinygltf::Image* image, const int, std::string*, std::string*, int, int, const unsigned char* bytes,
                int size, void*) {
  if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
  return true;
}

void check_extensions(File& file) {
  for (const std::string& extension : file.model.extensionsRequired)
    if (!known(extension))
      file.fail("it requires the extension '" + extension + "', which Triad does not know (it knows " +
                join(known_extensions(), ", ") + ")");
  for (const std::string& extension : file.model.extensionsUsed)
    if (!known(extension)) file.warn("the extension '" + extension + "' is not known and is ignored");
}

}  // namespace

void File::fail(const std::string& what) const { throw_input("cannot read '" + path + "': " + what); }

void File::fail_index(int index, size_t size, const char* what, const std::string& user) const {
  fail(user + " refers to " + what + " " + std::to_string(index) + ", but there " +
       (size == 0 ? "is none"
                  : (size == 1 ? "is only number 0" : "are only numbers 0 to " + std::to_string(size - 1))));
}

void File::warn(const std::string& what) {
  std::string line = "'" + path + "': " + what;
  if (std::find(warnings.begin(), warnings.end(), line) == warnings.end()) warnings.push_back(std::move(line));
}

std::string File::resolve(const std::string& uri) const {
  return (std::filesystem::path(path).parent_path() / uri).string();
}

std::string describe(const char* what, size_t index, const std::string& name) {
  return std::string(what) + " " + std::to_string(index) + (name.empty() ? "" : " '" + name + "'");
}

bool has(const tinygltf::Value& object, const char* key) { return object.IsObject() && object.Has(key); }

double number_of(const File& file, const tinygltf::Value& object, const char* key, double fallback,
                 const std::string& user) {
  if (!has(object, key)) return fallback;
  const tinygltf::Value& value = object.Get(key);
  const double number = value.IsNumber() ? value.GetNumberAsDouble() : std::numeric_limits<double>::quiet_NaN();
  if (!std::isfinite(number)) file.fail("'" + std::string(key) + "' of " + user + " is not a finite number");
  return number;
}

int index_of(const File& file, const tinygltf::Value& object, const char* key, int fallback,
             const std::string& user) {
  const double number = number_of(file, object, key, fallback, user);
  const int index = number > -1e9 && number < 1e9 ? static_cast<int>(number) : 0;
  if (index != number) file.fail("'" + std::string(key) + "' of " + user + " is not a number of a thing in the file");
  return index;
}

std::vector<double> numbers_of(const File& file, const tinygltf::Value& object, const char* key, size_t count,
                               std::vector<double> fallback, const std::string& user) {
  if (!has(object, key)) return fallback;
  const tinygltf::Value& value = object.Get(key);
  std::vector<double> numbers;
  for (size_t i = 0; value.IsArray() && i < value.ArrayLen(); ++i) {
    const tinygltf::Value& element = value.Get(static_cast<int>(i));
    if (element.IsNumber() && std::isfinite(element.GetNumberAsDouble()))
      numbers.push_back(element.GetNumberAsDouble());
  }
  if (numbers.size() != count || value.ArrayLen() != count)
    file.fail("'" + std::string(key) + "' of " + user + " is not a list of " + std::to_string(count) +
              " finite numbers");
  return numbers;
}

File parse_file(const std::string& path) {
  File file;
  file.path = path;
  const std::string bytes = read_text_file(path);
  if (bytes.empty()) file.fail("it is empty");
  if (bytes.size() > std::numeric_limits<uint32_t>::max() - 1)
    file.fail(
        "it has more than 4 GB, the most that one file of glTF can hold; keep its buffers in files of their own");
  const bool binary = bytes.compare(0, 4, "glTF") == 0;
  const std::string_view json = json_of(file, bytes, binary);
  if (nested_too_deeply(json)) file.fail("its JSON is nested more than 100 deep");

  tinygltf::TinyGLTF parser;
  parser.SetImageLoader(keep_bytes, nullptr);
  const std::string folder = std::filesystem::path(path).parent_path().string();
  std::string error, warning;
  bool ok = false;
  try {
    const auto size = static_cast<unsigned int>(bytes.size());
    ok = binary ? parser.LoadBinaryFromMemory(&file.model, &error, &warning,
                                              reinterpret_cast<const unsigned char*>(bytes.data()), size, folder)
                : parser.LoadASCIIFromString(&file.model, &error, &warning, bytes.data(), size, folder);
  } catch (const std::exception& thrown) {  // the parser lets some of the standard library's through
    error = thrown.what();
  }
  // Extensions first: what is unknown but required may be why the rest does not fit.
  if (ok) check_extensions(file);
  if (!ok || !error.empty())
    file.fail("it is not valid glTF: " + (error.empty() ? "no reason given" : one_line(error)));
  if (!warning.empty()) file.warn(one_line(warning));
  if (file.model.asset.version.rfind("2.", 0) != 0)
    file.fail("it is of glTF version '" + file.model.asset.version + "'; Triad reads version 2");
  return file;
}

}  // namespace triad::raytracer::gltf
