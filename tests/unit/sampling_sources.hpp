// SPDX-License-Identifier: Apache-2.0
// Sources for tests of strategies.
#pragma once

#include <cmath>
#include <functional>
#include <triad/base/random.hpp>
#include <triad/sampling/source.hpp>

namespace triad::test {

// Answers each request by a function.
class FunctionSource final : public Source {
 public:
  using Function = std::function<Sample(const SampleRequest&)>;
  FunctionSource(int width, int height, Function function)
      : width_(width), height_(height), function_(std::move(function)) {}
  int width() const override { return width_; }
  int height() const override { return height_; }
  SourceAbilities abilities() const override { return {.geometry = true}; }
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const override {
    for (size_t i = 0; i < requests.size(); ++i) samples[i] = function_(requests[i]);
  }

 private:
  int width_, height_;
  Function function_;
};

inline Sample grey(double value) {
  Sample sample;
  sample.rgb = {static_cast<float>(value), static_cast<float>(value), static_cast<float>(value)};
  return sample;
}

// level + amplitude * u with u uniform in [-1/2, 1/2), independent in all samples and channels; variance
// amplitude^2 / 12.
inline FunctionSource noise(int width, int height, double level, double amplitude) {
  return FunctionSource(width, height, [=](const SampleRequest& r) {
    const SampleRandom random(r.pixel_x, r.pixel_y, r.index, r.seed);
    Sample sample;
    for (uint32_t c = 0; c < 3; ++c)
      sample.rgb[c] = static_cast<float>(
          level + amplitude * (random.uniform(SampleRandom::kFirstSourceDimension + c) - .5 + 0x1p-25));
    return sample;
  });
}

}  // namespace triad::test
