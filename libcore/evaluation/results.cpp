// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/json_text.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/results.hpp>

namespace triad {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

const char* better_word(int better) { return better < 0 ? "lower" : better > 0 ? "higher" : "zero"; }

Json reports_json(const StageReports& reports) {
  Json object = Json::object();
  for (const auto& [key, value] : reports.values) object[key] = number(value);
  return object;
}

Json pooled_json(const MetricResult::Pooled& pooled) {
  Json object;
  object["scores"] = Json::object();
  for (const auto& score : pooled.scores) object["scores"][score.name] = number(score.value);
  object["min-at"] = {pooled.min_at.x, pooled.min_at.y};
  object["min-channel"] = pooled.min_at.channel;
  object["max-at"] = {pooled.max_at.x, pooled.max_at.y};
  object["max-channel"] = pooled.max_at.channel;
  object["values"] = pooled.values;
  object["weight"] = pooled.weight;
  object["histogram"] = {
      {"low", pooled.histogram.low}, {"high", pooled.histogram.high}, {"counts", pooled.histogram.counts}};
  return object;
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

const MetricResult::Score* find_score(const std::vector<MetricResult::Score>& scores, const std::string& name) {
  const auto found =
      std::find_if(scores.begin(), scores.end(), [&](const auto& score) { return score.name == name; });
  return found == scores.end() ? nullptr : &*found;
}

// Pooled scores without those that the metric has by itself.
std::vector<const MetricResult::Score*> pooled_beside(const MetricResult& result) {
  std::vector<const MetricResult::Score*> list;
  if (result.pooled)
    for (const auto& score : result.pooled->scores)
      if (!find_score(result.scores, score.name)) list.push_back(&score);
  return list;
}

std::vector<std::string> own_scores(const std::string& metric, PluginHost& host) {
  const triad_desc& desc = *host.find(metric).desc;
  std::vector<std::string> names;
  for (uint32_t s = 0; s < desc.n_scores; ++s) names.emplace_back(desc.scores[s]->name);
  return names;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string option_of(const Threshold& threshold) { return threshold.above ? "--fail-above" : "--fail-below"; }

std::string table_number(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

}  // namespace

std::string results_to_json(const std::vector<MetricResult>& results, const std::vector<RunRecord>& runs) {
  Json list = Json::array();
  for (const MetricResult& result : results) {
    Json object;
    object["test"] = result.test;
    object["reference"] = result.reference;
    object["metric"] = result.metric;
    object["label"] = result.label;
    object["parameters"] = Json::object();
    for (const auto& [name, value] : result.parameters) object["parameters"][name] = value;
    object["scores"] = object["better"] = Json::object();
    for (const auto& score : result.scores) {
      object["scores"][score.name] = number(score.value);
      object["better"][score.name] = better_word(score.better);
    }
    if (result.pooled) object["pooled"] = pooled_json(*result.pooled);
    object["reports"] = reports_json(result.reports);
    if (!result.reports.series.empty())
      for (const auto& [name, series] : result.reports.series)
        object["series"][name] = {{"x", series.x}, {"y", series.y}};
    object["nan"] = result.nonfinite.nan;
    object["inf"] = result.nonfinite.inf;
    object["seconds"] = result.seconds;
    list.push_back(std::move(object));
  }
  Json root;
  root["results"] = std::move(list);
  for (const RunRecord& run : runs) {
    Json object;
    object["input"] = run.input;
    object["output"] = run.output;
    object["seconds"] = run.result.seconds;
    object["stages"] = Json::array();
    for (const auto& stage : run.result.stages)
      object["stages"].push_back(
          {{"stage", stage.text}, {"seconds", stage.seconds}, {"reports", reports_json(stage.reports)}});
    object["nan"] = run.result.input_nonfinite.nan;
    object["inf"] = run.result.input_nonfinite.inf;
    root["runs"].push_back(std::move(object));
  }
  // File names may hold any bytes; those that are not UTF-8 are shown replaced rather than refused.
  return json_text(std::move(root), 2);
}

std::string results_to_csv(const std::vector<MetricResult>& results) {
  std::string text = "test,reference,metric,label,score,value,better,nan,inf,seconds\r\n";
  for (const MetricResult& result : results) {
    const auto line = [&](const std::string& score) {
      text += csv_field(result.test) + "," + csv_field(result.reference) + "," + result.metric + "," +
              csv_field(result.label) + "," + score + "," + std::to_string(result.nonfinite.nan) + "," +
              std::to_string(result.nonfinite.inf) + "," + format_double(result.seconds) + "\r\n";
    };
    const auto score_line = [&](const MetricResult::Score& score) {
      line(score.name + "," + format_double(score.value) + "," + better_word(score.better));
    };
    // Without scores (values that are not finite) a line with empty fields still shows the counts.
    if (result.scores.empty()) line(",,");
    for (const auto& score : result.scores) score_line(score);
    for (const auto* score : pooled_beside(result)) score_line(*score);
  }
  return text;
}

std::string results_to_table(const std::vector<MetricResult>& results, const std::vector<PooledName>& pooled) {
  if (results.empty()) return "";
  std::vector<std::vector<std::string>> rows{{"test", "metric", "scores"}};
  for (const MetricResult& result : results) {
    std::vector<std::string> parts;
    const auto show = [&](const MetricResult::Score& score) {
      parts.push_back(score.name + " " + table_number(score.value) + (score.unit.empty() ? "" : " " + score.unit));
    };
    for (const auto& score : result.scores) show(score);
    for (const auto* score : pooled_beside(result))
      if (std::any_of(pooled.begin(), pooled.end(), [&](const PooledName& name) {
            return (name.label.empty() || name.label == result.label) && name.score == score->name;
          }))
        show(*score);
    if (result.nonfinite.total())
      parts.push_back(std::to_string(result.nonfinite.nan) + " NaN, " + std::to_string(result.nonfinite.inf) +
                      " infinite");
    rows.push_back({printable(result.test), result.label, join(parts, "   ")});
  }
  size_t first = 0, second = 0;
  for (const auto& row : rows) {
    first = std::max(first, row[0].size());
    second = std::max(second, row[1].size());
  }
  std::string text;
  for (const auto& row : rows)
    text += row[0] + std::string(first - row[0].size() + 2, ' ') + row[1] +
            std::string(second - row[1].size() + 2, ' ') + row[2] + "\n";
  return text;
}

Threshold parse_threshold(const std::string& text, bool above) {
  const std::string option = above ? "--fail-above" : "--fail-below";
  const size_t dot = text.find('.'), equals = text.find('=');
  const auto value =
      equals == std::string::npos ? std::nullopt : parse_double(std::string_view(text).substr(equals + 1));
  if (dot == std::string::npos || equals == std::string::npos || dot > equals || dot == 0 || equals == dot + 1 ||
      !value || std::isnan(*value))
    throw_usage(option + " '" + text + "' is not LABEL.SCORE=VALUE, as in display.rmse=0.02");
  return {text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), text, *value, above};
}

void check_threshold_names(const std::vector<Threshold>& thresholds, const std::vector<ChainItem>& metrics,
                           PluginHost& host) {
  for (const Threshold& threshold : thresholds) {
    const std::string option = option_of(threshold);
    std::vector<std::string> labels;
    const ChainItem* found = nullptr;
    for (const ChainItem& metric : metrics) {
      labels.push_back(metric.label);
      if (metric.label == threshold.label) found = &metric;
    }
    if (!found)
      throw_usage(option + " '" + threshold.text + "': no metric is labelled '" + threshold.label + "'" +
                  did_you_mean(threshold.label, labels) + "; there " + (labels.size() == 1 ? "is" : "are") + " " +
                  (labels.empty() ? "none" : "'" + join(labels, "', '") + "'"));
    const std::vector<std::string> own = own_scores(found->id, host);
    std::vector<std::string> names = own;
    for (const std::string& name : pooled_score_names())
      if (!contains(own, name)) names.push_back(name);
    if (!contains(names, threshold.score)) {
      std::vector<std::string> pooled(names.begin() + std::ssize(own), names.end());
      throw_usage(option + " '" + threshold.text + "': '" + found->id + "' has no score '" + threshold.score + "'" +
                  did_you_mean(threshold.score, names) + "; it has '" + join(own, "', '") +
                  "', and of its error map '" + join(pooled, "', '") + "'");
    }
  }
}

std::vector<PooledName> named_pooled_scores(const std::string& names, const std::vector<Threshold>& thresholds,
                                            const std::vector<ChainItem>& metrics, PluginHost& host) {
  std::vector<PooledName> list;
  const std::vector<std::string>& known = pooled_score_names();
  if (lower(names) == "all") {
    for (const std::string& name : known) list.push_back({"", name});
  } else if (!names.empty()) {
    for (const std::string& name : split_quoted(names, ',')) {
      if (!contains(known, name))
        throw_usage("--pool '" + names + "': nothing pooled is called '" + name + "'" + did_you_mean(name, known) +
                    "; there are 'all', '" + join(known, "', '") + "'");
      list.push_back({"", name});
    }
  }
  for (const Threshold& threshold : thresholds)
    for (const ChainItem& metric : metrics)
      if (metric.label == threshold.label && contains(known, threshold.score) &&
          !contains(own_scores(metric.id, host), threshold.score))
        list.push_back({threshold.label, threshold.score});
  return list;
}

std::string pooled_by_threshold(const std::string& label, const std::vector<PooledName>& pooled,
                                const std::vector<Threshold>& thresholds) {
  for (const Threshold& threshold : thresholds)
    for (const PooledName& name : pooled)
      if (threshold.label == label && name.label == label && name.score == threshold.score)
        return option_of(threshold) + " '" + threshold.text + "'";
  return "";
}

std::vector<std::string> failed_thresholds(const std::vector<Threshold>& thresholds,
                                           const std::vector<MetricResult>& results) {
  std::vector<std::string> lines;
  for (const MetricResult& result : results)
    for (const Threshold& threshold : thresholds) {
      if (threshold.label != result.label || result.nonfinite_failed) continue;
      const std::string name = result.test + ": " + threshold.label + "." + threshold.score;
      const MetricResult::Score* score = find_score(result.scores, threshold.score);
      if (!score && result.pooled) score = find_score(result.pooled->scores, threshold.score);
      if (!score)
        lines.push_back(name + " has no value: " +
                        (result.pooled ? "the metric's map holds negative values" : "there was no pixel to pool"));
      else if (threshold.above ? score->value > threshold.value : score->value < threshold.value)
        lines.push_back(name + " is " + format_double(score->value) + ", " + (threshold.above ? "above " : "below ") +
                        format_double(threshold.value));
    }
  return lines;
}

}  // namespace triad
