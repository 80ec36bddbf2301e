// SPDX-License-Identifier: Apache-2.0
// What triad convergence found, as text, JSON, CSV and numbers to set thresholds on.
#pragma once

#include <optional>
#include <string>
#include <triad/evaluation/convergence.hpp>
#include <utility>
#include <vector>

#include "convergence_series.hpp"

namespace triad::app {

struct SeriesFit {
  std::optional<PowerLaw> samples, seconds;  // of the score over either
  // Of the squared error over samples, or seconds where samples are not known. free: the rate is fitted, too.
  ErrorFloor floor;
  std::optional<ErrorFloor> floor_free;
  std::optional<Interval> efficiency;  // 1 / (squared error x seconds)
};

// Of a series against the first one, at errors that both reach: the least, the middle (of logarithms), the largest.
struct EqualErrors {
  size_t series = 0;
  struct At {
    double score = 0;
    std::optional<Interval> seconds, samples;  // this series' over the first's
  };
  std::vector<At> at;  // none where they have no error in common
};

struct ConvergenceFindings {
  std::string reference, metric, label, score;
  bool squared = true;  // whether the score is a squared error
  std::optional<double> rate;
  std::vector<Series> series;
  std::vector<SeriesFit> fits;  // as many
  std::vector<EqualErrors> equal;
};

// A floor of the squared error in the score's own terms.
Interval floor_of_score(const ConvergenceFindings& findings, const ErrorFloor& floor);

std::string convergence_to_text(const ConvergenceFindings& findings);
std::string convergence_to_json(const ConvergenceFindings& findings);
// One line per picture: series,file,samples,seconds,<score>,squared_error,efficiency; RFC 4180.
std::string convergence_to_csv(const ConvergenceFindings& findings);

// The numbers that --fail-above and --fail-below know.
const std::vector<std::string>& convergence_threshold_names();
// Each with the series it belongs to: (name, number), all of that threshold's name.
std::vector<std::pair<std::string, double>> convergence_numbers(const ConvergenceFindings& findings,
                                                                const std::string& name);

}  // namespace triad::app
