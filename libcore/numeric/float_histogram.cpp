// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <triad/numeric/float_histogram.hpp>

namespace triad {
namespace {

constexpr size_t kPage = 256;  // bins
constexpr size_t kLeastBin = kLeastKey >> 16,
                 kLargestBin = kLargestKey >> 16;  // of the infinities, and of them alone

}  // namespace

FloatBins::FloatBins() : bins_(std::make_unique<Bin[]>(kFloatBins)) {}

void FloatBins::add(const uint32_t* keys, size_t count) {
  Bin* const bins = bins_.get();
  for (size_t i = 0; i < count; ++i) {
    const uint32_t key = keys[i];
    touched_[key >> 24] = 1;
    Bin& bin = bins[key >> 16];
    bin.weight += 1;
    bin.low += key & 0xffffu;
  }
}

void FloatBins::clear() {
  for (size_t page = 0; page < touched_.size(); ++page)
    if (touched_[page]) std::fill_n(&bins_[page * kPage], kPage, Bin{});
  touched_ = {};
}

FloatHistogram::FloatHistogram()
    : weight_(std::make_unique<uint64_t[]>(kFloatBins)), low_(std::make_unique<Uint128[]>(kFloatBins)) {}

void FloatHistogram::merge(const FloatBins& part) {
  for (size_t page = 0; page < part.touched_.size(); ++page) {
    if (!part.touched_[page]) continue;
    for (size_t bin = page * kPage; bin < (page + 1) * kPage; ++bin) {
      weight_[bin] += part.bins_[bin].weight;
      low_[bin] += part.bins_[bin].low;
    }
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
