// SPDX-License-Identifier: Apache-2.0
#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/study.hpp>

namespace fs = std::filesystem;

namespace triad {
namespace {

constexpr int kMostRepeats = 1000;

std::string value_text(const toml::node& node, const std::string& where) {
  if (const auto text = node.value_exact<std::string>()) return *text;
  if (const auto integer = node.value_exact<int64_t>()) return std::to_string(*integer);
  if (const auto real = node.value_exact<double>()) return format_double(*real);
  if (const auto flag = node.value_exact<bool>()) return *flag ? "true" : "false";
  throw_input(where + ": a setting is a string, a number or a boolean");
}

// Linear interpolation between order statistics: quantile 0 is the least value, 1 the largest.
double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  const double at = q * static_cast<double>(values.size() - 1);
  const auto low = static_cast<size_t>(at);
  const size_t high = std::min(low + 1, values.size() - 1);
  if (values[low] == values[high]) return values[low];  // infinite ones, too
  return values[low] + (values[high] - values[low]) * (at - static_cast<double>(low));
}

const std::vector<double>& values_of(const StudyRecord& record, const std::string& measured) {
  const auto found = record.values.find(measured);
  if (found == record.values.end() || found->second.empty())
    throw_internal("a study has no value '" + measured + "'");
  return found->second;
}

void require_measured(const StudyPlan& plan, const StudySettings& settings, const Measurements& measured) {
  std::vector<std::string> names;
  for (const auto& [name, value] : measured) names.push_back(name);
  for (const std::string& wanted : plan.pareto) {
    if (std::find(names.begin(), names.end(), wanted) != names.end()) continue;
    std::string which;
    for (const auto& [name, value] : settings) which += (which.empty() ? "" : ", ") + name + " = " + value;
    throw_input("'" + plan.file + "': 'pareto' names '" + wanted + "', which " + which + " does not measure" +
                did_you_mean(wanted, names) + "; it measures '" + join(names, "', '") + "'");
  }
}

std::string short_number(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, std::abs(value) >= 1e6 || value == std::floor(value) ? "%.0f" : "%.4g", value);
  return buffer;
}

}  // namespace

double StudyRecord::median(const std::string& measured) const { return quantile(values_of(*this, measured), .5); }

double StudyRecord::spread(const std::string& measured) const {
  const auto& runs = values_of(*this, measured);
  return (quantile(runs, .75) - quantile(runs, .25)) / 2;
}

std::vector<std::string> study_names() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(data_folder()) / "studies", error))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

StudyPlan load_study(const std::string& name) {
  StudyPlan plan;
  plan.file = name;
  if (name.find('/') == std::string::npos && !name.ends_with(".toml")) {
    const std::vector<std::string> names = study_names();
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw_usage("no study is called '" + name + "'" + did_you_mean(name, names) + "; there are '" +
                  join(names, "', '") + "', or name a plan's file");
    plan.file = fs::path(data_folder()) / "studies" / (name + ".toml");
  }
  plan.name = fs::path(plan.file).stem().string();
  toml::table root;
  try {
    root = toml::parse(read_text_file(plan.file), plan.file);
  } catch (const toml::parse_error& error) {
    throw_input("'" + plan.file + "' line " + std::to_string(error.source().begin.line) + ": " +
                std::string(error.description()));
  }
  const auto where = [&](const toml::node& node) {
    return "'" + plan.file + "' line " + std::to_string(node.source().begin.line);
  };
  std::set<std::string> settings;
  const auto add_name = [&](const std::string& setting, const toml::node& node) {
    if (!settings.insert(setting).second) throw_input(where(node) + ": the setting '" + setting + "' is given twice");
  };
  for (const auto& [key, node] : root) {
    const std::string k(key.str());
    if (k == "title" || k == "work") {
      const auto text = node.value_exact<std::string>();
      if (!text) throw_input(where(node) + ": '" + k + "' is a string");
      (k == "title" ? plan.title : plan.work) = *text;
    } else if (k == "repeats") {
      const auto count = node.value_exact<int64_t>();
      if (!count || *count < 1 || *count > kMostRepeats)
        throw_input(where(node) + ": 'repeats' is a whole number from 1 to " + std::to_string(kMostRepeats));
      plan.repeats = static_cast<int>(*count);
    } else if ((k == "measure" || k == "pareto" || k == "within") && node.is_array()) {
      auto& names = k == "measure" ? plan.measure : k == "pareto" ? plan.pareto : plan.within;
      for (const auto& element : *node.as_array()) names.push_back(value_text(element, where(node)));
    } else if (k == "fixed" && node.is_table()) {
      for (const auto& [setting, value] : *node.as_table()) {
        add_name(std::string(setting.str()), value);
        plan.fixed.emplace_back(std::string(setting.str()), value_text(value, where(value)));
      }
    } else if (k == "axis" && node.is_array()) {
      for (const auto& element : *node.as_array()) {
        const auto* table = element.as_table();
        StudyPlan::Axis axis;
        if (table) {
          axis.name = (*table)["name"].value_or("");
          if (const auto* values = (*table)["values"].as_array())
            for (const auto& value : *values) axis.values.push_back(value_text(value, where(value)));
        }
        if (!table || axis.name.empty() || axis.values.empty() || table->size() != 2)
          throw_input(where(element) + ": an axis has a 'name' and 'values', at least one, and nothing else");
        add_name(axis.name, element);
        plan.axes.push_back(std::move(axis));
      }
    } else {
      throw_input(where(node) + ": unknown or misshapen '" + k +
                  "'; a study has title, work, repeats, measure, pareto and within = [...], [fixed] and [[axis]]");
    }
  }
  if (plan.work.empty()) throw_input("'" + plan.file + "': 'work' is missing: what is to be run");
  if (plan.axes.empty()) throw_input("'" + plan.file + "': no [[axis]]: a study varies something");
  if (plan.pareto.empty() && !plan.within.empty())
    throw_input("'" + plan.file + "': 'within' groups what 'pareto' compares, and there is no 'pareto'");
  std::vector<std::string> axes;
  for (const auto& axis : plan.axes) axes.push_back(axis.name);
  for (const std::string& group : plan.within)
    if (std::find(axes.begin(), axes.end(), group) == axes.end())
      throw_input("'" + plan.file + "': 'within' names '" + group + "', which is no axis" +
                  did_you_mean(group, axes) + "; there are '" + join(axes, "', '") + "'");
  return plan;
}

