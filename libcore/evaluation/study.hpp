// SPDX-License-Identifier: Apache-2.0
// A study: the same work with different settings, run in turns and several times over, so that a slow minute of
// the machine hits all settings alike.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
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
//   repeats = 5                # of each setting and seed
//   seeds = 3                  # each repeat is one run with the setting seed = 0, one with 1 and one with 2
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
//
//   [[axis]]                   # a value may stand for several settings, and is called by its label
//   name = "method"
//   values = [{label = "plain", strategy = "control"}, {label = "fine", strategy = "grid:n=4", cells = "3x1"}]
//
//   [[faster]]                 # does one value of an axis take fewer seconds than another? A one-tailed test for
//   axis = "method"            # each combination of the other axes
//   first = "plain"
//   second = "fine"
//
//   [[equal]]                  # for each value of an axis, what it has of `compare` where it has as much of `at` as
//   axis = "method"            # `base` has, between its settings on the axis `along`
//   base = "plain"
//   along = "spp"
//   at = "seconds"
//   compare = "rmse"
//
//   [[published]]              # someone's figures, printed beside ours, both as ratios to the row `base`
//   title = "Table 1 of ..."
//   measure = "rmse"           # what of ours they are compared with
//   rows = "method"            # an axis
//   columns = "scene"          # another: a number for each of its values
//   base = "plain"
//   values = {plain = [1.5, 2], fine = [1, 1.5]}
struct StudyPlan {
  std::string name, title, work, file;
  int repeats = 5;
  int seeds = 0;  // 0: not set, and the work has its own
  std::vector<std::string> measure, pareto, within;
  StudySettings fixed;
  struct Axis {
    std::string name;
    std::vector<std::string> values;      // labels, where they stand for several settings
    std::vector<StudySettings> tables{};  // then, one for each; else empty
  };
  std::vector<Axis> axes;
  struct Faster {
    std::string axis, first, second;
  };
  std::vector<Faster> faster;
  struct Equal {
    std::string axis, base, along, at, compare;
  };
  std::vector<Equal> equal;
  struct Published {
    std::string title, measure, rows, columns, base;
    std::vector<std::pair<std::string, std::vector<double>>> values;  // by row
  };
  std::vector<Published> published;

  // Runs of each setting that count.
  int turns() const { return repeats * (seeds > 0 ? seeds : 1); }
  // Every setting's name with all its values, of [fixed], axes and tables.
  std::map<std::string, std::vector<std::string>> given() const;
  // Null if there is none of that name.
  const Axis* find_axis(const std::string& axis) const;
};

// `name`: a file, or the name of a bundled plan ("effects" is data/studies/effects.toml). Throws Error(kInput)
// with file and line: unknown keys, no axis, an axis without values, a setting given twice, repeats or seeds out of
// 1..1000, axes and values that are not there.
StudyPlan load_study(const std::string& name);
// The bundled plans' names, sorted.
std::vector<std::string> study_names();

// What one run of one setting measured: "seconds" and counts.
using Measurements = std::vector<std::pair<std::string, double>>;

struct StudyRecord {
  StudySettings settings;                             // of the axes, with labels for what stands for several
  std::map<std::string, std::vector<double>> values;  // measured name -> one value for each counted run
  std::vector<std::string> order;                     // the measured names as they were reported
  int seeds = 1;                                      // run i had the seed i % seeds

  double median(const std::string& measured) const;
  // Half the range between the quartiles.
  double spread(const std::string& measured) const;
  // One value for each seed, the mean of its runs; all runs where there is but one seed.
  std::vector<double> samples(const std::string& measured) const;
  // What tables show: the median of times (names that end in "seconds"), and of all where there is one seed; else the
  // mean over seeds.
  double shown(const std::string& measured) const;
};
bool is_time(const std::string& measured);

// The combinations of the axes, the last axis turning fastest.
std::vector<StudySettings> study_settings(const StudyPlan& plan);
// What `settings`, a combination of the axes, makes the work do: labels replaced by what they stand for, and the
// fixed settings.
StudySettings whole_settings(const StudyPlan& plan, const StudySettings& settings);

// One of plan.turns() runs of the settings number `setting`.
struct StudyTurn {
  size_t setting = 0;
  int turn = 0;
};
struct StudyRunner {
  // Is given whole_settings(), and {"seed", "2"} if plan.seeds is set.
  std::function<Measurements(const StudySettings&, const StudyTurn&)> work;
  bool warm_up = true;                                                   // a turn that is not counted, first
  std::function<std::optional<Measurements>(const StudyTurn&)> known{};  // of an earlier run, which is not repeated
  std::function<void(const StudyTurn&, const Measurements&)> keep{};     // told after each run
  std::function<void(double)> progress{};                                // share done in [0, 1] of what is not known
};

// Runs the work plan.turns() times in turns: all settings, then all again. Throws what the runner throws, and
// Error(kInput) as soon as a setting measures nothing of a name that the plan compares by (pareto, equal, published,
// faster), and after the first counted turn if none of them measures one of plan.measure.
std::vector<StudyRecord> run_study(const StudyPlan& plan, const std::vector<StudySettings>& settings,
                                   const StudyRunner& runner);

// For each record whether it is Pareto-optimal: among the records that share its values on the axes plan.within,
// none has values shown that are all at most as large, in the measures plan.pareto, and one that is smaller. Records
// that tie in every measure do not beat each other. Empty if plan.pareto is. A NaN beats nothing and is never marked.
std::vector<bool> pareto_optimal(const StudyPlan& plan, const std::vector<StudyRecord>& records);

// Columns of settings, then for each measured name its median, and its spread where runs differ; where there are
// seeds, its mean and half the width of its 95 % confidence interval instead, times apart. With plan.pareto, a column
// "best" in which * marks the Pareto-optimal. Below, what the plan compares (study_comparisons.hpp).
std::string study_table(const StudyPlan& plan, const std::vector<StudyRecord>& records);
// {"study","title","work","repeats","seeds","measure":[],"fixed":{},"pareto":{"measures":[],"within":[]},
// "runs":[{"settings":{},"median":{},"spread":{},"mean":{},"interval95":{},"values":{},"pareto"}],"faster":[],
// "equal":[],"published":[]}; "seeds" if the plan has them, "pareto" with plan.pareto only, that of a run true or
// false, "mean" and "interval95" (half its width, over seeds or runs) where there are two values at least, the last
// three if the plan asks for them. A number that is not finite is null.
std::string study_to_json(const StudyPlan& plan, const std::vector<StudyRecord>& records);

}  // namespace triad
