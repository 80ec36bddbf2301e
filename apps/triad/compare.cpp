// SPDX-License-Identifier: Apache-2.0
// triad compare TEST... --ref REF -m METRIC...
#include <algorithm>
#include <triad/base/error.hpp>

#include "options.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

struct CompareOptions {
  HostOptions host;
  PictureOptions picture;
  MetricOptions metric;
  std::vector<std::string> tests;
  std::string nan = "fail";
};

void compare(const CompareOptions& options) {
  RunRequest request;
  options.picture.apply(request);
  options.metric.apply(request);
  request.metric_nan = parse_nan(options.nan, {"fail", "ignore", "zero"});
  request.metric_space = options.picture.to;
  std::vector<ChainItem> metrics;
  for (const std::string& text : options.metric.metrics) metrics.push_back(parse_metric(text));
  if (metrics.empty()) throw_usage("compare needs a metric: -m error, -m display ...; see triad list");
  if (options.metric.references.size() != 1)
    throw_usage(
        "compare needs one reference: --ref FILE (given: " + std::to_string(options.metric.references.size()) + ")");
  make_labels_unique(metrics);

  // Frames of a sequence are pictures of their own, beside the reference of the same number if it has one.
  struct Pair {
    std::string test, reference;
  };
  std::vector<Pair> pairs;
  const std::string& reference = options.metric.references[0];
  for (const std::string& test : options.tests) {
    if (!is_sequence(test)) {
      if (is_sequence(reference))
        throw_usage("--ref '" + reference + "' has a frame number, but the test picture '" + test + "' has none");
      pairs.push_back({test, reference});
      continue;
    }
    for (const int frame : find_frames(test))
      pairs.push_back({frame_path(test, frame), frame_path(reference, frame)});
  }

  std::vector<std::string> paths = options.tests;
  paths.insert(paths.end(), {reference, options.metric.mask});
  options.metric.check_outputs(paths);
  MapPaths maps(options.metric.map, pairs.size() > 1 || metrics.size() > 1);
  maps.make_folder();

  PluginHost host(options.host.plugin_path);
  const ColourConfig colours = ColourConfig::load(options.host.ocio);
  const std::vector<Threshold> thresholds = options.metric.thresholds();
  check_threshold_names(thresholds, metrics, host);

  ReadOptions read_reference = options.picture.read_reference();
  if (read_reference.channels.empty() && read_reference.layer.empty())
    read_reference.channels = options.picture.read().channels;
  std::vector<MetricResult> results;
  Progress progress("compare");
  for (size_t i = 0; i < pairs.size(); ++i) {
    RunRequest one = request;
    one.input = {pairs[i].test, options.picture.read()};
    for (const ChainItem& metric : metrics)
      one.metrics.push_back({metric, {pairs[i].reference, read_reference}, maps.next(pairs[i].test, metric.label)});
    RunResult result;
    const auto progress_to = [&](double share) {
      progress.update((static_cast<double>(i) + share) / static_cast<double>(pairs.size()));
    };
    if (!attempt(pairs.size() > 1, [&] { result = Run(one, host, colours).execute(progress_to); })) continue;
    results.insert(results.end(), result.metrics.begin(), result.metrics.end());
  }
  g_exit_status = std::max(g_exit_status, report(options.metric, thresholds, results, {}));
}

}  // namespace

void setup_compare(CLI::App& app) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* verb = app.add_subcommand("compare", "Judge pictures against a reference");
  verb->add_option("tests", options->tests, "Pictures, or sequences like out.####.png")
      ->required()
      ->type_name("TEST");
  options->metric.add(*verb, "The picture to compare with; a sequence for sequences");
  verb->add_option("--nan", options->nan,
                   "NaN and infinite values: fail the comparison, ignore the pixels, or take them for zero")
      ->type_name("POLICY")
      ->capture_default_str();
  options->picture.add(*verb,
                       "Colour space in which metrics without one of their own compare (default: linear light)");
  options->host.add_plugin_path(*verb);
  options->host.add_ocio(*verb);
  verb->footer(
      "Examples:\n"
      "  triad compare a.exr b.exr --ref truth.exr -m error\n"
      "  triad compare out.png --ref wide.exr -m display:ppd=40@near -m display:ppd=67@far --json -\n"
      "  triad compare out.png --ref truth.exr -m error --fail-above error.rmse=0.02 --map error.exr\n"
      "Exit status: 0 done, 1 a threshold was crossed or pictures hold NaN, 2 usage or input error, 3 internal");
  verb->callback([options] { compare(*options); });
}

}  // namespace triad::app
