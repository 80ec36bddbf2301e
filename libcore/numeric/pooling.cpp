// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <triad/base/parallel.hpp>
#include <triad/numeric/pooling.hpp>
#include <triad/numeric/widest.hpp>

namespace triad {
namespace {

constexpr size_t kLargestBin = kLargestKey >> 16;
constexpr int kMostParts = 4;                  // of the second look; each has counters of its own
constexpr uint64_t kValuesPerPart = 1u << 20;  // fewer are not worth a thread

int parts_for(uint64_t values) {
  return static_cast<int>(
      std::clamp<uint64_t>(values / kValuesPerPart, 1, static_cast<uint64_t>(std::min(kMostParts, thread_limit()))));
}

// The keys of `count` values, and the least and largest of them.
struct KeyRange {
  uint32_t least = UINT32_MAX, largest = 0;
};
KeyRange make_keys(const float* values, size_t count, uint32_t* keys) {
  KeyRange range;
  run_widest([&]() TRIAD_INLINE_BODY {
    uint32_t least = UINT32_MAX, largest = 0;
    for (size_t i = 0; i < count; ++i) {
      const uint32_t key = float_key(values[i]);
      keys[i] = key;
      least = std::min(least, key);
      largest = std::max(largest, key);
    }
    range = {least, largest};
  });
  return range;
}

}  // namespace

std::strong_ordering Pooling::Place::operator<=>(const Place& other) const {
  if (y != other.y) return y <=> other.y;
  if (x != other.x) return x <=> other.x;
  return channel <=> other.channel;
}

Pooling::Block::Block(size_t capacity, bool weighted) : weighted_(weighted) { start(capacity); }

void Pooling::Block::start(size_t capacity) {
  if (chunk_.capacity < capacity) chunk_ = ValueStore::make_chunk(capacity, weighted_);
  chunk_.count = 0;
  bins_.clear();
  min_key_ = UINT32_MAX;
  max_key_ = 0;
  nan_at_.reset();
}

void Pooling::Block::note(uint32_t key, const Place& place) {
  if ((key < kLeastKey || key > kLargestKey) && !nan_at_) nan_at_ = place;
  if (key < min_key_) {
    min_key_ = key;
    min_at_ = place;
  }
  // The first value is the largest so far whatever it is; its key is never 0, which is a not-a-number's.
  if (key > max_key_) {
    max_key_ = key;
    max_at_ = place;
  }
}

void Pooling::Block::add_row(const float* values, const float* weights, int pixels, int channels, int x, int y) {
  uint32_t* const keys = &chunk_.values[chunk_.count];
  if (!weighted_) {
    const size_t count = static_cast<size_t>(pixels) * static_cast<size_t>(channels);
    const KeyRange range = make_keys(values, count, keys);
    const auto look_for = [&](auto is_it) {
      const auto i = static_cast<int64_t>(std::find_if(keys, keys + count, is_it) - keys);
      note(keys[i], {x + static_cast<int>(i / channels), y, static_cast<int>(i % channels)});
    };
    if (range.least < kLeastKey || range.largest > kLargestKey)
      look_for([](uint32_t key) { return key < kLeastKey || key > kLargestKey; });
    if (range.least < min_key_) look_for([&](uint32_t key) { return key == range.least; });
    if (range.largest > max_key_) look_for([&](uint32_t key) { return key == range.largest; });
    bins_.add(keys, count, range.least, range.largest);
    chunk_.count += count;
    return;
  }
  uint16_t* const kept_weights = &chunk_.weights[chunk_.count];
  size_t kept = 0;
  for (int i = 0; i < pixels; ++i, values += channels) {
    const float share = weights[i] > 0 ? std::min(weights[i], 1.0f) : 0.0f;
    const auto weight = static_cast<uint32_t>(static_cast<double>(share) * FloatBins::kMostWeight + .5);
    if (weight == 0) continue;
    for (int c = 0; c < channels; ++c) {
      const uint32_t key = float_key(values[c]);
      note(key, {x + i, y, c});
      keys[kept] = key;
      kept_weights[kept++] = static_cast<uint16_t>(weight);
      bins_.add(key, weight);
    }
  }
  chunk_.count += kept;
}

Pooling::Pooling(bool weighted, uint64_t keep_bytes, uint64_t values_expected)
    : weighted_(weighted), store_(weighted, keep_bytes, values_expected) {}

std::unique_ptr<Pooling::Block> Pooling::take(size_t capacity) {
  std::unique_ptr<Block> block;
  {
    const std::lock_guard lock(mutex_);
    if (!free_.empty()) {
      block = std::move(free_.back());
      free_.pop_back();
    }
  }
  if (!block) return std::make_unique<Block>(capacity, weighted_);
  block->start(capacity);
  return block;
}

void Pooling::add(std::unique_ptr<Block> block) {
  const uint64_t count = block->values();
  store_.add(block->chunk_);
  const std::lock_guard lock(mutex_);
  if (count > 0) {
    histogram_.merge(block->bins_);
    values_ += count;
    if (block->min_key_ < min_key_ || (block->min_key_ == min_key_ && block->min_at_ < min_at_)) {
      min_key_ = block->min_key_;
      min_at_ = block->min_at_;
    }
    if (block->max_key_ > max_key_ || (block->max_key_ == max_key_ && block->max_at_ < max_at_)) {
      max_key_ = block->max_key_;
      max_at_ = block->max_at_;
    }
  }
  free_.push_back(std::move(block));
}

// A percentile whose bin is known, and what lies below that bin.
struct Pooling::Wanted {
  double* value = nullptr;
  size_t bin = 0;
  uint32_t percent = 0;
  bool by_sum = false;
  uint64_t weight_before = 0;
  ExactSum sum_before;
};

std::optional<Pooling::Result> Pooling::finish() {
  free_.clear();
  if (values_ == 0) return std::nullopt;
  Result result;
  const uint64_t total = histogram_.total();
  result.values = values_;
  result.weight = static_cast<double>(total) / (weighted_ ? FloatBins::kMostWeight : 1);
  result.mean = histogram_.mean();
  result.min = static_cast<double>(key_float(min_key_));
  result.max = static_cast<double>(key_float(max_key_));
  result.min_at = min_at_;
  result.max_at = max_at_;

  std::vector<Wanted> wanted;
  {
    uint64_t before = 0;
    size_t p = 0;
    for (size_t bin = 0; bin < kFloatBins && p < kPooledPercents.size(); ++bin) {
      const uint64_t after = before + histogram_.weight(bin);
      // At most 2^40 values of 2^16: a hundred times that is below 2^63.
      for (; p < kPooledPercents.size() && after * 100 >= static_cast<uint64_t>(kPooledPercents[p]) * total; ++p)
        wanted.push_back(
            {&result.percentiles[p], bin, static_cast<uint32_t>(kPooledPercents[p]), false, before, ExactSum{}});
      before = after;
    }
  }
  if (min_key_ >= kZeroKey) {
    auto& weighted = result.weighted.emplace();
    const ExactSum sum = histogram_.sum();
    if (histogram_.weight(kLargestBin) > 0) {
      weighted.fill(std::numeric_limits<double>::infinity());
    } else if (!sum.zero()) {
      ExactSum before;
      size_t p = 0;
      for (size_t bin = kZeroKey >> 16; bin < kLargestBin && p < kPooledPercents.size(); ++bin) {
        if (histogram_.weight(bin) == 0) continue;
        ExactSum after = before;
        histogram_.add_sum(bin, after);
        for (; p < kPooledPercents.size() && after.times(100) >= sum.times(static_cast<uint32_t>(kPooledPercents[p]));
             ++p)
          wanted.push_back({&weighted[p], bin, static_cast<uint32_t>(kPooledPercents[p]), true, 0, before});
        before = after;
      }
    }
  }
  look_again(wanted, result);
  return result;
}

void Pooling::look_again(std::vector<Wanted>& wanted, Result& result) const {
  // Bins that are looked into, numbered from 1.
  std::vector<uint8_t> slot_of(kFloatBins, 0);
  std::vector<size_t> slots;
  for (const Wanted& one : wanted) {
    if (slot_of[one.bin]) continue;
    slots.push_back(one.bin);
    slot_of[one.bin] = static_cast<uint8_t>(slots.size());
  }
  // The finite range; where infinities are among the values it takes a look of its own.
  uint32_t least = min_key_, largest = max_key_;
  const int parts = parts_for(values_);
  if (least == kLeastKey || largest == kLargestKey) {
    std::vector<KeyRange> ranges(static_cast<size_t>(parts));
    parallel_for(parts, [&](int64_t part) {
      KeyRange& range = ranges[static_cast<size_t>(part)];
      store_.visit(static_cast<int>(part), parts, [&](const uint32_t* keys, const uint16_t*, size_t count) {
        for (size_t i = 0; i < count; ++i) {
          if (keys[i] == kLeastKey || keys[i] == kLargestKey) continue;
          range.least = std::min(range.least, keys[i]);
          range.largest = std::max(range.largest, keys[i]);
        }
      });
    });
    least = UINT32_MAX;
    largest = 0;
    for (const KeyRange& range : ranges) {
      least = std::min(least, range.least);
      largest = std::max(largest, range.largest);
    }
    if (least > largest) least = largest = kZeroKey;  // nothing finite
  }
  const double low = result.low = std::min(0.0, static_cast<double>(key_float(least)));
  const double high = result.high = std::max(0.0, static_cast<double>(key_float(largest)));
  const double bins_per_unit = high > low ? kPooledHistogramBins / (high - low) : 0;

  struct Part {
    std::vector<uint64_t> lower;  // 65536 for each slot
    std::array<std::array<uint64_t, kPooledHistogramBins>, 2> histogram{};
  };
  std::vector<Part> found(static_cast<size_t>(parts));
  parallel_for(parts, [&](int64_t index) {
    Part& part = found[static_cast<size_t>(index)];
    part.lower.resize(slots.size() * kFloatBins);
    store_.visit(static_cast<int>(index), parts, [&](const uint32_t* keys, const uint16_t* weights, size_t count) {
      constexpr size_t kRun = 1024;
      int32_t bins[kRun];
      for (size_t begin = 0; begin < count; begin += kRun) {
        const size_t n = std::min(kRun, count - begin);
        const uint32_t* const run = keys + begin;
        run_widest([&]() TRIAD_INLINE_BODY {
          for (size_t i = 0; i < n; ++i) {
            // Not a number (an infinity times a width of none) becomes 0 here.
            const double at = (static_cast<double>(key_float(run[i])) - low) * bins_per_unit;
            bins[i] = static_cast<int32_t>(std::min(std::max(0.0, at), kPooledHistogramBins - 1.0));
          }
        });
        // Neighbours often fall into one bin, and then wait for each other's sum: even and odd ones have their own.
        const auto count_run = [&](const auto& weight_of) {
          for (size_t i = 0; i < n; ++i) {
            const uint32_t key = run[i];
            const uint64_t weight = weight_of(i);
            part.histogram[i % 2][static_cast<size_t>(bins[i])] += weight;
            if (const size_t slot = slot_of[key >> 16])
              part.lower[(slot - 1) * kFloatBins + (key & 0xffffu)] += weight;
          }
        };
        if (weights)
          count_run([&](size_t i) -> uint64_t { return weights[begin + i]; });
        else
          count_run([](size_t) -> uint64_t { return 1; });
      }
    });
  });
  for (size_t p = 1; p < found.size(); ++p) {
    for (size_t i = 0; i < found[0].lower.size(); ++i) found[0].lower[i] += found[p].lower[i];
    for (size_t half = 0; half < 2; ++half)
      for (size_t i = 0; i < kPooledHistogramBins; ++i) found[0].histogram[half][i] += found[p].histogram[half][i];
  }
  for (size_t i = 0; i < kPooledHistogramBins; ++i)
    result.histogram.push_back(static_cast<double>(found[0].histogram[0][i] + found[0].histogram[1][i]) /
                               (weighted_ ? FloatBins::kMostWeight : 1));

  const uint64_t total = histogram_.total();
  const ExactSum sum = histogram_.sum();
  for (Wanted& one : wanted) {
    const uint64_t* const lower = &found[0].lower[(slot_of[one.bin] - size_t{1}) * kFloatBins];
    const ExactSum goal = one.by_sum ? sum.times(one.percent) : ExactSum{};
    for (uint32_t i = 0; i < kFloatBins; ++i) {
      if (lower[i] == 0) continue;
      const uint32_t key = static_cast<uint32_t>(one.bin) << 16 | i;
      bool reached = false;
      if (one.by_sum) {
        one.sum_before.add_float(key_bits(key), lower[i]);
        reached = one.sum_before.times(100) >= goal;
      } else {
        one.weight_before += lower[i];
        reached = one.weight_before * 100 >= one.percent * total;
      }
      if (!reached) continue;
      *one.value = static_cast<double>(key_float(key));
      break;
    }
  }
}

uint64_t Pooling::held_bytes(bool weighted, uint64_t keep_bytes, uint64_t values_expected) {
  return kFloatBins * (sizeof(uint64_t) + sizeof(Uint128)) +
         std::min(keep_bytes, values_expected * (weighted ? 6 : 4));
}

uint64_t Pooling::block_bytes(bool weighted, uint64_t capacity) {
  return kFloatBins * 3 * sizeof(uint64_t) + capacity * (weighted ? 6 : 4);
}

uint64_t Pooling::finish_bytes(uint64_t values) {
  return static_cast<uint64_t>(parts_for(values)) *
         (2 * kPooledPercents.size() * kFloatBins * sizeof(uint64_t) + (2u << 20));
}

}  // namespace triad
