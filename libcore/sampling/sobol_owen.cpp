// SPDX-License-Identifier: Apache-2.0
#include <triad/numeric/widest.hpp>
#include <triad/sampling/point_strategy.hpp>
#include <triad/sampling/sobol.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "sobol-owen",
    "spp scrambled Sobol points in each pixel",
    "The first spp points of the Sobol sequence, dimensions 0 and 1, with an Owen scrambling of its own for each "
    "pixel. "
    "Unbiased; with spp a power of two, each elementary interval of the pixel (a box of 2^-a by 2^-b with 2^(a+b) = "
    "spp) holds exactly one. The general choice.",
    {{"spp", "samples per pixel", 1, 1 << 24, 16}}};

class SobolOwen final : public PointStrategy {
 public:
  explicit SobolOwen(const StrategyValues& values)
      : PointStrategy(kInfo, values), spp_(static_cast<uint32_t>(values.at("spp"))) {}
  bool estimates_error() const override { return true; }

 protected:
  uint32_t samples_per_pixel() const override { return spp_; }
  void points(int pixel_x, int pixel_y, uint64_t seed, uint32_t first, const Points& out) const override {
    const SobolOwenSeeds seeds(SampleRandom::pixel_key(pixel_x, pixel_y, seed));
    run_widest([&]() TRIAD_INLINE_BODY {
      double *x = out.x.data(), *y = out.y.data();
      const auto n = static_cast<uint32_t>(out.x.size());
      for (uint32_t k = 0; k < n; ++k) {
        const std::array<uint32_t, 2> bits = sobol_owen_point(first + k, seeds);
        x[k] = bits[0] * 0x1p-32;
        y[k] = bits[1] * 0x1p-32;
      }
    });
  }

 private:
  uint32_t spp_;
};

}  // namespace

const StrategyEntry& sobol_owen_strategy() {
  static const StrategyEntry entry{
      kInfo, [](const StrategyValues& v) -> std::unique_ptr<Strategy> { return std::make_unique<SobolOwen>(v); }};
  return entry;
}

}  // namespace triad
