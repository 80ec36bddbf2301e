// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <triad/base/random.hpp>
#include <triad/numeric/widest.hpp>
#include <triad/sampling/cell_points.hpp>
#include <triad/sampling/cell_points_avx512.hpp>
#include <triad/sampling/sobol.hpp>
#include <type_traits>

namespace triad {
namespace {

constexpr size_t kMost =
    1024;  // samples asked for at once, or one pixel's if those are more: 145 kB with their places
constexpr size_t kPacket = 16;  // sources may trace so many rays side by side, and best if there are always as many

constexpr size_t kLanes = 8;  // of vectors; arrays that they go through have whole ones

size_t pixels_together(size_t per_pixel) {
  const size_t most = std::max<size_t>(1, kMost / per_pixel);
  for (size_t n = most; 2 * n > most; --n)
    if (n * per_pixel % kPacket == 0) return n;
  return most;
}

// In [0, 1), with one conversion of signed numbers: vectors have none of unsigned ones before AVX-512.
TRIAD_INLINE_BODY inline double fraction(uint32_t bits) {
  return .5 + static_cast<int32_t>(bits ^ 0x80000000u) * 0x1p-32;
}

}  // namespace

CellBatch::CellBatch(const CellPoints& points, uint32_t first, uint32_t past, float footprint_px, uint64_t seed)
    : points_(points), seed_(seed), first_(first), per_pixel_(past - first) {
  const size_t pixels = pixels_together(per_pixel_), n = pixels * per_pixel_;
  pixel_x_.resize(pixels);
  pixel_y_.resize(pixels);
  requests_.resize(n, {.footprint_px = footprint_px, .seed = seed});
  for (auto* each : {&x_, &y_}) each->resize((n + kLanes - 1) / kLanes * kLanes);
  cell_.resize(x_.size());
  for (size_t i = 0; i < n; ++i) requests_[i].index = first + static_cast<uint32_t>(i % per_pixel_);
  if (points.points_.kind() != PixelPoints::Kind::kSobol) return;
  for (auto* each : {&start_x_, &start_y_, &seed_x_, &seed_y_}) each->resize(n);
  for (auto* each : {&pixel_seed_x_, &pixel_seed_y_}) each->resize(pixels);
  for (size_t i = 0; i < n; ++i) {
    const uint32_t index = requests_[i].index;
    const std::array<uint32_t, 2> plain =
        i < per_pixel_ ? sobol_point_reversed(index) : std::array{start_x_[i - per_pixel_], start_y_[i - per_pixel_]};
    start_x_[i] = i < per_pixel_ ? owen_scramble_start(plain[0]) : plain[0];
    start_y_[i] = i < per_pixel_ ? owen_scramble_start(plain[1]) : plain[1];
  }
}

TRIAD_INLINE_BODY inline void CellBatch::seed_pixels() {
  const size_t n = pixels_;
  uint32_t *const seed_x = pixel_seed_x_.data(), *const seed_y = pixel_seed_y_.data();
  const int32_t *const pixel_x = pixel_x_.data(), *const pixel_y = pixel_y_.data();
  const uint64_t seed = seed_;
  for (size_t k = 0; k < n; ++k) {
    const SobolOwenSeeds seeds(SampleRandom::pixel_key(pixel_x[k], pixel_y[k], seed));
    seed_x[k] = seeds.x;
    seed_y[k] = seeds.y;
  }
}

// As sobol_owen_places() does it, but with all samples of all pixels side by side.
TRIAD_INLINE_BODY inline void CellBatch::place_sobol_owen() {
  const size_t n = pixels_ * per_pixel_, per_pixel = per_pixel_;
  uint32_t *const seed_x = seed_x_.data(), *const seed_y = seed_y_.data();
  for (size_t k = 0; k < pixels_; ++k) {
    std::fill_n(seed_x + k * per_pixel, per_pixel, pixel_seed_x_[k]);
    std::fill_n(seed_y + k * per_pixel, per_pixel, pixel_seed_y_[k]);
  }
  const uint32_t *const start_x = start_x_.data(), *const start_y = start_y_.data();
  double *const x = x_.data(), *const y = y_.data();
  for (size_t i = 0; i < n; ++i) {
    x[i] = fraction(reverse_bits(owen_scramble_rest(start_x[i], seed_x[i])));
    y[i] = fraction(reverse_bits(owen_scramble_rest(start_y[i], seed_y[i])));
  }
}

TRIAD_INLINE_BODY inline void CellBatch::move_into_cells() {
  using Eight = CellSide::Eight;
  typedef int32_t EightInts __attribute__((vector_size(32)));
  const size_t n = pixels_ * per_pixel_, per_pixel = per_pixel_;
  double *const x = x_.data(), *const y = y_.data();
  const int32_t columns = points_.cells_.x, rows = points_.cells_.y;
  uint32_t* const cell = cell_.data();
  for (size_t i = 0; i < n; i += kLanes) {
    Eight along, down;
    std::memcpy(&along, x + i, sizeof(along));
    std::memcpy(&down, y + i, sizeof(down));
    points_.across_.move(along);
    points_.down_.move(down);
    const EightInts in =
        __builtin_convertvector(down, EightInts) * columns + __builtin_convertvector(along, EightInts);
    std::memcpy(x + i, &along, sizeof(along));
    std::memcpy(y + i, &down, sizeof(down));
    std::memcpy(cell + i, &in, sizeof(in));
  }
  // Members that lie side by side, in one store each.
  typedef double Two __attribute__((vector_size(16)));
  typedef int32_t TwoInts __attribute__((vector_size(8)));
  static_assert(offsetof(SampleRequest, x) == 0 && offsetof(SampleRequest, y) == 8 &&
                offsetof(SampleRequest, pixel_y) == offsetof(SampleRequest, pixel_x) + 4 &&
                std::is_trivially_copyable_v<SampleRequest>);
  for (size_t k = 0; k < pixels_; ++k) {
    const TwoInts pixel{pixel_x_[k], pixel_y_[k]};
    const Two corner{static_cast<double>(pixel[0]) * columns, static_cast<double>(pixel[1]) * rows};
    SampleRequest* request = &requests_[k * per_pixel];
    for (size_t i = k * per_pixel; i < (k + 1) * per_pixel; ++i, ++request) {
      const Two at = corner + Two{x[i], y[i]};
      std::memcpy(static_cast<void*>(request), &at, sizeof(at));
      std::memcpy(&request->pixel_x, &pixel, sizeof(pixel));
    }
  }
}

void CellBatch::place() {
#if defined(__x86_64__)
  static const bool by_hand = default_cpu_path() == CpuPath::kAvx512;
  if (by_hand && points_.points_.kind() == PixelPoints::Kind::kSobol && per_pixel_ % avx512::kTogether == 0) {
    run_widest([&]() TRIAD_INLINE_BODY { seed_pixels(); });
    avx512::place_in_cells({pixels_, pixel_x_.data(), pixel_y_.data(), pixel_seed_x_.data(), pixel_seed_y_.data()},
                           points_.across_, points_.down_, start_x_.data(), start_y_.data(),
                           std::span(requests_).first(pixels_ * per_pixel_), cell_.data());
    return;
  }
#endif
  if (points_.points_.kind() == PixelPoints::Kind::kSobol)
    return run_widest([&]() TRIAD_INLINE_BODY {
      seed_pixels();
      place_sobol_owen();
      move_into_cells();
    });
  for (size_t i = 0; i < pixels_ * per_pixel_; ++i) {
    requests_[i].pixel_x = pixel_x_[i / per_pixel_];
    requests_[i].pixel_y = pixel_y_[i / per_pixel_];
  }
  points_.points_.places(requests(), x_, y_);
  run_widest([&]() TRIAD_INLINE_BODY { move_into_cells(); });
}

}  // namespace triad