std::vector<StudySettings> study_settings(const StudyPlan& plan) {
  std::vector<StudySettings> all{{}};
  for (const auto& axis : plan.axes) {
    std::vector<StudySettings> longer;
    for (const StudySettings& settings : all)
      for (const std::string& value : axis.values) {
        longer.push_back(settings);
        longer.back().emplace_back(axis.name, value);
      }
    all = std::move(longer);
  }
  return all;
}

std::vector<StudyRecord> run_study(const StudyPlan& plan, const std::vector<StudySettings>& settings,
                                   const std::function<Measurements(const StudySettings&)>& work,
                                   const std::function<void(double)>& progress) {
  std::vector<StudyRecord> records(settings.size());
  const double total = static_cast<double>(settings.size()) * (plan.repeats + 1);
  double done = 0;
  for (int repeat = -1; repeat < plan.repeats; ++repeat)
    for (size_t i = 0; i < settings.size(); ++i) {
      check_cancel();
      StudySettings whole = settings[i];
      whole.insert(whole.end(), plan.fixed.begin(), plan.fixed.end());
      const Measurements measured = work(whole);
      if (progress) progress(++done / total);
      if (repeat < 0) {  // caches and clocks warm up
        require_measured(plan, settings[i], measured);
        continue;
      }
      records[i].settings = settings[i];
      for (const auto& [name, value] : measured) {
        auto& values = records[i].values[name];
        if (values.empty()) records[i].order.push_back(name);
        values.push_back(value);
      }
    }
  return records;
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
    const StudyRecord& record = records[r];
    auto& row = rows.emplace_back();
    for (const auto& [name, value] : record.settings) row.push_back(value);
    for (const std::string& column : columns) {
      if (!record.values.contains(column)) {
        row.push_back("-");
        continue;
      }
      const double spread = record.spread(column);
      row.push_back(short_number(record.median(column)) + (spread > 0 ? " ±" + short_number(spread) : ""));
    }
    if (!best.empty()) row.push_back(best[r] ? "*" : "");
  }
  // "±" is two bytes of UTF-8 and one column.
  const auto width = [](const std::string& text) {
    return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
  };
  std::string text = plan.title.empty() ? "" : plan.title + "\n";
  for (const auto& row : rows) {
    for (size_t c = 0; c < row.size(); ++c) {
      size_t widest = 0;
      for (const auto& other : rows) widest = std::max(widest, width(other[c]));
      const std::string blanks(widest - width(row[c]), ' ');
      // Settings to the left, numbers to the right.
      text += (c ? "  " : "") + (c < plan.axes.size() ? row[c] + blanks : blanks + row[c]);
    }
    while (text.back() == ' ') text.pop_back();
    text += "\n";
  }
  return text;
}

std::string study_to_json(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  using Json = nlohmann::ordered_json;
  const auto object = [](const StudySettings& settings) {
    Json json = Json::object();
    for (const auto& [name, value] : settings) json[name] = value;
    return json;
  };
  Json root;
  root["study"] = plan.name;
  root["title"] = plan.title;
  root["work"] = plan.work;
  root["repeats"] = plan.repeats;
  root["fixed"] = object(plan.fixed);
  const std::vector<bool> best = pareto_optimal(plan, records);
  if (!best.empty()) root["pareto"] = {{"measures", plan.pareto}, {"within", plan.within}};
  root["runs"] = Json::array();
  for (size_t r = 0; r < records.size(); ++r) {
    const StudyRecord& record = records[r];
    Json run;
    run["settings"] = object(record.settings);
    run["median"] = run["spread"] = run["values"] = Json::object();
    for (const std::string& name : record.order) {
      run["median"][name] = record.median(name);
      run["spread"][name] = record.spread(name);
      run["values"][name] = record.values.at(name);
    }
    if (!best.empty()) run["pareto"] = static_cast<bool>(best[r]);
    root["runs"].push_back(std::move(run));
  }
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace triad
