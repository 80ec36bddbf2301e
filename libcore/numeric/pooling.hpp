// SPDX-License-Identifier: Apache-2.0
// Percentiles, mean, extremes and a histogram of the values of a picture that comes by strips.
//
// Two looks at the values, in memory that does not grow with their number: the first counts them by their upper 16
// bits (FloatHistogram), which gives the exact sum and says in which few bins the percentiles lie; the second counts
// the lower 16 bits of the values in these bins. Everything that is counted is an integer, so that no result depends
// on the order of strips or the number of threads.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <triad/numeric/float_histogram.hpp>
#include <triad/numeric/value_store.hpp>
#include <vector>

namespace triad {

inline constexpr std::array<int, 6> kPooledPercents{5, 25, 50, 75, 95, 99};
inline constexpr int kPooledHistogramBins = 100;

class Pooling {
 public:
  struct Place {
    int x = 0, y = 0, channel = 0;
    // Reading order.
    std::strong_ordering operator<=>(const Place& other) const;
    bool operator==(const Place&) const = default;
  };

  // The values of one strip, on one thread.
  class Block {
   public:
    Block(size_t capacity, bool weighted);
    // Row y, pixels from x on; rows of a block ascend. weights: one for each pixel, in [0, 1], taken in steps of
    // 1/65535, those of 0 leave a pixel out; required of a weighted Pooling, null for others.
    void add_row(const float* values, const float* weights, int pixels, int channels, int x, int y);
    // Where the first value that is not a number stood; nothing else counts then.
    const std::optional<Place>& nan_at() const { return nan_at_; }
    size_t values() const { return chunk_.count; }

   private:
    friend class Pooling;
    void note(uint32_t key, const Place& place);
    void start(size_t capacity);

    bool weighted_;
    FloatBins bins_;
    ValueStore::Chunk chunk_;
    uint32_t min_key_ = UINT32_MAX, max_key_ = 0;
    Place min_at_, max_at_;
    std::optional<Place> nan_at_;
  };

  struct Result {
    uint64_t values = 0;
    double weight = 0;
    double mean = 0;  // not a number when infinities of both signs are among the values
    double min = 0, max = 0;
    Place min_at, max_at;  // the first of each in reading order
    // Of kPooledPercents. The smallest value v for which the values <= v have that share of the weight.
    std::array<double, kPooledPercents.size()> percentiles{};
    // Each value also weighted by itself: the value at which the running sum of the sorted values (each times its
    // weight) reaches that share of the whole sum. As FLIP's reference tool pools its error maps (Andersson et al.,
    // FLIP: A Difference Evaluator for Alternating Images, HPG 2020). None when there are negative values.
    std::optional<std::array<double, kPooledPercents.size()>> weighted;
    // floor((v - low) (100 / (high - low))) in double, the largest value in the last bin; all in the first where the
    // two are equal. Infinities are in the first and last.
    double low = 0, high = 0;  // min(0, least) and max(0, largest) of the finite values
    std::vector<double> histogram;
  };

  // weighted: whether pixels have weights. Up to keep_bytes of values stay in memory, more go to a temporary file.
  // values_expected: at most.
  Pooling(bool weighted, uint64_t keep_bytes, uint64_t values_expected);

  // Room for `capacity` values. Thread-safe.
  std::unique_ptr<Block> take(size_t capacity);
  // Thread-safe, in any order; the block must be without a nan_at(). Throws Error(kInput) as ValueStore does.
  void add(std::unique_ptr<Block> block);
  // Once, after all. None when there was no value. Uses the threads of parallel_for.
  std::optional<Result> finish();

  // Bytes held from the first block on, beside the blocks themselves; by one block; and by finish() on top.
  static uint64_t held_bytes(bool weighted, uint64_t keep_bytes, uint64_t values_expected);
  static uint64_t block_bytes(bool weighted, uint64_t capacity);
  static uint64_t finish_bytes(uint64_t values);

 private:
  struct Wanted;
  void look_again(std::vector<Wanted>& wanted, Result& result) const;

  const bool weighted_;
  ValueStore store_;
  std::mutex mutex_;  // of what follows
  FloatHistogram histogram_;
  std::vector<std::unique_ptr<Block>> free_;
  uint64_t values_ = 0;
  uint32_t min_key_ = UINT32_MAX, max_key_ = 0;
  Place min_at_, max_at_;
};

}  // namespace triad
