// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>
#include <triad/colour/internal/transform_impl.hpp>

namespace ocio = OCIO_NAMESPACE;

namespace triad {
namespace {

using colour::Matrix3;

constexpr double kD65X = .3127, kD65Y = .3290;

// What configurations call the two spaces that Triad cannot do without: ours, those of the ACES projects, of
// OpenColorIO's CG and studio configs, and of Blender.
const char* const kLinearNames[] = {"lin_rec709",
                                    "lin_rec709_srgb",
                                    "lin_srgb",
                                    "lin_rec709_scene",
                                    "Linear Rec.709 (sRGB)",
                                    "Linear Rec.709",
                                    "Linear BT.709",
                                    "Utility - Linear - Rec.709",
                                    "Utility - Linear - sRGB"};
const char* const kSrgbNames[] = {"srgb",
                                  "srgb_texture",
                                  "srgb_tx",
                                  "sRGB - Texture",
                                  "sRGB Encoded Rec.709 (sRGB)",
                                  "srgb_rec709_scene",
                                  "Utility - sRGB - Texture",
                                  "Input - Generic - sRGB - Texture",
                                  "sRGB - Display"};

// Primaries with their own white: BT.709-6, SMPTE EG 432-1, BT.2020-2, AMPAS S-2014-004 (AP1), ST 2065-1 (AP0).
constexpr std::array<double, 8> kPublished[] = {{.64, .33, .30, .60, .15, .06, .3127, .3290},
                                                {.68, .32, .265, .69, .15, .06, .3127, .3290},
                                                {.708, .292, .170, .797, .131, .046, .3127, .3290},
                                                {.713, .293, .165, .830, .128, .044, .32168, .33767},
                                                {.7347, .2653, 0, 1, .0001, -.0770, .32168, .33767}};

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
  return text;
}

std::array<double, 8> adapted(const std::array<double, 8>& xy, colour::Cones cones) {
  const Matrix3 to_d65 = colour::adaptation(xy[6], xy[7], kD65X, kD65Y, cones);
  return colour::chromaticities_of(colour::multiply(to_d65, colour::rgb_to_xyz(xy)));
}

bool near(const std::array<double, 8>& a, const std::array<double, 8>& b) {
  constexpr double kTolerance = 2e-4;  // half of the last digit of primaries as they are published
  for (int i = 0; i < 8; ++i)
    if (!(std::abs(a[i] - b[i]) <= kTolerance)) return false;
  return true;
}

bool near_adapted(const std::array<double, 8>& xy, const std::array<double, 8>& in_d65) {
  return near(adapted(xy, colour::Cones::kBradford), in_d65) || near(adapted(xy, colour::Cones::kCat02), in_d65);
}

}  // namespace

struct ColourConfig::Impl {
  ocio::ConstConfigRcPtr config;
  std::string origin, linear, srgb;
  std::mutex mutex;
  std::map<std::pair<std::string, std::string>, ColourTransform> transforms;

  std::string find(const std::string& name) const {
    if (name.empty()) return "";
    const auto space = config->getColorSpace(name.c_str());
    return space ? space->getName() : "";
  }

  template <size_t kCount>
  std::string find_first(const char* const (&candidates)[kCount]) const {
    for (const char* name : candidates)
      if (const std::string found = find(name); !found.empty()) return found;
    return "";
  }
};

ColourConfig ColourConfig::load(const std::string& path) {
  std::string origin = path;
  if (origin.empty())
    if (const char* named = std::getenv("OCIO"); named && *named) origin = named;
  if (origin.empty()) origin = data_folder() + "/colour/config.ocio";
  ColourConfig result;
  result.impl_ = std::make_shared<Impl>();
  Impl& impl = *result.impl_;
  impl.origin = origin;
  std::error_code ignored;
  if (std::filesystem::is_directory(origin, ignored))
    throw_input("cannot read the colour configuration '" + origin + "': it is a folder; name its config.ocio");
  ocio::SetLoggingLevel(ocio::LOGGING_LEVEL_NONE);  // what matters comes as an exception
  try {
    impl.config = ocio::Config::CreateFromFile(origin.c_str());
  } catch (const std::exception& error) {
    throw_input("cannot read the colour configuration '" + origin + "': " + one_line(error.what()));
  }
  impl.linear = impl.find_first(kLinearNames);
  impl.srgb = impl.find_first(kSrgbNames);
  if (impl.linear.empty())
    throw_input("the colour configuration '" + origin +
                "' has no linear Rec.709; give that space one of the aliases lin_rec709, lin_srgb or "
                "'Linear Rec.709 (sRGB)'");
  if (impl.srgb.empty())
    throw_input("the colour configuration '" + origin +
                "' has no sRGB; give that space one of the aliases srgb, srgb_texture or 'sRGB - Texture'");
  return result;
}

std::vector<std::string> ColourConfig::names() const {
  std::vector<std::string> result;
  const auto& config = *impl_->config;
  const int n = config.getNumColorSpaces(ocio::SEARCH_REFERENCE_SPACE_ALL, ocio::COLORSPACE_ACTIVE);
  for (int i = 0; i < n; ++i)
    result.emplace_back(
        config.getColorSpaceNameByIndex(ocio::SEARCH_REFERENCE_SPACE_ALL, ocio::COLORSPACE_ACTIVE, i));
  return result;
}

std::string ColourConfig::resolve(const std::string& name) const {
  if (const std::string found = impl_->find(name); !found.empty()) return found;
  // What readers say of files, and our own names for the two spaces, work with every configuration.
  const std::string small = lower(name);
  if (small == "linear" || small == "lin_rec709" || small == "lin_srgb") return impl_->linear;
  if (small == "srgb") return impl_->srgb;
  return "";
}

