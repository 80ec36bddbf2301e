// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <triad/pipeline/run_drive.hpp>

namespace triad {

NonFinite treat_nonfinite(const StripBuffer& buffer, RowRange rows, bool zero) {
  NonFinite found;
  for (int y = rows.y0; y < rows.y1; ++y) {
    const size_t count = static_cast<size_t>(buffer.width()) * buffer.channels();
    found += zero ? zero_nonfinite(buffer.row(y), count) : count_nonfinite(buffer.row(y), count);
  }
  return found;
}

NonFinite Run::Impl::nonfinite_of(const MetricNode& metric, const Execution& run) {
  NonFinite found = run.nonfinite_of_test;
  found += run.nonfinite_of_references[metric.reference];
  if (metric.variance_input >= 0) found += run.nonfinite_of_variance;
  return found;
}

void Run::Impl::DriveWork::examine(Token& token) {
  if (!final_sink_ || impl_.metrics.empty()) return;
  if (counts_) count_nonfinite_values(token);
  if (impl_.request.metric_nan == NanPolicy::kIgnore && token.mask) leave_out_nonfinite(token);
  // The files that are written keep their values; the metrics' copy does not.
  if (treat_nonfinite(token.current, token.current.rows(), false).total()) {
    token.current = copy_of(run_.pool, token.current, token.current.rows(), token.current.pads());
    treat_nonfinite(token.current, token.current.rows(), true);
  }
  for (const StripBuffer& reference : token.references)
    if (reference) treat_nonfinite(reference, reference.rows(), true);
  if (token.variance) treat_nonfinite(token.variance, token.variance.rows(), true);
}

void Run::Impl::DriveWork::count_nonfinite_values(const Token& token) {
  const TokenPlan& plan = *token.plan;
  const NonFinite in_test = pooled_nonfinite(token, token.current, sink_spec_, plan.sink);
  NonFinite in_variance;
  if (token.variance)
    in_variance = pooled_nonfinite(
        token, token.variance, sink_spec_,
        {std::max(plan.sink.y0, plan.variance_rows.y0), std::min(plan.sink.y1, plan.variance_rows.y1)});
  std::vector<NonFinite> in_references(impl_.references.size());
  for (size_t r = 0; r < in_references.size(); ++r) {
    if (!token.references[r]) continue;
    // Rows of the reference that belong to this strip alone.
    const ImageSpec& spec = impl_.references[r].source->spec();
    const int64_t height = spec.height;
    const RowRange all = plan.reference_rows[r];
    RowRange own{static_cast<int>(plan.sink.y0 * height / sink_spec_.height),
                 static_cast<int>(plan.sink.y1 * height / sink_spec_.height)};
    own = {std::max(own.y0, all.y0), std::min(own.y1, all.y1)};
    in_references[r] = pooled_nonfinite(token, token.references[r], spec, own);
  }
  const std::lock_guard lock(run_.mutex);
  run_.nonfinite_of_test += in_test;
  run_.nonfinite_of_variance += in_variance;
  for (size_t r = 0; r < in_references.size(); ++r) run_.nonfinite_of_references[r] += in_references[r];
}

// Of rows of the test or a reference: what is not finite and not left out by the mask or the crop.
NonFinite Run::Impl::DriveWork::pooled_nonfinite(const Token& token, const StripBuffer& buffer, const ImageSpec& spec,
                                                 RowRange rows) const {
  NonFinite found = treat_nonfinite(buffer, rows, false);
  if (!found.total() || !token.mask) return found;
  found = {};
  for (int y = rows.y0; y < rows.y1; ++y) {
    const int mask_y = std::clamp(static_cast<int>(static_cast<int64_t>(y) * sink_spec_.height / spec.height),
                                  token.mask.rows().y0, token.mask.rows().y1 - 1);
    for (int x = 0; x < spec.width; ++x)
      if (token.mask.row(mask_y)[static_cast<int64_t>(x) * sink_spec_.width / spec.width] > 0)
        found += count_nonfinite(buffer.row(y) + static_cast<size_t>(x) * buffer.channels(),
                                 static_cast<size_t>(buffer.channels()));
  }
  return found;
}

void Run::Impl::DriveWork::leave_out_nonfinite(Token& token) const {
  // Whether the part of a picture of `spec` that lies on the sink's pixel (x, y) holds such a value.
  const auto bad = [&](const StripBuffer& buffer, const ImageSpec& spec, int x, int y) {
    const int64_t x0 = static_cast<int64_t>(x) * spec.width / sink_spec_.width;
    const int64_t x1 = std::max(x0 + 1, (static_cast<int64_t>(x) + 1) * spec.width / sink_spec_.width);
    const int64_t y0 = static_cast<int64_t>(y) * spec.height / sink_spec_.height;
    const int64_t y1 = std::max(y0 + 1, (static_cast<int64_t>(y) + 1) * spec.height / sink_spec_.height);
    const size_t count = static_cast<size_t>(std::min<int64_t>(x1, spec.width) - x0) * buffer.channels();
    for (int64_t v = std::max<int64_t>(y0, buffer.rows().y0); v < std::min<int64_t>(y1, buffer.rows().y1); ++v)
      if (count_nonfinite(buffer.row(static_cast<int>(v)) + x0 * buffer.channels(), count).total()) return true;
    return false;
  };
  for (int y = token.plan->mask_rows.y0; y < token.plan->mask_rows.y1; ++y)
    for (int x = 0; x < sink_spec_.width; ++x) {
      bool out = bad(token.current, sink_spec_, x, y) || (token.variance && bad(token.variance, sink_spec_, x, y));
      for (size_t r = 0; r < impl_.references.size() && !out; ++r)
        out = token.references[r] && bad(token.references[r], impl_.references[r].source->spec(), x, y);
      if (out) token.mask.row(y)[x] = 0;
    }
}

}  // namespace triad
