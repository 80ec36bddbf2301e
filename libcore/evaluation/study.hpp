// SPDX-License-Identifier: Apache-2.0
// A study: the same work with different settings, run in turns and several times over, so that a slow minute of
// the machine hits all settings alike.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace triad {

// Setting names and values, in the plan's order.
using StudySettings = std::vector<std::pair<std::string, std::string>>;

// A plan in TOML:
//
//   title = "What each effect costs"
//   work = "render"            # what is run
//   repeats = 5                # of each setting, after one that is not counted
//   measure = ["seconds"]      # columns of the table: names that the work reports; {}: all
//   pareto = ["seconds", "rmse"]  # marks the settings that none beats in one of these and equals in the others,
//   within = ["scene"]            # among those that have the same values on these axes; {}: among all
//
//   [fixed]                    # settings that all runs share
//   size = "200x112"
//
//   [[axis]]                   # every combination of the axes' values is one setting
//   name = "scene"
//   values = ["cornell.gltf", "room.glb"]
struct StudyPlan {
  std::string name, title, work, file;
  int repeats = 5;
  std::vector<std::string> measure, pareto, within;
  StudySettings fixed;
  struct Axis {
    std::string name;
    std::vector<std::string> values;
  };
  std::vector<Axis> axes;
};

// `name`: a file, or the name of a bundled plan ("effects" is data/studies/effects.toml). Throws Error(kInput)
// with file and line: unknown keys, no axis, an axis without values, a setting given twice, repeats out of 1..1000.
StudyPlan load_study(const std::string& name);
// The bundled plans' names, sorted.
std::vector<std::string> study_names();

// What one run of one setting measured: "seconds" and counts. Values that are the same in every run (counts)
// show their one value, others median and spread.
using Measurements = std::vector<std::pair<std::string, double>>;

struct StudyRecord {
  StudySettings settings;                             // of the axes
  std::map<std::string, std::vector<double>> values;  // measured name -> one value for each counted run
  std::vector<std::string> order;                     // the measured names as they were reported
  double median(const std::string& measured) const;
  // Half the range between the quartiles.
  double spread(const std::string& measured) const;
};

// The combinations of the axes, the last axis turning fastest.
std::vector<StudySettings> study_settings(const StudyPlan& plan);

// Runs `work` for each of `settings` (fixed settings appended) once without counting, then plan.repeats times in
// turns: all settings, then all again. progress: share done in [0, 1]. Throws what `work` throws, and Error(kInput)
// as soon as a setting measures nothing of a name in plan.pareto.
std::vector<StudyRecord> run_study(const StudyPlan& plan, const std::vector<StudySettings>& settings,
                                   const std::function<Measurements(const StudySettings&)>& work,
                                   const std::function<void(double)>& progress = {});

// For each record whether it is Pareto-optimal: among the records that share its values on the axes plan.within,
// none has medians that are all at most as large, in the measures plan.pareto, and one that is smaller. Records
// that tie in every measure do not beat each other. Empty if plan.pareto is. A NaN beats nothing and is never marked.
std::vector<bool> pareto_optimal(const StudyPlan& plan, const std::vector<StudyRecord>& records);

// Columns of settings, then for each measured name its median, and its spread where runs differ; with plan.pareto,
// a column "best" in which * marks the Pareto-optimal.
std::string study_table(const StudyPlan& plan, const std::vector<StudyRecord>& records);
// {"study","title","work","repeats","fixed":{},"pareto":{"measures":[],"within":[]},
// "runs":[{"settings":{},"median":{},"spread":{},"values":{},"pareto"}]}; both "pareto" with plan.pareto only, that
// of a run true or false. A number that is not finite is null.
std::string study_to_json(const StudyPlan& plan, const std::vector<StudyRecord>& records);

}  // namespace triad
