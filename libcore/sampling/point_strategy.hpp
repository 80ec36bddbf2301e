// SPDX-License-Identifier: Apache-2.0
// What strategies have in common that put n points into each pixel and take the mean of the samples there.
#pragma once

#include <triad/sampling/passes.hpp>
#include <triad/sampling/strategy_base.hpp>

namespace triad {

// Renders as Passes::run_all_in_turn() does. A pixel's samples are summed by ascending index, by one thread at a
// time.
class PointStrategy : public StrategyBase {
 public:
  using StrategyBase::StrategyBase;
  uint64_t most_samples(int width, int height) const override;
  Film::Holds film_holds() const override { return Passes::film_holds(samples_per_pixel()); }
  RenderResult render(const Source& source, const RenderOptions& options) const override;

 protected:
  virtual uint32_t samples_per_pixel() const = 0;
  virtual float footprint_px() const;         // a pixel's share, unless a strategy says otherwise
  virtual Passes::Points points() const = 0;  // as long as this lives
};

// A step near the golden section of `count`, and prime to it: 0, stride, 2 stride ... modulo `count` is an order of
// count places side by side in which the first few are all over them, for renders that are ended early.
uint64_t spread_stride(uint64_t count);

// The places of sobol-owen, as Passes::Place says. Where neighbours are of one pixel, their indices must count up by
// one.
void place_sobol_owen(std::span<SampleRequest> requests, size_t each = 0);
// The same, in [0, 1) of each request's pixel.
void sobol_owen_places(std::span<const SampleRequest> requests, std::span<double> x, std::span<double> y);

}  // namespace triad
