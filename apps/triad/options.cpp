// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include "verbs.hpp"

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

namespace {
// An empty text is a variable of a script that was never set, not a wish for the default.
const CLI::Validator kNotEmpty(
    [](std::string& text) { return text.empty() ? std::string("the value is empty") : std::string(); }, "",
    "not empty");
}  // namespace

const CLI::Validator& not_empty() { return kNotEmpty; }

namespace {
void add_text(CLI::App& verb, const char* name, std::string& value, const std::string& doc, const char* type) {
  verb.add_option(name, value, doc)->type_name(type)->check(not_empty());
}
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
      ->type_name("XxY")
      ->check(not_empty());
  add_text(verb, "--ref-cells", ref_cells, "The same for the reference", "XxY");
  add_text(verb, "--from", from, "Colour space of the input (default: what the file says)", "SPACE");
  add_text(verb, "--ref-from", ref_from, "Colour space of the reference", "SPACE");
  add_text(verb, "--to", to, to_doc, "SPACE");
  add_text(verb, "--part", part, "Part of a multi-part file, by name or number from 0", "PART");
  add_text(verb, "--ref-part", ref_part, "Part of the reference", "PART");
  add_text(verb, "--channels", channels, "Channels to read, as in R,G,B or a layer's name; see triad info",
           "A,B,...");
  add_text(verb, "--ref-channels", ref_channels, "Channels of the reference (compare: as --channels by default)",
           "A,B,...");
  add_text(verb, "--layer", layer,
           "Layer (AOV) of a file of several, of the reference too: albedo, N, Z; see triad info", "NAME");
  add_text(verb, "--ref-layer", ref_layer, "Layer of the reference (default: that of --layer)", "NAME");
  verb.add_option("--threads", threads, "Threads (default: all cores)")
      ->type_name("N")
      ->check(CLI::Range(1, kMostThreads));
  verb.add_option("--strip-rows", strip_rows, "Rows worked on together (default: by size); never changes the result")
      ->type_name("N")
      ->check(CLI::Range(1, 1 << 30));
  add_text(verb, "--max-memory", max_memory, "Memory to stay within, e.g. 400M (default: half of the machine's)",
           "BYTES");
}

bool PictureOptions::names_reference() const {
  return !ref_cells.empty() || !ref_from.empty() || !ref_part.empty() || !ref_channels.empty() || !ref_layer.empty();
}

namespace {
std::vector<std::string> channel_names(const std::string& text) {
  if (text.empty()) return {};
  std::vector<std::string> names = split_quoted(text, ',');
  for (std::string& name : names) name = unquote(name);
  return names;
}
}  // namespace

ReadOptions PictureOptions::read() const {
  if (!layer.empty() && !channels.empty()) throw_usage("--layer and --channels exclude each other");
  ReadOptions options;
  options.part = part;
  options.layer = layer;
  options.channels = channel_names(channels);
  options.colour_space = from;
  if (!cells.empty()) options.cells = parse_cells(cells, "--cells");
  return options;
}

ReadOptions PictureOptions::read_reference() const {
  if (!ref_layer.empty() && !ref_channels.empty()) throw_usage("--ref-layer and --ref-channels exclude each other");
  ReadOptions options;
  options.part = ref_part;
  options.layer = !ref_layer.empty() ? ref_layer : ref_channels.empty() ? layer : "";
  options.channels = channel_names(ref_channels);
  options.colour_space = ref_from;
  if (!ref_cells.empty()) options.cells = parse_cells(ref_cells, "--ref-cells");
  return options;
}

void PictureOptions::apply(RunRequest& request) const {
  request.strip_rows = strip_rows;
  if (!max_memory.empty()) {
    request.max_memory = parse_memory(max_memory);
    set_scratch_budget(request.max_memory);
  }
  if (threads > 0) set_thread_limit(threads);
}

