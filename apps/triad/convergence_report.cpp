// SPDX-License-Identifier: Apache-2.0
#include "convergence_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <triad/base/json_text.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/study_comparisons.hpp>

namespace triad::app {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? Json(nullptr) : Json(value > 0 ? "inf" : "-inf");
}
Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }
Json interval_json(const Interval& i) {
  return {{"value", number(i.value)}, {"low", number(i.low)}, {"high", number(i.high)}};
}

Json law_json(const std::optional<PowerLaw>& law, bool squared) {
  if (!law) return nullptr;
  return {{"slope", interval_json(law->slope)},
          {"expected", squared ? -1. : -.5},
          {"intercept", number(law->intercept)},
          {"scatter", number(law->scatter)}};
}

Json floor_json(const ConvergenceFindings& findings, const std::optional<ErrorFloor>& floor) {
  if (!floor) return nullptr;
  return {{"score", interval_json(floor_of_score(findings, *floor))},
          {"squared_error", interval_json(floor->floor)},
          {"found", floor->found()},
          {"variance", number(floor->variance)},
          {"rate", number(floor->rate)},
          {"scatter", number(floor->scatter)}};
}

double efficiency_of(const SeriesPicture& picture) {
  return picture.cost.seconds ? 1 / (picture.squared_error * *picture.cost.seconds) : NAN;
}

std::string short_text(double value) { return std::isfinite(value) ? short_number(value) : format_double(value); }

std::string range_text(const Interval& i) {
  return fmt::format("{} ({} to {})", short_text(i.value), short_text(i.low), short_text(i.high));
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

std::string slope_line(const std::string& over, const PowerLaw& law, const ConvergenceFindings& findings) {
  return fmt::format("  slope over {}: {}; independent samples have {}\n", over, range_text(law.slope),
                     findings.squared ? "-1" : "-.5");
}

std::string floor_line(const ConvergenceFindings& findings, const Series& series, const SeriesFit& fit) {
  const Interval floor = floor_of_score(findings, fit.floor);
  const double least =
      std::min_element(series.pictures.begin(), series.pictures.end(), [](const auto& a, const auto& b) {
        return a.score < b.score;
      })->score;
  if (!fit.floor.found() && !(floor.high < least))  // all of the error may be bias
    return "  nothing can be said of bias: take more pictures, or such that differ more in samples\n";
  if (!fit.floor.found())
    return fmt::format("  no bias found: at most {} of {} stays, however long it renders\n", short_text(floor.high),
                       findings.score);
  std::string text =
      fmt::format("  bias: {} of {} stays, however long it renders\n", range_text(floor), findings.score);
  if (findings.rate && fit.floor_free && !fit.floor_free->found())
    text += fmt::format(
        "    if the variance falls as N^-{}; an error that falls more slowly, without bias, would explain it too\n",
        short_text(*findings.rate));
  return text;
}

std::string series_text(const ConvergenceFindings& findings, const Series& series, const SeriesFit& fit) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> head{"  picture"};
  if (fit.samples) head.emplace_back("samples");
  if (fit.seconds) head.emplace_back("seconds");
  head.push_back(findings.score);
  if (fit.seconds) head.emplace_back("efficiency");
  rows.push_back(head);
  for (const SeriesPicture& picture : series.pictures) {
    std::vector<std::string> row{"  " + printable(picture.file)};
    if (fit.samples) row.push_back(short_text(*picture.cost.samples));
    if (fit.seconds) row.push_back(short_text(*picture.cost.seconds));
    row.push_back(short_text(picture.score));
    if (fit.seconds) row.push_back(short_text(efficiency_of(picture)));
    rows.push_back(row);
  }
  std::string text = fmt::format("{}: {} pictures, {} against {}\n", printable(series.name), series.pictures.size(),
                                 findings.label + "." + findings.score, printable(findings.reference));
  text += aligned_columns(rows, 1);
  if (fit.samples) text += slope_line("samples", *fit.samples, findings);
  if (fit.seconds) text += slope_line("seconds", *fit.seconds, findings);
  text += floor_line(findings, series, fit);
  if (fit.efficiency)
    text += fmt::format("  efficiency 1 / (squared error x seconds): {}\n", range_text(*fit.efficiency));
  return text;
}

std::string equal_text(const ConvergenceFindings& findings, const EqualErrors& equal) {
  const std::string &first = findings.series[0].name, &other = findings.series[equal.series].name;
  if (equal.at.empty())
    return fmt::format("{} and {} reach no error in common: nothing to compare\n", printable(first),
                       printable(other));
  std::vector<std::vector<std::string>> rows{{"  " + findings.score}};
  if (equal.at[0].seconds) rows[0].emplace_back("seconds");
  if (equal.at[0].samples) rows[0].emplace_back("samples");
  for (const auto& at : equal.at) {
    std::vector<std::string> row{"  " + short_text(at.score)};
    if (at.seconds) row.push_back(range_text(*at.seconds));
    if (at.samples) row.push_back(range_text(*at.samples));
    rows.push_back(row);
  }
  return fmt::format("{} over {}, at equal error: above 1, {} is the faster\n", printable(other), printable(first),
                     printable(first)) +
         aligned_columns(rows, 1);
}

}  // namespace

