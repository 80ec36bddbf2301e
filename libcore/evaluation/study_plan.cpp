// SPDX-License-Identifier: Apache-2.0
#include <toml++/toml.h>
#include <algorithm>
#include <filesystem>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/study.hpp>

namespace fs = std::filesystem;

namespace triad {
namespace {

constexpr int kMostTurns = 1000;  // repeats, and seeds: far beyond what anybody waits for

class PlanReader {
 public:
  explicit PlanReader(StudyPlan& plan) : plan_(plan) {}

  void read() {
    toml::table root;
    try {
      root = toml::parse(read_text_file(plan_.file), plan_.file);
    } catch (const toml::parse_error& error) {
      throw_input("'" + plan_.file + "' line " + std::to_string(error.source().begin.line) + ": " +
                  std::string(error.description()));
    }
    for (const auto& [key, node] : root) read_key(std::string(key.str()), node);
    check();
  }

 private:
  std::string where(const toml::node& node) const {
    return "'" + plan_.file + "' line " + std::to_string(node.source().begin.line);
  }

  std::string value_text(const toml::node& node) const {
    if (const auto text = node.value_exact<std::string>()) return *text;
    if (const auto integer = node.value_exact<int64_t>()) return std::to_string(*integer);
    if (const auto real = node.value_exact<double>()) return format_double(*real);
    if (const auto flag = node.value_exact<bool>()) return *flag ? "true" : "false";
    throw_input(where(node) + ": a setting is a string, a number or a boolean");
  }

  int count(const std::string& key, const toml::node& node) const {
    const auto value = node.value_exact<int64_t>();
    if (!value || *value < 1 || *value > kMostTurns)
      throw_input(where(node) + ": '" + key + "' is a whole number from 1 to " + std::to_string(kMostTurns));
    return static_cast<int>(*value);
  }

  void read_key(const std::string& k, const toml::node& node) {
    if (k == "title" || k == "work") {
      const auto text = node.value_exact<std::string>();
      if (!text) throw_input(where(node) + ": '" + k + "' is a string");
      (k == "title" ? plan_.title : plan_.work) = *text;
    } else if (k == "repeats" || k == "seeds") {
      (k == "repeats" ? plan_.repeats : plan_.seeds) = count(k, node);
    } else if ((k == "measure" || k == "pareto" || k == "within") && node.is_array()) {
      auto& names = k == "measure" ? plan_.measure : k == "pareto" ? plan_.pareto : plan_.within;
      for (const auto& element : *node.as_array()) names.push_back(value_text(element));
    } else if (k == "fixed" && node.is_table()) {
      for (const auto& [setting, value] : *node.as_table()) {
        add_name(std::string(setting.str()), value);
        plan_.fixed.emplace_back(std::string(setting.str()), value_text(value));
      }
    } else if (k == "axis" && node.is_array()) {
      for (const auto& element : *node.as_array()) read_axis(element);
    } else if (k == "faster" && node.is_array()) {
      for (const auto& element : *node.as_array()) {
        const auto texts = read_texts(element, k, {"axis", "first", "second"});
        plan_.faster.push_back({texts[0], texts[1], texts[2]});
      }
    } else if (k == "equal" && node.is_array()) {
      for (const auto& element : *node.as_array()) {
        const auto texts = read_texts(element, k, {"axis", "base", "along", "at", "compare"});
        plan_.equal.push_back({texts[0], texts[1], texts[2], texts[3], texts[4]});
      }
    } else if (k == "published" && node.is_array()) {
      for (const auto& element : *node.as_array()) read_published(element);
    } else {
      throw_input(
          where(node) + ": unknown or misshapen '" + k +
          "'; a study has title, work, repeats, seeds, measure, pareto and within = [...], [fixed], [[axis]], "
          "[[faster]], [[equal]] and [[published]]");
    }
  }

  void add_name(const std::string& setting, const toml::node& node) {
    if (!names_.insert(setting).second) throw_input(where(node) + ": the setting '" + setting + "' is given twice");
  }

