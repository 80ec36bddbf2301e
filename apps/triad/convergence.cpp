// SPDX-License-Identifier: Apache-2.0
// triad convergence DIR|FILE... --ref REF
#include <algorithm>
#include <cmath>
#include <iostream>
#include <set>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/base/text.hpp>

#include "convergence_report.hpp"
#include "options.hpp"
#include "verbs.hpp"

namespace triad::app {
namespace {

constexpr size_t kLeastPictures = 3, kForFreeRate = 5;

struct ConvergenceOptions {
  HostOptions host;
  PictureOptions picture;
  MetricOptions metric;  // crop, mask and files of results; one metric, one reference
  std::vector<std::string> pictures, against;
  std::string reference, metric_text = "error", score, score_is = "auto", samples_from = "auto", rate = "1",
                         nan = "fail";
};

// NAME=VALUE.
struct NumberThreshold {
  std::string option, text, name;
  double value = 0;
  bool above = false;
};

std::vector<NumberThreshold> parse_thresholds(const MetricOptions& options) {
  std::vector<NumberThreshold> list;
  const auto add = [&](const std::vector<std::string>& texts, bool above) {
    for (const std::string& text : texts) {
      const std::string option = above ? "--fail-above" : "--fail-below";
      const size_t equals = text.find('=');
      const auto value =
          equals == std::string::npos ? std::nullopt : parse_double(std::string_view(text).substr(equals + 1));
      if (!value || std::isnan(*value)) throw_usage(option + " '" + text + "' is not NAME=VALUE, as in slope=-0.9");
      const std::string name = text.substr(0, equals);
      const auto& names = convergence_threshold_names();
      if (std::find(names.begin(), names.end(), name) == names.end())
        throw_usage(option + " '" + text + "': there is no '" + name + "'" + did_you_mean(name, names) +
                    "; there are '" + join(names, "', '") + "'");
      list.push_back({option, text, name, *value, above});
    }
  };
  add(options.fail_above, true);
  add(options.fail_below, false);
  return list;
}

// The score that falls as a picture gets better, squared if there is such a one.
std::string choose_score(const std::string& asked, const ChainItem& metric, PluginHost& host) {
  const triad_desc& desc = *host.find(metric.id).desc;
  std::string name = asked;
  if (name.starts_with(metric.label + ".")) name = name.substr(metric.label.size() + 1);
  std::vector<std::string> names, falling;
  for (uint32_t s = 0; s < desc.n_scores; ++s) {
    names.emplace_back(desc.scores[s]->name);
    if (desc.scores[s]->better < 0) falling.emplace_back(desc.scores[s]->name);
  }
  const auto has = [](const std::vector<std::string>& list, const std::string& one) {
    return std::find(list.begin(), list.end(), one) != list.end();
  };
  if (name.empty()) {
    for (const char* usual : {"mse", "rmse"})
      if (has(falling, usual)) return usual;
    throw_usage("-m " + metric.id +
                " has neither mse nor rmse; name the score whose fall is judged: --score, one of '" +
                join(names, "', '") + "'");
  }
  if (!has(names, name))
    throw_usage("--score '" + asked + "': '" + metric.id + "' has no score '" + name + "'" +
                did_you_mean(name, names) + "; it has '" + join(names, "', '") + "'");
  if (!has(falling, name))
    throw_usage("--score '" + asked + "' is no error: the better a picture, the lower it must be" +
                (falling.empty() ? "" : "; '" + metric.id + "' has '" + join(falling, "', '") + "'"));
  return name;
}

bool is_squared(const std::string& asked, const std::string& metric, const std::string& score) {
  if (asked == "squared" || asked == "root") return asked == "squared";
  if (asked != "auto") throw_usage("--score-is '" + asked + "' is none of 'auto', 'squared' and 'root'");
  if (metric.starts_with("relmse")) return true;
  return score.find("mse") != std::string::npos && score.find("rmse") == std::string::npos;
}

std::optional<double> parse_rate(const std::string& text) {
  if (text == "free") return std::nullopt;
  const auto rate = parse_double(text);
  if (!rate || !(*rate > 0 && *rate <= 6))
    throw_usage("--rate '" + text + "' is neither 'free' nor a number above 0 and up to 6, as in 1");
  return rate;
}

void check_counts(const Series& one) {
  if (one.pictures.size() < kLeastPictures)
    throw_input("'" + one.name + "' has " + std::to_string(one.pictures.size()) +
                (one.pictures.size() == 1 ? " picture" : " pictures") + ", and a slope with its interval needs " +
                std::to_string(kLeastPictures) + " or more");
  std::set<double> costs;
  const bool samples = one.pictures[0].cost.samples.has_value();
  for (const SeriesPicture& picture : one.pictures)
    costs.insert(samples ? *picture.cost.samples : *picture.cost.seconds);
  if (costs.size() < 2)
    throw_input("all pictures of '" + one.name + "' have " + format_double(*costs.begin()) +
                (samples ? " samples per pixel" : " seconds") + "; a slope needs different ones");
}

void judge(const ConvergenceOptions& options, const ChainItem& metric, ConvergenceFindings& findings,
           PluginHost& host) {
  const ColourConfig colours = ColourConfig::load(options.host.ocio);
  RunRequest request;
  options.picture.apply(request);
  options.metric.apply(request);
  request.metric_nan = parse_nan(options.nan, {"fail", "ignore", "zero"});
  request.metric_space = options.picture.to;
  ReadOptions read_reference = options.picture.read_reference();
  if (read_reference.channels.empty() && read_reference.layer.empty())
    read_reference.channels = options.picture.read().channels;
  double count = 0, done = 0;
  for (const Series& one : findings.series) count += static_cast<double>(one.pictures.size());
  Progress progress("convergence");
  for (Series& one : findings.series)
    for (SeriesPicture& picture : one.pictures) {
      RunRequest run = request;
      run.input = {picture.file, options.picture.read()};
      MetricRequest& asked = run.metrics.emplace_back();
      asked.item = metric;
      asked.reference = {options.reference, read_reference};
      const RunResult result =
          Run(run, host, colours).execute([&](double share) { progress.update((done + share) / count); });
      ++done;
      const MetricResult& judged = result.metrics.at(0);
      if (judged.nonfinite_failed)
        throw_input(picture.file + ": " + nonfinite_refusal(judged.nonfinite, {"ignore", "zero"}));
      for (const auto& score : judged.scores)
        if (score.name == findings.score) picture.score = score.value;
      if (picture.score == 0)
        throw_input(picture.file + ": its " + findings.score +
                    " is 0, which no render with noise has; is it a copy of '" + options.reference + "'?");
      if (!(picture.score > 0) || !std::isfinite(picture.score))
        throw_input(picture.file + ": its " + findings.score + " is " + format_double(picture.score) +
                    ", and an error must be above 0");
      picture.squared_error = findings.squared ? picture.score : picture.score * picture.score;
    }
}

// Noise differs in every render: the same error to the last bit is the same picture.
void check_copies(const Series& one) {
  for (size_t i = 0; i < one.pictures.size(); ++i)
    for (size_t k = 0; k < i; ++k)
      if (one.pictures[i].score == one.pictures[k].score)
        throw_input(one.pictures[i].file + ": it has exactly the error of '" + one.pictures[k].file +
                    "', so that they seem to be one picture; each render counts once");
}

std::vector<CostedError> points_of(const Series& one, bool samples, bool squared) {
  std::vector<CostedError> points;
  for (const SeriesPicture& picture : one.pictures)
    points.push_back(
        {samples ? *picture.cost.samples : *picture.cost.seconds, squared ? picture.squared_error : picture.score});
  return points;
}

SeriesFit fit_series(const Series& one, std::optional<double> rate) {
  SeriesFit fit;
  const bool has_samples = one.pictures[0].cost.samples.has_value();
  if (has_samples) fit.samples = fit_power_law(points_of(one, true, false));
  if (one.pictures[0].cost.seconds) {
    const auto points = points_of(one, false, false);
    const bool alike =
        std::all_of(points.begin(), points.end(), [&](const CostedError& p) { return p.cost == points[0].cost; });
    if (alike)
      warn("all pictures of '" + one.name + "' took " + format_double(points[0].cost) +
           " seconds; no slope over seconds");
    else
      fit.seconds = fit_power_law(points);
    std::vector<double> efficiencies;
    for (const SeriesPicture& picture : one.pictures)
      efficiencies.push_back(1 / (picture.squared_error * *picture.cost.seconds));
    fit.efficiency = geometric_mean(efficiencies);
  }
  const auto squared = points_of(one, has_samples, true);
  if (!rate && squared.size() < kLeastPictures + 1)
    throw_usage("--rate free needs " + std::to_string(kLeastPictures + 1) + " pictures or more, and '" + one.name +
                "' has " + std::to_string(squared.size()));
  fit.floor = fit_floor(squared, rate);
  if (squared.size() >= kForFreeRate) fit.floor_free = fit_floor(squared, std::nullopt);
  return fit;
}

// What the errors themselves say against the numbers of samples or seconds.
void check_costs(const Series& one, const SeriesFit& fit) {
  const bool samples = fit.samples.has_value();
  const std::string what = samples ? " samples per pixel" : " seconds";
  const PowerLaw& law = samples ? *fit.samples : *fit.seconds;
  if (law.slope.low > 0) {
    warn("the error of '" + one.name + "' rises with" + (samples ? " samples" : " seconds") +
         ": do the numbers belong to these pictures, and do they show what the reference shows?");
    return;
  }
  if (fit.floor.found()) return;  // then it is no line, and points off it prove nothing
  const auto points = points_of(one, samples, false);
  const auto odd = find_outlier(points);
  if (!odd) return;
  const SeriesPicture& picture = one.pictures[odd->point];
  warn(picture.file + ": " + (samples ? picture.cost.samples_from : picture.cost.seconds_from) + " says " +
       format_double(points[odd->point].cost) + what + ", but its error is that of about " +
       rough_cost(odd->expected_cost) + " among the others of '" + one.name + "'");
}

EqualErrors compare_series(const ConvergenceFindings& findings, size_t other) {
  EqualErrors equal{other, {}};
  const Series &a = findings.series[0], &b = findings.series[other];
  const auto &fit_a = findings.fits[0], &fit_b = findings.fits[other];
  const bool samples = fit_a.samples && fit_b.samples, seconds = fit_a.seconds && fit_b.seconds;
  if (!samples && !seconds) {
    warn("'" + a.name + "' and '" + b.name + "' have neither samples nor seconds both; nothing to compare");
    return equal;
  }
  const auto common =
      common_errors(points_of(a, fit_a.samples.has_value(), false), points_of(b, fit_b.samples.has_value(), false));
  if (!common) return equal;
  for (const double score : {common->first, std::sqrt(common->first * common->second), common->second}) {
    EqualErrors::At at{score, std::nullopt, std::nullopt};
    if (seconds) at.seconds = cost_ratio(*fit_a.seconds, *fit_b.seconds, score);
    if (samples) at.samples = cost_ratio(*fit_a.samples, *fit_b.samples, score);
    equal.at.push_back(at);
  }
  return equal;
}

// Before the work: whether there will be such a number.
void check_thresholds(const std::vector<NumberThreshold>& thresholds, const std::vector<Series>& series) {
  const auto none = [&](auto has) {
    return std::none_of(series.begin(), series.end(), [&](const Series& one) { return has(one.pictures[0].cost); });
  };
  const bool no_samples = none([](const RenderCost&cost) { return cost.samples.has_value(); }),
             no_seconds = none([](const RenderCost&cost) { return cost.seconds.has_value(); });
  for (const NumberThreshold& threshold : thresholds) {
    const std::string& name = threshold.name;
    std::string needs;
    if (no_seconds && (name.find("seconds") != std::string::npos || name == "efficiency")) needs = "seconds";
    if (no_samples && (name == "slope" || name == "samples-ratio")) needs = "samples";
    if (series.size() < 2 && name.ends_with("-ratio")) needs = "a second series";
    if (!needs.empty())
      throw_usage(threshold.option + " '" + threshold.text + "': '" + name + "' needs " + needs +
                  ", which these pictures do not have");
  }
}

int failed_thresholds(const std::vector<NumberThreshold>& thresholds, const ConvergenceFindings& findings) {
  int status = 0;
  for (const NumberThreshold& threshold : thresholds) {
    const auto numbers = convergence_numbers(findings, threshold.name);
    // One for each series, or for each beside the first; what could not be told keeps no limit.
    const size_t due = findings.series.size() - (threshold.name.ends_with("-ratio") ? 1 : 0);
    if (numbers.size() < due) {
      std::cerr << "triad: " << threshold.option << " '" << threshold.text << "': " << threshold.name
                << (numbers.empty() ? " cannot be told of these pictures\n" : " cannot be told of all series\n");
      status = 1;
    }
    for (const auto& [name, value] : numbers)
      if (!(threshold.above ? value <= threshold.value : value >= threshold.value)) {
        std::cerr << "triad: " << printable(name) << ": " << threshold.name << " is " << format_double(value)
                  << (threshold.above ? ", above " : ", below ") << format_double(threshold.value) << "\n";
        status = 1;
      }
  }
  return status;
}

void convergence(ConvergenceOptions options) {
  const std::vector<NumberThreshold> thresholds = parse_thresholds(options.metric);
  const ChainItem metric = parse_metric(options.metric_text);
  PluginHost host(options.host.plugin_path);
  ConvergenceFindings findings;
  findings.reference = options.reference;
  findings.metric = metric.id;
  findings.label = metric.label;
  findings.score = choose_score(options.score, metric, host);
  findings.squared = is_squared(options.score_is, metric.id, findings.score);
  findings.rate = parse_rate(options.rate);
  parse_nan(options.nan, {"fail", "ignore", "zero"});

  findings.series = collect_series(options.pictures, "pictures");
  for (Series& one : collect_series(options.against, "against")) findings.series.push_back(std::move(one));
  check_distinct(findings.series, options.reference);
  std::vector<std::string> files{options.reference, options.metric.mask, options.samples_from};
  for (const Series& one : findings.series)
    for (const SeriesPicture& picture : one.pictures) files.push_back(picture.file);
  options.metric.check_outputs(files);
  find_costs(findings.series, options.samples_from, options.picture.read());
  for (const Series& one : findings.series) check_counts(one);
  check_thresholds(thresholds, findings.series);

  judge(options, metric, findings, host);
  for (const Series& one : findings.series) {
    check_copies(one);
    findings.fits.push_back(fit_series(one, findings.rate));
    check_costs(one, findings.fits.back());
  }
  for (size_t i = 1; i < findings.series.size(); ++i) findings.equal.push_back(compare_series(findings, i));

  if (options.metric.json != "-" && options.metric.csv != "-")
    std::cout << convergence_to_text(findings) << std::flush;
  if (!options.metric.json.empty()) write_text_file(options.metric.json, convergence_to_json(findings));
  if (!options.metric.csv.empty()) write_text_file(options.metric.csv, convergence_to_csv(findings));
  g_exit_status = std::max(g_exit_status, failed_thresholds(thresholds, findings));
}

}  // namespace

void setup_convergence(CLI::App& app) {
  auto options = std::make_shared<ConvergenceOptions>();
  CLI::App* verb = app.add_subcommand(
      "convergence", "How the error of a series of renders falls with samples and seconds: slope, bias, efficiency");
  const auto add_text = [&](const char* name, std::string& value, const std::string& doc, const char* type) {
    verb->add_option(name, value, doc)->type_name(type)->check(not_empty());
  };
  const auto add_list = [&](const char* name, std::vector<std::string>& values, const std::string& doc,
                            const char* type) {
    verb->add_option(name, values, doc)->type_name(type)->allow_extra_args(false)->check(not_empty());
  };
  verb->add_option("pictures", options->pictures,
                   "Renders of one scene with more and more samples; each folder is a series of its own")
      ->required()
      ->type_name("DIR|FILE");
  verb->add_option("--ref,--reference", options->reference, "What they converge to; its own noise counts as bias")
      ->required()
      ->type_name("FILE")
      ->check(not_empty());
  add_list("--against", options->against, "Another series to compare the first with; may be repeated", "DIR|FILE");
  add_text("--samples-from", options->samples_from,
           "What tells samples and seconds: name, metadata, a table with the columns file,samples,seconds, or auto: "
           "name and metadata, which must agree (default)",
           "HOW");
  add_text("-m,--metric", options->metric_text,
           "The metric: name, name:key=value,... or either with @label (default: error)", "METRIC");
  add_text("--score", options->score, "Which of its scores (default: mse, else rmse)", "SCORE");
  add_text("--score-is", options->score_is,
           "squared: falls as 1/N, root: as 1/sqrt(N), auto: squared for names with mse but not rmse (default)",
           "KIND");
  add_text(
      "--rate", options->rate,
      "How the variance falls without bias: as N^-RATE; free fits that too, and takes more pictures (default: 1)",
      "RATE");
  add_text("--nan", options->nan, "NaN and infinite values: fail, ignore the pixels, or take them for zero",
           "POLICY");
  add_text("--json", options->metric.json, "Write the findings as JSON; - for standard output", "FILE");
  add_text("--csv", options->metric.csv, "Write a line per picture as CSV; - for standard output", "FILE");
  add_list("--fail-above", options->metric.fail_above,
           "Exit with 1 if a number is above a value: " + join(convergence_threshold_names(), ", "), "NAME=V");
  add_list("--fail-below", options->metric.fail_below, "Exit with 1 if a number is below a value", "NAME=V");
  add_text("--crop", options->metric.crop, "Pool scores inside this part of the pictures only", "X,Y,W,H");
  add_text("--mask", options->metric.mask, "Pool scores weighted by this picture's first channel", "FILE");
  options->picture.add(*verb,
                       "Colour space in which metrics without one of their own compare (default: linear light)");
  options->host.add_plugin_path(*verb);
  options->host.add_ocio(*verb);
  verb->footer(
      "Examples:\n"
      "  triad convergence renders/ --ref truth.exr\n"
      "  triad convergence cornell_4spp.exr cornell_16spp.exr cornell_64spp.exr --ref truth.exr --json -\n"
      "  triad convergence new/ --against old/ --ref truth.exr --samples-from costs.csv --fail-below "
      "seconds-ratio=1\n"
      "  triad convergence renders/ --ref truth.exr -m display:ppd=40 --score rmse --fail-above floor-low=0\n"
      "Samples and seconds come from names (cornell_64spp.exr, cornell-0064.exr, cornell_64_12.5s.exr), from the "
      "headers of Triad, pbrt and Blender, from Triad's record beside a picture (triad render -o a.exr --json "
      "a.json), "
      "or from a table.\n"
      "Error = bias^2 + variance / N^rate: bias is claimed where its interval is above 0. Stratified samples "
      "(sobol-owen) "
      "fall faster than 1/N; a rate of free may then take the end of that for bias.\n"
      "Exit status: 0 done, 1 a threshold was crossed, 2 usage or input error, 3 internal");
  verb->callback([options] { convergence(*options); });
}

}  // namespace triad::app