Interval floor_of_score(const ConvergenceFindings& findings, const ErrorFloor& floor) {
  const Interval& f = floor.floor;
  if (findings.squared) return f;
  return {std::sqrt(f.value), std::sqrt(f.low), std::sqrt(f.high)};
}

std::string convergence_to_text(const ConvergenceFindings& findings) {
  std::string text;
  for (size_t i = 0; i < findings.series.size(); ++i)
    text += (i > 0 ? "\n" : "") + series_text(findings, findings.series[i], findings.fits[i]);
  for (const EqualErrors& equal : findings.equal) text += "\n" + equal_text(findings, equal);
  return text + "In brackets: intervals of 95 %.\n";
}

std::string convergence_to_json(const ConvergenceFindings& findings) {
  Json root{{"reference", findings.reference}, {"metric", findings.metric},
            {"label", findings.label},         {"score", findings.score},
            {"squared", findings.squared},     {"rate", findings.rate ? Json(*findings.rate) : Json("free")}};
  root["series"] = Json::array();
  for (size_t i = 0; i < findings.series.size(); ++i) {
    const Series& series = findings.series[i];
    const SeriesFit& fit = findings.fits[i];
    Json object{{"name", series.name}, {"pictures", Json::array()}};
    for (const SeriesPicture& picture : series.pictures)
      object["pictures"].push_back(
          {{"file", picture.file},
           {"samples", number(picture.cost.samples)},
           {"samples_from", picture.cost.samples ? Json(picture.cost.samples_from) : Json(nullptr)},
           {"seconds", number(picture.cost.seconds)},
           {"seconds_from", picture.cost.seconds ? Json(picture.cost.seconds_from) : Json(nullptr)},
           {"score", number(picture.score)},
           {"squared_error", number(picture.squared_error)},
           {"efficiency", number(efficiency_of(picture))}});
    object["over_samples"] = law_json(fit.samples, findings.squared);
    object["over_seconds"] = law_json(fit.seconds, findings.squared);
    object["floor"] = floor_json(findings, fit.floor);
    object["floor_at_any_rate"] = floor_json(findings, fit.floor_free);
    object["efficiency"] = fit.efficiency ? interval_json(*fit.efficiency) : Json(nullptr);
    root["series"].push_back(std::move(object));
  }
  root["equal_error"] = Json::array();
  for (const EqualErrors& equal : findings.equal) {
    Json object{
        {"first", findings.series[0].name}, {"other", findings.series[equal.series].name}, {"at", Json::array()}};
    for (const auto& at : equal.at)
      object["at"].push_back({{"score", number(at.score)},
                              {"seconds", at.seconds ? interval_json(*at.seconds) : Json(nullptr)},
                              {"samples", at.samples ? interval_json(*at.samples) : Json(nullptr)}});
    root["equal_error"].push_back(std::move(object));
  }
  return json_text(std::move(root), 2);
}

std::string convergence_to_csv(const ConvergenceFindings& findings) {
  const auto text_of = [](const std::optional<double>& value) { return value ? format_double(*value) : ""; };
  std::string text = "series,file,samples,seconds," + csv_field(findings.score) + ",squared_error,efficiency\r\n";
  for (const Series& series : findings.series)
    for (const SeriesPicture& picture : series.pictures)
      text += csv_field(series.name) + "," + csv_field(picture.file) + "," + text_of(picture.cost.samples) + "," +
              text_of(picture.cost.seconds) + "," + format_double(picture.score) + "," +
              format_double(picture.squared_error) + "," +
              (picture.cost.seconds ? format_double(efficiency_of(picture)) : "") + "\r\n";
  return text;
}

const std::vector<std::string>& convergence_threshold_names() {
  static const std::vector<std::string> kNames{"slope",      "slope-seconds", "floor",        "floor-low",
                                               "efficiency", "seconds-ratio", "samples-ratio"};
  return kNames;
}

std::vector<std::pair<std::string, double>> convergence_numbers(const ConvergenceFindings& findings,
                                                                const std::string& name) {
  std::vector<std::pair<std::string, double>> numbers;
  for (size_t i = 0; i < findings.series.size(); ++i) {
    const SeriesFit& fit = findings.fits[i];
    const Interval floor = floor_of_score(findings, fit.floor);
    const auto put = [&](const std::string& own, double value) {
      if (own == name) numbers.emplace_back(findings.series[i].name, value);
    };
    if (fit.samples) put("slope", fit.samples->slope.value);
    if (fit.seconds) put("slope-seconds", fit.seconds->slope.value);
    put("floor", floor.value);
    put("floor-low", floor.low);
    if (fit.efficiency) put("efficiency", fit.efficiency->value);
  }
  for (const EqualErrors& equal : findings.equal) {
    if (equal.at.empty()) continue;
    const auto& middle = equal.at[equal.at.size() / 2];
    const std::string pair = findings.series[equal.series].name + " over " + findings.series[0].name;
    if (middle.seconds && name == "seconds-ratio") numbers.emplace_back(pair, middle.seconds->value);
    if (middle.samples && name == "samples-ratio") numbers.emplace_back(pair, middle.samples->value);
  }
  return numbers;
}

}  // namespace triad::app
