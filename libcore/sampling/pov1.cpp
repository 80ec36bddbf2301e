// SPDX-License-Identifier: Apache-2.0
#include <triad/sampling/pov_colour.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "pov1",
    "POV-Ray's method 1: n x n samples where a pixel differs from the left or the upper one",
    "A sample at each pixel's centre. Then, in reading order, wherever a pixel differs from its left or its upper "
    "neighbour by the threshold or more, n x n samples on a regular grid in the pixel and in that neighbour, each "
    "at most once; their mean with the centre's sample is the pixel. A neighbour that has got its samples is "
    "compared "
    "as what it has become. Quick, and what is seen to differ is smoothed; but what lies between the centres is "
    "found by luck, and as differences are looked for to the left and above only, lines that fall to the right come "
    "out better than those that rise. The map of reasons says 1 where a pixel differed from its left or upper "
    "neighbour, 2 where the right or the lower neighbour differed from it. Noise differs too.",
    {{"n", "samples along each side of a pixel", 1, 256, 3}, pov_threshold_param(), pov_gamma_param()}};

enum class Reason : uint8_t { kNone, kOwn, kNeighbour };

class Pov1 final : public StrategyBase {
 public:
  explicit Pov1(const StrategyValues& values) : StrategyBase(kInfo, values) {}
  bool estimates_error() const override { return false; }
  std::vector<std::string> reason_channels() const override { return {"reason.supersampled"}; }
  uint64_t most_samples(int width, int height) const override {
    const uint64_t n = whole("n");
    return (n * n + 1) * static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    SampleTaker taker(*this, source, options);
    const Film& film = taker.film();
    std::vector<PovColour> colours(film.pixels());  // with all samples that a pixel has
    std::vector<Reason> reasons(film.pixels(), Reason::kNone);
    if (centres(taker, colours)) supersample(taker, colours, reasons);
    if (options.planes.reasons) {
      std::vector<float>& map = taker.result().reasons.emplace_back(film.pixels());
      for (size_t p = 0; p < map.size(); ++p) map[p] = static_cast<float>(reasons[p]);
    }
    return taker.finish();
  }

 private:
  bool centres(SampleTaker& taker, std::vector<PovColour>& colours) const {
    const PovEncoding encode(value("gamma"));
    const auto width = static_cast<size_t>(taker.film().width());
    const bool all = ask_many(
        taker, colours.size(),
        [&](size_t p) {
          const auto x = static_cast<int32_t>(p % width), y = static_cast<int32_t>(p / width);
          return SampleRequest{x + .5, y + .5, 1, x, y, 0, taker.options().seed};
        },
        [&](size_t p, const Sample& sample) { colours[p] = encode(sample); });
    taker.end_pass();
    return all;
  }

  // Decisions are made in reading order, and go on wherever they do not need the colour of a pixel whose samples are
  // not there yet; whenever none can go on, the samples are asked for, of all these pixels together.
  void supersample(SampleTaker& taker, std::vector<PovColour>& colours, std::vector<Reason>& reasons) const {
    const Film& film = taker.film();
    const double threshold = value("threshold");
    std::vector<uint8_t> waits(film.pixels(), 0);
    std::vector<size_t> wanted;
    size_t undecided = film.pixels();
    const auto want = [&](size_t p, Reason reason) {
      if (reasons[p] != Reason::kNone) return;
      reasons[p] = reason;
      waits[p] = 1;
      wanted.push_back(p);
    };
    const auto visit = [&](int x, int y) {
      const size_t p = film.pixel(x, y), left = p - (x > 0), up = y > 0 ? p - static_cast<size_t>(film.width()) : p;
      if (waits[left] || waits[up]) return false;
      const bool differs_left = x > 0 && pov_distance(colours[left], colours[p]) >= threshold;
      const bool differs_up = y > 0 && pov_distance(colours[up], colours[p]) >= threshold;
      if (differs_left) want(left, Reason::kNeighbour);
      if (differs_up) want(up, Reason::kNeighbour);
      if (differs_left || differs_up) want(p, Reason::kOwn);
      --undecided;
      return true;
    };
    // The one above is the left neighbour of the one above and to the right, which comes before this.
    ReadingOrder order(film.width(), film.height(), 1);
    for (;;) {
      order.advance(visit);
      if (wanted.empty()) break;
      // Of those that are decided, only neighbours of others may still be called for: a staircase of pixels.
      const size_t left =
          undecided + wanted.size() + static_cast<size_t>(film.width()) + static_cast<size_t>(film.height());
      taker.expect(static_cast<double>(taker.samples()) + static_cast<double>(left) * (value("n") * value("n")));
      if (!take_grids(taker, wanted, colours)) break;
      for (const size_t p : wanted) waits[p] = 0;
      wanted.clear();
    }
    taker.end_pass();
  }

  bool take_grids(SampleTaker& taker, const std::vector<size_t>& pixels, std::vector<PovColour>& colours) const {
    const Film& film = taker.film();
    const uint32_t n = whole("n"), each = n * n;
    const auto width = static_cast<size_t>(film.width());
    const bool all = ask_many(
        taker, pixels.size() * each,
        [&](size_t i) {
          const size_t p = pixels[i / each];
          const auto x = static_cast<int32_t>(p % width), y = static_cast<int32_t>(p / width);
          const auto k = static_cast<uint32_t>(i % each);
          return SampleRequest{x + (k % n + .5) / n, y + (k / n + .5) / n, 1 / static_cast<float>(n), x, y, k + 1,
                               taker.options().seed};
        },
        [](size_t, const Sample&) {});
    const PovEncoding encode(value("gamma"));
    for (const size_t p : pixels) {
      if (film.count(p) == 0) continue;
      const std::array<double, 3> mean = film.mean(p);
      colours[p] =
          encode(std::array{static_cast<float>(mean[0]), static_cast<float>(mean[1]), static_cast<float>(mean[2])});
    }
    return all;
  }
};

}  // namespace

const StrategyEntry& pov1_strategy() {
  static const StrategyEntry entry = strategy_entry<Pov1>(kInfo);
  return entry;
}

}  // namespace triad
