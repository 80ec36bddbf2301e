// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/evaluation/study.hpp>

namespace triad {
namespace {

// What records have in common that are compared with each other.
std::vector<std::string> group_of(const StudyPlan& plan, const StudyRecord& record) {
  std::vector<std::string> values;
  for (const auto& [name, value] : record.settings)
    if (std::find(plan.within.begin(), plan.within.end(), name) != plan.within.end()) values.push_back(value);
  return values;
}

bool beats(const std::vector<double>& a, const std::vector<double>& b) {
  bool smaller = false;
  for (size_t i = 0; i < a.size(); ++i) {
    if (!(a[i] <= b[i])) return false;
    smaller = smaller || a[i] < b[i];
  }
  return smaller;
}

}  // namespace

std::vector<bool> pareto_optimal(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  if (plan.pareto.empty()) return {};
  std::vector<std::vector<std::string>> groups;
  std::vector<std::vector<double>> shown;
  for (const StudyRecord& record : records) {
    groups.push_back(group_of(plan, record));
    auto& values = shown.emplace_back();
    for (const std::string& name : plan.pareto) values.push_back(record.shown(name));
  }
  std::vector<bool> best(records.size());
  for (size_t i = 0; i < records.size(); ++i) {
    const bool number = std::none_of(shown[i].begin(), shown[i].end(), [](double v) { return std::isnan(v); });
    bool beaten = false;
    for (size_t j = 0; j < records.size() && !beaten; ++j)
      beaten = groups[j] == groups[i] && beats(shown[j], shown[i]);
    best[i] = number && !beaten;
  }
  return best;
}

}  // namespace triad
