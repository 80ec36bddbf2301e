// SPDX-License-Identifier: Apache-2.0
// triad report RESULTS
#include "report.hpp"

#include <filesystem>
#include <iostream>
#include <map>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>

#include "options.hpp"
#include "verbs.hpp"

namespace fs = std::filesystem;

namespace triad::app {
namespace {

struct ReportOptions {
  std::string results, output, cells, ref_cells, max_memory;
  std::string embed = "auto";
  int threads = 0;
};

const std::map<std::string, ReportEmbed> kEmbeds{
    {"auto", ReportEmbed::kAuto}, {"all", ReportEmbed::kAll}, {"codes", ReportEmbed::kCodes}};

void report_results(const ReportOptions& options) {
  require_viewer();
  if (options.threads > 0) set_thread_limit(options.threads);
  std::error_code error;
  const fs::path results = options.results;
  const bool is_file = fs::is_regular_file(results, error);
  if (!is_file && !(options.cells.empty() && options.ref_cells.empty()))
    throw_usage("--cells and --ref-cells are for the pictures of triad compare; those of a study say it themselves");
  ReadOptions tests, references;
  if (!options.cells.empty()) tests.cells = parse_cells(options.cells, "--cells");
  if (!options.ref_cells.empty()) references.cells = parse_cells(options.ref_cells, "--ref-cells");
  const ReportData data =
      is_file ? read_comparison_report(options.results, tests, references) : read_study_report(options.results);
  const fs::path beside = is_file ? fs::path(results).replace_extension(".html") : results / "report.html";
  const std::string path = options.output.empty() ? beside.string() : options.output;
  std::vector<std::string> inputs{options.results};
  if (!is_file)
    for (const char* name : {"results.json", "plan.json", "table.txt"}) inputs.push_back((results / name).string());
  for (const ReportPicture& picture : data.pictures) inputs.push_back(picture.path);
  check_report_file("-o", path, inputs);
  write_report(data, ColourConfig::load(), path, kEmbeds.at(options.embed),
               options.max_memory.empty() ? 0 : parse_memory(options.max_memory));
  std::cout << path << std::endl;
}

}  // namespace

void setup_report(CLI::App& app) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* verb = app.add_subcommand("report", "Make a page of results, with charts and pictures");
  verb->add_option("results", options->results, "The folder that triad study -o wrote, or triad compare's JSON")
      ->required()
      ->type_name("RESULTS");
  verb->add_option("-o,--output", options->output,
                   "The page (default: DIR/report.html, or the JSON's name with .html)")
      ->type_name("FILE")
      ->check(not_empty());
  verb->add_option("--embed", options->embed,
                   "auto: past 100 MB the page holds 8-bit pictures, and the float data lies in a folder beside it, "
                   "named after it; codes: so do small ones; all: everything in one file")
      ->type_name("WHAT")
      ->check(CLI::IsMember({"auto", "all", "codes"}))
      ->capture_default_str();
  verb->add_option("--cells", options->cells, "Fine cells of a display pixel in triad compare's pictures, as there")
      ->type_name("XxY");
  verb->add_option("--ref-cells", options->ref_cells, "The same for the reference")->type_name("XxY");
  verb->add_option("--threads", options->threads, "Threads (default: all cores)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  verb->add_option("--max-memory", options->max_memory,
                   "Memory to stay within, e.g. 400M (default: half of the machine's)")
      ->type_name("SIZE")
      ->check(not_empty());
  verb->footer(
      "The page opens from disk in any browser of 2023 or later, without a network or a server: which method is best "
      "for a budget, "
      "the pictures side by side, as a panel's emitters and as an eye sees them, and what accuracy costs.\n"
      "Examples:\n  triad study cells -o out/cells && triad report out/cells\n"
      "  triad report out/cells -o cells.html --embed all\n"
      "  triad compare a.exr b.exr --ref truth.exr -m error --json scores.json && triad report scores.json");
  verb->callback([options] { report_results(*options); });
}

}  // namespace triad::app