void MetricOptions::add(CLI::App& verb, const std::string& reference_doc) {
  const auto add_list = [&](const char* name, std::vector<std::string>& values, const std::string& doc,
                            const char* type) {
    verb.add_option(name, values, doc)->type_name(type)->allow_extra_args(false)->check(not_empty());
  };
  add_list("-m,--metric", metrics, "A metric: name, name:key=value,... or either with @label; may be repeated",
           "METRIC");
  add_list("--ref,--reference", references, reference_doc, "FILE");
  add_text(verb, "--map", maps.map,
           "Write the error map: numbers (.exr), or colours (.png); a folder (ending in /) for several", "FILE");
  add_text(verb, "--map-format", maps.format, "What maps in a folder are: exr or png (default: exr)", "F");
  add_text(
      verb, "--map-scale", maps.scale,
      "Values that the colours span: LOW:HIGH, each (every map its own) or common (default: 0 to what the metric "
      "can reach, else one scale for all maps of a metric, from 0 to what 99 % of the values do not exceed; of maps "
      "with values below 0, from the least to the greatest)",
      "SCALE");
  verb.add_option("--colour-map,--color-map", maps.colour_map, "Colours of maps: magma or viridis")
      ->type_name("NAME")
      ->check(not_empty())
      ->capture_default_str();
  add_text(verb, "--json", json,
           "Write the results as JSON; - for standard output. Bytes of names that are no UTF-8 are \\xNN", "FILE");
  add_text(verb, "--csv", csv, "Write the scores as CSV; - for standard output", "FILE");
  add_text(verb, "--pool", pool,
           "Show these of the scores pooled from the error map: mean, min, max, p5 ... p99, weighted-p5 ... or all",
           "P,P,...");
  add_list("--fail-above", fail_above, "Exit with 1 if a score is above a value: LABEL.SCORE=VALUE", "L.S=V");
  add_list("--fail-below", fail_below, "Exit with 1 if a score is below a value", "L.S=V");
  add_text(verb, "--crop", crop, "Pool scores inside this part of the test picture only", "X,Y,W,H");
  add_text(verb, "--mask", mask, "Pool scores weighted by this picture's first channel", "FILE");
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

std::vector<PooledName> MetricOptions::pooled(const std::vector<ChainItem>& metric_items, PluginHost& host) const {
  return named_pooled_scores(pool, thresholds(), metric_items, host);
}

namespace {
// Equal for all names of one file.
fs::path real_path(const std::string& path) {
  if (path == "-") return path;
  std::error_code error;
  // Absolute first: of a relative path that does not exist yet, nothing is made canonical.
  const fs::path found = fs::weakly_canonical(fs::absolute(path, error), error);
  return error ? fs::path(path) : found;
}
}  // namespace

void check_report_file(const std::string& option, const std::string& path, const std::vector<std::string>& others) {
  if (path.empty()) return;
  for (const std::string& other : others)
    if (!other.empty() && real_path(path) == real_path(other))
      throw_usage(option + " '" + path + "' is read or written by this call already; name another file");
  check_text_file(path);
}

void MetricOptions::check_outputs(const std::vector<std::string>& others) const {
  check_report_file("--json", json, others);
  std::vector<std::string> with_json = others;
  with_json.push_back(json);
  check_report_file("--csv", csv, with_json);
}

uint64_t parse_memory(const std::string& text) {
  const auto bytes = parse_bytes(text);
  if (!bytes) throw_usage("--max-memory '" + text + "' is not a size; write 400M or 2G");
  return *bytes;
}

NanPolicy parse_nan(const std::string& text, const std::vector<std::string>& allowed) {
  if (std::find(allowed.begin(), allowed.end(), text) == allowed.end())
    throw_usage("--nan '" + text + "' is none of '" + join(allowed, "', '") + "'" + did_you_mean(text, allowed));
  return text == "fail"     ? NanPolicy::kFail
         : text == "zero"   ? NanPolicy::kZero
         : text == "ignore" ? NanPolicy::kIgnore
                            : NanPolicy::kKeep;
}

bool attempt(bool several, const std::function<void()>& work) {
  try {
    work();
    return true;
  } catch (const Error& error) {
    if (!several || error.kind() != ErrorKind::kInput) throw;
    std::cerr << "triad: " << printable(error.what()) << std::endl;
    g_exit_status = error.exit_status();
    return false;
  }
}

int report(const MetricOptions& options, const std::vector<Threshold>& thresholds,
           const std::vector<PooledName>& pooled, const std::vector<MetricResult>& results,
           const std::vector<RunRecord>& runs, const std::vector<std::string>& policies) {
  if (options.json != "-" && options.csv != "-") std::cout << results_to_table(results, pooled) << std::flush;
  if (!options.json.empty()) write_text_file(options.json, results_to_json(results, runs));
  if (!options.csv.empty()) write_text_file(options.csv, results_to_csv(results));
  return report_failures(thresholds, results, policies);
}

std::string nonfinite_refusal(const NonFinite& found, const std::vector<std::string>& policies) {
  return std::to_string(found.nan) + " NaN and " + std::to_string(found.inf) +
         " infinite values in it and its reference; no scores without --nan " + join(policies, " or --nan ");
}

int report_failures(const std::vector<Threshold>& thresholds, const std::vector<MetricResult>& results,
                    const std::vector<std::string>& policies) {
  int status = 0;
  std::string seen;
  for (const MetricResult& result : results) {
    if (!result.nonfinite_failed || result.test == seen) continue;
    seen = result.test;
    std::cerr << "triad: " << printable(result.test) << ": " << nonfinite_refusal(result.nonfinite, policies) << "\n";
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
