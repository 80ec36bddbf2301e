// SPDX-License-Identifier: Apache-2.0
#include <triad/base/random.hpp>
#include <triad/sampling/pov_colour.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "pov-stochastic",
    "POV-Ray 3.8's method 3: random samples until a pixel's mean is known well enough",
    "Random points in each pixel, one more in each round, until the mean of the values^(1/gamma) is known to the "
    "threshold with the confidence asked for: z (s_r + s_g + s_b) / sqrt(n) <= threshold, with z such that a normal "
    "variable lies within z standard deviations with that probability, and s and n the standard deviation and the "
    "number of all samples in the pixel and the four next to it. A pixel goes on again when its neighbours find "
    "something. POV-Ray's +AM3 has a most of 4^depth samples, and looks at neighbours in its own block only, in "
    "reading order; here all pixels look at what there was before the round. No pattern shows, noise does; what one "
    "sample in each of five pixels misses stays missed.",
    {{"threshold",
      "how wrong the sum of a pixel's red, green and blue may be, in values^(1/gamma); 0 takes all samples where "
      "there is any difference",
      0, std::numeric_limits<double>::infinity(), .3, true},
     {"confidence", "with what probability", 0, .999999999, .9, true},
     {"spp", "most samples in a pixel", 1, 1 << 24, 64},
     pov_gamma_param()}};

// z with P(|Z| <= z) = confidence for a standard normal Z, to 1e-12: erfc(z / sqrt(2)) = 1 - confidence, by
// bisection.
double two_sided_z(double confidence) {
  double low = 0, high = 10;  // P(|Z| > 10) is 1.5e-23
  while (high - low > 1e-12) {
    const double z = .5 * (low + high);
    (std::erfc(z * std::sqrt(.5)) > 1 - confidence ? low : high) = z;
  }
  return .5 * (low + high);
}

// Of the encoded values of samples.
struct Statistics {
  std::array<double, 3> sum{}, squares{};
  uint32_t count = 0;

  void add(const PovColour& colour) {
    ++count;
    for (int c = 0; c < 3; ++c) {
      const double v = colour.encoded[c];
      sum[c] += v;
      squares[c] += v * v;
    }
  }
  void merge(const Statistics& other) {
    count += other.count;
    for (int c = 0; c < 3; ++c) {
      sum[c] += other.sum[c];
      squares[c] += other.squares[c];
    }
  }
  // The sum over channels of the mean's standard deviation; infinite until it can be known.
  double uncertainty() const {
    if (count < 2) return std::numeric_limits<double>::infinity();
    double total = 0;
    for (int c = 0; c < 3; ++c)
      total += std::sqrt(std::max(0., (squares[c] - sum[c] * sum[c] / count) / (count - 1)) / count);
    return total;
  }
};

class PovStochastic final : public StrategyBase {
 public:
  explicit PovStochastic(const StrategyValues& values)
      : StrategyBase(kInfo, values),
        threshold_(value("threshold")),
        z_(two_sided_z(value("confidence"))),
        spp_(whole("spp")),
        encode_(value("gamma")) {}
  // Most pixels have a single sample, which has no halves.
  bool estimates_error() const override { return false; }
  uint64_t most_samples(int width, int height) const override {
    return uint64_t{spp_} * static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    SampleTaker taker(*this, source, options);
    const Film& film = taker.film();
    std::vector<Statistics> statistics(film.pixels());
    std::vector<uint32_t> taken(film.pixels(), 0);  // those that were not valid included
    std::vector<size_t> pixels(film.pixels());
    for (size_t p = 0; p < pixels.size(); ++p) pixels[p] = p;
    while (!pixels.empty()) {
      const bool all = take_one(taker, pixels, statistics, taken);
      taker.end_pass();
      if (!all) break;
      pixels = unsure(film, with_neighbours(film, pixels), statistics, taken);
    }
    return taker.finish();
  }

 private:
  bool take_one(SampleTaker& taker, const std::vector<size_t>& pixels, std::vector<Statistics>& statistics,
                std::vector<uint32_t>& taken) const {
    const auto width = static_cast<size_t>(taker.film().width());
    const float footprint_px = 1 / std::sqrt(static_cast<float>(spp_));
    const uint64_t seed = taker.options().seed;
    return ask_many(
        taker, pixels.size(),
        [&](size_t i) {
          const size_t p = pixels[i];
          const auto x = static_cast<int32_t>(p % width), y = static_cast<int32_t>(p / width);
          const SampleRandom random(x, y, taken[p], seed);
          return SampleRequest{
              x + double{random.uniform(0)}, y + double{random.uniform(1)}, footprint_px, x, y, taken[p], seed};
        },
        [&](size_t i, const Sample& sample) {
          const size_t p = pixels[i];
          ++taken[p];
          if (sample.valid) statistics[p].add(encode_(sample));
        });
  }

  // Those that were sampled and the four around each, ascending: nothing has changed for all others.
  static std::vector<size_t> with_neighbours(const Film& film, const std::vector<size_t>& pixels) {
    std::vector<uint8_t> marked(film.pixels());
    const auto width = static_cast<size_t>(film.width());
    for (const size_t p : pixels) {
      const size_t x = p % width;
      marked[p] = 1;
      if (x > 0) marked[p - 1] = 1;
      if (x + 1 < width) marked[p + 1] = 1;
      if (p >= width) marked[p - width] = 1;
      if (p + width < marked.size()) marked[p + width] = 1;
    }
    std::vector<size_t> all;
    for (size_t p = 0; p < marked.size(); ++p)
      if (marked[p]) all.push_back(p);
    return all;
  }

  std::vector<size_t> unsure(const Film& film, const std::vector<size_t>& candidates,
                             const std::vector<Statistics>& statistics, const std::vector<uint32_t>& taken) const {
    const auto width = static_cast<size_t>(film.width());
    std::vector<uint8_t> goes_on(candidates.size());
    constexpr size_t kBlock = 1024;
    parallel_for(static_cast<int64_t>((candidates.size() + kBlock - 1) / kBlock), [&](int64_t block) {
      const size_t first = static_cast<size_t>(block) * kBlock;
      for (size_t i = first; i < std::min(candidates.size(), first + kBlock); ++i) {
        const size_t p = candidates[i], x = p % width;
        if (taken[p] >= spp_) continue;
        Statistics pooled = statistics[p];
        if (x > 0) pooled.merge(statistics[p - 1]);
        if (p >= width) pooled.merge(statistics[p - width]);
        if (x + 1 < width) pooled.merge(statistics[p + 1]);
        if (p + width < statistics.size()) pooled.merge(statistics[p + width]);
        goes_on[i] = pooled.count < 2 || z_ * pooled.uncertainty() > threshold_;
      }
    });
    std::vector<size_t> pixels;
    for (size_t i = 0; i < candidates.size(); ++i)
      if (goes_on[i]) pixels.push_back(candidates[i]);
    return pixels;
  }

  const double threshold_, z_;
  const uint32_t spp_;
  const PovEncoding encode_;
};

}  // namespace

const StrategyEntry& pov_stochastic_strategy() {
  static const StrategyEntry entry = strategy_entry<PovStochastic>(kInfo);
  return entry;
}

}  // namespace triad
