// SPDX-License-Identifier: Apache-2.0
// triad run IN [STAGE]... [-o OUT] [-m METRIC --ref REF]...
#include <algorithm>
#include <iostream>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>

#include "compare_references.hpp"
#include "options.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

struct RunOptions {
  HostOptions host;
  PictureOptions picture;
  MetricOptions metric;
  std::string input, output, chain, nan = "keep", depth, compression;
  std::vector<std::string> stages;
  bool explain = false;
};

// Of each reference, once.
void warn_of_black_references(const RunRequest& request, const ColourConfig& colours) {
  std::set<std::string> seen;
  for (const MetricRequest& metric : request.metrics)
    if (seen.insert(metric.reference.path).second)
      warn_of_black(metric.reference.path, metric.reference.read, colours);
}

void run(const RunOptions& options) {
  RunRequest request;
  options.picture.apply(request);
  options.metric.apply(request);
  std::vector<ChainItem> metrics;
  if (!options.chain.empty()) {
    const Chain chain = load_chain(options.chain);
    request.stages = chain.stages;
    metrics = chain.metrics;
  }
  for (const std::string& text : options.stages) request.stages.push_back(parse_stage(text));
  for (const std::string& text : options.metric.metrics) metrics.push_back(parse_metric(text));
  make_labels_unique(metrics);

  const auto& references = options.metric.references;
  if (metrics.empty() && !references.empty()) throw_usage("--ref without a metric: name one with -m");
  if (!metrics.empty() && references.empty())
    throw_usage("-m " + metrics[0].id + " needs a reference: name it with --ref");
  if (references.size() > 1 && references.size() != metrics.size())
    throw_usage("--ref is given " + std::to_string(references.size()) + " times for " +
                std::to_string(metrics.size()) + " metrics; give one for all, or one for each");
  if (metrics.empty() &&
      (!options.metric.crop.empty() || !options.metric.mask.empty() || !options.metric.maps.map.empty()))
    throw_usage("--crop, --mask and --map belong to metrics: name one with -m");
  const bool writes =
      std::any_of(request.stages.begin(), request.stages.end(), [](const auto& s) { return s.is_write; });
  if (options.output.empty() && !writes && metrics.empty() && !options.explain)
    throw_usage("nothing to do: name an output with -o OUT or write:OUT, or a metric with -m");

  if (!writes && options.output.empty() && !options.picture.to.empty())
    throw_usage("--to is the colour space of an output: name one with -o");

  request.input.read = options.picture.read();
  request.output_space = options.picture.to;
  if (!options.depth.empty()) request.write.depth = parse_depth(options.depth);
  request.write.compression = options.compression;
  request.nan = parse_nan(options.nan, {"fail", "zero", "keep"});
  request.metric_nan = request.nan == NanPolicy::kZero ? NanPolicy::kZero : NanPolicy::kFail;

  // A sequence is a run for each of its frames.
  std::vector<int> frames{0};
  const bool sequence = is_sequence(options.input);
  if (sequence) {
    frames = find_frames(options.input);
    const auto needs_number = [&](const std::string& path) {
      if (!path.empty() && !is_sequence(path) && frames.size() > 1)
        throw_usage("'" + path + "' would be written once for each of " + std::to_string(frames.size()) +
                    " frames; put #### where the frame's number goes");
    };
    needs_number(options.output);
    for (const ChainItem& item : request.stages)
      if (item.is_write) needs_number(item.path);
  } else if (is_sequence(options.output)) {
    throw_usage("-o '" + options.output + "' has a frame number, but the input '" + options.input + "' has none");
  }

  PluginHost host(options.host.plugin_path);
  const ColourConfig colours = ColourConfig::load(options.host.ocio);
  const std::vector<Threshold> thresholds = options.metric.thresholds();
  check_threshold_names(thresholds, metrics, host);
  const std::vector<PooledName> pooled = options.metric.pooled(metrics, host);
  request.pool = !pooled.empty() || !options.metric.json.empty() || !options.metric.csv.empty();

  std::vector<std::string> paths = references;
  paths.insert(paths.end(), {options.input, options.output, options.metric.mask, options.chain});
  for (const ChainItem& item : request.stages) paths.push_back(item.path);
  options.metric.check_outputs(paths);
  MapFiles maps(options.metric.maps, metrics.size() > 1 || frames.size() > 1, frames.size() > 1);
  std::vector<std::string> labels;
  for (const ChainItem& metric : metrics) labels.push_back(metric.label);
  for (const int frame : frames) maps.add(sequence ? frame_path(options.input, frame) : options.input, labels);
  maps.check(paths);
  if (!options.explain) maps.make_folders();

  std::vector<MetricResult> results;
  std::vector<RunRecord> records;
  Progress progress(options.input);
  for (size_t f = 0; f < frames.size(); ++f) {
    RunRequest one = request;
    one.input.path = sequence ? frame_path(options.input, frames[f]) : options.input;
    one.output = sequence ? frame_path(options.output, frames[f]) : options.output;
    if (sequence)
      for (ChainItem& item : one.stages)
        if (item.is_write) item.path = frame_path(item.path, frames[f]);
    for (size_t m = 0; m < metrics.size(); ++m) {
      const std::string& reference = references[references.size() == 1 ? 0 : m];
      MetricRequest metric{
          metrics[m],
          {sequence ? frame_path(reference, frames[f]) : reference, options.picture.read_reference()},
          options.explain ? maps.map_name(f, m) : maps.run_path(f, m),
          pooled_by_threshold(metrics[m].label, pooled, thresholds)};
      one.metrics.push_back(std::move(metric));
    }
    if (options.explain) {
      std::cout << Run(one, host, colours).explain();
      return;
    }
    RunResult result;
    const auto progress_to = [&](double share) {
      progress.update((static_cast<double>(f) + share) / static_cast<double>(frames.size()));
    };
    if (!attempt(frames.size() > 1, [&] {
          Run chain(one, host, colours);
          warn_of_black_references(one, colours);
          result = chain.execute(progress_to);
          maps.done(f, one, result, colours);
        })) {
      maps.failed(f);
      continue;
    }
    if (request.nan == NanPolicy::kZero && result.input_nonfinite.total())
      warn("'" + one.input.path + "': " + std::to_string(result.input_nonfinite.nan) + " NaN and " +
           std::to_string(result.input_nonfinite.inf) + " infinite values replaced by 0");
    results.insert(results.end(), result.metrics.begin(), result.metrics.end());
    records.push_back({one.input.path, one.output, std::move(result)});
  }
  maps.finish(colours);
  g_exit_status = std::max(g_exit_status, report(options.metric, thresholds, pooled, results, records, {"zero"}));
}

}  // namespace