std::string ColourConfig::require(const std::string& name, const std::string& option) const {
  std::string found = resolve(name);
  if (!found.empty()) return found;
  std::vector<std::string> known = names();
  std::string message = option + ": no colour space '" + name + "'";
  const std::string suggestion = did_you_mean(name, known);
  constexpr size_t kMostListed = 20;
  if (known.size() > kMostListed) known.resize(kMostListed);
  throw_usage(message + suggestion + "; there are " + join(known, ", "));
}

bool ColourConfig::is_data(const std::string& name) const {
  const auto space = impl_->config->getColorSpace(resolve(name).c_str());
  return space && space->isData();
}

bool ColourConfig::is_linear(const std::string& name) const {
  const std::string space = resolve(name);
  if (space.empty() || is_data(space)) return false;
  return transform(space, impl_->linear).impl_->linear;
}

bool ColourConfig::has_display_codes(const std::string& name) const {
  return !resolve(name).empty() && !is_data(name) && !is_linear(name);
}

std::array<double, 9> ColourConfig::rgb_to_xyz(const std::string& linear_space) const {
  const ColourTransform to_709 = transform(linear_space, impl_->linear);
  Matrix3 m{1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (to_709.impl_->own) {
    if (to_709.impl_->own->has_matrix) m = to_709.impl_->own->matrix;
  } else {
    for (int c = 0; c < 3; ++c) {
      float rgb[3] = {};
      rgb[c] = 1;
      to_709.apply(rgb, 1, 3, -1);
      for (int i = 0; i < 3; ++i) m[i * 3 + c] = rgb[i];
    }
  }
  return colour::multiply(rec709_to_xyz(), m);
}

std::string ColourConfig::linear_sibling(const std::string& name) const {
  const std::string space = resolve(name);
  if (space.empty() || is_data(space)) return impl_->linear;
  if (is_linear(space)) return space;
  // The light of full red, green and blue. A linear space with the same primaries has it within a curve's
  // rounding; spaces whose decoding is not a curve per channel have none.
  const ColourTransform to_709 = transform(space, impl_->linear);
  Matrix3 light;
  for (int c = 0; c < 3; ++c) {
    float rgb[3] = {};
    rgb[c] = 1;
    to_709.apply(rgb, 1, 3, -1);
    for (int i = 0; i < 3; ++i) light[i * 3 + c] = rgb[i];
  }
  const Matrix3 wanted = colour::multiply(rec709_to_xyz(), light);
  for (const auto& candidate : names()) {
    if (!is_linear(candidate)) continue;
    const auto m = rgb_to_xyz(candidate);
    double difference = 0;
    for (int i = 0; i < 9; ++i) difference = std::max(difference, std::abs(m[i] - wanted[i]));
    if (difference < 2e-4) return candidate;
  }
  return impl_->linear;
}

std::array<float, 8> ColourConfig::chromaticities(const std::string& linear_space) const {
  std::array<double, 8> xy = colour::chromaticities_of(rgb_to_xyz(linear_space));
  for (const auto& published : kPublished)
    if (near_adapted(published, xy)) {
      xy = published;
      break;
    }
  std::array<float, 8> result;
  for (int i = 0; i < 8; ++i) result[i] = static_cast<float>(xy[i]);
  return result;
}

std::string ColourConfig::match_chromaticities(const std::array<float, 8>& stated) const {
  std::array<double, 8> xy;
  for (int i = 0; i < 8; ++i) xy[i] = stated[i];
  if (!(xy[1] > 0 || xy[3] > 0) || !(xy[7] > 0)) return "";
  for (const auto& name : names())
    if (is_linear(name) && near_adapted(xy, colour::chromaticities_of(rgb_to_xyz(name)))) return name;
  return "";
}

const std::string& ColourConfig::lin_rec709() const { return impl_->linear; }
const std::string& ColourConfig::srgb() const { return impl_->srgb; }
const std::string& ColourConfig::origin() const { return impl_->origin; }

ColourTransform ColourConfig::transform(const std::string& from, const std::string& to) const {
  const std::string source = require(from, "colour transform"), target = require(to, "colour transform");
  const std::lock_guard lock(impl_->mutex);
  const auto key = std::make_pair(source, target);
  if (const auto it = impl_->transforms.find(key); it != impl_->transforms.end()) return it->second;

  auto made = std::make_shared<ColourTransform::Impl>();
  made->from = source;
  made->to = target;
  made->identity = source == target || is_data(source) || is_data(target);
  made->linear = true;
  if (!made->identity) try {
      const auto processor = impl_->config->getProcessor(source.c_str(), target.c_str());
      made->own = colour::as_evaluator(processor);
      if (made->own) {
        made->identity = made->own->simplify();
        made->linear = made->own->linear();
      } else {
        made->processor = processor->getDefaultCPUProcessor();
        made->identity = processor->isNoOp();
        // f(k v) = k f(v) for a dark, a middle and a bright colour.
        float probe[9] = {.018f, .009f, .004f, .18f, .09f, .04f, 1.8f, .9f, .4f};
        colour::apply_processor(*made->processor, true, probe, 3, 3, -1);
        for (int i = 0; i < 6; ++i)
          made->linear &= std::abs(probe[i + 3] - 10 * probe[i]) < 1e-3f * std::abs(probe[i + 3]) + 1e-6f;
      }
    } catch (const ocio::Exception& error) {
      throw_input("the colour configuration '" + impl_->origin + "' cannot go from '" + source + "' to '" + target +
                  "': " + one_line(error.what()));
    }
  ColourTransform result;
  result.impl_ = std::move(made);
  impl_->transforms.emplace(key, result);
  return result;
}

}  // namespace triad
