// SPDX-License-Identifier: Apache-2.0
// Pictures beside their references as a report.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>

#include "report.hpp"

namespace triad::app {
namespace {

using Json = nlohmann::ordered_json;

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

// What a test picture is called beside those of other references: without its folder where that is its reference's
// own, so that pictures made alike are found together.
std::string name_beside(const std::string& test, const std::string& reference) {
  const std::filesystem::path file(test);
  return file.parent_path() == std::filesystem::path(reference).parent_path() ? file.filename().string() : test;
}

// The file of which JSON says the name: with the bytes that JSON cannot hold.
std::string file_named(const std::string& text) {
  std::error_code error;
  const std::string bytes = unescape_non_utf8(text);
  return !std::filesystem::exists(text, error) && std::filesystem::exists(bytes, error) ? bytes : text;
}

// As ranking_to_json() writes it.
void read_as(ReadOptions& options, const Json& said) {
  options.part = said.value("part", options.part);
  options.layer = said.value("layer", options.layer);
  options.channels = said.value("channels", options.channels);
  options.colour_space = said.value("space", options.colour_space);
  if (!options.cells && said.contains("cells"))
    options.cells = parse_cells(said["cells"].get<std::string>(), "cells");
}

}  // namespace

ReportData comparison_report(const std::vector<MetricResult>& results, const ReadOptions& tests,
                             const ReadOptions& references) {
  ReportData data;
  data.kind = "comparison";
  std::set<std::string> truths;
  for (const MetricResult& result : results) truths.insert(result.reference);
  data.title = truths.size() == 1 ? "Pictures beside " + *truths.begin() : "Pictures beside their references";
  if (truths.size() > 1) data.axes.push_back("reference");
  data.axes.push_back("picture");

  std::map<std::string, int> reference_numbers;
  std::map<std::pair<std::string, std::string>, size_t> run_numbers;  // by test and reference
  for (const MetricResult& result : results) {
    const auto [run, is_new] = run_numbers.emplace(std::pair(result.test, result.reference), data.runs.size());
    if (is_new) {
      const auto [reference, is_first] =
          reference_numbers.emplace(result.reference, static_cast<int>(data.pictures.size()));
      if (is_first) {
        ReportPicture picture{result.reference, result.reference, references};
        picture.is_reference = true;
        data.pictures.push_back(std::move(picture));
      }
      const bool several = truths.size() > 1;
      StudySettings settings{{"picture", several ? name_beside(result.test, result.reference) : result.test}};
      if (several) settings.insert(settings.begin(), {"reference", result.reference});
      ReportPicture picture{result.test, result.test, tests};
      picture.reference = reference->second;
      picture.settings = settings;
      ReportRun one{settings};
      one.picture = static_cast<int>(data.pictures.size());
      data.pictures.push_back(std::move(picture));
      data.runs.push_back(std::move(one));
    }
    for (const MetricResult::Score& score : result.scores) {
      const std::string name = result.label + "." + score.name;
      data.runs[run->second].shown[name] = score.value;
      add_once(data.measures, name);
      if (score.better > 0) add_once(data.higher_is_better, name);
    }
    for (const auto& [name, value] : result.parameters) {
      if (name == "ppd" && data.ppd == 0) data.ppd = parse_double(value).value_or(0);
      if (name == "layout" && data.layout.empty() && value != "auto") data.layout = value;
    }
  }
  return data;
}

ReportData read_comparison_report(const std::string& path, ReadOptions tests, ReadOptions references) {
  const Json json = Json::parse(read_text_file(path), nullptr, false);
  const std::string what =
      "'" + path + "': a report is made of what triad compare --json wrote, or of a study's folder";
  if (!json.is_object() || !json.contains("results") || !json["results"].is_array() || json["results"].empty())
    throw_input(what);
  std::vector<MetricResult> results;
  try {
    if (json.contains("reading")) {
      read_as(tests, json["reading"].at("test"));
      read_as(references, json["reading"].at("reference"));
    }
    for (const Json& one : json["results"]) {
      MetricResult& result = results.emplace_back();
      result.test = file_named(one.at("test").get<std::string>());
      result.reference = file_named(one.at("reference").get<std::string>());
      result.metric = one.at("metric").get<std::string>();
      result.label = one.at("label").get<std::string>();
      for (const auto& [name, value] : one.at("parameters").items())
        result.parameters.emplace_back(name, value.is_string() ? value.get<std::string>() : value.dump());
      for (const auto& [name, value] : one.at("scores").items()) {
        const std::string better = one.at("better").value(name, "lower");
        const double number = value.is_number()   ? value.get<double>()
                              : value.is_string() ? parse_double(value.get<std::string>()).value_or(NAN)
                                                  : NAN;
        result.scores.push_back({name, "", number, better == "higher" ? 1 : better == "zero" ? 0 : -1});
      }
    }
  } catch (const nlohmann::json::exception& wrong) {
    throw_input(what + " (" + wrong.what() + ")");
  }
  return comparison_report(results, tests, references);
}

}  // namespace triad::app
