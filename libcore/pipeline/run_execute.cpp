// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/pipeline/picture_keeper.hpp>
#include <triad/pipeline/run_drive.hpp>

namespace triad {
namespace {

using Clock = std::chrono::steady_clock;

// Errors are measurements: where a format can, it keeps them as floats.
std::unique_ptr<ImageWriter> open_map_writer(const MetricNode& metric) {
  const bool codes = is_display_encoded_format(metric.map_path, Depth::kDefault);
  return ImageWriter::open(metric.map_path, metric.map_spec, {codes ? Depth::kDefault : Depth::kFloat, ""});
}

}  // namespace

RunResult Run::Impl::execute(const std::function<void(double)>& progress) {
  const auto start = Clock::now();
  Execution run;
  run.progress = progress;
  for (const PictureOutput& out : outputs) {
    if (!out.path.empty()) {
      run.writers.push_back(ImageWriter::open(out.path, out.spec, request.write));
      continue;
    }
    run.kept = std::make_shared<Image>(blank_image(out.spec, request.input.path));
    run.writers.push_back(std::make_unique<PictureKeeper>(*run.kept));
  }
  for (const auto& metric : metrics)
    run.map_writers.push_back(metric->map_path.empty() ? nullptr : open_map_writer(*metric));
  for (const auto& metric : metrics) run.poolings.push_back(metric->pools() ? make_pooling(*metric) : nullptr);
  run.metric_states.resize(metrics.size());
  run.failed.resize(metrics.size());
  run.nonfinite_of_references.resize(references.size());
  run.replaced.resize(filters.size());
  for (size_t i = 0; i < filters.size(); ++i) run.filter_ns.push_back(std::make_unique<std::atomic<int64_t>>(0));
  for (const Drive& drive : drives) run.tokens_total += drive.tokens();

  std::vector<std::vector<double>> scores(metrics.size());
  for (const Drive& drive : drives) {
    DriveWork(*this, drive, run)();
    if (drive.sink != Sink::kFinal) continue;
    for (size_t m = 0; m < metrics.size(); ++m) {
      if (drive.pass >= metrics[m]->plan.plan.passes || run.failed[m]) continue;
      // What a metric would say of pictures whose bad values count as 0 is not what is wrong with them.
      run.failed[m] = request.metric_nan == NanPolicy::kFail && nonfinite_of(*metrics[m], run).total() > 0;
      if (run.failed[m]) {
        if (drive.pass + 1 < metrics[m]->plan.plan.passes && run.map_writers[m]) run.map_writers[m].reset();
        continue;
      }
      const ScopedNanoseconds watch(metrics[m]->nanoseconds);
      scores[m] = metrics[m]->instance.end_pass(drive.pass, run.metric_states[m].data());
    }
  }
  for (size_t i = 0; i < filters.size(); ++i)
    if (run.replaced[i].total())
      warn("'" + filters[i]->instance().info().id() + "' replaced " + std::to_string(run.replaced[i].nan) +
           " NaN and " + std::to_string(run.replaced[i].inf) + " infinite values of '" + request.input.path +
           "' by 0: they would have spread");
  check_cancel();
  for (auto& writer : run.writers) writer->commit();
  for (auto& writer : run.map_writers)
    if (writer) writer->commit();

  RunResult& result = run.result;
  for (size_t i = 0; i < filters.size(); ++i)
    result.stages.push_back(
        {filter_texts[i], static_cast<double>(run.filter_ns[i]->load()) * 1e-9, filters[i]->instance().reports()});
  for (size_t m = 0; m < metrics.size(); ++m) {
    MetricNode& metric = *metrics[m];
    MetricResult made;
    made.test = request.input.path;
    made.reference = references[metric.reference].path;
    made.metric = metric.instance.info().id();
    made.label = metric.label;
    made.parameters = metric.instance.parameters();
    made.nonfinite = nonfinite_of(metric, run);
    made.nonfinite_failed = run.failed[m];
    const triad_desc& desc = *metric.instance.info().desc;
    if (!made.nonfinite_failed)
      for (uint32_t s = 0; s < desc.n_scores; ++s) {
        const triad_score& score = *desc.scores[s];
        const double value = scores[m][s];
        if (std::isnan(value) || (std::isinf(value) && !(score.flags & TRIAD_SCORE_MAY_BE_INFINITE)))
          throw_internal("'" + made.metric + "' gave " + (std::isnan(value) ? "NaN" : "an infinity") +
                         " as its score '" + score.name + "'");
        made.scores.push_back({score.name, score.unit ? score.unit : "", value, score.better});
      }
    if (run.poolings[m] && !made.nonfinite_failed) made.pooled = pooled_result(metric, *run.poolings[m]);
    run.poolings[m].reset();
    made.reports = metric.instance.reports();
    made.seconds = static_cast<double>(metric.nanoseconds.load()) * 1e-9;
    result.metrics.push_back(std::move(made));
  }
  result.picture = run.kept;
  result.input_nonfinite = run.input_nonfinite;
  result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return std::move(result);
}

}  // namespace triad