  void read_axis(const toml::node& node) {
    const auto* table = node.as_table();
    StudyPlan::Axis axis;
    std::set<std::string> inside;  // settings that tables name: each table may name each once
    if (table) {
      axis.name = (*table)["name"].value_or("");
      if (const auto* values = (*table)["values"].as_array())
        for (const auto& value : *values) read_value(value, axis, inside);
    }
    if (!table || axis.name.empty() || axis.values.empty() || table->size() != 2)
      throw_input(where(node) + ": an axis has a 'name' and 'values', at least one, and nothing else");
    if (!axis.tables.empty() && axis.tables.size() != axis.values.size())
      throw_input(where(node) + ": the values of the axis '" + axis.name + "' are either all tables or none is");
    for (size_t i = 0; i < axis.values.size(); ++i)
      if (std::find(axis.values.begin(), axis.values.begin() + static_cast<long>(i), axis.values[i]) !=
          axis.values.begin() + static_cast<long>(i))
        throw_input(where(node) + ": the axis '" + axis.name + "' has the value '" + axis.values[i] + "' twice");
    if (plan_.find_axis(axis.name)) throw_input(where(node) + ": the axis '" + axis.name + "' is given twice");
    if (axis.tables.empty()) inside.insert(axis.name);
    for (const std::string& setting : inside) add_name(setting, node);
    plan_.axes.push_back(std::move(axis));
  }

  void read_value(const toml::node& value, StudyPlan::Axis& axis, std::set<std::string>& inside) const {
    const auto* table = value.as_table();
    if (!table) {
      axis.values.push_back(value_text(value));
      return;
    }
    StudySettings settings;
    std::string label;
    for (const auto& [key, node] : *table) {
      if (key.str() == "label") {
        label = value_text(node);
        continue;
      }
      settings.emplace_back(std::string(key.str()), value_text(node));
      inside.insert(settings.back().first);
    }
    if (label.empty() || settings.empty())
      throw_input(where(value) + ": a value that is a table has a 'label' and settings");
    axis.values.push_back(label);
    axis.tables.push_back(std::move(settings));
  }

  // The texts of a table that has these keys and, of others, `more`.
  std::vector<std::string> read_texts(const toml::node& node, const std::string& key,
                                      const std::vector<std::string>& wanted, const std::string& more = "") const {
    std::vector<std::string> texts;
    const auto* table = node.as_table();
    if (table)
      for (const std::string& name : wanted) {
        const auto text = (*table)[name].value_exact<std::string>();
        if (text && !text->empty()) texts.push_back(*text);
      }
    if (!table || texts.size() != wanted.size() || table->size() != wanted.size() + !more.empty())
      throw_input(where(node) + ": [[" + key + "]] has " + join(wanted, ", ") + (more.empty() ? "" : " and " + more) +
                  ", the texts in quotes, and nothing else");
    return texts;
  }

  void read_published(const toml::node& node) {
    const auto texts = read_texts(node, "published", {"title", "measure", "rows", "columns", "base"}, "values");
    StudyPlan::Published& published =
        plan_.published.emplace_back(StudyPlan::Published{texts[0], texts[1], texts[2], texts[3], texts[4], {}});
    const auto* values = (*node.as_table())["values"].as_table();
    if (!values) throw_input(where(node) + ": the 'values' of [[published]] are a table of lists, one for each row");
    for (const auto& [row, list] : *values) {
      auto& numbers = published.values.emplace_back(std::string(row.str()), std::vector<double>{}).second;
      if (list.is_array())
        for (const auto& element : *list.as_array()) numbers.push_back(element.value_or(0.));
      if (numbers.empty() || std::any_of(numbers.begin(), numbers.end(), [](double v) { return !(v > 0); }))
        throw_input(where(list) + ": the row '" + std::string(row.str()) + "' is a list of numbers above 0");
    }
  }

