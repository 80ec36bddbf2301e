// SPDX-License-Identifier: Apache-2.0
// triad compare TEST... --ref REF -m METRIC...
#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/evaluation/ranking.hpp>

#include "compare_pairs.hpp"
#include "compare_references.hpp"
#include "options.hpp"
#include "report.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

struct CompareOptions {
  HostOptions host;
  PictureOptions picture;
  MetricOptions metric;
  std::vector<std::string> tests;
  std::string nan = "fail", sort, table, report;
  size_t top = 20;
  bool skip_missing = false, quiet = false;
};

std::vector<ChainItem> metrics_of(const CompareOptions& options) {
  std::vector<ChainItem> metrics;
  for (const std::string& text : options.metric.metrics) metrics.push_back(parse_metric(text));
  if (metrics.empty()) throw_usage("compare needs a metric: -m error, -m display ...; see triad list");
  if (options.metric.references.size() != 1)
    throw_usage(
        "compare needs one reference: --ref FILE (given: " + std::to_string(options.metric.references.size()) +
        "); a folder or a sequence has one for each picture");
  make_labels_unique(metrics);
  return metrics;
}

// Files that this call reads, so that none of them is written over.
std::vector<std::string> inputs_of(const std::vector<ComparePair>& pairs, const CompareOptions& options) {
  std::vector<std::string> paths{options.metric.mask};
  for (const ComparePair& pair : pairs) paths.insert(paths.end(), {pair.test, pair.reference});
  return paths;
}

// Everything that is the same for all pictures.
struct Comparison {
  PluginHost host;
  ColourConfig colours;
  std::vector<ChainItem> metrics;
  std::vector<Threshold> thresholds;
  std::vector<PooledName> pooled;
  std::optional<RankKey> sort;
  RunRequest request;

  explicit Comparison(const CompareOptions& options)
      : host(options.host.plugin_path), colours(ColourConfig::load(options.host.ocio)), metrics(metrics_of(options)) {
    options.picture.apply(request);
    options.metric.apply(request);
    request.metric_nan = parse_nan(options.nan, {"fail", "ignore", "zero"});
    request.metric_space = options.picture.to;
    request.input.read = options.picture.read();
    thresholds = options.metric.thresholds();
    check_threshold_names(thresholds, metrics, host);
    pooled = options.metric.pooled(metrics, host);
    if (!options.sort.empty()) {
      sort = parse_rank_key(options.sort, metrics, host);
      for (const ChainItem& metric : metrics)
        if (metric.label == sort->label && !has_own_score(metric, sort->score))
          pooled.push_back({sort->label, sort->score});
    }
    // Without a reader of them, pooled scores are not worth their time.
    request.pool =
        !pooled.empty() || !options.metric.json.empty() || !options.metric.csv.empty() || !options.table.empty();
  }

  bool has_own_score(const ChainItem& metric, const std::string& score) {
    const triad_desc& desc = *host.find(metric.id).desc;
    return std::any_of(desc.scores, desc.scores + desc.n_scores,
                       [&](const triad_score* s) { return score == s->name; });
  }

  MetricRequest metric_request(size_t m, const PictureRequest& reference, const std::string& map_path) {
    const std::string& label = metrics[m].label;
    std::string named = pooled_by_threshold(label, pooled, thresholds);
    if (named.empty() && sort && sort->label == label && !has_own_score(metrics[m], sort->score))
      named = "--sort '" + sort->label + "." + sort->score + "'";
    return {metrics[m], reference, map_path, named};
  }
};

