// SPDX-License-Identifier: Apache-2.0
#include <oneapi/tbb/parallel_pipeline.h>

#include <algorithm>
#include <cstring>
#include <triad/base/file.hpp>
#include <triad/pipeline/picture_keeper.hpp>
#include <triad/pipeline/run_drive.hpp>

namespace triad {

Run::Impl::DriveWork::DriveWork(Impl& impl, const Drive& drive, Execution& run)
    : impl_(impl),
      drive_(drive),
      run_(run),
      source_(drive.from_memory ? *run.held_source : *impl.input),
      sink_spec_(impl.level(drive.last)),
      final_sink_(drive.sink == Sink::kFinal),
      counts_(final_sink_ && drive.pass == 0) {
  if (drive.sink == Sink::kHold)
    run.next_held = std::make_unique<Image>(blank_image(sink_spec_, impl.request.input.path));
  if (drive.sink == Sink::kPass)
    run.state = StageState(impl.filters[static_cast<size_t>(drive.last)]->plan().state_bytes);
  if (final_sink_)
    for (size_t m = 0; m < impl.metrics.size(); ++m)
      if (drive.pass < impl.metrics[m]->plan.plan.passes)
        run.metric_states[m] = StageState(impl.metrics[m]->plan.plan.state_bytes);
  for (int at = drive.first; at < drive.last; ++at)
    filter_totals_.emplace_back(impl.filters[static_cast<size_t>(at)]->plan().state_bytes);
}

void Run::Impl::DriveWork::operator()() {
  const std::vector<Step> steps = this->steps();
  TokenPlanner planner(impl_, drive_);
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
        token->filter_states.resize(filter_totals_.size());
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
  tbb::parallel_pipeline(static_cast<size_t>(drive_.in_flight),
                         line & tbb::make_filter<TokenPtr, void>(tbb::filter_mode::serial_in_order, [](TokenPtr) {}));

  static_cast<void>(done.load(std::memory_order_acquire));
  finish();
}

std::vector<Run::Impl::DriveWork::Step> Run::Impl::DriveWork::steps() {
  std::vector<Step> steps;
  for (int at = drive_.first; at < drive_.last; ++at) {
    steps.push_back({false, [this, at](Token& token) { keep_for_writing(token, at, false); }});
    steps.push_back({impl_.filters[static_cast<size_t>(at)]->plan().threads == TRIAD_SERIAL,
                     [this, at](Token& token) { run_filter(token, at); }});
  }
  if (drive_.sink == Sink::kHold) {
    steps.push_back({false, [this](Token& token) {
                       keep_for_writing(token, drive_.last, false);
                       for (int y = token.plan->sink.y0; y < token.plan->sink.y1; ++y)
                         std::memcpy(run_.next_held->row(y), token.current.row(y),
                                     run_.next_held->row_floats() * sizeof(float));
                     }});
  } else if (drive_.sink == Sink::kPass) {
    FilterNode& filter = *impl_.filters[static_cast<size_t>(drive_.last)];
    steps.push_back({filter.plan().threads == TRIAD_SERIAL, [this, &filter](Token& token) {
                       token.states.resize(1);
                       const ScopedNanoseconds watch(*run_.filter_ns[static_cast<size_t>(drive_.last)]);
                       filter.run_pass(run_.pool, drive_.pass, token.current, token.plan->stages.back(), true,
                                       token.states[0]);
                     }});
  } else if (drive_.sink == Sink::kWrite) {
    steps.push_back({false, [this](Token& token) { keep_for_writing(token, drive_.last, true); }});
  } else {
    steps.push_back({false, [this](Token& token) {
                       token.states.resize(impl_.metrics.size());
                       token.maps.resize(impl_.metrics.size());
                       keep_for_writing(token, drive_.last, impl_.metrics.empty());
                       examine(token);
                     }});
    for (size_t m = 0; m < impl_.metrics.size(); ++m)
      steps.push_back(
          {impl_.metrics[m]->plan.plan.threads == TRIAD_SERIAL, [this, m](Token& token) { run_metric(token, m); }});
  }
  steps.push_back({true, [this](Token& token) { merge_and_write(token); }});
  return steps;
}

void Run::Impl::DriveWork::merge_and_write(Token& token) {
  for (auto& [o, strip] : token.to_write) {
    const size_t k = static_cast<size_t>(impl_.outputs[o].level - drive_.first);
    const RowRange rows{std::max(token.plan->rows[k].y0, token.plan->fresh[k]), token.plan->rows[k].y1};
    run_.writers[o]->write_rows(rows.y0, rows.y1, strip.row(rows.y0), strip.stride());
  }
  for (size_t k = 0; k < token.filter_states.size(); ++k)
    for (const auto& state : token.filter_states[k]) {
      const FilterNode& filter = *impl_.filters[static_cast<size_t>(drive_.first) + k];
      filter.instance().merge(filter.plan().passes - 1, filter_totals_[k].data(), state.data());
    }
  if (drive_.sink == Sink::kPass) {
    FilterNode& filter = *impl_.filters[static_cast<size_t>(drive_.last)];
    for (const auto& state : token.states[0])
      if (state.data()) filter.instance().merge(drive_.pass, run_.state.data(), state.data());
  }
  if (final_sink_)
    for (size_t m = 0; m < impl_.metrics.size(); ++m) {
      for (const auto& state : token.states[m])
        if (state.data()) impl_.metrics[m]->instance.merge(drive_.pass, run_.metric_states[m].data(), state.data());
      if (token.maps[m])
        run_.map_writers[m]->write_rows(token.plan->sink.y0, token.plan->sink.y1,
                                        token.maps[m].row(token.plan->sink.y0), token.maps[m].stride());
    }
  ++run_.tokens_done;
  if (run_.progress)
    run_.progress(static_cast<double>(run_.tokens_done) /
                  static_cast<double>(std::max<int64_t>(1, run_.tokens_total)));
}

void Run::Impl::DriveWork::finish() {
  if (drive_.sink == Sink::kHold) {
    run_.held = std::move(run_.next_held);
    run_.held_source = memory_source(*run_.held);
  }
  if (drive_.sink == Sink::kPass)
    impl_.filters[static_cast<size_t>(drive_.last)]->instance().end_pass(drive_.pass, run_.state.data());
  if (drive_.sink != Sink::kPass && drive_.writes)
    for (size_t k = 0; k < filter_totals_.size(); ++k) {
      FilterNode& filter = *impl_.filters[static_cast<size_t>(drive_.first) + k];
      filter.instance().end_pass(filter.plan().passes - 1, filter_totals_[k].data());
    }
}

}  // namespace triad
