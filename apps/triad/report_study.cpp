// SPDX-License-Identifier: Apache-2.0
// A study's folder as a report.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/study_comparisons.hpp>
#include <triad/evaluation/study_folder.hpp>

#include "report.hpp"
#include "study_references.hpp"
#include "study_work.hpp"

namespace fs = std::filesystem;

namespace triad::app {
namespace {

using Json = nlohmann::ordered_json;

Json read_json(const fs::path& path, const std::string& what) {
  std::error_code error;
  if (!fs::exists(path, error))
    throw_input("'" + path.parent_path().string() + "' has no " + path.filename().string() + "; " + what);
  Json json = Json::parse(read_text_file(path), nullptr, false);
  if (!json.is_object()) throw_input("'" + path.string() + "' is no JSON object; " + what);
  return json;
}

StudySettings settings_of(const Json& json) {
  StudySettings settings;
  for (const auto& [name, value] : json.items()) settings.emplace_back(name, value.get<std::string>());
  return settings;
}

std::string value_of(const StudySettings& settings, const std::string& name) {
  for (const auto& [key, value] : settings)
    if (key == name) return value;
  return "";
}

double number_of(const Json& json) { return json.is_number() ? json.get<double>() : NAN; }

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

ReportRun run_of(const Json& json, int seeds) {
  ReportRun run;
  run.settings = settings_of(json.at("settings"));
  for (const auto& [name, value] : json.at("median").items()) {
    // As StudyRecord::shown() has it, and as study_table() says how far to trust it.
    const bool of_seeds = seeds > 1 && !is_time(name) && json.at("mean").contains(name);
    run.shown[name] = number_of(of_seeds ? json.at("mean").at(name) : value);
    run.around[name] = number_of(json.at(of_seeds ? "interval95" : "spread").at(name));
    for (const Json& one : json.at("values").at(name)) run.values[name].push_back(number_of(one));
  }
  if (json.contains("pareto")) run.pareto = json.at("pareto").get<bool>();
  return run;
}

// Measures of which more is better, by the last part of their names.
bool is_higher_better(const std::string& measure) {
  static const std::set<std::string> kNames{"psnr", "ssim", "ms-ssim", "unchanged"};
  return kNames.contains(measure.substr(measure.rfind('.') + 1));
}

// Axes on which a method is the same and takes more: those that the plan compares along, and what is called so.
std::vector<std::string> axes_along(const Json& results, const std::vector<std::string>& axes) {
  static const std::set<std::string> kNames{"level", "spp", "samples", "n", "depth", "frames", "iterations", "taps"};
  std::vector<std::string> along;
  for (const std::string& axis : axes)
    if (kNames.contains(axis)) along.push_back(axis);
  if (!results.contains("equal")) return along;
  // {"at", "compare", "base", AXIS, ALONG, "where", "ratio"}
  for (const Json& one : results.at("equal")) {
    std::string last;
    for (const auto& [key, value] : one.items())
      if (std::find(axes.begin(), axes.end(), key) != axes.end()) last = key;
    if (!last.empty()) add_once(along, last);
  }
  return along;
}

std::string cell_of(const Json& json) {
  if (json.is_string()) return json.get<std::string>();
  if (json.is_number()) return short_number(json.get<double>());
  if (!json.is_object()) return "–";
  std::string text;
  for (const auto& [key, value] : json.items()) text += (text.empty() ? "" : ", ") + key + " " + cell_of(value);
  return text;
}

// An array of objects with the same keys, or nearly.
void add_table(const Json& results, const std::string& key, const std::string& caption, ReportData& data) {
  if (!results.contains(key) || results.at(key).empty()) return;
  ReportTable table{caption, {}, {}};
  for (const Json& one : results.at(key))
    for (const auto& [name, value] : one.items()) add_once(table.head, name);
  for (const Json& one : results.at(key)) {
    auto& row = table.rows.emplace_back();
    for (const std::string& name : table.head) row.push_back(one.contains(name) ? cell_of(one.at(name)) : "");
  }
  data.tables.push_back(std::move(table));
}

// The pictures that the study's metrics were given for the truth.
class References {
 public:
  explicit References(const std::string& folder) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(StudyFolder::references(folder), error)) {
      if (entry.path().extension() != ".json") continue;
      const Json json = Json::parse(read_text_file(entry.path()), nullptr, false);
      const fs::path picture = fs::path(entry.path()).replace_extension(".exr");
      if (json.is_object() && json.value("reference", Json()).is_string() && fs::exists(picture, error))
        known_.emplace(json["reference"].get<std::string>(), picture.string());
    }
  }

  // Of a run with these settings; "" if there is none. What is judged on a panel has a truth on the panel's cells:
  // that one tells more than its mean.
  std::string find(const std::string& plan, const StudySettings& whole) const {
    const SettingValues values(plan, whole);
    const std::string text = values.filled(values.text_or("reference", ""), values.layout_cells());
    if (StudyReferences::is_file(text)) return text;
    const std::string source = values.text_or("source", "");
    std::string best;
    size_t most = 0;
    for (const auto& [key, path] : known_) {
      if (!key.starts_with(source + " ") || !key.ends_with(" by " + text)) continue;
      bool fits = key.find(" " + values.text_or("size", "") + " ") != std::string::npos;
      for (const char* name : {"camera", "effects"}) {
        const std::string value = values.text_or(name, "");
        fits = fits && (value.empty() || key.find(fmt::format(" {} '{}'", name, value)) != std::string::npos);
      }
      const size_t at = key.find(" cells ");
      const Cells cells = at == std::string::npos ? Cells{} : cells_at(key, at + 7);
      const auto count = static_cast<size_t>(cells.x * cells.y);
      if (!fits || count <= most) continue;
      most = count;
      best = path;
    }
    return best;
  }

