// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/base/parallel.hpp>
#include <triad/sampling/filtered_points.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "splat", "samples all over the film, each added to every pixel whose reconstruction filter covers it",
    "spp points in each pixel, and in those beyond the border that filters reach. A pixel is the mean of all samples "
    "under its filter, weighted by it. Where weights cancel (negative values of mitchell, lanczos2, lanczos3, few "
    "samples), it is the sample nearest to its centre, and where a narrow filter meets none, the mean of its own. "
    "Wide "
    "filters use a sample many times over, which makes edges smooth and noise low in frequency: neighbours share "
    "their "
    "samples. Bright specks become blots of the filter's shape. A variance that is asked for is that of the mean of "
    "a "
    "pixel's own samples.",
    FilteredPoints::params()};

// What remains of a sample until it is splatted.
struct Kept {
  double x, y;
  std::array<float, 3> rgb;
  bool usable;
};

// Red, green, blue, and weight.
struct Weighted {
  alignas(32) std::array<double, 4> sum{};
};

// The weights along one axis of a sample at x: of the pixels `first` .. `past` - 1, inside [low, high).
struct Reach {
  static constexpr int kMost = 64;  // above twice the largest radius, 8 times 3 pixels
  int first, past;
  std::array<double, kMost> weights;

  Reach(const ReconstructionTable& filter, double x, int low, int high)
      : first(std::max(low, static_cast<int>(std::floor(x - filter.radius_px() - .5)) + 1)),
        past(std::min(high, static_cast<int>(std::floor(x + filter.radius_px() - .5)) + 1)) {
    for (int p = first; p < past; ++p) weights[static_cast<size_t>(p - first)] = filter(x - p - .5);
  }
};

// One render. In each pass, bands of rows are sampled one after another; then the samples of the band, and of the
// rows before it that its filters reach, are added to pixels by threads that own columns of them. Each pixel meets
// its samples pass by pass, row by row and from left to right, whoever owns it.
class Splatting {
 public:
  Splatting(SampleTaker& taker, const PixelPoints& points, const ReconstructionFilter& filter,
            const ReconstructionTable& table, float footprint_px)
      : taker_(taker),
        points_(points),
        filter_(table),
        is_signed_(filter.is_signed()),
        footprint_px_(footprint_px),
        width_(taker.film().width()),
        height_(taker.film().height()),
        border_(border_px(filter)),
        sums_(taker.film().pixels()),
        signed_weights_(is_signed_ ? taker.film().pixels() : 0) {}

  // Pixels beyond each border whose samples count inside.
  static int border_px(const ReconstructionFilter& filter) {
    return std::max(0, static_cast<int>(std::ceil(filter.radius_px() - .5)));
  }

  // Samples per pixel of a pass, so that the fewest rows that are kept at once take kMostKept; or one, if they are
  // wider still.
  uint32_t most_in_pass() const {
    constexpr uint64_t kMostKept = 1 << 22;  // samples: 134 MB
    constexpr uint64_t kMost = 16;
    const uint64_t rows = static_cast<uint64_t>(std::min(height_, kFewestRows) + 2 * border_);
    const uint64_t across = static_cast<uint64_t>(width_) + 2 * static_cast<uint64_t>(border_);
    return static_cast<uint32_t>(std::clamp(kMostKept / (rows * across), uint64_t{1}, kMost));
  }

  // Samples first .. past - 1 of each pixel. False: the render was stopped.
  bool pass(uint32_t first, uint32_t past) {
    constexpr int kSamplesAtOnce = 1 << 18;  // 8 MB of them, or more if the fewest rows have more
    const int across = width_ + 2 * border_;
    const auto each = static_cast<int>(past - first);
    const int rows = std::min(height_, std::max({kFewestRows, kSamplesAtOnce / each / across}));
    first_ = first;
    each_ = past - first;
    row_samples_ = static_cast<size_t>(across) * each_;
    ring_rows_ = rows + 2 * border_;
    kept_.resize(row_samples_ * static_cast<size_t>(ring_rows_));
    for (int y0 = 0, sampled = -border_; y0 < height_; y0 += rows) {
      const int y1 = std::min(y0 + rows, height_);
      if (!sample_rows(sampled, y1 + border_)) return false;
      sampled = y1 + border_;
      if (is_signed_)
        splat_rows<true>(y0, y1);
      else
        splat_rows<false>(y0, y1);
    }
    return true;
  }

  // `film` is the one that samples were added to.
  std::vector<std::array<double, 3>> colour(const Film& film) const {
    std::vector<std::array<double, 3>> colour(sums_.size());
    for (size_t p = 0; p < colour.size(); ++p) {
      const auto& [red, green, blue, weight] = sums_[p].sum;
      if (weight == 0) {  // a filter narrower than a pixel may meet no sample
        colour[p] = film.mean(p);
      } else if (is_signed_ && signed_weights_[p].cancel()) {
        const std::array<float, 3>& nearest = signed_weights_[p].nearest;
        colour[p] = {nearest[0], nearest[1], nearest[2]};
      } else {
        colour[p] = {red / weight, green / weight, blue / weight};
      }
    }
    return colour;
  }

