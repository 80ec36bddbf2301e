// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/parallel.hpp>
#include <triad/base/text.hpp>

namespace fs = std::filesystem;

namespace triad::app {
namespace {
double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }
constexpr double kQuietStart_s = .5;  // work that ends sooner shows no bar
constexpr double kInterval_s = .1;    // between two drawings
constexpr int kMostThreads = 1024;
}  // namespace

void HostOptions::add_plugin_path(CLI::App& verb) {
  verb.add_option("--plugin-path", plugin_path, "A folder or file to look for plugins in first; may be repeated")
      ->type_name("PATH")
      ->allow_extra_args(false);
}

void HostOptions::add_ocio(CLI::App& verb) {
  verb.add_option("--ocio", ocio, "An OpenColorIO configuration (default: $OCIO, else the bundled one)")
      ->type_name("FILE");
}

void PictureOptions::add(CLI::App& verb, const std::string& to_doc) {
  verb.add_option("--cells", cells, "Fine cells per display pixel of the input, e.g. 3x1 for a wide render")
      ->type_name("XxY");
  verb.add_option("--ref-cells", ref_cells, "The same for the reference")->type_name("XxY");
  verb.add_option("--from", from, "Colour space of the input (default: what the file says)")->type_name("SPACE");
  verb.add_option("--ref-from", ref_from, "Colour space of the reference")->type_name("SPACE");
  verb.add_option("--to", to, to_doc)->type_name("SPACE");
  verb.add_option("--part", part, "Part of a multi-part file, by name or number from 0")->type_name("PART");
  verb.add_option("--channels", channels, "Channels to read, as in R,G,B or a layer's name; see triad info")
      ->type_name("A,B,...");
  verb.add_option("--threads", threads, "Threads (default: all cores)")
      ->type_name("N")
      ->check(CLI::Range(1, kMostThreads));
  verb.add_option("--strip-rows", strip_rows, "Rows worked on together (default: by size); never changes the result")
      ->type_name("N")
      ->check(CLI::Range(1, 1 << 30));
  verb.add_option("--max-memory", max_memory, "Memory to stay within, e.g. 400M (default: half of the machine's)")
      ->type_name("BYTES");
}

ReadOptions PictureOptions::read() const {
  ReadOptions options;
  options.part = part;
  if (!channels.empty()) options.channels = split_quoted(channels, ',');
  for (std::string& name : options.channels) name = unquote(name);
  options.colour_space = from;
  if (!cells.empty()) options.cells = parse_cells(cells, "--cells");
  return options;
}

ReadOptions PictureOptions::read_reference() const {
  ReadOptions options;
  options.colour_space = ref_from;
  if (!ref_cells.empty()) options.cells = parse_cells(ref_cells, "--ref-cells");
  return options;
}

void PictureOptions::apply(RunRequest& request) const {
  request.strip_rows = strip_rows;
  if (!max_memory.empty()) {
    const auto bytes = parse_bytes(max_memory);
    if (!bytes) throw_usage("--max-memory '" + max_memory + "' is not a size; write 400M or 2G");
    request.max_memory = *bytes;
    set_scratch_budget(*bytes);
  }
  if (threads > 0) set_thread_limit(threads);
}

void MetricOptions::add(CLI::App& verb) {
  verb.add_option("-m,--metric", metrics, "A metric: name, name:key=value,... or either with @label; may be repeated")
      ->type_name("METRIC")
      ->allow_extra_args(false);
  verb.add_option("--ref,--reference", references,
                  "The picture to compare with; one for all metrics, or one for each")
      ->type_name("FILE")
      ->allow_extra_args(false);
  verb.add_option("--map", map, "Write the error map; a folder (ending in /) for several")->type_name("FILE");
  verb.add_option("--json", json, "Write the results as JSON; - for standard output")->type_name("FILE");
  verb.add_option("--csv", csv, "Write the scores as CSV; - for standard output")->type_name("FILE");
  verb.add_option("--fail-above", fail_above, "Exit with 1 if a score is above a value: LABEL.SCORE=VALUE")
      ->type_name("L.S=V")
      ->allow_extra_args(false);
  verb.add_option("--fail-below", fail_below, "Exit with 1 if a score is below a value")
      ->type_name("L.S=V")
      ->allow_extra_args(false);
  verb.add_option("--crop", crop, "Pool scores inside this part of the test picture only")->type_name("X,Y,W,H");
  verb.add_option("--mask", mask, "Pool scores weighted by this picture's first channel")->type_name("FILE");
}