 private:
  static Cells cells_at(const std::string& key, size_t begin) {
    return parse_cells(key.substr(begin, key.find(' ', begin) - begin), "the reference '" + key + "'");
  }
  std::map<std::string, std::string> known_;  // what it is of -> path
};

void add_pictures(const std::string& folder, ReportData& data) {
  std::map<size_t, fs::path> found;  // by setting
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(folder) / "pictures", error)) {
    const std::string name = entry.path().filename().string();
    const auto number = parse_int(name.substr(0, name.find('-')));
    if (name.ends_with(".exr") && number && *number >= 0) found.emplace(static_cast<size_t>(*number), entry.path());
  }
  if (!found.empty() && found.size() < data.runs.size())
    warn("'" + folder + "' has pictures of " + std::to_string(found.size()) + " of its " +
         std::to_string(data.runs.size()) + " settings; triad study with the same plan and folder makes them anew");
  const References references(folder);
  const std::string plan = (fs::path(folder) / "plan.json").string();
  std::map<std::string, int> numbers;  // of references, by path
  for (const auto& [setting, path] : found) {
    if (setting >= data.runs.size()) continue;
    ReportRun& run = data.runs[setting];
    const std::string reference = references.find(plan, run.whole);
    int number = -1;
    if (!reference.empty() && fs::exists(reference, error)) {
      const auto [known, is_new] = numbers.emplace(reference, static_cast<int>(data.pictures.size()));
      number = known->second;
      if (is_new) {
        ReportPicture picture{"reference", reference};
        picture.is_reference = true;
        for (const char* axis : {"source", "scene", "picture"})
          if (const std::string value = value_of(run.settings, axis); !value.empty()) picture.name += " of " + value;
        data.pictures.push_back(picture);
      }
    }
    run.picture = static_cast<int>(data.pictures.size());
    ReportPicture picture{"", path.string()};
    for (const auto& [axis, value] : run.settings) picture.name += (picture.name.empty() ? "" : ", ") + value;
    picture.reference = number;
    picture.settings = run.settings;
    data.pictures.push_back(std::move(picture));
  }
}

ReportData read_results(const std::string& folder) {
  const std::string what = "a report is made of a study's folder once the study is done: triad study PLAN -o DIR";
  const Json results = read_json(fs::path(folder) / "results.json", what);
  const Json plan = read_json(fs::path(folder) / "plan.json", what);
  ReportData data;
  data.title = results.value("title", "");
  if (data.title.empty()) data.title = "Study " + results.value("study", "");
  const int seeds = results.value("seeds", 1);
  if (results.contains("pareto")) {
    data.pareto = results["pareto"].at("measures").get<std::vector<std::string>>();
    data.within = results["pareto"].at("within").get<std::vector<std::string>>();
  }
  for (const Json& run : results.at("runs")) data.runs.push_back(run_of(run, seeds));
  const Json& wholes = plan.at("settings");
  if (wholes.size() != data.runs.size())
    throw_input(fmt::format("'{}': plan.json has {} settings, results.json has {} runs; run the study again", folder,
                            wholes.size(), data.runs.size()));
  for (size_t i = 0; i < data.runs.size(); ++i) data.runs[i].whole = settings_of(wholes[i]);

  for (const ReportRun& run : data.runs)
    for (const auto& [axis, value] : run.settings) add_once(data.axes, axis);
  data.plain = results.value("measure", std::vector<std::string>{});
  for (const std::string& name : data.pareto) add_once(data.measures, name);
  for (const Json& run : results.at("runs"))
    for (const auto& [name, value] : run.at("median").items()) add_once(data.measures, name);
  for (const std::string& name : data.measures)
    if (is_higher_better(name)) data.higher_is_better.push_back(name);
  data.along = axes_along(results, data.axes);
  data.around_is =
      seeds > 1
          ? "± is half the width of the 95 % confidence interval over seeds; of seconds, half the range between "
            "the quartiles."
          : "± is half the range between the quartiles of the runs.";

  const StudySettings fixed = settings_of(results.at("fixed"));
  data.layout = value_of(fixed, "layout");
  data.ppd = parse_double(value_of(fixed, "ppd")).value_or(0);
  data.facts.emplace_back("study", results.value("study", ""));
  for (const char* name : {"size", "layout", "ppd", "metric", "reference"})
    if (const std::string value = value_of(fixed, name); !value.empty()) data.facts.emplace_back(name, value);
  data.facts.emplace_back("seeds", std::to_string(seeds));
  data.facts.emplace_back("repeats", std::to_string(results.value("repeats", 1)));
  for (const char* name : {"threads", "version"})
    if (plan.contains(name) && plan[name].is_string()) data.facts.emplace_back(name, plan[name].get<std::string>());

  add_table(results, "equal", "At equal cost: what a method has over the base", data);
  add_table(results, "faster", "Which is faster: one-tailed tests over all runs", data);
  add_table(results, "published", "Published figures beside these, as ratios to the base", data);
  add_pictures(folder, data);
  return data;
}

}  // namespace

ReportData read_study_report(const std::string& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw_input("'" + folder +
                "' is not there; a report is made of a study's folder (triad study PLAN -o DIR), or of what triad "
                "compare --json wrote");
  try {
    return read_results(folder);
  } catch (const nlohmann::json::exception&) {
    throw_input("'" + folder + "': results.json or plan.json is not as a study writes it; run the study again");
  }
}

}  // namespace triad::app
