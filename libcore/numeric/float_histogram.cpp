// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <triad/numeric/float_histogram.hpp>

namespace triad {
namespace {

constexpr int kPackedShift = 40;
constexpr uint64_t kPackedLow = (uint64_t{1} << kPackedShift) - 1;
constexpr size_t kMostPacked = (size_t{1} << 24) - 1;  // values of which neither half overflows
constexpr size_t kLeastBin = kLeastKey >> 16,
                 kLargestBin = kLargestKey >> 16;  // of the infinities, and of them alone

}  // namespace

FloatBins::FloatBins()
    : bins_(std::make_unique<Bin[]>(kFloatBins)), packed_(std::make_unique<uint64_t[]>(kFloatBins)) {}

void FloatBins::add(const uint32_t* keys, size_t count, uint32_t least, uint32_t largest) {
  least_ = std::min(least_, least >> 16);
  largest_ = std::max(largest_, largest >> 16);
  uint64_t* const packed = packed_.get();
  while (count > 0) {
    if (packed_count_ == kMostPacked) unpack();
    const size_t now = std::min(count, kMostPacked - packed_count_);
    for (size_t i = 0; i < now; ++i) packed[keys[i] >> 16] += (uint64_t{1} << kPackedShift) + (keys[i] & 0xffffu);
    packed_count_ += now;
    keys += now;
    count -= now;
  }
}

void FloatBins::unpack() {
  for (size_t bin = least_; bin <= largest_; ++bin) {
    bins_[bin].weight += packed_[bin] >> kPackedShift;
    bins_[bin].low += packed_[bin] & kPackedLow;
    packed_[bin] = 0;
  }
  packed_count_ = 0;
}

void FloatBins::clear() {
  if (least_ <= largest_) {
    std::fill(&bins_[least_], &bins_[largest_] + 1, Bin{});
    std::fill(&packed_[least_], &packed_[largest_] + 1, 0);
  }
  packed_count_ = 0;
  least_ = kFloatBins;
  largest_ = 0;
}

FloatHistogram::FloatHistogram()
    : weight_(std::make_unique<uint64_t[]>(kFloatBins)), low_(std::make_unique<Uint128[]>(kFloatBins)) {}

void FloatHistogram::merge(const FloatBins& part) {
  for (size_t bin = part.least_; bin <= part.largest_; ++bin) {
    const uint64_t packed = part.packed_[bin];
    const FloatBins::Bin& own = part.bins_[bin];
    if (packed == 0 && own.weight == 0) continue;
    weight_[bin] += own.weight + (packed >> kPackedShift);
    low_[bin] += own.low + (packed & kPackedLow);
  }
}

void FloatHistogram::add_sum(size_t bin, ExactSum& sum) const {
  // All values of a bin have one sign and one exponent: they are integers times one power of two.
  const uint32_t bits = key_bits(static_cast<uint32_t>(bin) << 16);
  const bool negative = bits >> 31 != 0;
  const uint32_t exponent = bits >> 23 & 0xff;
  const uint32_t upper = (exponent ? 0x800000u : 0u) | (bits & 0x7f0000u);
  // A negative value's bits are its key's, inverted.
  const Uint128 lower = negative ? static_cast<Uint128>(weight_[bin]) * 0xffffu - low_[bin] : low_[bin];
  sum.add(static_cast<Uint128>(weight_[bin]) * upper + lower, exponent ? static_cast<int>(exponent) - 1 : 0,
          negative);
}

uint64_t FloatHistogram::total() const {
  uint64_t total = 0;
  for (size_t bin = 0; bin < kFloatBins; ++bin) total += weight_[bin];
  return total;
}

ExactSum FloatHistogram::sum() const {
  ExactSum sum;
  for (size_t bin = kLeastBin + 1; bin < kLargestBin; ++bin)
    if (weight_[bin]) add_sum(bin, sum);
  return sum;
}

double FloatHistogram::mean() const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const uint64_t all = total();
  if (all == 0 || (weight_[kLeastBin] && weight_[kLargestBin])) return std::numeric_limits<double>::quiet_NaN();
  if (weight_[kLeastBin]) return -kInfinity;
  if (weight_[kLargestBin]) return kInfinity;
  return sum().value() / static_cast<double>(all);
}

}  // namespace triad
