// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <triad/evaluation/study_comparisons.hpp>

namespace triad {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kSignificance = .05;  // of the one-tailed test

const std::string& value_on(const StudyRecord& record, const std::string& axis) {
  static const std::string kNone;
  for (const auto& [name, value] : record.settings)
    if (name == axis) return value;
  return kNone;
}

// The settings on all axes but these.
StudySettings others(const StudyRecord& record, const std::vector<std::string>& axes) {
  StudySettings rest;
  for (const auto& setting : record.settings)
    if (std::find(axes.begin(), axes.end(), setting.first) == axes.end()) rest.push_back(setting);
  return rest;
}

// Each once, in order.
std::vector<StudySettings> groups(const std::vector<StudyRecord>& records, const std::vector<std::string>& axes) {
  std::vector<StudySettings> all;
  for (const StudyRecord& record : records) {
    StudySettings rest = others(record, axes);
    if (std::find(all.begin(), all.end(), rest) == all.end()) all.push_back(std::move(rest));
  }
  return all;
}

// Those of a group that have `value` on `axis`.
std::vector<const StudyRecord*> select(const std::vector<StudyRecord>& records, const StudySettings& group,
                                       const std::vector<std::string>& axes, const std::string& axis,
                                       const std::string& value) {
  std::vector<const StudyRecord*> found;
  for (const StudyRecord& record : records)
    if (value_on(record, axis) == value && others(record, axes) == group) found.push_back(&record);
  return found;
}

using Curve = std::vector<std::pair<double, double>>;  // logarithms

double interpolate(Curve curve, double at) {
  if (std::any_of(curve.begin(), curve.end(),
                  [](const auto& p) { return !std::isfinite(p.first) || !std::isfinite(p.second); }))
    return kNan;
  std::sort(curve.begin(), curve.end());
  for (size_t i = 0; i < curve.size(); ++i) {
    if (curve[i].first == at) return curve[i].second;
    if (i + 1 == curve.size() || !(curve[i].first < at && at < curve[i + 1].first)) continue;
    const double share = (at - curve[i].first) / (curve[i + 1].first - curve[i].first);
    return curve[i].second + share * (curve[i + 1].second - curve[i].second);
  }
  return kNan;
}

std::string text_of(const StudySettings& settings) {
  std::string text;
  for (const auto& [name, value] : settings) text += (text.empty() ? "" : ", ") + name + " = " + value;
  return text;
}

std::string ratio_text(double ratio) { return std::isfinite(ratio) ? fmt::format("{:.3g}", ratio) : "-"; }

std::string faster_text(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  std::vector<std::vector<std::string>> rows{{"takes fewer seconds?", "of", "ratio", "t", "freedom", "p", "at 5 %"}};
  for (const FasterResult& result : compare_seconds(plan, records))
    rows.push_back({result.first + " than " + result.second, text_of(result.where), ratio_text(result.ratio),
                    ratio_text(result.test.t), ratio_text(result.test.freedom), ratio_text(result.test.p),
                    std::isnan(result.test.p)       ? "-"
                    : result.test.p < kSignificance ? "yes"
                                                    : "no"});
  return "\n" + aligned_columns(rows, 2);
}

std::string equal_text(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  std::string text;
  const auto results = compare_at_equal(plan, records);
  for (size_t e = 0; e < plan.equal.size(); ++e) {
    const auto& equal = plan.equal[e];
    std::vector<std::vector<std::string>> rows(1);
    rows[0] = {equal.axis, ""};
    for (const std::string& along : plan.find_axis(equal.along)->values) rows[0].push_back(along);
    for (const EqualResult& result : results) {
      if (result.equal != e) continue;
      const std::string where = text_of(result.where);
      if (rows.back()[0] != result.value || rows.back()[1] != where || rows.size() == 1)
        rows.push_back({result.value, where});
      rows.back().push_back(ratio_text(result.ratio));
    }
    text += "\n" + equal.compare + " relative to " + equal.base + "'s at equal " + equal.at + ", by " + equal.along +
            " of " + equal.base + "\n" + aligned_columns(rows, 2);
  }
  return text;
}

std::string published_text(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  std::string text;
  const auto results = compare_published(plan, records);
  for (size_t p = 0; p < plan.published.size(); ++p) {
    const auto& published = plan.published[p];
    text +=
        "\n" + published.title + ": " + published.measure + " relative to " + published.base + ", ours (published)\n";
    std::vector<std::vector<std::string>> rows(1);
    rows[0] = {published.rows, ""};
    for (const std::string& column : plan.find_axis(published.columns)->values) rows[0].push_back(column);
    for (const PublishedResult& result : results) {
      if (result.published != p) continue;
      const std::string where = text_of(result.where);
      if (rows.size() == 1 || rows.back()[0] != result.row || rows.back()[1] != where)
        rows.push_back({result.row, where});
      rows.back().push_back(ratio_text(result.ours) + " (" + ratio_text(result.theirs) + ")");
    }
    text += aligned_columns(rows, 2);
  }
  return text;
}

}  // namespace

