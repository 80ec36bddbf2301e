// SPDX-License-Identifier: Apache-2.0
#include <oneapi/tbb/parallel_pipeline.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/base/log.hpp>
#include <triad/pipeline/picture_keeper.hpp>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/run_impl.hpp>

namespace triad {
namespace {

using Clock = std::chrono::steady_clock;

// Adds the time of a scope to a counter of nanoseconds.
class Stopwatch {
 public:
  explicit Stopwatch(std::atomic<int64_t>& sum) : sum_(sum), start_(Clock::now()) {}
  ~Stopwatch() { sum_ += std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - start_).count(); }

 private:
  std::atomic<int64_t>& sum_;
  Clock::time_point start_;
};

StripBuffer copy_of(BufferPool& pool, const StripBuffer& from, RowRange rows) {
  StripBuffer copy(pool, rows, from.width(), from.channels(), {});
  for (int y = rows.y0; y < rows.y1; ++y)
    std::memcpy(copy.row(y), from.row(y), static_cast<size_t>(from.width()) * from.channels() * sizeof(float));
  return copy;
}

NonFinite treat_nonfinite(const StripBuffer& buffer, RowRange rows, bool zero) {
  NonFinite found;
  for (int y = rows.y0; y < rows.y1; ++y) {
    const size_t count = static_cast<size_t>(buffer.width()) * buffer.channels();
    found += zero ? zero_nonfinite(buffer.row(y), count) : count_nonfinite(buffer.row(y), count);
  }
  return found;
}

// Errors are measurements: where a format can, it keeps them as floats.
std::unique_ptr<ImageWriter> open_map_writer(const MetricNode& metric) {
  const bool codes = is_display_encoded_format(metric.map_path, Depth::kDefault);
  return ImageWriter::open(metric.map_path, metric.map_spec, {codes ? Depth::kDefault : Depth::kFloat, ""});
}

}  // namespace

struct Run::Impl::Token {
  std::optional<TokenPlan> plan;
  StripBuffer current;
  std::vector<StripBuffer> references;
  StripBuffer mask, variance;
  std::vector<std::pair<size_t, StripBuffer>> to_write;  // index into outputs
  std::vector<std::vector<StageState>> states;           // per metric, per call; one list for a filter's pass
  std::vector<std::vector<StageState>> filter_states;    // per filter of the drive, of its last pass
  std::vector<StripBuffer> maps;
};

struct Run::Impl::Execution {
  BufferPool pool;
  std::vector<std::unique_ptr<ImageWriter>> writers;  // one per output
  std::vector<std::unique_ptr<ImageWriter>> map_writers;
  std::vector<std::unique_ptr<Pooling>> poolings;  // per metric, or none
  StageState state;                                // of a filter's pass
  std::vector<StageState> metric_states;
  std::vector<bool> failed;  // metrics, over values that are not finite
  std::vector<NonFinite> nonfinite_of_references;
  NonFinite nonfinite_of_test, nonfinite_of_variance, input_nonfinite;
  std::vector<std::unique_ptr<std::atomic<int64_t>>> filter_ns;
  std::mutex mutex;  // of the counts below
  std::vector<NonFinite> replaced;
  std::unique_ptr<Image> held;
  std::unique_ptr<PictureSource> held_source;
  std::unique_ptr<Image> next_held;
  std::shared_ptr<Image> kept;  // with keep_picture
  std::function<void(double)> progress;
  int64_t tokens_done = 0, tokens_total = 0;
  RunResult result;
};

NonFinite Run::Impl::nonfinite_of(const MetricNode& metric, const Execution& run) {
  NonFinite found = run.nonfinite_of_test;
  found += run.nonfinite_of_references[metric.reference];
  if (metric.variance_input >= 0) found += run.nonfinite_of_variance;
  return found;
}

