// SPDX-License-Identifier: Apache-2.0
// triad study PLAN
#include <filesystem>
#include <iostream>
#include <optional>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/parallel.hpp>
#include <triad/evaluation/study_folder.hpp>

#include "options.hpp"
#include "study_files.hpp"
#include "study_work.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

struct StudyOptions {
  std::string plan, json, folder;
  int repeats = 0, seeds = 0, threads = 0;
};

void study(const StudyOptions& options) {
  if (options.threads > 0) set_thread_limit(options.threads);
  StudyPlan plan = load_study(options.plan);
  if (options.repeats > 0) plan.repeats = options.repeats;
  if (options.seeds > 0) {
    if (plan.given().contains("seed"))
      throw_usage("--seeds runs every setting with several values of 'seed', which '" + plan.file + "' sets");
    plan.seeds = options.seeds;
  }
  if (!options.json.empty()) check_text_file(options.json);
  const auto work = make_study_work(plan, options.folder.empty() ? "" : StudyFolder::references(options.folder));
  const std::vector<StudySettings> settings = naming_plan(plan, [&] { return work->expand(study_settings(plan)); });
  std::vector<StudySettings> wholes;
  for (const StudySettings& one : settings) wholes.push_back(whole_settings(plan, one));
  for (const StudySettings& whole : wholes) naming_plan(plan, [&] { work->check(whole); });
  const StudyFiles files = naming_plan(plan, [&] { return study_files(plan, wholes); });
  check_json_path(options.json, plan, files, options.folder);

  std::optional<StudyFolder> folder;
  if (!options.folder.empty())
    folder.emplace(options.folder, plan, settings,
                   StudySettings{{"version", TRIAD_VERSION}, {"threads", std::to_string(thread_limit())}},
                   file_contents(files));
  Progress progress("study " + plan.name);
  StudyRunner runner;
  runner.work = [&](const StudySettings& whole, const StudyTurn& turn) {
    return naming_plan(
        plan, [&] { return work->run(whole, folder && turn.turn == 0 ? folder->picture(turn.setting) : ""); });
  };
  runner.warm_up = !work->is_warm();
  runner.progress = [&](double done) { progress.update(done); };
  if (folder) {
    // A run whose picture was removed is made again, picture and all.
    runner.known = [&](const StudyTurn& turn) {
      const bool is_whole =
          !work->makes_pictures() || turn.turn > 0 || std::filesystem::exists(folder->picture(turn.setting));
      return is_whole ? folder->find(turn) : std::nullopt;
    };
    runner.keep = [&](const StudyTurn& turn, const Measurements& measured) { folder->keep(turn, measured); };
  }
  const auto records = run_study(plan, settings, runner);
  const std::string table = study_table(plan, records), json = study_to_json(plan, records);
  if (folder) folder->finish(json, table);
  if (options.json != "-") std::cout << table << std::flush;
  if (!options.json.empty()) write_text_file(options.json, json);
}

}  // namespace

void setup_study(CLI::App& app) {
  auto options = std::make_shared<StudyOptions>();
  CLI::App* verb = app.add_subcommand("study", "Measure what settings cost: runs in turns, medians, a table");
  verb->add_option("plan", options->plan, "A bundled plan's name, or a plan's TOML file")
      ->required()
      ->type_name("PLAN");
  verb->add_option("-o,--output", options->folder,
                   "A folder for every run, pictures and results; the same call goes on where one was ended")
      ->type_name("DIR")
      ->check(not_empty());
  verb->add_option("--repeats", options->repeats, "Counted runs of each setting and seed (default: the plan's)")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  verb->add_option("--seeds", options->seeds, "Seeds that each setting is run with (default: the plan's)")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  verb->add_option("--threads", options->threads, "Threads (default: all cores)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  verb->add_option("--json", options->json, "Write the results as JSON; - for standard output")->type_name("FILE");
  verb->footer(
      "Examples:\n  triad study effects --repeats 3 --json effects.json\n  triad study filter\n"
      "  triad study subpixel -o out/subpixel\n"
      "Numbers are medians ± half the range between the quartiles; with several seeds, all but seconds are means ± "
      "half "
      "the width of the 95 % confidence interval. * marks settings that no other beats in all that the plan "
      "compares.");
  verb->callback([options] { study(*options); });
}

}  // namespace triad::app