 private:
  static constexpr int kFewestRows = 16;  // of a band: enough for all threads
  static constexpr int kColumns = 32;     // that a thread owns at once
  static constexpr size_t kBatch = 256;   // samples asked for at once

  Kept* kept(int x, int y) {
    return kept_.data() + static_cast<size_t>((y + border_) % ring_rows_) * row_samples_ +
           static_cast<size_t>(x + border_) * each_;
  }

  bool sample_rows(int y0, int y1) {
    const int tile = std::max(1, taker_.options().tile_px), across = width_ + 2 * border_;
    const int columns = across / tile + (across % tile > 0), rows = (y1 - y0) / tile + ((y1 - y0) % tile > 0);
    parallel_for(int64_t{columns} * rows, [&](int64_t t) {
      const int left = static_cast<int>(t % columns) * tile, top = static_cast<int>(t / columns) * tile;
      const int x0 = left - border_, x1 = x0 + std::min(tile, across - left);
      sample_tile(x0, x1, y0 + top, y0 + top + std::min(tile, y1 - y0 - top));
    });
    return !taker_.stopped();
  }

  void sample_tile(int x0, int x1, int y0, int y1) {
    std::vector<SampleRequest> requests(kBatch);
    std::vector<Sample> samples(kBatch);
    std::vector<Kept*> places(kBatch);
    size_t size = 0;
    const auto flush = [&] {
      const std::span<SampleRequest> asked(requests.data(), size);
      const std::span<Sample> answers(samples.data(), size);
      points_.place(asked);
      if (!taker_.take(asked, answers)) return false;
      for (size_t i = 0; i < size; ++i) *places[i] = {asked[i].x, asked[i].y, answers[i].rgb, answers[i].valid};
      size = 0;
      return true;
    };
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        Kept* const to = kept(x, y);
        for (uint32_t i = 0; i < each_; ++i) {
          if (size == kBatch && !flush()) return;
          places[size] = to + i;
          requests[size++] = {0, 0, footprint_px_, x, y, first_ + i, taker_.options().seed};
        }
      }
    flush();
  }

  template <bool kSigned>
  void splat_rows(int y0, int y1) {
    const int stripes = width_ / kColumns + (width_ % kColumns > 0);
    parallel_for(stripes, [&](int64_t stripe) {
      const int x0 = static_cast<int>(stripe) * kColumns, x1 = x0 + std::min(kColumns, width_ - x0);
      for (int y = y0 - border_; y < y1 + border_; ++y) {
        const Kept* const past = kept(x1 - 1 + border_, y) + each_;
        for (const Kept* k = kept(x0 - border_, y); k < past; ++k)
          if (k->usable) splat<kSigned>(*k, Reach(filter_, k->x, x0, x1), Reach(filter_, k->y, y0, y1));
      }
    });
  }

  template <bool kSigned>
  void splat(const Kept& k, const Reach& across, const Reach& down) {
    const std::array<double, 4> value{k.rgb[0], k.rgb[1], k.rgb[2], 1};
    for (int y = down.first; y < down.past; ++y)
      for (int x = across.first; x < across.past; ++x) {
        const double w =
            across.weights[static_cast<size_t>(x - across.first)] * down.weights[static_cast<size_t>(y - down.first)];
        const size_t p = static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
        for (size_t c = 0; c < 4; ++c) sums_[p].sum[c] += w * value[c];
        if constexpr (kSigned) signed_weights_[p].add(w, k.x - x - .5, k.y - y - .5, k.rgb);
      }
  }

  SampleTaker& taker_;
  const PixelPoints& points_;
  const ReconstructionTable& filter_;
  const bool is_signed_;
  const float footprint_px_;
  const int width_, height_, border_;
  std::vector<Weighted> sums_;
  std::vector<SignedWeights> signed_weights_;  // of filters with negative values
  // Of the pass: rows of samples, in a ring.
  uint32_t first_ = 0, each_ = 0;
  int ring_rows_ = 0;
  size_t row_samples_ = 0;
  std::vector<Kept> kept_;
};

class Splat final : public FilteredPoints {
 public:
  explicit Splat(const StrategyValues& values) : FilteredPoints(kInfo, values) {}
  bool estimates_error() const override { return false; }  // halves of a pixel's own samples say little of it
  uint64_t most_samples(int width, int height) const override {
    const int border = Splatting::border_px(filter());
    return uint64_t{spp()} * static_cast<uint64_t>(width + 2 * border) * static_cast<uint64_t>(height + 2 * border);
  }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    SampleTaker taker(*this, source, options);
    Splatting splatting(taker, points(), filter(), table(), footprint_px());
    const uint32_t at_once = splatting.most_in_pass();
    // The first pass has one, so that all is covered soon.
    for (uint32_t first = 0, last = 1; first < spp(); first = last, last = std::min(spp(), last + at_once)) {
      const bool done = splatting.pass(first, last);
      taker.end_pass();
      if (!done) break;
    }
    RenderResult result = taker.finish();
    result.colour = splatting.colour(result.film);
    return result;
  }
};

}  // namespace

const StrategyEntry& splat_strategy() {
  static const StrategyEntry entry = strategy_entry<Splat>(kInfo);
  return entry;
}

}  // namespace triad
