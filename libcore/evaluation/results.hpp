// SPDX-License-Identifier: Apache-2.0
// Scores as tables, JSON and CSV, and thresholds on them.
#pragma once

#include <string>
#include <triad/pipeline/run.hpp>
#include <vector>

namespace triad {

// {"results":[{"test","reference","metric","label","parameters":{},"scores":{},"better":{},"reports":{},
// "series":{},"nan","inf","seconds"}], "runs":[...]} with two blanks of indentation and a line break at the end.
// An infinite number is the string "inf" or "-inf". "runs", one per picture: {"input","output","seconds",
// "stages":[{"stage","seconds","reports":{}}],"nan","inf"}; left out when `runs` is empty.
struct RunRecord {
  std::string input, output;
  RunResult result;
};
std::string results_to_json(const std::vector<MetricResult>& results, const std::vector<RunRecord>& runs = {});

// One line per result and score: test,reference,metric,label,score,value,better,nan,inf,seconds; RFC 4180.
std::string results_to_csv(const std::vector<MetricResult>& results);

// For the terminal: a line per test and metric, a column per score. Ends with a line break.
std::string results_to_table(const std::vector<MetricResult>& results);

// "LABEL.SCORE=VALUE"
struct Threshold {
  std::string label, score, text;
  double value = 0;
  bool above = true;  // fail when the score is above the value (or below it)
};
// Throws Error(kUsage) naming `option`.
Threshold parse_threshold(const std::string& text, bool above);
// Throws Error(kUsage) if no metric has that label or score, naming what there is.
void check_threshold_names(const std::vector<Threshold>& thresholds, const std::vector<ChainItem>& metrics,
                           PluginHost& host);
// A line for each threshold that is crossed: "x.exr: display.rmse is 0.31, above 0.2".
std::vector<std::string> failed_thresholds(const std::vector<Threshold>& thresholds,
                                           const std::vector<MetricResult>& results);

}  // namespace triad
