// SPDX-License-Identifier: Apache-2.0
// What POV-Ray's antialiasing methods compare, and how they ask for long lists of samples.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <triad/base/parallel.hpp>
#include <triad/sampling/sample_taker.hpp>
#include <triad/sampling/strategy_base.hpp>
#include <vector>

namespace triad {

// A colour, or nothing where its samples were not valid.
struct PovColour {
  std::array<float, 3> linear{kUnknown, kUnknown, kUnknown};
  std::array<float, 3> encoded{kUnknown, kUnknown, kUnknown};  // linear^(1/gamma), negative light as 0

  static constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  bool known() const { return !std::isnan(linear[0]); }
};

// POV-Ray compares encoded colours: by Antialias_Gamma, 2.5 by default (its manual, section 3.2.8.5.5).
class PovEncoding {
 public:
  explicit PovEncoding(double gamma) : power_(static_cast<float>(1 / gamma)) {}

  PovColour operator()(const std::array<float, 3>& linear) const {
    PovColour colour;
    colour.linear = linear;
    for (int c = 0; c < 3; ++c) colour.encoded[c] = std::pow(std::max(0.f, linear[c]), power_);
    return colour;
  }
  PovColour operator()(const Sample& sample) const { return sample.valid ? (*this)(sample.rgb) : PovColour{}; }

 private:
  float power_;
};

// The sum of the absolute differences of red, green and blue, encoded: POV-Ray's ColourDistance. Not a number where
// one is unknown, so that no comparison with a threshold holds.
inline float pov_distance(const PovColour& a, const PovColour& b) {
  return std::abs(a.encoded[0] - b.encoded[0]) + std::abs(a.encoded[1] - b.encoded[1]) +
         std::abs(a.encoded[2] - b.encoded[2]);
}

inline StrategyParam pov_threshold_param() {
  return {"threshold",
          "difference at which more samples are taken: |dr| + |dg| + |db| of values^(1/gamma), at most 3 "
          "for light in 0 ... 1; 0 takes all samples",
          0,
          std::numeric_limits<double>::infinity(),
          .3,
          true};
}
inline StrategyParam pov_gamma_param() {
  return {"gamma", "values are compared after ^(1/gamma); 1 compares light", .1, 10, 2.5, true};
}

// Asks for count samples, request(i) of each, and hands use(i, sample) every answer; both are called on several
// threads, for different i. Thousands at a time: the list itself would take more memory than the picture. False: the
// render was stopped, and only the first were handed over.
template <class Request, class Use>
bool ask_many(SampleTaker& taker, size_t count, const Request& request, const Use& use) {
  constexpr size_t kAtOnce = size_t{1} << 15, kBlock = 1024;
  std::vector<SampleRequest> requests(std::min(count, kAtOnce));
  std::vector<Sample> samples(requests.size());
  for (size_t first = 0; first < count; first += kAtOnce) {
    const size_t n = std::min(kAtOnce, count - first);
    const auto each = [&](const auto& body) {
      parallel_for(static_cast<int64_t>((n + kBlock - 1) / kBlock), [&](int64_t block) {
        const size_t begin = static_cast<size_t>(block) * kBlock;
        for (size_t i = begin; i < std::min(n, begin + kBlock); ++i) body(i);
      });
    };
    each([&](size_t i) { requests[i] = request(first + i); });
    std::fill_n(samples.begin(), n, Sample{});
    if (!taker.ask(std::span(requests).first(n), std::span(samples).first(n))) return false;
    each([&](size_t i) { use(first + i, samples[i]); });
  }
  return true;
}

// Visits pixels as if in reading order where each depends on few of those before it: on the one to the left, and in
// the row above on all up to `ahead` columns further right.
class ReadingOrder {
 public:
  ReadingOrder(int width, int height, int ahead)
      : width_(width), height_(height), ahead_(ahead), next_(static_cast<size_t>(height), 0) {}

  // visit(x, y) for every pixel whose turn it is, again and again; false puts it off to the next call of advance().
  template <class Visit>
  void advance(const Visit& visit) {
    for (int y = first_row_; y < height_; ++y) {
      int& x = next_[static_cast<size_t>(y)];
      const int above = y == 0 ? width_ : next_[static_cast<size_t>(y) - 1];
      const int end = above == width_ ? width_ : above - ahead_;
      while (x < end && visit(x, y)) ++x;
      if (x == 0) break;  // nor will any row below
      if (x == width_ && y == first_row_) ++first_row_;
    }
  }

 private:
  int width_, height_, ahead_, first_row_ = 0;
  std::vector<int> next_;  // of each row, the pixel that was not visited yet
};

}  // namespace triad
