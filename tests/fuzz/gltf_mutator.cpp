// SPDX-License-Identifier: Apache-2.0
// Changes glTF files as libFuzzer asks, so that most of them still parse: a change to bytes alone rarely gets past
// the JSON. Every third change is to bytes all the same.
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace {

using nlohmann::json;
using Random = std::minstd_rand;

// What glTF files say, each with a value that has the right shape.
const std::pair<const char*, const char*> kPhrases[] = {
    {"bufferView", "0"},
    {"byteOffset", "4"},
    {"byteStride", "12"},
    {"byteLength", "36"},
    {"count", "3"},
    {"normalized", "true"},
    {"componentType", "5121"},
    {"componentType", "5122"},
    {"componentType", "5126"},
    {"type", "\"VEC2\""},
    {"type", "\"VEC4\""},
    {"type", "\"MAT4\""},
    {"sparse", R"({"count":1,"indices":{"bufferView":0,"componentType":5121},"values":{"bufferView":0}})"},
    {"indices", "1"},
    {"mode", "5"},
    {"mode", "6"},
    {"mode", "1"},
    {"NORMAL", "0"},
    {"TANGENT", "0"},
    {"COLOR_0", "0"},
    {"TEXCOORD_0", "0"},
    {"TEXCOORD_1", "0"},
    {"targets", R"([{"POSITION":0}])"},
    {"children", "[1]"},
    {"matrix", "[1,0,0,0,0,1,0,0,0,0,1,0,2,0,0,1]"},
    {"translation", "[1e7,0,0]"},
    {"rotation", "[0,0,0.7071,0.7071]"},
    {"scale", "[1,-1,1e-20]"},
    {"mesh", "0"},
    {"camera", "0"},
    {"skin", "0"},
    {"material", "0"},
    {"scene", "0"},
    {"source", "0"},
    {"sampler", "0"},
    {"wrapS", "33648"},
    {"wrapT", "33071"},
    {"magFilter", "9728"},
    {"alphaMode", "\"BLEND\""},
    {"alphaMode", "\"MASK\""},
    {"alphaCutoff", "0.5"},
    {"doubleSided", "true"},
    {"emissiveFactor", "[1,1,1]"},
    {"emissiveTexture", R"({"index":0})"},
    {"normalTexture", R"({"index":0,"scale":2})"},
    {"pbrMetallicRoughness",
     R"({"baseColorFactor":[1,1,1,0.5],"metallicFactor":0.5,"roughnessFactor":0,"baseColorTexture":{"index":0}})"},
    {"metallicRoughnessTexture", R"({"index":0,"texCoord":1})"},
    {"extensions", R"({"KHR_materials_transmission":{"transmissionFactor":1,"transmissionTexture":{"index":0}}})"},
    {"extensions", R"({"KHR_materials_ior":{"ior":0},"KHR_materials_emissive_strength":{"emissiveStrength":1e9}})"},
    {"extensions", R"({"KHR_texture_transform":{"offset":[1,2],"rotation":3,"scale":[4,5],"texCoord":1}})"},
    {"extensions", R"({"KHR_materials_unlit":{}})"},
    {"extensions", R"({"KHR_lights_punctual":{"light":0}})"},
    {"extensions",
     R"({"KHR_lights_punctual":{"lights":[{"type":"spot","intensity":9,"spot":{"outerConeAngle":1}},{"type":"point"},{"type":"directional"}]}})"},
    {"extensionsRequired", R"(["KHR_mesh_quantization"])"},
    {"uri", "\"buffer.bin\""},
    {"uri", "\"picture.png\""},
    {"uri", "\"picture.exr\""},
    {"uri", "\"grey.png\""},
    {"uri", "\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAA\""},
    {"uri", "\"../../\""},
    {"mimeType", "\"image/png\""},
    {"orthographic", R"({"xmag":1,"ymag":2,"znear":0.1,"zfar":10})"},
    {"perspective", R"({"yfov":1,"znear":0.1})"},
    {"extras", R"({"aperture_radius_m":0.1,"focus_distance_m":2,"shutter_s":[0,1]})"},
    {"extras", R"({"background":[1,1,1]})"},
    {"extras", R"({"environment":"picture.exr","environment_strength":2})"},
    {"animations",
     R"([{"samplers":[{"input":0,"output":0}],"channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}]}])"},
    {"interpolation", "\"CUBICSPLINE\""},
    {"interpolation", "\"STEP\""},
    {"path", "\"rotation\""},
    {"path", "\"weights\""},
};

const char* const kValues[] = {"-1",
                               "0",
                               "1",
                               "2",
                               "3",
                               "4",
                               "127",
                               "255",
                               "256",
                               "65535",
                               "36",
                               "12",
                               "1e-9",
                               "-0.0",
                               "0.5",
                               "1e30",
                               "-1e308",
                               "2147483647",
                               "2147483648",
                               "4294967295",
                               "{}",
                               "[]",
                               "null",
                               "true",
                               "false",
                               "\"\"",
                               "\"x\"",
                               "-2147483648",
                               "9223372036854775807",
                               "5123",
                               "5125",
                               "1048576",
                               "1e-300",
                               "18446744073709551615"};