void Run::Impl::run_drive(const Drive& drive, Execution& run) {
  TokenPlanner planner(*this, drive);
  PictureSource& source = drive.from_memory ? *run.held_source : *input;
  const bool final_sink = drive.sink == Sink::kFinal, counts = final_sink && drive.pass == 0;
  const ImageSpec& sink_spec = level(drive.last);
  const bool input_pass = !drive.from_memory && drive.first == 0 && request.nan != NanPolicy::kKeep;

  if (drive.sink == Sink::kHold) {
    run.next_held = std::make_unique<Image>(blank_image(sink_spec, request.input.path));
  }
  if (drive.sink == Sink::kPass) run.state = StageState(filters[static_cast<size_t>(drive.last)]->plan().state_bytes);
  if (final_sink)
    for (size_t m = 0; m < metrics.size(); ++m)
      if (drive.pass < metrics[m]->plan.plan.passes)
        run.metric_states[m] = StageState(metrics[m]->plan.plan.state_bytes);

  const auto read = [&](Token& token) {
    const TokenPlan& plan = *token.plan;
    token.current =
        StripBuffer(run.pool, plan.rows[0], source.spec().width, source.spec().channel_count(), plan.pads[0]);
    source.read_rows(plan.rows[0], token.current.row(plan.rows[0].y0), token.current.stride());
    if (input_pass) {
      const RowRange fresh{std::max(plan.rows[0].y0, plan.fresh[0]), plan.rows[0].y1};
      const NonFinite found = treat_nonfinite(token.current, fresh, false);
      if (request.nan == NanPolicy::kFail && found.total())
        throw_input("'" + request.input.path + "': rows " + std::to_string(fresh.y0) + " to " +
                    std::to_string(fresh.y1 - 1) + " hold " + std::to_string(found.nan) + " NaN and " +
                    std::to_string(found.inf) + " infinite values; --nan zero or keep would go on");
      if (request.nan == NanPolicy::kZero) treat_nonfinite(token.current, plan.rows[0], true);
      if (drive.writes) run.input_nonfinite += found;
    }
    token.references.resize(references.size());
    for (size_t r = 0; r < references.size(); ++r) {
      const RowRange rows = plan.reference_rows[r];
      if (rows.empty()) continue;
      PictureSource& reference = *references[r].source;
      token.references[r] = StripBuffer(run.pool, rows, reference.spec().width, reference.spec().channel_count(),
                                        plan.reference_pads[r]);
      reference.read_rows(rows, token.references[r].row(rows.y0), token.references[r].stride());
    }
    if (!plan.variance_rows.empty()) {
      const RowRange rows = plan.variance_rows;
      token.variance = StripBuffer(run.pool, rows, sink_spec.width, 3, plan.variance_pads);
      variance->read_rows(rows, token.variance.row(rows.y0), token.variance.stride());
    }
    if (!plan.mask_rows.empty()) {
      const RowRange rows = plan.mask_rows;
      token.mask = StripBuffer(run.pool, rows, sink_spec.width, 1, plan.mask_pads);
      StripBuffer weights;
      if (mask) {
        weights = StripBuffer(run.pool, rows, sink_spec.width, mask->spec().channel_count(), {});
        mask->read_rows(rows, weights.row(rows.y0), weights.stride());
      }
      for (int y = rows.y0; y < rows.y1; ++y) {
        float* to = token.mask.row(y);
        for (int x = 0; x < sink_spec.width; ++x) {
          float weight = weights ? weights.row(y)[static_cast<size_t>(x) * weights.channels()] : 1.0f;
          weight = weight > 0 ? std::min(weight, 1.0f) : 0.0f;
          if (request.crop) {
            const CropRequest& c = *request.crop;
            if (x < c.x || y < c.y || x >= c.x + c.width || y >= c.y + c.height) weight = 0;
          }
          to[x] = weight;
        }
      }
    }
  };

  // What is to be written of a level, encoded for its file. `last_use`: nobody reads the strip after this.
  const auto keep_for_writing = [&](Token& token, int at, bool last_use) {
    if (!writes_at(drive, at)) return;
    const size_t k = static_cast<size_t>(at - drive.first);
    const RowRange rows{std::max(token.plan->rows[k].y0, token.plan->fresh[k]), token.plan->rows[k].y1};
    if (rows.empty()) return;
    size_t left = static_cast<size_t>(
        std::count_if(outputs.begin(), outputs.end(), [&](const PictureOutput& o) { return o.level == at; }));
    for (size_t o = 0; o < outputs.size(); ++o) {
      if (outputs[o].level != at) continue;
      --left;
      const bool own = last_use && left == 0;
      StripBuffer out = own ? token.current : copy_of(run.pool, token.current, rows);
      convert_rows(out, rows, outputs[o].spec, outputs[o].transform);
      token.to_write.emplace_back(o, std::move(out));
    }
  };

  const auto run_filter = [&](Token& token, int at) {
    FilterNode& filter = *filters[static_cast<size_t>(at)];
    const size_t k = static_cast<size_t>(at - drive.first);
    const StripNeeds& needs = token.plan->stages[k];
    const bool again = drive.sink == Sink::kPass || !drive.writes;  // another drive does the same
    const int fresh = again ? INT32_MAX : token.plan->fresh[k];
    const int fresh_out = again ? INT32_MAX : token.plan->fresh[k + 1];
    NonFinite replaced;
    {
      const Stopwatch watch(*run.filter_ns[static_cast<size_t>(at)]);
      token.current = filter.run(run.pool, token.current, needs, token.plan->pads[k + 1], fresh, fresh_out, true,
                                 replaced, token.filter_states[k]);
    }
    if (replaced.total()) {
      const std::lock_guard lock(run.mutex);
      run.replaced[static_cast<size_t>(at)] += replaced;
    }
  };

  const auto run_metric = [&](Token& token, size_t m) {
    MetricNode& metric = *metrics[m];
    const TokenPlan& plan = *token.plan;
    if (plan.metrics[m].empty() || run.failed[m]) return;
    const Stopwatch watch(metric.nanoseconds);
    // Both are copied before values are replaced: other metrics look at the same strips.
    const StripBuffer& reference_rows = token.references[metric.reference];
    const ImageSpec& reference_spec = references[metric.reference].source->spec();
    StripBuffer test = prepare_input(run.pool, token.current, false, sink_spec, metric.test_binding);
    StripBuffer reference = prepare_input(run.pool, reference_rows, false, reference_spec, metric.reference_binding);
    const bool last_pass = drive.pass + 1 == metric.plan.plan.passes;
    if (last_pass && metric.makes_map())
      token.maps[m] = StripBuffer(run.pool, plan.sink, metric.map_spec.width, metric.map_spec.channel_count(), {});
    const int edge = metric.plan.plan.edge;
    for (const MetricCall& call : plan.metrics[m]) {
      const triad_rect& test_need = call.needs[static_cast<size_t>(metric.test_input)];
      const triad_rect& reference_need = call.needs[static_cast<size_t>(metric.reference_input)];
      fill_edges(test, test_need, sink_spec.height, edge);
      fill_edges(reference, reference_need, reference_spec.height, edge);
      const triad_strip test_strip = test.view(test_need), reference_strip = reference.view(reference_need);
      std::vector<const triad_strip*> inputs(metric.instance.info().desc->n_inputs, nullptr);
      inputs[static_cast<size_t>(metric.test_input)] = &test_strip;
      inputs[static_cast<size_t>(metric.reference_input)] = &reference_strip;
      triad_strip mask_strip{};
      if (token.mask && metric.mask_input >= 0) {
        const triad_rect& mask_need = call.needs[static_cast<size_t>(metric.mask_input)];
        fill_edges(token.mask, mask_need, sink_spec.height, TRIAD_EDGE_ZERO);
        mask_strip = token.mask.view(mask_need);
        inputs[static_cast<size_t>(metric.mask_input)] = &mask_strip;
      }
      triad_strip variance_strip{};
      if (metric.variance_input >= 0) {
        const triad_rect& variance_need = call.needs[static_cast<size_t>(metric.variance_input)];
        fill_edges(token.variance, variance_need, sink_spec.height, edge);
        variance_strip = token.variance.view(variance_need);
        inputs[static_cast<size_t>(metric.variance_input)] = &variance_strip;
      }
      const triad_rect rect{0, call.out.y0, sink_spec.width, call.out.y1};
      triad_strip map_strip{};
      const bool map = static_cast<bool>(token.maps[m]);
      if (map) map_strip = token.maps[m].view(rect);
      token.states[m].emplace_back(metric.plan.plan.state_bytes);
      auto& state = token.states[m].back();
      metric.instance.strip(drive.pass, rect, inputs, map ? &map_strip : nullptr, state.data());
    }
    if (last_pass && metric.pools()) pool_map(metric, token, token.maps[m], *run.poolings[m]);
    if (metric.map_path.empty()) token.maps[m].reset();
  };

  // Of rows of the test or a reference: what is not finite and not left out by the mask or the crop.
  const auto pooled_nonfinite = [&](const Token& token, const StripBuffer& buffer, const ImageSpec& spec,
                                    RowRange rows) {
    NonFinite found = treat_nonfinite(buffer, rows, false);
    if (!found.total() || !token.mask) return found;
    found = {};
    for (int y = rows.y0; y < rows.y1; ++y) {
      const int mask_y = std::clamp(static_cast<int>(static_cast<int64_t>(y) * sink_spec.height / spec.height),
                                    token.mask.rows().y0, token.mask.rows().y1 - 1);
      for (int x = 0; x < spec.width; ++x)
        if (token.mask.row(mask_y)[static_cast<int64_t>(x) * sink_spec.width / spec.width] > 0)
          found += count_nonfinite(buffer.row(y) + static_cast<size_t>(x) * buffer.channels(),
                                   static_cast<size_t>(buffer.channels()));
    }
    return found;
  };

  // Values that are not finite in what the metrics compare: counted once, weighted out, replaced by 0.
  const auto examine = [&](Token& token) {
    if (!final_sink || metrics.empty()) return;
    const TokenPlan& plan = *token.plan;
    NonFinite in_test;
    std::vector<NonFinite> in_references(references.size());
    NonFinite in_variance;
    if (counts) in_test = pooled_nonfinite(token, token.current, sink_spec, plan.sink);
    if (counts && token.variance)
      in_variance = pooled_nonfinite(
          token, token.variance, sink_spec,
          {std::max(plan.sink.y0, plan.variance_rows.y0), std::min(plan.sink.y1, plan.variance_rows.y1)});
    for (size_t r = 0; r < references.size(); ++r) {
      if (!token.references[r] || !counts) continue;
      // Rows of the reference that belong to this strip alone.
      const int64_t height = references[r].source->spec().height;
      const RowRange all = plan.reference_rows[r];
      RowRange own{static_cast<int>(plan.sink.y0 * height / sink_spec.height),
                   static_cast<int>(plan.sink.y1 * height / sink_spec.height)};
      own = {std::max(own.y0, all.y0), std::min(own.y1, all.y1)};
      in_references[r] = pooled_nonfinite(token, token.references[r], references[r].source->spec(), own);
    }
    if (request.metric_nan == NanPolicy::kIgnore && token.mask)
      for (int y = plan.mask_rows.y0; y < plan.mask_rows.y1; ++y)
        for (int x = 0; x < sink_spec.width; ++x) {
          const auto bad = [&](const StripBuffer& buffer, const ImageSpec& spec) {
            const int64_t x0 = static_cast<int64_t>(x) * spec.width / sink_spec.width;
            const int64_t x1 = std::max(x0 + 1, (static_cast<int64_t>(x) + 1) * spec.width / sink_spec.width);
            const int64_t y0 = static_cast<int64_t>(y) * spec.height / sink_spec.height;
            const int64_t y1 = std::max(y0 + 1, (static_cast<int64_t>(y) + 1) * spec.height / sink_spec.height);
            for (int64_t v = std::max<int64_t>(y0, buffer.rows().y0); v < std::min<int64_t>(y1, buffer.rows().y1);
                 ++v)
              if (count_nonfinite(buffer.row(static_cast<int>(v)) + x0 * buffer.channels(),
                                  static_cast<size_t>(std::min<int64_t>(x1, spec.width) - x0) * buffer.channels())
                      .total())
                return true;
            return false;
          };
          bool out = bad(token.current, sink_spec) || (token.variance && bad(token.variance, sink_spec));
          for (size_t r = 0; r < references.size() && !out; ++r)
            out = token.references[r] && bad(token.references[r], references[r].source->spec());
          if (out) token.mask.row(y)[x] = 0;
        }
    // The files that are written keep their values; the metrics' copy does not.
    if (treat_nonfinite(token.current, token.current.rows(), false).total()) {
      const StripBuffer copy(run.pool, token.current.rows(), token.current.width(), token.current.channels(),
                             token.current.pads());
      for (int y = copy.rows().y0; y < copy.rows().y1; ++y)
        std::memcpy(copy.row(y), token.current.row(y),
                    static_cast<size_t>(copy.width()) * copy.channels() * sizeof(float));
      treat_nonfinite(copy, copy.rows(), true);
      token.current = copy;
    }
    for (const StripBuffer& reference : token.references)
      if (reference) treat_nonfinite(reference, reference.rows(), true);
    if (token.variance) treat_nonfinite(token.variance, token.variance.rows(), true);
    if (!counts) return;
    const std::lock_guard lock(run.mutex);
    run.nonfinite_of_test += in_test;
    run.nonfinite_of_variance += in_variance;
    for (size_t r = 0; r < references.size(); ++r) run.nonfinite_of_references[r] += in_references[r];
  };

  std::vector<StageState> filter_totals;
  for (int at = drive.first; at < drive.last; ++at)
    filter_totals.emplace_back(filters[static_cast<size_t>(at)]->plan().state_bytes);
  const auto finish = [&](Token& token) {
    for (auto& [o, strip] : token.to_write) {
      const size_t k = static_cast<size_t>(outputs[o].level - drive.first);
      const RowRange rows{std::max(token.plan->rows[k].y0, token.plan->fresh[k]), token.plan->rows[k].y1};
      run.writers[o]->write_rows(rows.y0, rows.y1, strip.row(rows.y0), strip.stride());
    }
    for (size_t k = 0; k < token.filter_states.size(); ++k)
      for (const auto& state : token.filter_states[k]) {
        const FilterNode& filter = *filters[static_cast<size_t>(drive.first) + k];
        filter.instance().merge(filter.plan().passes - 1, filter_totals[k].data(), state.data());
      }
    if (drive.sink == Sink::kPass) {
      FilterNode& filter = *filters[static_cast<size_t>(drive.last)];
      for (const auto& state : token.states[0])
        if (state.data()) filter.instance().merge(drive.pass, run.state.data(), state.data());
    }
    if (final_sink)
      for (size_t m = 0; m < metrics.size(); ++m) {
        for (const auto& state : token.states[m])
          if (state.data()) metrics[m]->instance.merge(drive.pass, run.metric_states[m].data(), state.data());
        if (token.maps[m])
          run.map_writers[m]->write_rows(token.plan->sink.y0, token.plan->sink.y1,
                                         token.maps[m].row(token.plan->sink.y0), token.maps[m].stride());
      }
    ++run.tokens_done;
    if (run.progress)
      run.progress(static_cast<double>(run.tokens_done) /
                   static_cast<double>(std::max<int64_t>(1, run.tokens_total)));
  };

  // The steps between reading and finishing, each serial or free.
  struct Step {
    bool serial;
    std::function<void(Token&)> work;
  };
  std::vector<Step> steps;
  for (int at = drive.first; at < drive.last; ++at) {
    steps.push_back({false, [&, at](Token& token) { keep_for_writing(token, at, false); }});
    steps.push_back({filters[static_cast<size_t>(at)]->plan().threads == TRIAD_SERIAL,
                     [&, at](Token& token) { run_filter(token, at); }});
  }
  if (drive.sink == Sink::kHold) {
    steps.push_back({false, [&](Token& token) {
                       keep_for_writing(token, drive.last, false);
                       for (int y = token.plan->sink.y0; y < token.plan->sink.y1; ++y)
                         std::memcpy(run.next_held->row(y), token.current.row(y),
                                     run.next_held->row_floats() * sizeof(float));
                     }});
  } else if (drive.sink == Sink::kPass) {
    FilterNode& filter = *filters[static_cast<size_t>(drive.last)];
    steps.push_back({filter.plan().threads == TRIAD_SERIAL, [&](Token& token) {
                       token.states.resize(1);
                       const Stopwatch watch(*run.filter_ns[static_cast<size_t>(drive.last)]);
                       filter.run_pass(run.pool, drive.pass, token.current, token.plan->stages.back(), true,
                                       token.states[0]);
                     }});
  } else if (drive.sink == Sink::kWrite) {
    steps.push_back({false, [&](Token& token) { keep_for_writing(token, drive.last, true); }});
  } else {
    steps.push_back({false, [&](Token& token) {
                       token.states.resize(metrics.size());
                       token.maps.resize(metrics.size());
                       keep_for_writing(token, drive.last, metrics.empty());
                       examine(token);
                     }});
    for (size_t m = 0; m < metrics.size(); ++m)
      steps.push_back(
          {metrics[m]->plan.plan.threads == TRIAD_SERIAL, [&, m](Token& token) { run_metric(token, m); }});
  }
  steps.push_back({true, finish});

  // oneTBB orders all steps before the pipeline's return, but ThreadSanitizer cannot see into it; this says so.
  std::atomic<int64_t> done{0};
  using TokenPtr = std::shared_ptr<Token>;
  tbb::filter<void, TokenPtr> line = tbb::make_filter<void, TokenPtr>(
      tbb::filter_mode::serial_in_order, [&](tbb::flow_control& control) -> TokenPtr {
        auto token = std::make_shared<Token>();
        token->plan = planner.next();
        if (!token->plan) {
          control.stop();
          return nullptr;
        }
        check_cancel();
        token->filter_states.resize(filter_totals.size());
        read(*token);
        return token;
      });
  // Free steps that follow each other run as one.
  for (size_t begin = 0; begin < steps.size();) {
    size_t end = begin + 1;
    while (end < steps.size() && steps[end].serial == steps[begin].serial) ++end;
    line = line & tbb::make_filter<TokenPtr, TokenPtr>(
                      steps[begin].serial ? tbb::filter_mode::serial_in_order : tbb::filter_mode::parallel,
                      [&steps, &done, begin, end](TokenPtr token) {
                        for (size_t s = begin; s < end; ++s) steps[s].work(*token);
                        done.fetch_add(1, std::memory_order_release);
                        return token;
                      });
    begin = end;
  }
  tbb::parallel_pipeline(static_cast<size_t>(drive.in_flight),
                         line & tbb::make_filter<TokenPtr, void>(tbb::filter_mode::serial_in_order, [](TokenPtr) {}));

  static_cast<void>(done.load(std::memory_order_acquire));

  if (drive.sink == Sink::kHold) {
    run.held = std::move(run.next_held);
    run.held_source = memory_source(*run.held);
  }
  if (drive.sink == Sink::kPass)
    filters[static_cast<size_t>(drive.last)]->instance().end_pass(drive.pass, run.state.data());
  if (drive.sink != Sink::kPass && drive.writes)
    for (size_t k = 0; k < filter_totals.size(); ++k) {
      FilterNode& filter = *filters[static_cast<size_t>(drive.first) + k];
      filter.instance().end_pass(filter.plan().passes - 1, filter_totals[k].data());
    }
}

