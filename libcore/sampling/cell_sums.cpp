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

// More are not worth going through: each sample is added to the film by itself.
constexpr size_t kMostSums = 64;

class Adder {
 public:
  Adder(SampleTaker& taker, const Cells& cells, CellBatch& batch, std::span<const Sample> samples)
      : taker_(taker), film_(taker.film()), cells_(cells), batch_(batch), samples_(samples) {}

  template <bool kHalves>
  TRIAD_INLINE_BODY void by_pixels() {
    const size_t per_pixel = batch_.per_pixel();
    const auto columns = static_cast<uint32_t>(cells_.x), rows = static_cast<uint32_t>(cells_.y);
    const size_t sums = size_t{columns} * rows << kHalves;
    const SampleRequest* const requests = batch_.requests().data();
    const uint32_t* const cells = batch_.cells().data();
    alignas(32) Four sum[kMostSums];
    for (size_t k = 0; k < batch_.pixels(); ++k) {
      for (size_t c = 0; c < sums; ++c) sum[c] = Four{};
      FourInts all = {-1, -1, -1, -1};
      const size_t first = k * per_pixel;
      for (size_t i = first; i < first + per_pixel; ++i) {
        FourInts bits;
        std::memcpy(&bits, &samples_[i], sizeof(bits));
        all &= bits;
        bits = (bits & FourInts{-1, -1, -1, 0}) | FourInts{0, 0, 0, kOne};
        FourFloats rgb1;
        std::memcpy(&rgb1, &bits, sizeof(bits));
        const size_t c = kHalves ? 2 * cells[i] + sobol_half(requests[i].index) : cells[i];
        sum[c] += __builtin_convertvector(rgb1, Four);
      }
      Four total = sum[0];
      for (size_t c = 1; c < sums; ++c) total += sum[c];
      // What is not finite stays so in a sum, and finite floats have a finite one.
      if ((all[3] & kValid) == 0 || !std::isfinite(total[0] + total[1] + total[2])) {
        one_by_one(k);
        continue;
      }
      for (uint32_t v = 0, c = 0; v < rows; ++v) {
        const size_t p =
            film_.pixel(batch_.pixel_x(k) * cells_.x, batch_.pixel_y(k) * cells_.y + static_cast<int>(v));
        for (uint32_t u = 0; u < columns; ++u, c += 1 + kHalves) {
          const Four both = kHalves ? sum[c] + sum[c + 1] : sum[c];
          film_.add_sum(p + u, record(both));
          if constexpr (kHalves) film_.add_half_sum(p + u, record(sum[c + 1]));
        }
      }
    }
  }

  void one_by_one() {
    for (size_t k = 0; k < batch_.pixels(); ++k) one_by_one(k);
  }

 private:
  static_assert(offsetof(Sample, rgb) == 0 && offsetof(Sample, valid) == 12 && sizeof(Sample) >= 16);
  TRIAD_INLINE_BODY static Film::SampleSum record(const Four& sum) {
    Film::SampleSum record;
    static_assert(sizeof(record) == sizeof(sum));
    std::memcpy(&record, &sum, sizeof(sum));
    return record;
  }
  static constexpr int32_t kOne = 0x3f800000, kValid = 0xff;

  __attribute__((noinline)) void one_by_one(size_t pixel) {
    const size_t first = pixel * batch_.per_pixel();
    for (size_t i = first; i < first + batch_.per_pixel(); ++i) {
      const int cell = static_cast<int>(batch_.cells()[i]);
      const int x = batch_.pixel_x(pixel) * cells_.x + cell % cells_.x;
      const int y = batch_.pixel_y(pixel) * cells_.y + cell / cells_.x;
      if (!film_.add(film_.pixel(x, y), batch_.requests()[i].index, samples_[i])) taker_.drop(x, y);
    }
  }

  SampleTaker& taker_;
  Film& film_;
  const Cells& cells_;
  CellBatch& batch_;
  const std::span<const Sample> samples_;
};

}  // namespace

bool take_into_cells(SampleTaker& taker, const Cells& cells, CellBatch& batch, std::span<Sample> samples) {
  samples = samples.first(batch.requests().size());
  return taker.ask_once(batch.requests(), samples, [&] {
    const bool halves = taker.film().planes().error;
    const size_t sums = static_cast<size_t>(cells.x * cells.y) << halves;
    Adder adder(taker, cells, batch, samples);
    if (!taker.film().keeps_sums() || sums > kMostSums || 2 * batch.per_pixel() < sums)
      adder.one_by_one();
    else if (halves)
      run_widest([&]() TRIAD_INLINE_BODY { adder.by_pixels<true>(); });
    else
      run_widest([&]() TRIAD_INLINE_BODY { adder.by_pixels<false>(); });
  });
}

}  // namespace triad