  void check() const {
    const std::string file = "'" + plan_.file + "': ";
    if (plan_.work.empty()) throw_input(file + "'work' is missing: what is to be run");
    if (plan_.axes.empty()) throw_input(file + "no [[axis]]: a study varies something");
    if (plan_.pareto.empty() && !plan_.within.empty())
      throw_input(file + "'within' groups what 'pareto' compares, and there is no 'pareto'");
    if (plan_.seeds > 0 && names_.contains("seed"))
      throw_input(file + "'seeds' runs every setting with several values of 'seed', which is set, too");
    for (const std::string& group : plan_.within) check_axis("within", group);
    for (const auto& faster : plan_.faster)
      for (const std::string& value : {faster.first, faster.second}) check_value("faster", faster.axis, value);
    for (const auto& equal : plan_.equal) {
      check_value("equal", equal.axis, equal.base);
      check_axis("equal", equal.along);
      if (equal.along == equal.axis) throw_input(file + "[[equal]] has twice the axis '" + equal.along + "'");
    }
    for (const auto& published : plan_.published) {
      const size_t columns = check_axis("published", published.columns).values.size();
      if (published.rows == published.columns)
        throw_input(file + "[[published]] has twice the axis '" + published.rows + "'");
      check_value("published", published.rows, published.base);
      bool base = false;
      for (const auto& [row, numbers] : published.values) {
        check_value("published", published.rows, row);
        base = base || row == published.base;
        if (numbers.size() != columns)
          throw_input(file + "[[published]] has " + std::to_string(numbers.size()) + " numbers for '" + row +
                      "', and the axis '" + published.columns + "' has " + std::to_string(columns) + " values");
      }
      if (!base) throw_input(file + "[[published]] has no numbers for its base '" + published.base + "'");
    }
  }

  const StudyPlan::Axis& check_axis(const std::string& key, const std::string& name) const {
    std::vector<std::string> names;
    for (const auto& axis : plan_.axes) names.push_back(axis.name);
    const auto* axis = plan_.find_axis(name);
    if (!axis)
      throw_input("'" + plan_.file + "': '" + key + "' names '" + name + "', which is no axis" +
                  did_you_mean(name, names) + "; there are '" + join(names, "', '") + "'");
    return *axis;
  }

  void check_value(const std::string& key, const std::string& name, const std::string& value) const {
    const auto& values = check_axis(key, name).values;
    if (std::find(values.begin(), values.end(), value) == values.end())
      throw_input("'" + plan_.file + "': '" + key + "' names '" + value + "', which is no value of the axis '" +
                  name + "'" + did_you_mean(value, values) + "; there are '" + join(values, "', '") + "'");
  }

  StudyPlan& plan_;
  std::set<std::string> names_;  // of settings
};

}  // namespace

std::map<std::string, std::vector<std::string>> StudyPlan::given() const {
  std::map<std::string, std::vector<std::string>> all;
  for (const auto& [setting, value] : fixed) all[setting].push_back(value);
  for (const Axis& axis : axes) {
    if (axis.tables.empty()) all[axis.name] = axis.values;
    for (const StudySettings& table : axis.tables)
      for (const auto& [setting, value] : table) all[setting].push_back(value);
  }
  return all;
}

const StudyPlan::Axis* StudyPlan::find_axis(const std::string& axis) const {
  for (const Axis& one : axes)
    if (one.name == axis) return &one;
  return nullptr;
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
  PlanReader(plan).read();
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

StudySettings whole_settings(const StudyPlan& plan, const StudySettings& settings) {
  StudySettings whole;
  for (const auto& setting : settings) {
    const auto* axis = plan.find_axis(setting.first);
    if (!axis || axis->tables.empty()) {
      whole.push_back(setting);
      continue;
    }
    const auto at = std::find(axis->values.begin(), axis->values.end(), setting.second) - axis->values.begin();
    const StudySettings& table = axis->tables.at(static_cast<size_t>(at));
    whole.insert(whole.end(), table.begin(), table.end());
  }
  whole.insert(whole.end(), plan.fixed.begin(), plan.fixed.end());
  return whole;
}

}  // namespace triad