void setup_run(CLI::App& app) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* verb = app.add_subcommand("run", "Run a picture through a chain of filters; write it, judge it, or both");
  verb->add_option("input", options->input, "A picture, or a sequence like in.####.exr")->required()->type_name("IN");
  verb->add_option("stages", options->stages,
                   "Filters in order: name or name:key=value,...; write:PATH keeps the picture at that point")
      ->type_name("STAGE");
  verb->add_option("-o,--output", options->output, "The file to write")->type_name("OUT")->check(not_empty());
  verb->add_option("--chain", options->chain, "Stages and metrics from a TOML file, before those of the command line")
      ->type_name("FILE")
      ->check(not_empty());
  verb->add_flag("--explain", options->explain, "Print the plan and touch no pixel");
  verb->add_option("--nan", options->nan, "What to do about NaN and infinite input values: fail, zero or keep")
      ->type_name("POLICY")
      ->capture_default_str();
  verb->add_option("--depth", options->depth, "Stored type: 8, 16, half or float (default: by format)")
      ->type_name("D");
  verb->add_option("--compression", options->compression, "Compression of the output: none, zip, piz, jpeg:95 ...")
      ->type_name("C")
      ->check(not_empty());
  options->picture.add(*verb, "Colour space of the output (default: sRGB for PNG and JPEG, linear for EXR)");
  options->metric.add(*verb, "The picture to compare with; one for all metrics, or one for each");
  options->host.add_plugin_path(*verb);
  options->host.add_ocio(*verb);
  verb->footer(
      "Examples:\n"
      "  triad run wide.exr platt:layout=rgb,ppd=40 -o out.png\n"
      "  triad run wide.exr subpixel -m display:ppd=40 --ref wide.exr\n"
      "  triad run shot.####.exr box:x=2,y=2 -o small.####.png\n"
      "  triad run wide.exr platt write:full.exr crop:w=64,h=64 -o corner.png --explain\n"
      "See also: triad list, triad help STAGE");
  verb->callback([options] { run(*options); });
}

}  // namespace triad::app
