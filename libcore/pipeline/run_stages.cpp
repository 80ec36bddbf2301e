// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/run_drive.hpp>

namespace triad {

StripBuffer copy_of(BufferPool& pool, const StripBuffer& from, RowRange rows, const Pads& pads) {
  StripBuffer copy(pool, rows, from.width(), from.channels(), pads);
  for (int y = rows.y0; y < rows.y1; ++y)
    std::memcpy(copy.row(y), from.row(y), static_cast<size_t>(from.width()) * from.channels() * sizeof(float));
  return copy;
}

void Run::Impl::DriveWork::keep_for_writing(Token& token, int at, bool last_use) {
  if (!impl_.writes_at(drive_, at)) return;
  const size_t k = static_cast<size_t>(at - drive_.first);
  const RowRange rows{std::max(token.plan->rows[k].y0, token.plan->fresh[k]), token.plan->rows[k].y1};
  if (rows.empty()) return;
  size_t left = static_cast<size_t>(std::count_if(impl_.outputs.begin(), impl_.outputs.end(),
                                                  [&](const PictureOutput& o) { return o.level == at; }));
  for (size_t o = 0; o < impl_.outputs.size(); ++o) {
    if (impl_.outputs[o].level != at) continue;
    --left;
    const bool own = last_use && left == 0;
    StripBuffer out = own ? token.current : copy_of(run_.pool, token.current, rows, {});
    convert_rows(out, rows, impl_.outputs[o].spec, impl_.outputs[o].transform);
    token.to_write.emplace_back(o, std::move(out));
  }
}

void Run::Impl::DriveWork::run_filter(Token& token, int at) {
  FilterNode& filter = *impl_.filters[static_cast<size_t>(at)];
  const size_t k = static_cast<size_t>(at - drive_.first);
  const StripNeeds& needs = token.plan->stages[k];
  const bool again = drive_.sink == Sink::kPass || !drive_.writes;  // another drive does the same
  const int fresh = again ? INT32_MAX : token.plan->fresh[k];
  const int fresh_out = again ? INT32_MAX : token.plan->fresh[k + 1];
  NonFinite replaced;
  {
    const ScopedNanoseconds watch(*run_.filter_ns[static_cast<size_t>(at)]);
    token.current = filter.run(run_.pool, token.current, needs, token.plan->pads[k + 1], fresh, fresh_out, true,
                               replaced, token.filter_states[k]);
  }
  if (replaced.total()) {
    const std::lock_guard lock(run_.mutex);
    run_.replaced[static_cast<size_t>(at)] += replaced;
  }
}

void Run::Impl::DriveWork::run_metric(Token& token, size_t m) {
  MetricNode& metric = *impl_.metrics[m];
  const TokenPlan& plan = *token.plan;
  if (plan.metrics[m].empty() || run_.failed[m]) return;
  const ScopedNanoseconds watch(metric.nanoseconds);
  // Both are copied before values are replaced: other metrics look at the same strips.
  const StripBuffer& reference_rows = token.references[metric.reference];
  const ImageSpec& reference_spec = impl_.references[metric.reference].source->spec();
  StripBuffer test = prepare_input(run_.pool, token.current, false, sink_spec_, metric.test_binding);
  StripBuffer reference = prepare_input(run_.pool, reference_rows, false, reference_spec, metric.reference_binding);
  const bool last_pass = drive_.pass + 1 == metric.plan.plan.passes;
  if (last_pass && metric.makes_map())
    token.maps[m] = StripBuffer(run_.pool, plan.sink, metric.map_spec.width, metric.map_spec.channel_count(), {});
  const int edge = metric.plan.plan.edge;
  for (const MetricCall& call : plan.metrics[m]) {
    const triad_rect& test_need = call.needs[static_cast<size_t>(metric.test_input)];
    const triad_rect& reference_need = call.needs[static_cast<size_t>(metric.reference_input)];
    fill_edges(test, test_need, sink_spec_.height, edge);
    fill_edges(reference, reference_need, reference_spec.height, edge);
    const triad_strip test_strip = test.view(test_need), reference_strip = reference.view(reference_need);
    std::vector<const triad_strip*> inputs(metric.instance.info().desc->n_inputs, nullptr);
    inputs[static_cast<size_t>(metric.test_input)] = &test_strip;
    inputs[static_cast<size_t>(metric.reference_input)] = &reference_strip;
    triad_strip mask_strip{};
    if (token.mask && metric.mask_input >= 0) {
      const triad_rect& mask_need = call.needs[static_cast<size_t>(metric.mask_input)];
      fill_edges(token.mask, mask_need, sink_spec_.height, TRIAD_EDGE_ZERO);
      mask_strip = token.mask.view(mask_need);
      inputs[static_cast<size_t>(metric.mask_input)] = &mask_strip;
    }
    triad_strip variance_strip{};
    if (metric.variance_input >= 0) {
      const triad_rect& variance_need = call.needs[static_cast<size_t>(metric.variance_input)];
      fill_edges(token.variance, variance_need, sink_spec_.height, edge);
      variance_strip = token.variance.view(variance_need);
      inputs[static_cast<size_t>(metric.variance_input)] = &variance_strip;
    }
    const triad_rect rect{0, call.out.y0, sink_spec_.width, call.out.y1};
    triad_strip map_strip{};
    const bool map = static_cast<bool>(token.maps[m]);
    if (map) map_strip = token.maps[m].view(rect);
    token.states[m].emplace_back(metric.plan.plan.state_bytes);
    auto& state = token.states[m].back();
    metric.instance.strip(drive_.pass, rect, inputs, map ? &map_strip : nullptr, state.data());
  }
  if (last_pass && metric.pools()) pool_map(metric, token, token.maps[m], *run_.poolings[m]);
  if (metric.map_path.empty()) token.maps[m].reset();
}

void Run::Impl::DriveWork::pool_map(const MetricNode& metric, const Token& token, const StripBuffer& map,
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
                     impl_.pools_by_weight() ? token.mask.row(y) + x0 : nullptr, width, channels, x0, y);
    if (const auto& at = block->nan_at())
      throw PluginError("map.not-a-number", metric.instance.info().id(), metric.instance.info().file,
                        "strip() wrote a value that is not a number into its map, at x " + std::to_string(at->x) +
                            ", y " + std::to_string(at->y) + ", channel " + std::to_string(at->channel));
    pooling.add(std::move(block));
  }
}

}  // namespace triad
