// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/text.hpp>
#include <triad/evaluation/study.hpp>
#include <triad/evaluation/study_statistics.hpp>

namespace triad {
namespace {

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
  const auto require = [&](const std::string& key, const std::string& wanted) {
    if (std::find(names.begin(), names.end(), wanted) != names.end()) return;
    std::string which;
    for (const auto& [name, value] : settings) which += (which.empty() ? "" : ", ") + name + " = " + value;
    throw_input("'" + plan.file + "': '" + key + "' names '" + wanted + "', which " + which + " does not measure" +
                did_you_mean(wanted, names) + "; it measures '" + join(names, "', '") + "'");
  };
  for (const std::string& wanted : plan.pareto) require("pareto", wanted);
  if (!plan.faster.empty()) require("faster", "seconds");
  for (const auto& published : plan.published) require("published", published.measure);
  for (const auto& equal : plan.equal) {
    require("equal", equal.at);
    require("equal", equal.compare);
  }
}

// A column that some settings measure and others do not is fine; one that none does is a mistake.
void require_columns(const StudyPlan& plan, const std::set<std::string>& measured) {
  const std::vector<std::string> names(measured.begin(), measured.end());
  for (const std::string& wanted : plan.measure)
    if (!measured.contains(wanted))
      throw_input("'" + plan.file + "': 'measure' names '" + wanted + "', which nothing in this study measures" +
                  did_you_mean(wanted, names) + "; it measures '" + join(names, "', '") + "'");
}

}  // namespace

bool is_time(const std::string& measured) { return measured.ends_with("seconds"); }

double StudyRecord::median(const std::string& measured) const { return quantile(values_of(*this, measured), .5); }

double StudyRecord::spread(const std::string& measured) const {
  const auto& runs = values_of(*this, measured);
  return (quantile(runs, .75) - quantile(runs, .25)) / 2;
}

std::vector<double> StudyRecord::samples(const std::string& measured) const {
  const auto& runs = values_of(*this, measured);
  const auto count = static_cast<size_t>(seeds);
  if (count <= 1 || runs.size() < count) return runs;
  std::vector<double> means;
  for (size_t seed = 0; seed < count; ++seed) {
    std::vector<double> own;
    for (size_t i = seed; i < runs.size(); i += count) own.push_back(runs[i]);
    means.push_back(mean_of(own));
  }
  return means;
}

double StudyRecord::shown(const std::string& measured) const {
  return seeds > 1 && !is_time(measured) ? mean_of(samples(measured)) : median(measured);
}

std::vector<StudyRecord> run_study(const StudyPlan& plan, const std::vector<StudySettings>& settings,
                                   const StudyRunner& runner) {
  const int seeds = std::max(plan.seeds, 1);
  std::vector<std::vector<std::optional<Measurements>>> known(settings.size());
  std::vector<bool> whole(settings.size(), true);
  double total = 0, done = 0;
  for (size_t i = 0; i < settings.size(); ++i)
    for (int turn = 0; turn < plan.turns(); ++turn) {
      known[i].push_back(runner.known ? runner.known({i, turn}) : std::nullopt);
      if (known[i].back()) continue;
      whole[i] = false;
      ++total;
    }
  if (runner.warm_up) total += static_cast<double>(std::count(whole.begin(), whole.end(), false));
  std::vector<StudyRecord> records(settings.size());
  std::set<std::string> names;
  for (int turn = runner.warm_up ? -1 : 0; turn < plan.turns(); ++turn) {
    for (size_t i = 0; i < settings.size(); ++i) {
      check_cancel();
      const bool counted = turn >= 0, there = counted ? known[i][static_cast<size_t>(turn)].has_value() : whole[i];
      Measurements measured;
      if (there && counted) {
        measured = *known[i][static_cast<size_t>(turn)];
      } else if (!there) {
        StudySettings given = whole_settings(plan, settings[i]);
        if (plan.seeds > 0) given.emplace_back("seed", std::to_string(std::max(turn, 0) % seeds));
        measured = runner.work(given, {i, turn});
        if (counted && runner.keep) runner.keep({i, turn}, measured);
        if (runner.progress) runner.progress(++done / total);
      } else {
        continue;
      }
      if (turn <= 0) require_measured(plan, settings[i], measured);
      for (const auto& [name, value] : measured) names.insert(name);
      if (!counted) continue;  // caches and clocks warm up
      records[i].settings = settings[i];
      records[i].seeds = seeds;
      for (const auto& [name, value] : measured) {
        auto& values = records[i].values[name];
        if (values.empty()) records[i].order.push_back(name);
        values.push_back(value);
      }
    }
    if (turn == 0) require_columns(plan, names);
  }
  return records;
}

}  // namespace triad
