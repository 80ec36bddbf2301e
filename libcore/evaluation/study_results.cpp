// SPDX-License-Identifier: Apache-2.0
// What is said of a study's results: the table, JSON.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <triad/base/json_text.hpp>
#include <triad/evaluation/study_comparisons.hpp>

namespace triad {
namespace {

using Json = nlohmann::ordered_json;

Json object(const StudySettings& settings) {
  Json json = Json::object();
  for (const auto& [name, value] : settings) json[name] = value;
  return json;
}

// The number and, where runs or seeds differ, how far to trust it.
std::string cell(const StudyRecord& record, const std::string& measured) {
  if (!record.values.contains(measured)) return "-";
  const bool of_seeds = record.seeds > 1 && !is_time(measured);
  const double around = of_seeds ? half_width_95(record.samples(measured)) : record.spread(measured);
  return short_number(record.shown(measured)) + (around > 0 ? " ±" + short_number(around) : "");
}

Json comparisons_json(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  Json root = Json::object();
  for (const FasterResult& result : compare_seconds(plan, records))
    root["faster"].push_back({{"first", result.first},
                              {"second", result.second},
                              {"where", object(result.where)},
                              {"ratio", result.ratio},
                              {"t", result.test.t},
                              {"freedom", result.test.freedom},
                              {"p", result.test.p}});
  for (const EqualResult& result : compare_at_equal(plan, records)) {
    const auto& equal = plan.equal[result.equal];
    root["equal"].push_back({{"at", equal.at},
                             {"compare", equal.compare},
                             {"base", equal.base},
                             {equal.axis, result.value},
                             {equal.along, result.along},
                             {"where", object(result.where)},
                             {"ratio", result.ratio}});
  }
  for (const PublishedResult& result : compare_published(plan, records)) {
    const auto& published = plan.published[result.published];
    root["published"].push_back({{"title", published.title},
                                 {"measure", published.measure},
                                 {"base", published.base},
                                 {"row", result.row},
                                 {"column", result.column},
                                 {"where", object(result.where)},
                                 {"ours", result.ours},
                                 {"theirs", result.theirs}});
  }
  return root;
}

}  // namespace

std::string short_number(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, std::abs(value) >= 1e6 || value == std::floor(value) ? "%.0f" : "%.4g", value);
  return buffer;
}

std::string aligned_columns(const std::vector<std::vector<std::string>>& rows, size_t left) {
  // "±" is two bytes of UTF-8 and one column.
  const auto width = [](const std::string& text) {
    return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
  };
  std::vector<size_t> widest;
  for (const auto& row : rows)
    for (size_t c = 0; c < row.size(); ++c) {
      widest.resize(std::max(widest.size(), c + 1));
      widest[c] = std::max(widest[c], width(row[c]));
    }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (size_t c = 0; c < row.size(); ++c) {
      if (widest[c] == 0) continue;
      const std::string blanks(widest[c] - width(row[c]), ' ');
      line += (line.empty() ? "" : "  ") + (c < left ? row[c] + blanks : blanks + row[c]);
    }
    while (!line.empty() && line.back() == ' ') line.pop_back();
    text += line + "\n";
  }
  return text;
}

std::string study_table(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  std::vector<std::string> columns = plan.measure;
  if (columns.empty() && !records.empty()) columns = records[0].order;
  std::vector<std::vector<std::string>> rows(1);
  for (const auto& axis : plan.axes) rows[0].push_back(axis.name);
  for (const std::string& column : columns) rows[0].push_back(column);
  const std::vector<bool> best = pareto_optimal(plan, records);
  if (!best.empty()) rows[0].push_back("best");
  for (size_t r = 0; r < records.size(); ++r) {
    auto& row = rows.emplace_back();
    for (const auto& [name, value] : records[r].settings) row.push_back(value);
    for (const std::string& column : columns) row.push_back(cell(records[r], column));
    if (!best.empty()) row.push_back(best[r] ? "*" : "");
  }
  return (plan.title.empty() ? "" : plan.title + "\n") + aligned_columns(rows, plan.axes.size()) +
         comparisons_text(plan, records);
}

std::string study_to_json(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  Json root;
  root["study"] = plan.name;
  root["title"] = plan.title;
  root["work"] = plan.work;
  root["repeats"] = plan.repeats;
  if (plan.seeds > 0) root["seeds"] = plan.seeds;
  root["measure"] = plan.measure;
  root["fixed"] = object(plan.fixed);
  const std::vector<bool> best = pareto_optimal(plan, records);
  if (!best.empty()) root["pareto"] = {{"measures", plan.pareto}, {"within", plan.within}};
  root["runs"] = Json::array();
  for (size_t r = 0; r < records.size(); ++r) {
    const StudyRecord& record = records[r];
    Json run;
    run["settings"] = object(record.settings);
    run["median"] = run["spread"] = run["mean"] = run["interval95"] = run["values"] = Json::object();
    for (const std::string& name : record.order) {
      run["median"][name] = record.median(name);
      run["spread"][name] = record.spread(name);
      const std::vector<double> samples = record.samples(name);
      if (samples.size() > 1) {
        run["mean"][name] = mean_of(samples);
        run["interval95"][name] = half_width_95(samples);
      }
      run["values"][name] = record.values.at(name);
    }
    if (!best.empty()) run["pareto"] = static_cast<bool>(best[r]);
    root["runs"].push_back(std::move(run));
  }
  root.update(comparisons_json(plan, records));
  return json_text(std::move(root), 2);
}

}  // namespace triad
