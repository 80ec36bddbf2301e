// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/json_text.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/study_folder.hpp>

namespace fs = std::filesystem;

namespace triad {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kLongestName = 120;  // of a picture, below the 255 bytes that file systems take

Json settings_json(const StudySettings& settings) {
  Json json = Json::object();
  for (const auto& [name, value] : settings) json[name] = value;
  return json;
}

// The same as a file holds it.
Json kept_settings(const StudySettings& settings) {
  Json json = settings_json(settings);
  escape_strings(json);
  return json;
}

// All that a run depends on.
Json identity(const StudyPlan& plan, const std::vector<StudySettings>& settings, const StudySettings& facts,
              const StudySettings& files) {
  Json json;
  json["work"] = plan.work;
  json["repeats"] = plan.repeats;
  json["seeds"] = plan.seeds;
  for (const auto& [name, value] : facts) json[name] = value;
  json["files"] = settings_json(files);
  json["settings"] = Json::array();
  for (const StudySettings& one : settings) json["settings"].push_back(settings_json(whole_settings(plan, one)));
  return json;
}

std::string shown(const Json& value) { return value.is_string() ? value.get<std::string>() : json_text(value, -1); }

// The first file that is not what it was; "" none.
std::string changed_file(const Json& there, const Json& here) {
  for (const auto& [name, contents] : here.items()) {
    if (!there.contains(name)) return "the file '" + name + "' had no part in it";
    if (there[name] != contents) return "the file '" + name + "' has changed since";
  }
  for (const auto& [name, contents] : there.items())
    if (!here.contains(name)) return "the file '" + name + "' is not there any more";
  return "";
}

// The first thing that differs: "repeats: 3 there, 5 here".
std::string difference(const Json& there, const Json& here) {
  const auto differ = [](const std::string& what, const Json& a, const Json& b) {
    return what + ": " + (a.is_null() ? "nothing" : "'" + shown(a) + "'") + " there, " +
           (b.is_null() ? "nothing" : "'" + shown(b) + "'") + " here";
  };
  for (const auto& [key, value] : here.items()) {
    const Json old = there.contains(key) ? there[key] : Json();
    if (old == value || key == "files") continue;
    if (key != "settings" || !old.is_array()) return differ(key, old, value);
    if (old.size() != value.size())
      return fmt::format("combinations of settings: {} there, {} here", old.size(), value.size());
    for (size_t i = 0; i < value.size(); ++i) {
      for (const auto& [name, text] : value[i].items()) {
        const Json before = old[i].contains(name) ? old[i][name] : Json();
        if (before != text) return differ("the setting '" + name + "'", before, text);
      }
      for (const auto& [name, text] : old[i].items())
        if (!value[i].contains(name)) return differ("the setting '" + name + "'", text, Json());
    }
  }
  // Last, as other settings have other files.
  const Json files = there.contains("files") ? there["files"] : Json();
  const std::string changed = changed_file(files.is_object() ? files : Json::object(), here["files"]);
  return !changed.empty() ? changed : there == here ? "" : "what it was begun with";
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(format_double(value)); }

void make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error && !fs::is_directory(path))
    throw_input("cannot make the folder '" + path.string() + "' for a study's results: " + error.message());
}

constexpr const char* kParts[] = {"runs", "references", "pictures"};

bool is_hidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

// Files that were to be renamed when they were whole.
void remove_leftovers(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().filename().string().starts_with(".triad-")) fs::remove(entry.path(), error);
}

}  // namespace

