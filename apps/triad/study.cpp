// SPDX-License-Identifier: Apache-2.0
// triad study PLAN
#include <iostream>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/parallel.hpp>
#include <triad/evaluation/study.hpp>

#include "options.hpp"
#include "study_work.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

struct StudyOptions {
  std::string plan, json;
  int repeats = 0, threads = 0;
};

void study(const StudyOptions& options) {
  if (options.threads > 0) set_thread_limit(options.threads);
  StudyPlan plan = load_study(options.plan);
  if (options.repeats > 0) plan.repeats = options.repeats;
  const auto work = make_study_work(plan);
  const std::vector<StudySettings> settings = work->expand(study_settings(plan));
  Progress progress("study " + plan.name);
  const auto records = run_study(
      plan, settings, [&](const StudySettings& s) { return work->run(s); },
      [&](double done) { progress.update(done); });
  if (options.json != "-") std::cout << study_table(plan, records) << std::flush;
  if (!options.json.empty()) write_text_file(options.json, study_to_json(plan, records));
}

}  // namespace

void setup_study(CLI::App& app) {
  auto options = std::make_shared<StudyOptions>();
  CLI::App* verb = app.add_subcommand("study", "Measure what settings cost: runs in turns, medians, a table");
  verb->add_option("plan", options->plan, "A bundled plan's name, or a plan's TOML file")
      ->required()
      ->type_name("PLAN");
  verb->add_option("--repeats", options->repeats, "Counted runs of each setting (default: the plan's)")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  verb->add_option("--threads", options->threads, "Threads (default: all cores)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  verb->add_option("--json", options->json, "Write the results as JSON; - for standard output")->type_name("FILE");
  verb->footer(
      "Examples:\n  triad study effects --repeats 3 --json effects.json\n  triad study filter\nNumbers are medians, "
      "± "
      "half the range between the quartiles; * marks settings that no other beats in all that the plan compares.");
  verb->callback([options] { study(*options); });
}

}  // namespace triad::app
