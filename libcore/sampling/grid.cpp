// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstddef>
#include <cstring>
#include <triad/numeric/widest.hpp>
#include <triad/sampling/pixel_points.hpp>
#include <triad/sampling/point_strategy.hpp>
#include <triad/sampling/request_members.hpp>
#include <vector>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "grid",
    "n x n samples on a regular grid in each pixel",
    "The mean of samples at ((i + 1/2) / n, (j + 1/2) / n). Exact where light changes linearly; edges "
    "near the horizontal or the vertical show n steps of grey at most.",
    {{"n", "samples along each side of a pixel", 1, 1024, 2}}};

typedef int32_t TwoInts __attribute__((vector_size(8)));
typedef double Two __attribute__((vector_size(16)));
typedef int64_t TwoWords __attribute__((vector_size(16)));
typedef int64_t FourWords __attribute__((vector_size(32)));

class Grid final : public PointStrategy {
 public:
  explicit Grid(const StrategyValues& values)
      : PointStrategy(kInfo, values), n_(static_cast<uint32_t>(values.at("n"))) {
    for (const uint32_t cell : scattered_cells(n_, n_))
      places_.push_back({(cell % n_ + .5) / n_, (cell / n_ + .5) / n_});
  }
  bool estimates_error() const override { return false; }

 protected:
  uint32_t samples_per_pixel() const override { return n_ * n_; }
  void place(std::span<SampleRequest> requests) const override {
    static_assert(offsetof(SampleRequest, pixel_y) == offsetof(SampleRequest, pixel_x) + sizeof(int32_t));
    static_assert(offsetof(SampleRequest, x) == 0 && offsetof(SampleRequest, y) == sizeof(double));
    for (SampleRequest& request : requests) {
      TwoInts pixel;
      Two place;
      std::memcpy(&pixel, &request.pixel_x, sizeof(pixel));
      std::memcpy(&place, &places_[request.index], sizeof(place));
      place += __builtin_convertvector(pixel, Two);
      std::memcpy(static_cast<void*>(&request), &place, sizeof(place));
    }
  }

  void place_runs(std::span<SampleRequest> requests, size_t each) const override {
    run_wide([&]() TRIAD_INLINE_BODY {
      for (size_t first = 0; first < requests.size(); first += each) {
        SampleRequest* const run = &requests[first];
        TwoInts pixel;
        std::memcpy(&pixel, &run->pixel_x, sizeof(pixel));
        const Two corner = __builtin_convertvector(pixel, Two);
        const std::array<double, 2>* const places = &places_[run->index];
        RequestMembers members = members_of(*run);
        for (size_t i = 0; i < each; ++i, members += kNextIndex) {
          Two place;
          std::memcpy(&place, &places[i], sizeof(place));
          place += corner;
          // All that comes before the seed, in one store.
          static_assert(offsetof(SampleRequest, seed) == sizeof(FourWords));
          const FourWords all = __builtin_shufflevector((TwoWords)place, (TwoWords)members, 0, 1, 2, 3);
          std::memcpy(static_cast<void*>(&run[i]), &all, sizeof(all));
        }
      }
    });
  }

 private:
  uint32_t n_;
  // In a pixel, by index, so that a render that is ended early has samples all over the pixel.
  std::vector<std::array<double, 2>> places_;
};

}  // namespace

const StrategyEntry& grid_strategy() {
  static const StrategyEntry entry = strategy_entry<Grid>(kInfo);
  return entry;
}

}  // namespace triad
