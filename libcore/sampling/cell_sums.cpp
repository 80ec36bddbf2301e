// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <triad/numeric/widest.hpp>
#include <triad/sampling/cell_sums.hpp>
#include <triad/sampling/passes.hpp>
#include <triad/sampling/sobol.hpp>

namespace triad {
namespace {

typedef int32_t FourInts __attribute__((vector_size(16)));
using Four = Film::SampleSum;
typedef int32_t EightInts __attribute__((vector_size(32)));
typedef float EightFloats __attribute__((vector_size(32)));
typedef double Eight __attribute__((vector_size(64)));

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

  // For a film that keeps sums, of kSums cells, or with 0 of any number. For a known number samples of even and of
  // odd index have sums of their own, which wait for each other half as long.
  template <bool kHalves, size_t kSums>
  TRIAD_INLINE_BODY void by_pixels() {
    constexpr size_t kSets = kSums > 0 ? 2 : 1, kMost = kSums > 0 ? kSums : kMostSums;
    const size_t per_pixel = batch_.per_pixel(), alone = batch_.first() == 0, sums = kSums > 0 ? kSums : sums_;
    const size_t columns = static_cast<size_t>(columns_), width = static_cast<size_t>(film_.width());
    const bool few = film_.keeps_means();
    Four sum[kSets * kMost], half[kHalves ? kMost : 1];
    const auto clear = [&]() TRIAD_INLINE_BODY {
      for (size_t c = 0; c < sums; ++c)
        for (size_t set = 0; set < kSets; ++set) sum[set * kMost + c] = Four{};
      if constexpr (kHalves)
        for (size_t c = 0; c < sums; ++c) half[c] = Four{};
    };
    const auto join_sets = [&]() TRIAD_INLINE_BODY {
      if constexpr (kSets > 1)
        for (size_t c = 0; c < sums; ++c) sum[c] += sum[kMost + c];
    };
    // Colours and ones of sample i, of even index, and of the next.
    const auto add_pair = [&](size_t i, const EightInts& bits) TRIAD_INLINE_BODY {
      Eight x;
      to_colours_and_ones(bits, x);
      const Four even = __builtin_shufflevector(x, x, 0, 1, 2, 3), odd = __builtin_shufflevector(x, x, 4, 5, 6, 7);
      sum[cells_[i]] += even;
      sum[(kSets - 1) * kMost + cells_[i + 1]] += odd;
      if constexpr (kHalves) {
        if (sobol_half(requests_[i].index)) half[cells_[i]] += even;
        if (sobol_half(requests_[i + 1].index)) half[cells_[i + 1]] += odd;
      }
    };
    const auto add_one = [&](size_t i, const EightInts& bits) TRIAD_INLINE_BODY {
      Eight x;
      to_colours_and_ones(bits, x);
      const Four one = __builtin_shufflevector(x, x, 0, 1, 2, 3);
      sum[(requests_[i].index % 2 == 1 ? (kSets - 1) * kMost : 0) + cells_[i]] += one;
      if constexpr (kHalves)
        if (sobol_half(requests_[i].index)) half[cells_[i]] += one;
    };
    for (size_t k = 0; k < batch_.pixels(); ++k) {
      const size_t begin = k * per_pixel, second = begin + alone, past = begin + per_pixel;
      if constexpr (kSums == 3 && !kHalves)
        if (columns == kSums && batch_.first() % 2 == 0 &&
            film_.add_to_three(first_cell(k), samples_.subspan(begin, per_pixel), &cells_[begin], alone))
          continue;
      if (alone && !few) by_itself(k, begin);
      clear();
      EightInts all{-1, -1, -1, -1, -1, -1, -1, -1};
      size_t i = second;
      EightInts bits;
      const auto add_next = [&]() TRIAD_INLINE_BODY {
        load(i, i, bits);
        all &= bits;
        add_one(i++, bits);
      };
      if (i < past && requests_[i].index % 2 == 1) add_next();
      for (; i + 1 < past; i += 2) {
        load(i, i + 1, bits);
        all &= bits;
        add_pair(i, bits);
      }
      if (i < past) add_next();
      join_sets();
      Four total{};
      for (size_t c = 0; c < sums; ++c) total += sum[c];
      // What is not finite stays so in a sum, and finite floats have a finite one.
      if ((all[3] & all[7] & kValid) == 0 || !std::isfinite(total[0] + total[1] + total[2])) {
        clear();
        for (i = second; i < past; ++i) {
          load(i, i, bits);
          if (usable(samples_[i]))
            add_one(i, bits);
          else
            leave_out(k, i);
        }
        join_sets();
      }
      // The film would keep the very first as it is, and add the others to it.
      if (alone && few) {
        if (usable(samples_[begin])) {
          load(begin, begin, bits);
          Eight x;
          to_colours_and_ones(bits, x);
          sum[cells_[begin]] += __builtin_shufflevector(x, x, 0, 1, 2, 3);
        } else {
          leave_out(k, begin);
        }
      }
      size_t row = first_cell(k);
      for (size_t c = 0; c < sums; row += width)
        for (size_t u = 0; u < columns; ++u, ++c) {
          film_.add_sum(row + u, sum[c]);
          if constexpr (kHalves) film_.add_half_sum(row + u, half[c]);
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

  // The first 16 bytes of two samples: colours and whether they are valid.
  TRIAD_INLINE_BODY void load(size_t i, size_t j, EightInts& bits) const {
    FourInts first, second;
    std::memcpy(&first, &samples_[i], sizeof(first));
    std::memcpy(&second, &samples_[j], sizeof(second));
    bits = __builtin_shufflevector(first, second, 0, 1, 2, 3, 4, 5, 6, 7);
  }
  TRIAD_INLINE_BODY static void to_colours_and_ones(const EightInts& samples, Eight& x) {
    const EightInts bits =
        (samples & EightInts{-1, -1, -1, 0, -1, -1, -1, 0}) | EightInts{0, 0, 0, kOne, 0, 0, 0, kOne};
    EightFloats values;
    std::memcpy(&values, &bits, sizeof(bits));
    x = __builtin_convertvector(values, Eight);
  }
  TRIAD_INLINE_BODY size_t first_cell(size_t pixel) const {
    return film_.pixel(batch_.pixel_x(pixel) * columns_, batch_.pixel_y(pixel) * rows_);
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
    const Film::SampleSum one{sample.rgb[0], sample.rgb[1], sample.rgb[2], 1};
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

namespace {

template <size_t kSums>
void add_by_pixels(Adder& adder, const Film& film) {
  if (film.planes().error)
    run_wide([&]() TRIAD_INLINE_BODY { adder.by_pixels<true, kSums>(); });
  else
    run_wide([&]() TRIAD_INLINE_BODY { adder.by_pixels<false, kSums>(); });
}

}  // namespace

static_assert(kFewSamples == Passes::kSecondPass && kFewSamples <= Film::kMostFew);  // means are rounded once

Film::Holds film_for_cells(const Cells& cells, uint32_t spp) {
  const auto n = static_cast<size_t>(cells.x * cells.y);
  if (n == 1) return Passes::film_holds(spp);
  return n <= kMostFew && spp <= kFewSamples ? Film::Holds::kFew
         : spp <= Film::kMostSome            ? Film::Holds::kSome
                                             : Film::Holds::kMany;
}

bool take_into_cells(SampleTaker& taker, const Cells& cells, CellBatch& batch, std::span<Sample> samples) {
  samples = samples.first(batch.requests().size());
  if (cells.x * cells.y == 1) return taker.add(batch.requests(), samples);  // plain antialiasing
  return taker.ask_once(batch.requests(), samples, [&] {
    Adder adder(taker, cells, batch, samples);
    const Film& film = taker.film();
    if (!film.keeps_sums() || !adder.many_in_cells())
      adder.one_by_one();
    else if (cells.x * cells.y == 3)  // most displays
      add_by_pixels<3>(adder, film);
    else
      add_by_pixels<0>(adder, film);
  });
}

}  // namespace triad
