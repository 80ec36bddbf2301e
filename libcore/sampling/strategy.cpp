// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <triad/base/error.hpp>
#include <triad/sampling/strategy_base.hpp>

namespace triad {
namespace {

const std::vector<const StrategyEntry*>& entries() {
  static const std::vector<const StrategyEntry*> list{&control_strategy(),
                                                      &grid_strategy(),
                                                      &random_strategy(),
                                                      &jitter_strategy(),
                                                      &sobol_owen_strategy(),
                                                      &per_subpixel_strategy(),
                                                      &random_subpixel_strategy(),
                                                      &cells_strategy(),
                                                      &uniform_strategy(),
                                                      &splat_strategy(),
                                                      &importance_strategy(),
                                                      &pov1_strategy(),
                                                      &pov2_strategy(),
                                                      &pov3_strategy(),
                                                      &pov4_strategy(),
                                                      &pov5_strategy(),
                                                      &pov_stochastic_strategy(),
                                                      &quad_strategy(),
                                                      &tri_strategy(),
                                                      &variance_strategy(),
                                                      &exact_strategy()};
  return list;
}

}  // namespace

std::string StrategyBase::text() const { return named_text(info_, values_); }

Image RenderResult::image(const std::vector<std::string>& reason_channels) const {
  if (reason_channels.size() != reasons.size()) throw_internal("a render has other reasons than were asked for");
  Image image = film.image();
  const size_t before = image.spec.channels.size(), channels = before + reasons.size();
  for (size_t p = 0; p < colour.size(); ++p)
    for (size_t c = 0; c < 3; ++c) image.pixels[p * before + c] = static_cast<float>(colour[p][c]);
  if (reasons.empty()) return image;
  std::vector<float> wider(film.pixels() * channels);
  for (size_t p = 0; p < film.pixels(); ++p) {
    std::copy_n(&image.pixels[p * before], before, &wider[p * channels]);
    for (size_t r = 0; r < reasons.size(); ++r) wider[p * channels + before + r] = reasons[r][p];
  }
  image.pixels = std::move(wider);
  image.spec.channels.insert(image.spec.channels.end(), reason_channels.begin(), reason_channels.end());
  return image;
}

std::vector<const StrategyInfo*> strategy_list() {
  std::vector<const StrategyInfo*> list;
  for (const StrategyEntry* entry : entries()) list.push_back(&entry->info);
  return list;
}

std::unique_ptr<Strategy> make_strategy(const std::string& text, const std::string& option) {
  const Chosen chosen = choose_named("strategy", strategy_list(), text, option);
  return entries()[chosen.place]->make(chosen.values, option);
}

}  // namespace triad
