// SPDX-License-Identifier: Apache-2.0
// What a plan wants to be compared beyond its table: seconds by a test, methods at equal cost, published figures.
#pragma once

#include <triad/evaluation/study.hpp>
#include <triad/evaluation/study_statistics.hpp>

namespace triad {

// [[faster]] for one combination of the other axes, `where`.
struct FasterResult {
  std::string first, second;
  StudySettings where;
  double ratio = 0;   // of the medians of the seconds, first to second
  LessThanTest test;  // over all runs
};
std::vector<FasterResult> compare_seconds(const StudyPlan& plan, const std::vector<StudyRecord>& records);

// [[equal]] for one value of its axis, one of the base's settings along, and one combination of the other axes.
struct EqualResult {
  size_t equal = 0;  // which of plan.equal
  std::string value, along;
  StudySettings where;
  // What `value` has of `compare`, over what the base has, where it has as much of `at`: interpolated between its own
  // settings, linearly in the logarithms of both. NaN past both ends of its settings, or where a figure is not above
  // 0.
  double ratio = 0;
};
std::vector<EqualResult> compare_at_equal(const StudyPlan& plan, const std::vector<StudyRecord>& records);

// [[published]], as a table for a terminal: in each column our ratio to the base and, in brackets, the published one.
// Records that differ on a third axis give a table each.
struct PublishedResult {
  size_t published = 0;  // which of plan.published
  std::string row, column;
  StudySettings where;
  double ours = 0, theirs = 0;  // ratios to the base
};
std::vector<PublishedResult> compare_published(const StudyPlan& plan, const std::vector<StudyRecord>& records);

// All of them as text, empty if the plan asks for none.
std::string comparisons_text(const StudyPlan& plan, const std::vector<StudyRecord>& records);

// Lines of columns: the first `left` to the left, the others to the right, two blanks between them.
std::string aligned_columns(const std::vector<std::vector<std::string>>& rows, size_t left);
std::string short_number(double value);  // four digits; whole numbers and those from 1e6 in full

}  // namespace triad
