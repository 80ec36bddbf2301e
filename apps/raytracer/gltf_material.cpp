// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>

#include "gltf.hpp"

namespace triad::raytracer::gltf {
namespace {

constexpr double kMostRadiance = 1e18;  // its square still fits a float

class MaterialReader {
 public:
  MaterialReader(File& file, Scene& scene) : file_(file), scene_(scene) {}

  Material read(size_t index) {
    const auto& from = file_.model.materials[index];
    user_ = describe("material", index, from.name);
    Material material;
    material.name = from.name;
    const auto& pbr = from.pbrMetallicRoughness;
    const std::vector<double> base = colour(pbr.baseColorFactor, 4, {1, 1, 1, 1}, 1, "baseColorFactor");
    material.base_color = to_float3(base);
    material.alpha = static_cast<float>(base[3]);
    material.metallic = within(pbr.metallicFactor, 0, 1, "metallicFactor");
    material.roughness = within(pbr.roughnessFactor, 0, 1, "roughnessFactor");
    material.double_sided = from.doubleSided;
    material.alpha_cutoff = within(from.alphaCutoff, 0, kMostRadiance, "alphaCutoff");
    if (from.alphaMode == "MASK") {
      material.alpha_mode = AlphaMode::kMask;
    } else if (from.alphaMode == "BLEND") {
      material.alpha_mode = AlphaMode::kBlend;
    } else if (from.alphaMode != "OPAQUE") {
      file_.fail(user_ + " has the alphaMode '" + from.alphaMode + "'; there are OPAQUE, MASK and BLEND");
    }
    material.base_color_texture = use(pbr.baseColorTexture, true, "baseColorTexture");
    material.metallic_roughness_texture = use(pbr.metallicRoughnessTexture, false, "metallicRoughnessTexture");
    material.emission_texture = use(from.emissiveTexture, true, "emissiveTexture");
    if (from.normalTexture.index >= 0) file_.warn(user_ + " has a normal map, which is not used");
    read_extensions(from, material);
    return material;
  }

  // Decodes what the materials asked for, several pictures at a time.
  void decode() {
    scene_.textures.resize(wanted_.size());
    std::vector<std::pair<int, bool>> list(wanted_.size());
    for (const auto& [key, index] : wanted_) list[static_cast<size_t>(index)] = key;
    parallel_for(static_cast<int64_t>(list.size()), [&](int64_t i) {
      const auto k = static_cast<size_t>(i);
      scene_.textures[k] = read_picture(file_, list[k].first, list[k].second);
    });
  }

 private:
  float within(double value, double low, double high, const std::string& key) {
    if (value >= low && value <= high) return static_cast<float>(value);
    const double used = value > high ? high : low;
    file_.warn(key + " of " + user_ + " is " + format_double(value) + "; " + format_double(used) + " is used");
    return static_cast<float>(used);
  }

  static Float3 to_float3(const std::vector<double>& v) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
  }

  std::vector<double> colour(std::vector<double> values, size_t count, const std::vector<double>& fallback,
                             double most, const std::string& key) {
    if (values.empty()) return fallback;
    if (values.size() != count)
      file_.fail(key + " of " + user_ + " has " + std::to_string(values.size()) + " numbers; it takes " +
                 std::to_string(count));
    for (double& value : values) value = within(value, 0, most, key);
    return values;
  }