struct Scene {
  json root;
  std::string binary;
  bool is_binary = false;
};

uint32_t little32(const uint8_t* at) {
  uint32_t value = 0;
  std::memcpy(&value, at, sizeof value);
  return value;
}

// Nesting that nlohmann's writer, which is recursive, should not be asked for.
bool is_deep(const std::string& text) {
  int depth = 0;
  for (const char c : text) {
    depth += c == '{' || c == '[' ? 1 : c == '}' || c == ']' ? -1 : 0;
    if (depth > 200) return true;
  }
  return false;
}

std::optional<Scene> parse(const uint8_t* data, size_t size) {
  Scene scene;
  std::string text(reinterpret_cast<const char*>(data), size);
  if (scene.is_binary = size >= 20 && std::memcmp(data, "glTF", 4) == 0; scene.is_binary) {
    const size_t length = std::min<size_t>(little32(data + 12), size - 20);
    if (20 + length + 8 <= size) scene.binary = text.substr(20 + length + 8);
    text = text.substr(20, length);
  }
  if (is_deep(text)) return std::nullopt;
  scene.root = json::parse(text, nullptr, false);
  if (!scene.root.is_object()) return std::nullopt;
  return scene;
}

std::string text_of(const Scene& scene) {
  std::string text = scene.root.dump(-1, ' ', false, json::error_handler_t::replace);
  if (!scene.is_binary) return text;
  std::string binary = scene.binary;
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4);
  const auto word = [](size_t value) {
    const auto number = static_cast<uint32_t>(value);
    std::string bytes(4, '\0');
    std::memcpy(bytes.data(), &number, 4);
    return bytes;
  };
  return "glTF" + word(2) + word(28 + text.size() + binary.size()) + word(text.size()) + "JSON" + text +
         word(binary.size()) + std::string("BIN\0", 4) + binary;
}

// Every value in the document, parents before children.
std::vector<json*> values_of(json& root) {
  std::vector<json*> list{&root};
  for (size_t i = 0; i < list.size(); ++i)
    if (list[i]->is_structured())
      for (json& child : *list[i]) list.push_back(&child);
  return list;
}

template <typename List>
auto& pick(List& list, Random& random) {
  return list[random() % std::size(list)];
}

void change_number(json& value, Random& random) {
  const double number = value.get<double>();
  switch (random() % 4) {
    case 0: value = json::parse(pick(kValues, random)); break;
    case 1: value = value.is_number_integer() ? json(value.get<int64_t>() / 2 + 1) : json(number / 2); break;
    case 2: value = -number; break;
    default: {  // most integers are references to a neighbour
      const int64_t step = random() % 2 == 0 ? 1 : -1;
      value = value.is_number_integer() ? json(value.get<int64_t>() % (int64_t{1} << 40) + step) : json(number * 3);
    }
  }
}

void change(Scene& scene, Random& random) {
  const std::vector<json*> all = values_of(scene.root);
  json& value = *pick(all, random);
  switch (random() % 7) {
    case 0:
      if (value.is_number()) {
        change_number(value, random);
      } else if (&value != &scene.root) {
        value = json::parse(pick(kValues, random));
      }
      break;
    case 1:  // numbers are where the danger is
      for (int i = 0; i < 16; ++i)
        if (json& other = *pick(all, random); other.is_number()) return change_number(other, random);
      break;
    case 2:
      if (value.is_structured() && !value.empty())
        value.erase(std::next(value.begin(), static_cast<std::ptrdiff_t>(random() % value.size())));
      break;
    case 3:
      if (value.is_array() && !value.empty() && value.size() < 1000)
        value.push_back(json(value[random() % value.size()]));
      break;
    case 4: {
      const json copy = *pick(all, random);
      if (&value != &scene.root) value = copy;
      break;
    }
    case 5: {
      const auto& [key, phrase] = pick(kPhrases, random);
      if (value.is_object()) value[key] = json::parse(phrase);
      break;
    }
    default:
      if (scene.binary.empty() || random() % 16 == 0) {
        scene.is_binary = !scene.is_binary;
      } else {
        scene.binary.resize(scene.binary.size() + 4);  // room to grow
        scene.binary.resize(LLVMFuzzerMutate(reinterpret_cast<uint8_t*>(scene.binary.data()), scene.binary.size() - 4,
                                             scene.binary.size()));
      }
  }
}

}  // namespace

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned int seed) {
  Random random(seed);
  random.discard(8);
  auto scene = random() % 3 == 0 ? std::nullopt : parse(data, size);
  if (!scene) return LLVMFuzzerMutate(data, size, max_size);
  for (size_t i = 1 + random() % 3; i > 0; --i) change(*scene, random);
  const std::string text = text_of(*scene);
  if (text.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::memcpy(data, text.data(), text.size());
  return text.size();
}
