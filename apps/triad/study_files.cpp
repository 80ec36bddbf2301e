// SPDX-License-Identifier: Apache-2.0
#include "study_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/random.hpp>
#include <triad/base/text.hpp>

#include "bundled_scenes.hpp"
#include "study_work.hpp"

namespace fs = std::filesystem;

namespace triad::app {
namespace {

using Json = nlohmann::json;

bool is_file(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

std::string real(const std::string& path) {
  std::error_code error;
  const fs::path found = fs::weakly_canonical(path, error);
  return error ? path : found.string();
}

// "sky%20blue.png" is the file "sky blue.png" (RFC 3986, section 2.1).
std::string decoded(const std::string& uri) {
  std::string text;
  for (size_t i = 0; i < uri.size(); ++i) {
    const bool is_code = uri[i] == '%' && i + 2 < uri.size() &&
                         std::isxdigit(static_cast<unsigned char>(uri[i + 1])) &&
                         std::isxdigit(static_cast<unsigned char>(uri[i + 2]));
    text += is_code ? static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16)) : uri[i];
    if (is_code) i += 2;
  }
  return text;
}

// Buffers, pictures and the sky of a glTF scene, as it names them.
void find_linked(const Json& json, std::vector<std::string>& links) {
  for (const auto& [key, value] : json.items())
    if (value.is_structured())
      find_linked(value, links);
    else if (value.is_string() && (key == "uri" || key == "environment"))
      links.push_back(value.get<std::string>());
}

// What a scene says of itself, whether in a .gltf or a .glb; discarded for other files.
Json scene_json(const std::string& path) {
  constexpr size_t kHeader = 20;  // glTF 2.0, section 4.4: magic, version, length; the first chunk's length and type
  const std::string extension = lower(fs::path(path).extension().string());
  if (extension != ".gltf" && extension != ".glb") return Json(Json::value_t::discarded);
  const std::string text = read_text_file(path);
  if (!text.starts_with("glTF") || text.size() < kHeader) return Json::parse(text, nullptr, false);
  size_t length = 0;
  for (size_t byte = 4; byte-- > 0;) length = length << 8 | static_cast<unsigned char>(text[12 + byte]);
  return Json::parse(text.substr(kHeader, length), nullptr, false);
}

// By path, so that each is there once.
class Finder {
 public:
  void add(const std::string& name, const std::string& path) {
    if (!is_file(path) || !found_.emplace(real(path), std::pair(name, path)).second) return;
    const Json scene = scene_json(path);
    if (!scene.is_structured()) return;
    std::vector<std::string> links;
    find_linked(scene, links);
    for (const std::string& link : links)
      for (const std::string& file : {link, decoded(link)})
        if (!link.starts_with("data:")) add(name + ": " + file, (fs::path(path).parent_path() / file).string());
  }
  StudyFiles files() const {
    StudyFiles files;
    for (const auto& [path, file] : found_) files.push_back(file);
    std::sort(files.begin(), files.end());
    return files;
  }

 private:
  std::map<std::string, std::pair<std::string, std::string>> found_;
};

std::string contents(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw_input("'" + path + "': " + std::strerror(errno));
  uint64_t hash = 0, bytes = 0;
  std::vector<uint64_t> words(size_t{1} << 17);  // 1 MiB
  while (stream) {
    std::fill(words.begin(), words.end(), 0);
    stream.read(reinterpret_cast<char*>(words.data()), static_cast<std::streamsize>(words.size() * sizeof words[0]));
    const auto count = static_cast<size_t>(stream.gcount());
    for (size_t i = 0; i * sizeof words[0] < count; ++i) hash = mix_bits(hash ^ words[i]) + kGoldenIncrement;
    bytes += count;
  }
  if (stream.bad()) throw_input("'" + path + "' cannot be read");
  return fmt::format("{} bytes, {:016x}", bytes, hash);
}

}  // namespace

StudyFiles study_files(const StudyPlan& plan, const std::vector<StudySettings>& settings) {
  Finder finder;
  const std::vector<BundledScene> scenes = bundled_scenes();
  std::set<std::string> seen;
  for (const StudySettings& one : settings) {
    const SettingValues values(plan.file, one);
    const auto cells = values.layout_cells();
    for (const auto& [setting, value] : one) {
      const std::string text = values.filled(value, cells);
      if (!seen.insert(setting + "=" + text).second) continue;
      const auto scene = std::find_if(scenes.begin(), scenes.end(), [&](const auto& s) { return s.name == text; });
      const bool is_name = setting == "source" || setting == "scene" || setting == "picture";
      if (is_name && scene != scenes.end())
        finder.add(text, scene->file);
      else if (is_name)
        finder.add(text, text);
      // In a chain or a strategy: after a blank, ':', ',' or '='.
      std::string part;
      for (const char c : text + ' ') {
        if (std::string_view(" :,='\"").find(c) == std::string_view::npos) {
          part += c;
          continue;
        }
        if (part.find_first_of("./") != std::string::npos) finder.add(part, part);
        part.clear();
      }
      if (text.find_first_of("./") != std::string::npos) finder.add(text, text);
    }
  }
  return finder.files();
}

StudySettings file_contents(const StudyFiles& files) {
  StudySettings all;
  for (const auto& [name, path] : files) all.emplace_back(name, contents(path));
  return all;
}

void check_json_path(const std::string& json, const StudyPlan& plan, const StudyFiles& files,
                     const std::string& folder) {
  if (json.empty() || json == "-") return;
  const std::string path = real(json);
  const auto refuse = [&](const std::string& what) {
    throw_usage("--json '" + json + "' would overwrite " + what + "; name another file");
  };
  if (path == real(plan.file)) refuse("the plan");
  for (const auto& [name, file] : files)
    if (path == real(file)) refuse("what the study reads");
  if (folder.empty()) return;
  const fs::path home = real(folder), relative = fs::path(path).lexically_relative(home);
  // The results are there under the same name anyway.
  if (!relative.empty() && *relative.begin() != ".." && relative != "results.json")
    refuse("what the study keeps in '" + folder + "'");
}

}  // namespace triad::app
