// SPDX-License-Identifier: Apache-2.0
// Points in a pixel, spp of them, and how they lie: for strategies that leave this to the user.
#pragma once

#include <cstdint>
#include <span>
#include <triad/sampling/point_strategy.hpp>
#include <vector>

namespace triad {

// The cells of a grid of nx by ny, row by row from 0, in an order in which any first part of them lies all over the
// grid: with a stride near the golden section of their number, and prime to it.
std::vector<uint32_t> scattered_cells(uint32_t nx, uint32_t ny);

// Immutable; any thread may place.
class PixelPoints {
 public:
  enum class Kind {
    kSobol,   // scrambled Sobol points, as sobol-owen has them
    kRandom,  // independent, uniform in the pixel
    kJitter,  // one, uniform, in each cell of a grid of nx by ny = spp cells, as near to a square as spp allows
  };
  // The parameter that chooses: points=sobol, random or jitter.
  static StrategyParam param();

  PixelPoints(Kind kind, uint32_t spp);

  uint32_t samples_per_pixel() const { return spp_; }
  // Sets x and y of requests that say all else, index below spp, to points of [pixel_x, pixel_x + 1) and
  // [pixel_y, pixel_y + 1). They share a seed, and where neighbours are of one pixel, their indices count up by one.
  void place(std::span<SampleRequest> requests) const;
  // The same places within their pixels, in [0, 1): x[i], y[i] for requests[i].
  void places(std::span<const SampleRequest> requests, std::span<double> x, std::span<double> y) const;
  Kind kind() const { return kind_; }
  // Of jitter's grid; 1, 1 of the others.
  uint32_t columns() const { return nx_; }
  uint32_t rows() const { return ny_; }
  // Whether the two halves of the points that Film::estimated_rmse() compares are each spread like the whole.
  bool halves_are_alike() const { return kind_ != Kind::kJitter; }

 private:
  template <class Put>
  void each_place(std::span<const SampleRequest> requests, const Put& put) const;

  Kind kind_;
  uint32_t spp_, nx_ = 1, ny_ = 1;
  std::vector<uint32_t> cells_;  // of jitter, by index
};

// The plain mean of such points.
class PixelPointsStrategy : public PointStrategy {
 public:
  PixelPointsStrategy(const StrategyInfo& info, const StrategyValues& values, PixelPoints points)
      : PointStrategy(info, values), points_(std::move(points)) {}
  bool estimates_error() const override { return points_.halves_are_alike(); }

 protected:
  uint32_t samples_per_pixel() const override { return points_.samples_per_pixel(); }
  Passes::Points points() const override {
    return [this](std::span<SampleRequest> requests, size_t each) {
      if (each > 0) say_all(requests, each);
      points_.place(requests);
    };
  }

 private:
  PixelPoints points_;
};

}  // namespace triad
