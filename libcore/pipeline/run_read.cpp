// SPDX-License-Identifier: Apache-2.0
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <triad/base/error.hpp>
#include <triad/pipeline/run_drive.hpp>

namespace triad {
namespace {

// Reading jobs of one strip, side by side. Most of the time of a comparison is decoding, and each picture has a
// decoder of its own. Of several errors the first job's counts, whichever came first.
void run_side_by_side(const std::vector<std::function<void()>>& jobs) {
  if (jobs.size() == 1) return jobs.front()();
  std::vector<std::exception_ptr> errors(jobs.size());
  std::atomic<size_t> done{0};  // oneTBB orders the jobs before wait()'s return; this tells ThreadSanitizer so
  // Isolated: while it waits, this thread must not begin with another strip, which could take longer than the
  // reading.
  tbb::this_task_arena::isolate([&] {
    tbb::task_group group;
    for (size_t i = 1; i < jobs.size(); ++i)
      group.run([&, i] {
        try {
          jobs[i]();
        } catch (...) {
          errors[i] = std::current_exception();
        }
        done.fetch_add(1, std::memory_order_release);
      });
    try {
      jobs[0]();
    } catch (...) {
      errors[0] = std::current_exception();
    }
    group.wait();
    static_cast<void>(done.load(std::memory_order_acquire));
  });
  for (const auto& error : errors)
    if (error) std::rethrow_exception(error);
}

}  // namespace

void Run::Impl::DriveWork::read(Token& token) {
  const TokenPlan& plan = *token.plan;
  std::vector<std::function<void()>> jobs;
  jobs.emplace_back([&] { read_input(token); });
  token.references.resize(impl_.references.size());
  for (size_t r = 0; r < impl_.references.size(); ++r) {
    if (plan.reference_rows[r].empty()) continue;
    jobs.emplace_back([&, r] {
      const RowRange rows = plan.reference_rows[r];
      PictureSource& source = *impl_.references[r].source;
      StripBuffer& strip = token.references[r];
      strip =
          StripBuffer(run_.pool, rows, source.spec().width, source.spec().channel_count(), plan.reference_pads[r]);
      source.read_rows(rows, strip.row(rows.y0), strip.stride());
    });
  }
  if (!plan.variance_rows.empty())
    jobs.emplace_back([&] {
      const RowRange rows = plan.variance_rows;
      token.variance = StripBuffer(run_.pool, rows, sink_spec_.width, 3, plan.variance_pads);
      impl_.variance->read_rows(rows, token.variance.row(rows.y0), token.variance.stride());
    });
  if (!plan.mask_rows.empty()) jobs.emplace_back([&] { read_mask(token); });
  run_side_by_side(jobs);
}

void Run::Impl::DriveWork::read_input(Token& token) {
  const TokenPlan& plan = *token.plan;
  const RowRange rows = plan.rows[0];
  token.current = StripBuffer(run_.pool, rows, source_.spec().width, source_.spec().channel_count(), plan.pads[0]);
  source_.read_rows(rows, token.current.row(rows.y0), token.current.stride());
  const RunRequest& request = impl_.request;
  if (drive_.from_memory || drive_.first != 0 || request.nan == NanPolicy::kKeep) return;
  const RowRange fresh{std::max(rows.y0, plan.fresh[0]), rows.y1};
  const NonFinite found = treat_nonfinite(token.current, fresh, false);
  if (request.nan == NanPolicy::kFail && found.total())
    throw_input("'" + request.input.path + "': rows " + std::to_string(fresh.y0) + " to " +
                std::to_string(fresh.y1 - 1) + " hold " + std::to_string(found.nan) + " NaN and " +
                std::to_string(found.inf) + " infinite values; --nan zero or keep would go on");
  if (request.nan == NanPolicy::kZero) treat_nonfinite(token.current, rows, true);
  if (drive_.writes) run_.input_nonfinite += found;  // strips are read one by one
}

void Run::Impl::DriveWork::read_mask(Token& token) {
  const TokenPlan& plan = *token.plan;
  const RowRange rows = plan.mask_rows;
  token.mask = StripBuffer(run_.pool, rows, sink_spec_.width, 1, plan.mask_pads);
  StripBuffer weights;
  if (impl_.mask) {
    weights = StripBuffer(run_.pool, rows, sink_spec_.width, impl_.mask->spec().channel_count(), {});
    impl_.mask->read_rows(rows, weights.row(rows.y0), weights.stride());
  }
  for (int y = rows.y0; y < rows.y1; ++y) {
    float* to = token.mask.row(y);
    for (int x = 0; x < sink_spec_.width; ++x) {
      float weight = weights ? weights.row(y)[static_cast<size_t>(x) * weights.channels()] : 1.0f;
      weight = weight > 0 ? std::min(weight, 1.0f) : 0.0f;
      if (impl_.request.crop) {
        const CropRequest& c = *impl_.request.crop;
        if (x < c.x || y < c.y || x >= c.x + c.width || y >= c.y + c.height) weight = 0;
      }
      to[x] = weight;
    }
  }
}

}  // namespace triad