// Compares one picture after the other: a large one keeps all threads busy, and needs the memory.
std::vector<JudgedPicture> judge_all(const std::vector<ComparePair>& pairs, Comparison& comparison,
                                     References& references, MapFiles& maps) {
  std::vector<JudgedPicture> judged;
  Progress progress("compare");
  for (size_t i = 0; i < pairs.size(); ++i) {
    JudgedPicture picture{pairs[i].test, pairs[i].reference, pairs[i].sequence, pairs[i].frame, {}, ""};
    const auto progress_to = [&](double share) {
      progress.update((static_cast<double>(i) + share) / static_cast<double>(pairs.size()));
    };
    const bool done = attempt(pairs.size() > 1, [&] {
      try {
        RunRequest one = comparison.request;
        one.input.path = pairs[i].test;
        const PictureRequest reference = references.get(pairs[i].reference);
        for (size_t m = 0; m < comparison.metrics.size(); ++m)
          one.metrics.push_back(comparison.metric_request(m, reference, maps.run_path(i, m)));
        RunResult result = Run(one, comparison.host, comparison.colours).execute(progress_to);
        maps.done(i, one, result, comparison.colours);
        picture.results = std::move(result.metrics);
      } catch (const Error& error) {
        // A metric's own message does not say of which picture it is.
        const std::string what = error.what();
        const bool nameless = error.kind() == ErrorKind::kInput && what.find(pairs[i].test) == std::string::npos;
        picture.error = nameless ? pairs[i].test + ": " + what : what;
        throw Error(error.kind(), picture.error);
      }
    });
    if (!done) maps.failed(i);
    judged.push_back(std::move(picture));
  }
  return judged;
}

// Those that a report would show.
std::vector<ReportPicture> pictures_of(const std::vector<ComparePair>& pairs, const ReadOptions& read_test,
                                       const ReadOptions& read_reference) {
  std::set<std::string> references;
  std::vector<ReportPicture> pictures;
  for (const ComparePair& pair : pairs) {
    if (references.insert(pair.reference).second)
      pictures.push_back({pair.reference, pair.reference, read_reference});
    pictures.push_back({pair.test, pair.test, read_test});
  }
  return pictures;
}

void write_reports(const CompareOptions& options, const Comparison& comparison,
                   const std::vector<JudgedPicture>& judged, const std::vector<MetricResult>& results,
                   const std::vector<Ranking>& rankings, const std::vector<ShownFile>& files,
                   const ReadOptions& read_reference) {
  const MetricOptions& metric = options.metric;
  const bool alone = judged.size() == 1 && judged[0].sequence.empty();
  if (!options.quiet && metric.json != "-" && metric.csv != "-" && options.table != "-")
    std::cout << (alone ? results_to_table(results, comparison.pooled)
                        : ranking_to_table(judged, rankings, {options.top, comparison.pooled, comparison.thresholds}))
              << std::flush;
  if (!metric.json.empty())
    write_text_file(metric.json, ranking_to_json(judged, rankings, files, {options.picture.read(), read_reference}));
  if (!metric.csv.empty()) write_text_file(metric.csv, results_to_csv(results));
  if (!options.table.empty()) write_text_file(options.table, pictures_to_csv(judged));
}

void compare(const CompareOptions& options) {
  Comparison comparison(options);
  const std::vector<ComparePair> pairs =
      pair_pictures(options.tests, options.metric.references[0], options.skip_missing);

  // CLI11's ranges let not-a-number pass.
  if (std::isnan(options.metric.maps.exposure_ev)) throw_usage("--exposure: a number of stops is needed, not nan");
  std::vector<std::string> paths = inputs_of(pairs, options);
  options.metric.check_outputs(paths);
  paths.insert(paths.end(), {options.metric.json, options.metric.csv});
  check_report_file("--table", options.table, paths);
  paths.push_back(options.table);
  if (!options.report.empty()) {
    require_viewer();
    if (options.report == "-") throw_usage("--report writes a page and the data beside it: name a file, not -");
    check_report_file("--report", options.report, paths);
    paths.push_back(options.report);
  }
  MapFiles maps(options.metric.maps, pairs.size() > 1 || comparison.metrics.size() > 1, pairs.size() > 1);
  std::vector<std::string> labels, main_scores;
  for (const ChainItem& metric : comparison.metrics) {
    labels.push_back(metric.label);
    main_scores.push_back(main_score(metric.id, comparison.host));
  }
  for (const ComparePair& pair : pairs) maps.add(pair.test, labels);
  maps.check(paths);
  maps.make_folders();

  ReadOptions read_reference = options.picture.read_reference();
  if (read_reference.channels.empty() && read_reference.layer.empty())
    read_reference.channels = options.picture.read().channels;
  if (!options.report.empty())
    check_report_memory(pictures_of(pairs, options.picture.read(), read_reference), comparison.colours,
                        ReportEmbed::kAuto, comparison.request.max_memory);
  References references(read_reference, pairs, comparison.colours);
  const std::vector<JudgedPicture> judged = judge_all(pairs, comparison, references, maps);
  const std::vector<ShownFile> files = maps.finish(comparison.colours);

  std::vector<MetricResult> results;
  for (const JudgedPicture& picture : judged)
    results.insert(results.end(), picture.results.begin(), picture.results.end());
  const std::vector<Ranking> rankings = rank_pictures(judged, comparison.metrics, main_scores, comparison.sort);
  write_reports(options, comparison, judged, results, rankings, files, read_reference);
  g_exit_status = std::max(g_exit_status, report_failures(comparison.thresholds, results, {"ignore", "zero"}));
  if (!options.report.empty() && !results.empty())
    write_report(comparison_report(results, options.picture.read(), read_reference), comparison.colours,
                 options.report, ReportEmbed::kAuto, comparison.request.max_memory);
}

