// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <triad/numeric/widest.hpp>
#include <triad/sampling/cell_sums.hpp>
#include <triad/sampling/sobol.hpp>

namespace triad {
namespace {

typedef int32_t FourInts __attribute__((vector_size(16)));
typedef float FourFloats __attribute__((vector_size(16)));
typedef double Four __attribute__((vector_size(32)));

constexpr size_t kMostSums = 64;      // cells of a pixel that are gone through for its samples
constexpr size_t kMostFew = 16;       // cells, so that a few samples go into the film together
constexpr uint32_t kFewSamples = 16;  // of a pixel that come in one batch, or in two with the first of all alone

class Adder {
 public:
  Adder(SampleTaker& taker, const Cells& cells, const CellBatch& batch, std::span<const Sample> samples)
      : taker_(taker),
        film_(taker.film()),
        columns_(cells.x),
        rows_(cells.y),
        sums_(static_cast<size_t>(cells.x * cells.y)),
        batch_(batch),
        samples_(samples),
        requests_(batch.requests()),
        cells_(batch.cells()) {}

  // Whether by_pixels() is faster.
  bool many_in_cells() const {
    const size_t together = batch_.per_pixel() - (batch_.first() == 0);
    return together > 0 && (sums_ <= kMostFew || (sums_ <= kMostSums && sums_ < 2 * together));
  }

  // For a film that keeps sums.
  template <bool kHalves>
  TRIAD_INLINE_BODY void by_pixels() {
    const size_t per_pixel = batch_.per_pixel(), alone = batch_.first() == 0;
    Four sum[kMostSums], half[kHalves ? kMostSums : 1];
    for (size_t k = 0; k < batch_.pixels(); ++k) {
      const size_t begin = k * per_pixel, past = begin + per_pixel;
      for (size_t i = begin; i < begin + alone; ++i) by_itself(k, i);
      for (size_t c = 0; c < sums_; ++c) {
        sum[c] = Four{};
        if constexpr (kHalves) half[c] = Four{};
      }
      FourInts all{-1, -1, -1, -1};
      for (size_t i = begin + alone; i < past; ++i) {
        FourInts bits;
        std::memcpy(&bits, &samples_[i], sizeof(bits));
        all &= bits;
        add<kHalves>(i, bits, sum, half);
      }
      Four total = sum[0];
      for (size_t c = 1; c < sums_; ++c) total += sum[c];
      // What is not finite stays so in a sum, and finite floats have a finite one.
      if ((all[3] & kValid) == 0 || !std::isfinite(total[0] + total[1] + total[2])) {
        for (size_t c = 0; c < sums_; ++c) {
          sum[c] = Four{};
          if constexpr (kHalves) half[c] = Four{};
        }
        for (size_t i = begin + alone; i < past; ++i) {
          if (!usable(samples_[i])) {
            leave_out(k, i);
            continue;
          }
          FourInts bits;
          std::memcpy(&bits, &samples_[i], sizeof(bits));
          add<kHalves>(i, bits, sum, half);
        }
      }
      const size_t columns = static_cast<size_t>(columns_), width = static_cast<size_t>(film_.width());
      size_t row = film_.pixel(batch_.pixel_x(k) * columns_, batch_.pixel_y(k) * rows_);
      for (size_t c = 0; c < sums_; row += width)
        for (size_t u = 0; u < columns; ++u, ++c) {
          film_.add_sum(row + u, record(sum[c]));
          if constexpr (kHalves) film_.add_half_sum(row + u, record(half[c]));
        }
    }
  }

  // For any film.
  void one_by_one() {
    for (size_t k = 0; k < batch_.pixels(); ++k)
      for (size_t i = k * batch_.per_pixel(); i < (k + 1) * batch_.per_pixel(); ++i) {
        if (film_.keeps_sums()) {
          by_itself(k, i);
          continue;
        }
        const auto [x, y] = place(k, i);
        if (!film_.add(film_.pixel(x, y), requests_[i].index, samples_[i])) taker_.drop(x, y);
      }
  }

 private:
  static_assert(offsetof(Sample, rgb) == 0 && offsetof(Sample, valid) == 12 && sizeof(Sample) >= 16);
  static constexpr int32_t kOne = 0x3f800000, kValid = 0xff;  // 1 as a float; a bool's byte

  // The sample's colour and 1 to its cell's sum. `bits` are its first.
  template <bool kHalves>
  TRIAD_INLINE_BODY void add(size_t i, FourInts bits, Four* sum, Four* half) const {
    bits = (bits & FourInts{-1, -1, -1, 0}) | FourInts{0, 0, 0, kOne};
    FourFloats rgb1;
    std::memcpy(&rgb1, &bits, sizeof(bits));
    const Four x = __builtin_convertvector(rgb1, Four);
    sum[cells_[i]] += x;
    if constexpr (kHalves) {
      if (sobol_half(requests_[i].index)) half[cells_[i]] += x;
    }
  }
  TRIAD_INLINE_BODY static Film::SampleSum record(const Four& sum) {
    Film::SampleSum record;
    static_assert(sizeof(record) == sizeof(sum));
    std::memcpy(&record, &sum, sizeof(sum));
    return record;
  }
  struct Place {
    int x, y;
  };
  // On the film.
  TRIAD_INLINE_BODY Place place(size_t pixel, size_t i) const {
    const int cell = static_cast<int>(cells_[i]), row = rows_ == 1 ? 0 : cell / columns_;
    return {batch_.pixel_x(pixel) * columns_ + (cell - row * columns_), batch_.pixel_y(pixel) * rows_ + row};
  }
  TRIAD_INLINE_BODY void by_itself(size_t pixel, size_t i) {
    const Sample& sample = samples_[i];
    if (!usable(sample)) return leave_out(pixel, i);
    const auto [x, y] = place(pixel, i);
    const Film::SampleSum one{{sample.rgb[0], sample.rgb[1], sample.rgb[2]}, 1};
    film_.add_sum(film_.pixel(x, y), one);
    if (film_.planes().error && sobol_half(requests_[i].index)) film_.add_half_sum(film_.pixel(x, y), one);
  }
  __attribute__((noinline)) void leave_out(size_t pixel, size_t i) {
    const auto [x, y] = place(pixel, i);
    film_.leave_out(film_.pixel(x, y));
    taker_.drop(x, y);
  }

  SampleTaker& taker_;
  Film& film_;
  const int columns_, rows_;
  const size_t sums_;
  const CellBatch& batch_;
  const std::span<const Sample> samples_;
  const std::span<const SampleRequest> requests_;
  const std::span<const uint32_t> cells_;
};

}  // namespace

Film::Holds film_for_cells(const Cells& cells, uint32_t spp) {
  const auto n = static_cast<size_t>(cells.x * cells.y);
  return n > 1 && n <= kMostFew && spp <= kFewSamples ? Film::Holds::kFew : Film::Holds::kMany;
}

bool take_into_cells(SampleTaker& taker, const Cells& cells, CellBatch& batch, std::span<Sample> samples) {
  samples = samples.first(batch.requests().size());
  return taker.ask_once(batch.requests(), samples, [&] {
    Adder adder(taker, cells, batch, samples);
    const Film& film = taker.film();
    if (!film.keeps_sums() || !adder.many_in_cells())
      adder.one_by_one();
    else if (film.planes().error)
      run_widest([&]() TRIAD_INLINE_BODY { adder.by_pixels<true>(); });
    else
      run_widest([&]() TRIAD_INLINE_BODY { adder.by_pixels<false>(); });
  });
}

}  // namespace triad
