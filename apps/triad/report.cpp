// SPDX-License-Identifier: Apache-2.0
// triad report DIR
#include "report.hpp"

#include <filesystem>
#include <iostream>
#include <map>
#include <triad/base/parallel.hpp>

#include "options.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

struct ReportOptions {
  std::string folder, output;
  std::string embed = "auto";
  int threads = 0;
};

const std::map<std::string, ReportEmbed> kEmbeds{
    {"auto", ReportEmbed::kAuto}, {"all", ReportEmbed::kAll}, {"codes", ReportEmbed::kCodes}};

void report_study(const ReportOptions& options) {
  require_viewer();
  if (options.threads > 0) set_thread_limit(options.threads);
  const std::string path =
      options.output.empty() ? (std::filesystem::path(options.folder) / "report.html").string() : options.output;
  const ReportData data = read_study_report(options.folder);
  write_report(data, path, kEmbeds.at(options.embed));
  std::cout << path << std::endl;
}

}  // namespace

void setup_report(CLI::App& app) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* verb = app.add_subcommand("report", "Make a page of a study's results, with charts and pictures");
  verb->add_option("folder", options->folder, "The folder that triad study -o wrote")->required()->type_name("DIR");
  verb->add_option("-o,--output", options->output, "The page (default: DIR/report.html)")
      ->type_name("FILE")
      ->check(not_empty());
  verb->add_option("--embed", options->embed,
                   "auto: past 100 MB the page holds 8-bit pictures, and the float data lies in a folder beside it, "
                   "named after it; codes: so do small ones; all: everything in one file")
      ->type_name("WHAT")
      ->check(CLI::IsMember({"auto", "all", "codes"}))
      ->capture_default_str();
  verb->add_option("--threads", options->threads, "Threads (default: all cores)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  verb->footer(
      "The page opens from disk in any browser of 2023 or later, without a network or a server: which method is best "
      "for a budget, "
      "the pictures side by side, as a panel's emitters and as an eye sees them, and what accuracy costs.\n"
      "Examples:\n  triad study cells -o out/cells && triad report out/cells\n"
      "  triad report out/cells -o cells.html --embed all");
  verb->callback([options] { report_study(*options); });
}

}  // namespace triad::app