void add_list_options(CLI::App& verb, CompareOptions& options) {
  verb.add_option("--sort", options.sort,
                  "Rank by this score (default: each metric by its first that is better low or high)")
      ->type_name("LABEL.SCORE")
      ->check(not_empty());
  verb.add_option("--top", options.top, "Rows shown of a list; 0 for all. Files hold all of them")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb.add_option("--table", options.table,
                  "Write a line per picture and a column per score as CSV; - for standard output (--csv: a line per "
                  "score)")
      ->type_name("FILE")
      ->check(not_empty());
  verb.add_option("--report", options.report,
                  "Write an HTML page with the pictures beside their references and all scores; see triad report")
      ->type_name("FILE")
      ->check(not_empty());
  verb.add_flag("--skip-missing", options.skip_missing,
                "Compare the frames or names that both sides have; say which are missing");
  verb.add_flag("-q,--quiet", options.quiet, "No table on standard output; failures are still said");
}

}  // namespace

void setup_compare(CLI::App& app) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* verb = app.add_subcommand("compare", "Judge pictures against a reference, and rank them");
  verb->add_option("tests", options->tests, "Pictures, 'renders/*.exr', folders, or sequences like out.####.png")
      ->required()
      ->type_name("TEST");
  options->metric.add(*verb,
                      "The picture to compare with; a sequence for sequences; a folder of pictures of the "
                      "same names");
  verb->add_option("--nan", options->nan,
                   "NaN and infinite values: fail the comparison, ignore the pixels, or take them for zero")
      ->type_name("POLICY")
      ->capture_default_str();
  add_list_options(*verb, *options);
  verb->add_option("--sheet", options->metric.maps.sheet,
                   "Write reference, test and maps side by side as PNG; a folder (ending in /) for several pictures")
      ->type_name("FILE")
      ->check(not_empty());
  verb->add_option("--exposure", options->metric.maps.exposure_ev, "Stops by which sheets show pictures brighter")
      ->type_name("EV")
      ->check(CLI::Range(-100., 100.))
      ->capture_default_str();
  options->picture.add(*verb,
                       "Colour space in which metrics without one of their own compare (default: linear light)");
  options->host.add_plugin_path(*verb);
  options->host.add_ocio(*verb);
  verb->footer(
      "Examples:\n"
      "  triad compare a.exr b.exr --ref truth.exr -m error\n"
      "  triad compare 'renders/*.exr' --ref truth.exr -m error --map maps/ --map-format png --top 10\n"
      "  triad compare shot.####.exr --ref truth.####.exr -m error --sort error.rmse --table frames.csv\n"
      "  triad compare new/ --ref approved/ -m error --fail-above error.p95=0.02 --sheet failed/ --quiet\n"
      "  triad compare out.png --ref wide.exr -m display:ppd=40@near -m display:ppd=67@far --json -\n"
      "  triad compare a.exr b.exr --ref truth.exr -m error --report pictures.html\n"
      "A limit on p95 is a limit on how much of the picture may differ: 5 % may be above it.\n"
      "Exit status: 0 done, 1 a threshold was crossed or pictures hold NaN, 2 usage or input error, 3 internal");
  verb->callback([options] { compare(*options); });
}

}  // namespace triad::app