std::vector<Threshold> MetricOptions::thresholds() const {
  std::vector<Threshold> list;
  for (const std::string& text : fail_above) list.push_back(parse_threshold(text, true));
  for (const std::string& text : fail_below) list.push_back(parse_threshold(text, false));
  return list;
}

void MetricOptions::apply(RunRequest& request) const {
  request.mask = mask;
  if (crop.empty()) return;
  const auto parts = split_quoted(crop, ',');
  std::vector<int> numbers;
  for (const std::string& part : parts) {
    const auto value = parse_int(part);
    if (value && *value >= 0 && *value <= INT32_MAX) numbers.push_back(static_cast<int>(*value));
  }
  if (parts.size() != 4 || numbers.size() != 4 || numbers[2] < 1 || numbers[3] < 1)
    throw_usage("--crop '" + crop + "' is not X,Y,W,H in pixels, as in 0,0,64,64");
  request.crop = CropRequest{numbers[0], numbers[1], numbers[2], numbers[3]};
}

std::string map_path(const std::string& map, const std::string& test, const std::string& label, bool many) {
  if (map.empty()) return "";
  const bool folder = map.back() == '/' || fs::is_directory(map);
  if (!folder) {
    if (many)
      throw_usage("--map '" + map + "' is one file, but there are several maps; name a folder, with / at its end");
    return map;
  }
  std::error_code error;
  fs::create_directories(map, error);
  if (error) throw_input("--map '" + map + "': " + error.message());
  return (fs::path(map) / (fs::path(test).stem().string() + "." + label + ".exr")).string();
}

NanPolicy parse_nan(const std::string& text, const std::vector<std::string>& allowed) {
  if (std::find(allowed.begin(), allowed.end(), text) == allowed.end())
    throw_usage("--nan '" + text + "' is none of '" + join(allowed, "', '") + "'" + did_you_mean(text, allowed));
  return text == "fail"     ? NanPolicy::kFail
         : text == "zero"   ? NanPolicy::kZero
         : text == "ignore" ? NanPolicy::kIgnore
                            : NanPolicy::kKeep;
}

int report(const MetricOptions& options, const std::vector<Threshold>& thresholds,
           const std::vector<MetricResult>& results, const std::vector<RunRecord>& runs) {
  if (options.json != "-" && options.csv != "-") std::cout << results_to_table(results) << std::flush;
  if (!options.json.empty()) write_text_file(options.json, results_to_json(results, runs));
  if (!options.csv.empty()) write_text_file(options.csv, results_to_csv(results));
  int status = 0;
  std::string seen;
  for (const MetricResult& result : results) {
    if (!result.nonfinite_failed || result.test == seen) continue;
    seen = result.test;
    std::cerr << "triad: " << printable(result.test) << ": " << result.nonfinite.nan << " NaN and "
              << result.nonfinite.inf
              << " infinite values in it and its reference; no scores without --nan ignore or --nan zero\n";
    status = 1;
  }
  for (const std::string& line : failed_thresholds(thresholds, results)) {
    std::cerr << "triad: " << printable(line) << "\n";
    status = 1;
  }
  return status;
}

Progress::Progress(std::string what)
    : what_(printable(what)), terminal_(isatty(STDERR_FILENO) == 1), start_s_(now_s()), last_s_(start_s_) {}

Progress::~Progress() {
  if (shown_) std::fputs("\r\x1b[K", stderr);
}

void Progress::update(double done) {
  if (!terminal_) return;
  const double now = now_s();
  if (now - start_s_ < kQuietStart_s || now - last_s_ < kInterval_s) return;
  last_s_ = now;
  shown_ = true;
  const double left = done > 0 ? (now - start_s_) * (1 - done) / done : 0;
  const std::string line = fmt::format("\r\x1b[K{} {:3.0f}%, {:.0f} s left", what_, done * 100, left);
  std::fputs(line.c_str(), stderr);
}

}  // namespace triad::app