std::vector<FasterResult> compare_seconds(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  std::vector<FasterResult> results;
  for (const auto& faster : plan.faster)
    for (const StudySettings& group : groups(records, {faster.axis})) {
      const auto first = select(records, group, {faster.axis}, faster.axis, faster.first);
      const auto second = select(records, group, {faster.axis}, faster.axis, faster.second);
      if (first.empty() || second.empty()) continue;
      results.push_back({faster.first, faster.second, group,
                         first[0]->median("seconds") / second[0]->median("seconds"),
                         test_less(first[0]->values.at("seconds"), second[0]->values.at("seconds"))});
    }
  return results;
}

std::vector<EqualResult> compare_at_equal(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  std::vector<EqualResult> results;
  for (size_t e = 0; e < plan.equal.size(); ++e) {
    const auto& equal = plan.equal[e];
    const std::vector<std::string> axes{equal.axis, equal.along};
    for (const StudySettings& group : groups(records, axes)) {
      const auto base = select(records, group, axes, equal.axis, equal.base);
      for (const std::string& value : plan.find_axis(equal.axis)->values) {
        if (value == equal.base) continue;
        Curve curve;
        for (const StudyRecord* record : select(records, group, axes, equal.axis, value))
          curve.emplace_back(std::log(record->shown(equal.at)), std::log(record->shown(equal.compare)));
        for (const StudyRecord* one : base) {
          const double there = interpolate(curve, std::log(one->shown(equal.at)));
          results.push_back(
              {e, value, value_on(*one, equal.along), group, std::exp(there - std::log(one->shown(equal.compare)))});
        }
      }
    }
  }
  return results;
}

std::vector<PublishedResult> compare_published(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  std::vector<PublishedResult> results;
  for (size_t p = 0; p < plan.published.size(); ++p) {
    const auto& published = plan.published[p];
    const std::vector<std::string> axes{published.rows, published.columns};
    const auto& columns = plan.find_axis(published.columns)->values;
    const auto theirs = [&](const std::string& row) {
      return std::find_if(published.values.begin(), published.values.end(),
                          [&](const auto& values) { return values.first == row; });
    };
    const auto ours = [&](const StudySettings& group, const std::string& row, const std::string& column) {
      for (const StudyRecord* record : select(records, group, axes, published.rows, row))
        if (value_on(*record, published.columns) == column) return record->shown(published.measure);
      return kNan;
    };
    for (const StudySettings& group : groups(records, axes))
      for (const std::string& row : plan.find_axis(published.rows)->values) {
        const auto found = theirs(row);
        if (found == published.values.end()) continue;
        for (size_t c = 0; c < columns.size(); ++c)
          results.push_back({p, row, columns[c], group,
                             ours(group, row, columns[c]) / ours(group, published.base, columns[c]),
                             found->second[c] / theirs(published.base)->second[c]});
      }
  }
  return results;
}

std::string comparisons_text(const StudyPlan& plan, const std::vector<StudyRecord>& records) {
  return (plan.faster.empty() ? "" : faster_text(plan, records)) + equal_text(plan, records) +
         published_text(plan, records);
}

}  // namespace triad
