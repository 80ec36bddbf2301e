// SPDX-License-Identifier: Apache-2.0
// Sums of floats without any rounding.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <compare>
#include <cstdint>

namespace triad {

__extension__ using Uint128 = unsigned __int128;

// A fixed-point number of 512 bits in units of 2^-149, the smallest step of a float: 2^48 floats, each times a weight
// below 2^48, sum up in it exactly, so that neither order nor grouping matters. For comparing and for one rounding at
// the end, not for hot loops.
class ExactSum {
 public:
  // Adds (negative ? -1 : 1) * magnitude * 2^(shift - 149); shift in [0, 300].
  void add(Uint128 magnitude, int shift, bool negative) {
    std::array<uint64_t, kWords> term{};
    const size_t word = static_cast<size_t>(shift) / 64;
    const unsigned bit = static_cast<unsigned>(shift) % 64;
    const uint64_t low = static_cast<uint64_t>(magnitude), high = static_cast<uint64_t>(magnitude >> 64);
    term[word] = low << bit;
    term[word + 1] = high << bit | (bit ? low >> (64 - bit) : 0);
    term[word + 2] = bit ? high >> (64 - bit) : 0;
    uint64_t carry = negative ? 1 : 0;
    for (size_t i = 0; i < kWords; ++i) {
      const Uint128 sum = static_cast<Uint128>(words_[i]) + (negative ? ~term[i] : term[i]) + carry;
      words_[i] = static_cast<uint64_t>(sum);
      carry = static_cast<uint64_t>(sum >> 64);
    }
  }
  // Adds weight times the finite float of these bits (IEEE 754 binary32).
  void add_float(uint32_t bits, uint64_t weight) {
    const uint32_t exponent = bits >> 23 & 0xff, fraction = bits & 0x7fffff;
    const uint64_t mantissa = exponent ? fraction | 0x800000u : fraction;
    add(static_cast<Uint128>(mantissa) * weight, exponent ? static_cast<int>(exponent) - 1 : 0, bits >> 31 != 0);
  }

  // This times a small factor; the sum must not be negative.
  ExactSum times(uint32_t factor) const {
    ExactSum product;
    uint64_t carry = 0;
    for (size_t i = 0; i < kWords; ++i) {
      const Uint128 part = static_cast<Uint128>(words_[i]) * factor + carry;
      product.words_[i] = static_cast<uint64_t>(part);
      carry = static_cast<uint64_t>(part >> 64);
    }
    return product;
  }

  bool negative() const { return words_[kWords - 1] >> 63 != 0; }
  bool zero() const { return words_ == std::array<uint64_t, kWords>{}; }
  std::strong_ordering operator<=>(const ExactSum& other) const {
    if (negative() != other.negative())
      return negative() ? std::strong_ordering::less : std::strong_ordering::greater;
    for (size_t i = kWords; i-- > 0;)
      if (words_[i] != other.words_[i]) return words_[i] <=> other.words_[i];
    return std::strong_ordering::equal;
  }
  bool operator==(const ExactSum& other) const = default;

  // The nearest double.
  double value() const {
    if (negative()) {
      ExactSum opposite;
      uint64_t carry = 1;
      for (size_t i = 0; i < kWords; ++i) {
        opposite.words_[i] = ~words_[i] + carry;
        carry = carry && opposite.words_[i] == 0;
      }
      return -opposite.value();
    }
    size_t top = kWords;
    while (top > 0 && words_[top - 1] == 0) --top;
    if (top == 0) return 0;
    // The 64 bits from the first one on; what is below them only decides ties.
    const int lead = std::countl_zero(words_[top - 1]);
    uint64_t bits = words_[top - 1] << lead;
    bool rest = false;
    if (top > 1) {
      if (lead > 0) bits |= words_[top - 2] >> (64 - lead);
      rest = lead > 0 ? words_[top - 2] << lead != 0 : words_[top - 2] != 0;
      for (size_t i = 0; i + 2 < top; ++i) rest = rest || words_[i] != 0;
    }
    return std::ldexp(static_cast<double>(bits | (rest ? 1u : 0u)), static_cast<int>(top - 1) * 64 - lead - 149);
  }

 private:
  static constexpr size_t kWords = 8;
  std::array<uint64_t, kWords> words_{};
};

}  // namespace triad