void Run::Impl::pool_map(const MetricNode& metric, const Token& token, const StripBuffer& map,
                         Pooling& pooling) const {
  const int y0 = std::max(token.plan->sink.y0, metric.pool.y0), y1 = std::min(token.plan->sink.y1, metric.pool.y1);
  const int x0 = metric.pool.x0, width = metric.pool.x1 - x0, channels = map.channels();
  const int64_t row_values = int64_t{width} * channels;
  const int rows_at_once = static_cast<int>(std::clamp<int64_t>(FloatBins::kMostValues / row_values, 1, INT32_MAX));
  for (int y = y0; y < y1;) {
    const int end = static_cast<int>(std::min<int64_t>(y1, int64_t{y} + rows_at_once));
    auto block = pooling.take(static_cast<size_t>(end - y) * static_cast<size_t>(row_values));
    for (; y < end; ++y)
      block->add_row(map.row(y) + static_cast<int64_t>(x0) * channels,
                     pools_by_weight() ? token.mask.row(y) + x0 : nullptr, width, channels, x0, y);
    if (const auto& at = block->nan_at())
      throw PluginError("map.not-a-number", metric.instance.info().id(), metric.instance.info().file,
                        "strip() wrote a value that is not a number into its map, at x " + std::to_string(at->x) +
                            ", y " + std::to_string(at->y) + ", channel " + std::to_string(at->channel));
    pooling.add(std::move(block));
  }
}

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
    run_drive(drive, run);
    if (drive.sink != Sink::kFinal) continue;
    for (size_t m = 0; m < metrics.size(); ++m) {
      if (drive.pass >= metrics[m]->plan.plan.passes || run.failed[m]) continue;
      // What a metric would say of pictures whose bad values count as 0 is not what is wrong with them.
      run.failed[m] = request.metric_nan == NanPolicy::kFail && nonfinite_of(*metrics[m], run).total() > 0;
      if (run.failed[m]) {
        if (drive.pass + 1 < metrics[m]->plan.plan.passes && run.map_writers[m]) run.map_writers[m].reset();
        continue;
      }
      const Stopwatch watch(metrics[m]->nanoseconds);
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