// Held until the process ends, however it ends.
class StudyFolder::Lock {
 public:
  explicit Lock(const std::string& folder) {
    const std::string path = fs::path(folder) / ".lock";
    file_ = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
    if (file_ < 0) throw_input("cannot write to the folder '" + folder + "': " + std::strerror(errno));
    if (flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;  // some file systems have no locks
    close(file_);
    throw_input("another study is at work in the folder '" + folder + "'; wait for it, or name another folder");
  }
  ~Lock() { close(file_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  int file_ = -1;
};

StudyFolder::~StudyFolder() = default;

StudyFolder::StudyFolder(const std::string& path, const StudyPlan& plan, const std::vector<StudySettings>& settings,
                         const StudySettings& facts, const StudySettings& files)
    : path_(path), settings_(settings) {
  std::error_code error;
  if (fs::exists(path_, error) && !fs::is_directory(path_, error))
    throw_input("'" + path_ + "' is a file; a study keeps its results in a folder");
  const fs::path plan_file = fs::path(path_) / "plan.json";
  // Before anything is made in a folder that is not ours. Whoever begins here writes plan.json first: what is not
  // hidden then has it beside.
  for (const auto& entry : fs::directory_iterator(path_, error))
    if (!is_hidden(entry.path()) && !fs::exists(plan_file, error))
      throw_input("'" + path_ + "' is no study's folder, and not empty; name a new one");
  make_folder(path_);
  lock_ = std::make_unique<Lock>(path_);
  Json here = identity(plan, settings, facts, files);
  escape_strings(here);  // as it is written, and read again
  if (fs::exists(plan_file, error)) {
    const Json there = Json::parse(read_text_file(plan_file), nullptr, false);
    const std::string differs = there.is_object() ? difference(there, here) : "its plan.json cannot be read";
    if (!differs.empty())
      throw_input("'" + path_ + "' holds results of another study than '" + plan.file + "': " + differs +
                  "; name another folder, or remove this one");
    remove_leftovers(path_);
  } else {
    write_text_file(plan_file, json_text(here, 1));
  }
  for (const char* part : kParts) {
    make_folder(fs::path(path_) / part);
    remove_leftovers(fs::path(path_) / part);
  }
}

std::string StudyFolder::run_path(const StudyTurn& turn) const {
  return fs::path(path_) / "runs" / fmt::format("{}-{:04}.json", turn.turn, turn.setting);
}

std::optional<Measurements> StudyFolder::find(const StudyTurn& turn) const {
  const std::string path = run_path(turn);
  std::error_code error;
  if (!fs::exists(path, error)) return {};
  const Json json = Json::parse(read_text_file(path), nullptr, false);
  // Edited or damaged, it counts as not there.
  if (!json.is_object() || json.value("settings", Json()) != kept_settings(settings_.at(turn.setting)) ||
      json.value("turn", Json()) != turn.turn || !json.contains("measured") || !json["measured"].is_object() ||
      json.value("measures", Json()) != json["measured"].size())
    return {};
  Measurements measured;
  for (const auto& [name, value] : json["measured"].items()) {
    const auto parsed = value.is_number()   ? std::optional<double>(value.get<double>())
                        : value.is_string() ? parse_double(value.get<std::string>())
                                            : std::nullopt;
    if (!parsed) return {};
    measured.emplace_back(name, *parsed);
  }
  return measured;
}

void StudyFolder::keep(const StudyTurn& turn, const Measurements& measured) const {
  Json json;
  json["settings"] = settings_json(settings_.at(turn.setting));
  json["turn"] = turn.turn;
  json["measured"] = Json::object();
  for (const auto& [name, value] : measured) json["measured"][name] = number(value);
  json["measures"] = json["measured"].size();
  write_text_file(run_path(turn), json_text(json, 1));
}

std::string StudyFolder::references(const std::string& path) { return fs::path(path) / "references"; }

std::string StudyFolder::picture(size_t setting) const {
  std::string name = fmt::format("{:03}", setting);
  for (const auto& [axis, value] : settings_.at(setting)) name += "-" + value;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '=') c = '-';
  return fs::path(path_) / "pictures" / (name.substr(0, kLongestName) + ".exr");
}

void StudyFolder::finish(const std::string& json, const std::string& table) const {
  write_text_file(fs::path(path_) / "results.json", json);
  write_text_file(fs::path(path_) / "table.txt", table);
}

}  // namespace triad
