// SPDX-License-Identifier: Apache-2.0
// What a Run pools of its metrics' maps.
#include <algorithm>
#include <cmath>
#include <triad/base/parallel.hpp>
#include <triad/pipeline/run_impl.hpp>

namespace triad {
namespace {

constexpr uint64_t kKeepBytes = 64u << 20;  // of values that stay in memory; 16 million of them
constexpr uint64_t kLeastShare = 16;        // of the memory that may be used, no more than a part

// Which side of a map's values is better. A score that may be infinite is no mean of a map's values (PSNR of an
// error), and one that is best at zero is signed, while most maps hold sizes.
int better_of(const triad_desc& desc) {
  for (uint32_t s = 0; s < desc.n_scores; ++s)
    if (desc.scores[s]->better != 0 && !(desc.scores[s]->flags & TRIAD_SCORE_MAY_BE_INFINITE))
      return desc.scores[s]->better;
  return -1;
}

}  // namespace

uint64_t Run::Impl::pool_keep_bytes() const {
  const auto pooled =
      static_cast<uint64_t>(std::count_if(metrics.begin(), metrics.end(), [](const auto& m) { return m->pools(); }));
  const uint64_t limit = request.max_memory ? request.max_memory : machine_memory_bytes() / 2;
  return std::min(kKeepBytes, limit / kLeastShare) / std::max<uint64_t>(1, pooled);
}

std::unique_ptr<Pooling> Run::Impl::make_pooling(const MetricNode& metric) const {
  return std::make_unique<Pooling>(pools_by_weight(), pool_keep_bytes(),
                                   metric.pooled_values({0, metric.map_spec.height}));
}

std::optional<MetricResult::Pooled> Run::Impl::pooled_result(const MetricNode& metric, Pooling& pooling) const {
  auto found = pooling.finish();
  if (!found) return std::nullopt;
  const triad_desc& desc = *metric.instance.info().desc;
  MetricResult::Pooled pooled;
  const int better = better_of(desc);
  const auto add = [&](const std::string& name, double value) { pooled.scores.push_back({name, "", value, better}); };
  if (!std::isnan(found->mean)) add("mean", found->mean);
  add("min", found->min);
  for (size_t p = 0; p < kPooledPercents.size(); ++p)
    add("p" + std::to_string(kPooledPercents[p]), found->percentiles[p]);
  add("max", found->max);
  for (size_t p = 0; found->weighted && p < kPooledPercents.size(); ++p)
    add("weighted-p" + std::to_string(kPooledPercents[p]), (*found->weighted)[p]);
  pooled.min_at = {found->min_at.x, found->min_at.y, found->min_at.channel};
  pooled.max_at = {found->max_at.x, found->max_at.y, found->max_at.channel};
  pooled.histogram = {found->low, found->high, std::move(found->histogram)};
  pooled.values = found->values;
  pooled.weight = found->weight;
  return pooled;
}

}  // namespace triad
