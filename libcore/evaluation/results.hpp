// SPDX-License-Identifier: Apache-2.0
// Scores as tables, JSON and CSV, and thresholds on them.
#pragma once

#include <string>
#include <triad/pipeline/run.hpp>
#include <vector>

namespace triad {

// {"results":[{"test","reference","metric","label","parameters":{},"scores":{},"better":{},"pooled":{},"reports":{},
// "series":{},"nan","inf","seconds"}], "runs":[...]} with two blanks of indentation and a line break at the end.
// An infinite number is the string "inf" or "-inf". "runs", one per picture: {"input","output","seconds",
// "stages":[{"stage","seconds","reports":{}}],"nan","inf"}; left out when `runs` is empty. "pooled", where there is
// something pooled: {"scores":{},"min-at":[x,y],"min-channel","max-at":[x,y],"max-channel","values","weight",
// "histogram":{"low","high","counts":[]}}.
struct RunRecord {
  std::string input, output;
  RunResult result;
};
// File names keep the bytes that are no UTF-8 as "\xNN" (escape_non_utf8()).
std::string results_to_json(const std::vector<MetricResult>& results, const std::vector<RunRecord>& runs = {});

// One line per result and score: test,reference,metric,label,score,value,better,nan,inf,seconds; RFC 4180. Pooled
// scores follow the metric's own, but for those that have the name of one of its own.
std::string results_to_csv(const std::vector<MetricResult>& results);

// A pooled score that somebody wants to see.
struct PooledName {
  std::string label, score;  // label "": of every metric
};

// For the terminal: a line per test and metric, its own scores and those of `pooled`. Ends with a line break.
std::string results_to_table(const std::vector<MetricResult>& results, const std::vector<PooledName>& pooled = {});

// "LABEL.SCORE=VALUE"
struct Threshold {
  std::string label, score, text;
  double value = 0;
  bool above = true;  // fail when the score is above the value (or below it)
};
// Throws Error(kUsage) naming `option`.
Threshold parse_threshold(const std::string& text, bool above);
// Throws Error(kUsage) if no metric has that label, or neither the metric itself nor pooled_score_names() that score,
// naming what there is.
void check_threshold_names(const std::vector<Threshold>& thresholds, const std::vector<ChainItem>& metrics,
                           PluginHost& host);

// Pooled scores that are named: by `names` ("p95,p99", "all", as given to `--pool`; "" none) for every metric, by a
// threshold (whose metric has no score of its own by that name) for its metric. RunRequest::pool is needed when there
// is one. Thresholds must have passed check_threshold_names. Throws Error(kUsage) listing what can be named.
std::vector<PooledName> named_pooled_scores(const std::string& names, const std::vector<Threshold>& thresholds,
                                            const std::vector<ChainItem>& metrics, PluginHost& host);
// For MetricRequest::pooled_by_name: the first threshold that names a pooled score of the metric labelled so, else
// "".
std::string pooled_by_threshold(const std::string& label, const std::vector<PooledName>& pooled,
                                const std::vector<Threshold>& thresholds);

// A line for each threshold that is crossed: "x.exr: display.rmse is 0.31, above 0.2". A metric's own scores go
// before pooled ones of the same name. A pooled score that has no value (no pixel to pool, a map with negative
// values) fails.
std::vector<std::string> failed_thresholds(const std::vector<Threshold>& thresholds,
                                           const std::vector<MetricResult>& results);

}  // namespace triad