  void read_extensions(const tinygltf::Material& from, Material& material) {
    const auto extension = [&from](const char* name) {
      const auto found = from.extensions.find(name);
      return found == from.extensions.end() ? tinygltf::Value() : found->second;
    };
    const double strength =
        within(number_of(file_, extension("KHR_materials_emissive_strength"), "emissiveStrength", 1, user_), 0,
               kMostRadiance, "emissiveStrength");
    std::vector<double> emission = colour(from.emissiveFactor, 3, {0, 0, 0}, kMostRadiance, "emissiveFactor");
    for (double& value : emission) value = within(value * strength, 0, kMostRadiance, "the emission");
    material.emission = to_float3(emission);
    const double ior = number_of(file_, extension("KHR_materials_ior"), "ior", 1.5, user_);
    material.ior = ior == 0 ? 0 : within(ior, 1, kMostRadiance, "ior");
    const tinygltf::Value transmission = extension("KHR_materials_transmission");
    material.transmission =
        within(number_of(file_, transmission, "transmissionFactor", 0, user_), 0, 1, "transmissionFactor");
    if (has(transmission, "transmissionTexture")) {
      const tinygltf::Value& info = transmission.Get("transmissionTexture");
      const tinygltf::Value& own = info.Get("extensions");
      material.transmission_texture =
          use(index_of(file_, info, "index", -1, user_), index_of(file_, info, "texCoord", 0, user_),
              has(own, "KHR_texture_transform") ? own.Get("KHR_texture_transform") : tinygltf::Value(), false,
              "transmissionTexture");
    }
    material.unlit = from.extensions.contains("KHR_materials_unlit");
  }

  TextureUse use(const tinygltf::TextureInfo& info, bool is_colour, const std::string& key) {
    const auto found = info.extensions.find("KHR_texture_transform");
    return use(info.index, info.texCoord, found == info.extensions.end() ? tinygltf::Value() : found->second,
               is_colour, key);
  }

  TextureUse use(int index, int texcoord, const tinygltf::Value& transform, bool is_colour, const std::string& key) {
    TextureUse result;
    if (index == -1) return result;
    const std::string whose = key + " of " + user_;
    const auto& texture = file_.at(file_.model.textures, index, "texture", whose);
    if (texture.source < 0) {
      file_.warn(whose + " has no picture that Triad knows; it is ignored");
      return result;
    }
    file_.at(file_.model.images, texture.source, "image", whose);
    result.texcoord = index_of(file_, transform, "texCoord", texcoord, whose);
    if (result.texcoord < 0 || result.texcoord > 1) {
      file_.warn(whose + " uses texture coordinates " + std::to_string(result.texcoord) +
                 "; Triad reads sets 0 and 1, so it is ignored");
      return {};
    }
    const std::vector<double> offset = numbers_of(file_, transform, "offset", 2, {0, 0}, whose);
    const std::vector<double> scale = numbers_of(file_, transform, "scale", 2, {1, 1}, whose);
    const double rotation_rad = number_of(file_, transform, "rotation", 0, whose);
    // Counter-clockwise as the picture is seen, v running down, so the signs differ from the textbook's.
    const double c = std::cos(rotation_rad), s = std::sin(rotation_rad);
    const double matrix[6] = {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
    for (size_t i = 0; i < 6; ++i) result.transform[i] = static_cast<float>(matrix[i]);
    if (texture.sampler >= 0) {
      const auto& sampler = file_.at(file_.model.samplers, texture.sampler, "sampler", whose);
      result.wrap_u = wrap(sampler.wrapS, whose);
      result.wrap_v = wrap(sampler.wrapT, whose);
      result.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    result.texture = wanted_.try_emplace({texture.source, is_colour}, static_cast<int>(wanted_.size())).first->second;
    return result;
  }

  Wrap wrap(int mode, const std::string& whose) const {
    switch (mode) {
      case TINYGLTF_TEXTURE_WRAP_REPEAT: return Wrap::kRepeat;
      case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE: return Wrap::kClamp;
      case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT: return Wrap::kMirror;
      default:
        file_.fail(whose + " has a sampler with the wrap mode " + std::to_string(mode) +
                   "; there are 10497, 33071 and 33648");
    }
  }

  File& file_;
  Scene& scene_;
  std::string user_;
  std::map<std::pair<int, bool>, int> wanted_;  // (image, is colour) to index into Scene::textures
};

}  // namespace

void read_materials(File& file, Scene& scene) {
  MaterialReader reader(file, scene);
  for (size_t i = 0; i < file.model.materials.size(); ++i) scene.materials.push_back(reader.read(i));
  reader.decode();
}

}  // namespace triad::raytracer::gltf
