// SPDX-License-Identifier: Apache-2.0
// A report: results, charts and pictures as one HTML page that needs neither a network nor a server.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <triad/evaluation/study.hpp>
#include <triad/image/reader.hpp>
#include <triad/pipeline/run.hpp>
#include <utility>
#include <vector>

namespace triad::app {

// A picture's file. Its first three channels (or the only one) are shown, brought to linear Rec. 709 light.
struct ReportPicture {
  std::string name, path;
  ReadOptions read{};
  bool is_reference = false;
  int reference = -1;        // the picture that it is judged by, by number
  StudySettings settings{};  // its place on the report's axes
};

// Numbers by measure. What is not finite is shown as missing.
struct ReportRun {
  StudySettings settings;  // by axis
  StudySettings whole{};   // all that was set: "strategy", "filter", "cells" tell lines apart
  std::map<std::string, double> shown{}, around{};      // the value, and half the width of what it may be
  std::map<std::string, std::vector<double>> values{};  // of each run
  std::optional<bool> pareto{};
  int picture = -1;  // by number
};

// A table beside that of the runs.
struct ReportTable {
  std::string caption;
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;
};

struct ReportData {
  std::string kind = "study";  // or "comparison"
  std::string title;
  StudySettings facts{};  // of all runs; under the title
  std::vector<std::string>
      axes{};  // of settings; the rivals are "method", "filter", "strategy", "effects", or the last
  std::vector<std::string> along{};     // axes on which a method is the same at another price
  std::vector<std::string> measures{};  // of the runs, those that matter first
  std::vector<std::string> plain{};     // those that matter: the columns of the table; {}: all
  std::vector<std::string> higher_is_better{};
  std::vector<std::string> pareto{}, within{};  // StudyPlan's
  std::string around_is{};                      // what ReportRun::around is, in words
  std::string layout{};                         // the panel and distance that scores belong to, "" and 0 if none
  double ppd = 0;
  std::vector<ReportRun> runs{};
  std::vector<ReportPicture> pictures{};
  std::vector<ReportTable> tables{};
};

enum class ReportEmbed {
  kAuto,  // float data beside the page, and 8-bit pictures in it, where it would be larger than 100 MB
  kAll,   // one file, however large
  kCodes  // always as kAuto does with a large one
};

// Throws Error(kUsage) if this build has no viewer (CMake's TRIAD_VIEWER=OFF).
void require_viewer();

// Writes the page to `path`, and the float data that it leaves out to a folder beside it, named after it:
// out/report.html has out/report_data. The same data and files give the same bytes. Reads all pictures, on all
// threads that max_memory (bytes; 0: half of the machine's) has room for; they are all in memory, packed. Throws
// Error(kUsage) without a viewer, Error(kInput) for files that cannot be read or written, or naming --max-memory
// where it does not suffice.
void write_report(const ReportData& data, const ColourConfig& colours, const std::string& path,
                  ReportEmbed embed = ReportEmbed::kAuto, uint64_t max_memory = 0);
// Throws what write_report() would over max_memory, from the pictures' headers; those that cannot be read do not
// count.
void check_report_memory(const std::vector<ReportPicture>& pictures, const ColourConfig& colours,
                         ReportEmbed embed = ReportEmbed::kAuto, uint64_t max_memory = 0);

// The results in a study's folder. Throws Error(kInput) if it has none that are finished, or they cannot be read.
ReportData read_study_report(const std::string& folder);

// The scores of pictures, which are files, beside their references, read with these options. A layout or distance
// that is among the parameters of a metric is the one that scores belong to.
ReportData comparison_report(const std::vector<MetricResult>& results, const ReadOptions& tests,
                             const ReadOptions& references);
// The same from the file that `triad compare --json` wrote; pictures are looked for where it says that they are.
// They are read as that file says they were; cells that are given here come first. Throws Error(kInput) for another
// file.
ReportData read_comparison_report(const std::string& path, ReadOptions tests, ReadOptions references);

}  // namespace triad::app
