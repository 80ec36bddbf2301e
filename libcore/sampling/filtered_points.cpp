// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <triad/sampling/filtered_points.hpp>

namespace triad {

FilteredPoints::FilteredPoints(const StrategyInfo& info, const StrategyValues& values)
    : StrategyBase(info, values),
      filter_(static_cast<ReconstructionKernel>(whole("filter")), value("scale")),
      table_(filter_),
      points_(static_cast<PixelPoints::Kind>(whole("points")), whole("spp")) {}

uint64_t FilteredPoints::most_samples(int width, int height) const {
  return uint64_t{spp()} * static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
}

float FilteredPoints::footprint_px() const { return 1 / std::sqrt(static_cast<float>(spp())); }

std::vector<StrategyParam> FilteredPoints::params(std::vector<StrategyParam> more) {
  StrategyParam filter = choice_param("filter", "the reconstruction filter", reconstruction_names());
  filter.usual = static_cast<double>(ReconstructionKernel::kGaussian);
  std::vector<StrategyParam> params{std::move(filter),
                                    {"spp", "samples per pixel", 1, 1 << 24, 16},
                                    PixelPoints::param(),
                                    {"scale", "of the filter: 2 makes it twice as wide", .125, 8, 1, true}};
  params.insert(params.end(), more.begin(), more.end());
  return params;
}

}  // namespace triad
