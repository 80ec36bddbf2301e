// SPDX-License-Identifier: Apache-2.0
#include "study_references.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/json_text.hpp>
#include <triad/base/random.hpp>
#include <triad/pipeline/picture_source.hpp>

namespace fs = std::filesystem;

namespace triad::app {
namespace {

using Json = nlohmann::ordered_json;

// A name for people, and a hash, as different keys may look alike in it.
std::string file_name(const std::string& key) {
  uint64_t hash = 0;
  for (const char c : key) hash = mix_bits(hash ^ static_cast<unsigned char>(c)) + kGoldenIncrement;
  constexpr size_t kShown = 40;
  std::string name = key.substr(0, kShown);
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '-';
  return fmt::format("{}-{:016x}", name, hash);
}

}  // namespace

Image colour_only(const Image& image) {
  Image colour{image.spec, {}};
  colour.spec.channels.resize(3);
  colour.spec.alpha = -1;
  const size_t pixels = static_cast<size_t>(image.spec.width) * static_cast<size_t>(image.spec.height);
  const size_t channels = image.spec.channels.size();
  colour.pixels.resize(pixels * 3);
  for (size_t p = 0; p < pixels; ++p)
    for (size_t c = 0; c < 3; ++c) colour.pixels[p * 3 + c] = image.pixels[p * channels + c];
  return colour;
}

bool StudyReferences::is_file(const std::string& text) {
  const std::string name = text.substr(0, text.find(':'));
  return name.find('.') != std::string::npos || text.find('/') != std::string::npos;
}

const StudyReference& StudyReferences::get(const SourceRequest& wanted, const Source& source, const std::string& text,
                                           uint64_t seed, const std::string& where) {
  const std::string key = source_key(wanted) + " by " + text +
                          (seed == kTruthSeed || is_file(text) ? "" : " seed " + std::to_string(seed));
  const auto known = known_.find(key);
  if (known != known_.end()) return known->second;
  const bool is_seeded = seed != kTruthSeed && !is_file(text);
  if (is_seeded) drop_oldest(wanted);
  const fs::path base = fs::path(folder_) / file_name(key);
  const std::string picture = base.string() + ".exr", facts = base.string() + ".json";
  std::error_code error;
  StudyReference reference;
  // The facts are written last: where they are, the picture is whole.
  const Json kept =
      !folder_.empty() && fs::exists(facts, error) ? Json::parse(read_text_file(facts), nullptr, false) : Json();
  // Damaged, they count as not there.
  if (kept.is_object() && kept.value("reference", Json()) == escape_non_utf8(key) &&
      kept.value("rmse", Json()).is_number() && fs::exists(picture, error)) {
    reference = load(picture, wanted, where);
    reference.rmse = kept["rmse"].get<double>();
  } else if (is_file(text)) {
    reference = load(text, wanted, where);
  } else {
    reference = draw(wanted, source, text, seed, where);
    if (!folder_.empty()) {
      write_float_picture(picture, *reference.picture.image);
      write_text_file(facts, json_text(Json{{"reference", key}, {"rmse", reference.rmse}}, 1));
    }
  }
  reference.picture.name = key;
  if (is_seeded) seeded_.push_back(key);
  return known_[key] = reference;
}

// A study goes from seed to seed and does not come back, as scores are kept: those of earlier seeds are the oldest.
void StudyReferences::drop_oldest(const SourceRequest& wanted) {
  constexpr double kMostBytes = 512e6;  // 27 pictures of 1920x1080 with three floats, 9 of 3x1 cells
  const auto bytes_of = [](const PictureSize& film) { return 12. * film.width * film.height; };
  double bytes = bytes_of(film_size(wanted.picture, wanted.cells));
  for (const std::string& key : seeded_) {
    const ImageSpec& spec = known_.at(key).picture.image->spec;
    bytes += bytes_of({spec.width, spec.height});
  }
  while (bytes > kMostBytes && !seeded_.empty()) {
    const ImageSpec& spec = known_.at(seeded_.front()).picture.image->spec;
    bytes -= bytes_of({spec.width, spec.height});
    known_.erase(seeded_.front());
    seeded_.pop_front();
  }
}

void StudyReferences::check_file(const std::string& path, const SourceRequest& wanted,
                                 const std::string& where) const {
  const ImageSpec spec = open_file_source(path, {}, colours_)->spec();
  const PictureSize film = film_size(wanted.picture, wanted.cells);
  if (spec.width != film.width || spec.height != film.height)
    throw_input(fmt::format("{}: the reference '{}' has {}x{} pixels, and {}x{} are needed for {}x{} cells a pixel",
                            where, path, spec.width, spec.height, film.width, film.height, wanted.cells.x,
                            wanted.cells.y));
  if (spec.colour_channels != 3)
    throw_input(fmt::format("{}: the reference '{}' has no three channels of colour", where, path));
}

StudyReference StudyReferences::load(const std::string& path, const SourceRequest& wanted,
                                     const std::string& where) const {
  check_file(path, wanted, where);
  const auto file = open_file_source(path, {}, colours_);
  Image image{file->spec(), {}};
  image.pixels.resize(image.row_floats() * static_cast<size_t>(image.spec.height));
  file->read_rows({0, image.spec.height}, image.pixels.data(), image.row_floats());
  image = colour_only(image);
  image.spec.cells = wanted.cells;
  return {{path, std::make_shared<const Image>(std::move(image))}, 0};
}

StudyReference StudyReferences::draw(const SourceRequest& wanted, const Source& source, const std::string& text,
                                     uint64_t seed, const std::string& where) const {
  const auto strategy = make_strategy(text, where);
  RenderOptions options;
  options.seed = seed;
  options.cells = wanted.cells;
  options.planes.error = strategy->estimates_error();
  const RenderResult result = render_whole(*strategy, source, options);
  const double rmse = options.planes.error ? result.film.estimated_rmse() : 0;
  // One sample a pixel has no error that could be estimated.
  return {{"", std::make_shared<const Image>(
                   colour_only(render_picture(result, *strategy, options, source, wanted.cells, {})))},
          std::isfinite(rmse) ? rmse : 0};
}

const StudyReference& StudyReferences::averaged(const StudyReference& wide) {
  const Image& from = *wide.picture.image;
  const Cells cells = from.spec.cells;
  if (cells == Cells{}) return known_.at(wide.picture.name);
  const std::string key = wide.picture.name + ", averaged";
  const auto known = known_.find(key);
  if (known != known_.end()) return known->second;
  Image image{from.spec, {}};
  image.spec.width /= cells.x;
  image.spec.height /= cells.y;
  image.spec.cells = {};
  image.spec.pixel_aspect = 1;
  image.pixels.resize(image.row_floats() * static_cast<size_t>(image.spec.height));
  const double count = cells.x * cells.y;
  for (int y = 0; y < image.spec.height; ++y)
    for (int x = 0; x < image.spec.width; ++x)
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int j = 0; j < cells.y; ++j)
          for (int i = 0; i < cells.x; ++i)
            sum += static_cast<double>(from.row(y * cells.y + j)[(x * cells.x + i) * 3 + c]);
        image.row(y)[x * 3 + c] = static_cast<float>(sum / count);
      }
  return known_[key] = {{key, std::make_shared<const Image>(std::move(image))}, wide.rmse / std::sqrt(count)};
}

}  // namespace triad::app
