// SPDX-License-Identifier: Apache-2.0
// quad and tri: sampled coarsely first, and more finely where the coarse picture is not linear.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <triad/base/log.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/levels.hpp>
#include <triad/sampling/sample_taker.hpp>
#include <triad/sampling/strategy_base.hpp>

namespace triad {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr size_t kBatch = 256;  // samples asked for at once
constexpr int kBlock = 8;       // side of the squares of cells that are sampled one after another

const std::string kDoc =
    "One ray for each square of 2^under pixels first. Then level by level, with half the side: a cell is sampled if "
    "the neighbourhood of the one above that it lies in is not linear, and interpolated if it is. Linear means that "
    "the mean over opposite neighbours of |a - (b + c) / 2| is at most `colour` in red, green and blue, and the same "
    "of the places that rays met, divided by their distance, at most `position`; with ids=on all neighbours must "
    "also "
    "be the same object. `over` levels lie above the picture's own and are averaged. Thresholds are in linear light: "
    "in a picture with values far above 1, raise `colour` with them.\n\n"
    "An object smaller than a coarse cell is missed if no ray meets it: then take less `under`. Noise looks like "
    "detail, and so with noise=shared all rays draw the same random numbers: lamps are met at the same places from "
    "everywhere, and soft shadows become as many sharp ones as spp says. A pixel's expected error is that of "
    "noise=own, which samples nearly everything in pictures with soft light and small spp. But the cells of `over` "
    "then share their noise, too: with soft light, take spp=16 or more, or noise=own.\n\n"
    "Without geometry, as in functions and picture files, only colours count. The reasons (--aov reasons) are a "
    "picture: green is the share of a pixel's finest cells that were sampled for colour, blue for position, red for "
    "ids. Other planes, depth for instance, are empty where no ray was sent.";

std::vector<StrategyParam> with_common(std::vector<StrategyParam> own) {
  std::vector<StrategyParam> params{
      {"under", "levels below the picture's own: one ray for 2^under x 2^under pixels", 0, 6, 2},
      {"over", "levels above it: up to 2^over x 2^over rays in a pixel", 0, 4, 0},
      {"colour", "difference of linear light above which to go on; inf: colours are not looked at", 0, kInfinity, .03,
       true},
      {"position", "difference of positions over distance above which to go on; inf: not looked at", 0, kInfinity,
       .03, true},
      choice_param("ids", "whether to go on where neighbours are different objects", {"off", "on"}),
      {"spp", "samples at each place, for noisy light", 1, 1 << 16, 1},
      choice_param("noise", "the same random numbers for all rays, or own ones", {"shared", "own"})};
  params.insert(params.end(), own.begin(), own.end());
  return params;
}

const StrategyInfo kQuad{"quad", "coarse to fine on a square grid, by eight neighbours", kDoc, with_common({})};
const StrategyInfo kTri{"tri", "coarse to fine on a grid whose odd rows are shifted, by six neighbours",
                        kDoc +
                            "\n\nOn the triangular grid, samples in odd rows are half a cell to the right. "
                            "The way back to the square one is the mean of the two nearest in such a row: a blur, "
                            "which takes it further from a picture with a sample at each pixel's centre, and nearer "
                            "to one without aliasing. finest=square leaves out the shift on the last level, so that "
                            "no way back is needed.",
                        with_common({choice_param("finest", "the last level's grid", {"shifted", "square"})})};

// Gives each request the random numbers of one pixel.
class SharedNumbers final : public Source {
 public:
  explicit SharedNumbers(const Source& source) : source_(source) {}
  int width() const override { return source_.width(); }
  int height() const override { return source_.height(); }
  SourceAbilities abilities() const override { return source_.abilities(); }
  void eval(std::span<const SampleRequest> requests, std::span<Sample> samples) const override {
    std::array<SampleRequest, kBatch> shared;
    for (size_t first = 0; first < requests.size(); first += kBatch) {
      const size_t count = std::min(kBatch, requests.size() - first);
      for (size_t i = 0; i < count; ++i) {
        shared[i] = requests[first + i];
        shared[i].pixel_x = shared[i].pixel_y = 0;
      }
      source_.eval(std::span(shared).first(count), samples.subspan(first, count));
    }
  }

 private:
  const Source& source_;
};

class Levels final : public StrategyBase {
 public:
  Levels(const StrategyInfo& info, const StrategyValues& values)
      : StrategyBase(info, values),
        under_(static_cast<int>(whole("under"))),
        over_(static_cast<int>(whole("over"))),
        spp_(whole("spp")),
        shared_(whole("noise") == 0),
        triangular_(&info == &kTri),
        last_is_square_(triangular_ && whole("finest") == 1),
        thresholds_{value("colour"), value("position"), !std::isinf(value("position")), whole("ids") == 1} {}

  bool estimates_error() const override { return false; }
  bool uses_geometry() const override { return thresholds_.geometry || thresholds_.ids; }
  std::vector<std::string> reason_channels() const override { return {"reason.R", "reason.G", "reason.B"}; }
  uint64_t most_samples(int width, int height) const override {
    uint64_t cells = 0;
    for (int level = coarsest(width, height); level >= -over_; --level) {
      const LevelLattice at = lattice(width, height, level);
      cells += static_cast<uint64_t>(at.width) * static_cast<uint64_t>(at.height);
    }
    return cells * spp_;
  }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    const int width = source.width(), height = source.height();
    const bool geometry = uses_geometry() && source.abilities().geometry;
    require_film_memory(width, height, options.planes, most_bytes(width, height, geometry),
                        over_ > 0 ? "a smaller --size, or less `over`" : "a smaller --size");
    const SharedNumbers shared(source);
    SampleTaker taker(*this, shared_ ? shared : source, options);
    if (uses_geometry() && !geometry)
      warn(info().name + ": the source tells no positions and no ids, so colours alone say where rays are sent");

    int level = coarsest(width, height);
    std::optional<Level> above;
    Level here(lattice(width, height, level), geometry && level > -over_);
    refine(taker, here, nullptr, level);
    // A render that was stopped needs no cells finer than pixels.
    while (level > -over_ && !(level <= 0 && taker.stop())) {
      --level;
      here.judge(thresholds_);
      above = std::move(here);
      here = Level(lattice(width, height, level), geometry && level > -over_);
      refine(taker, here, &*above, level);
    }
    resolve(here, level, taker.result());
    if (options.planes.reasons) tell_reasons(here, level, above ? &*above : nullptr, taker.result());
    return taker.finish();
  }

 private:
  // Cells of 2^level pixels; not larger than the picture, so that all of them are in view.
  int coarsest(int width, int height) const {
    int level = under_;
    while (level > 0 && (1 << level) > std::min(width, height)) --level;
    return level;
  }
  LevelLattice lattice(int width, int height, int level) const {
    return {width, height, std::ldexp(1., level), triangular_ && !(last_is_square_ && level == -over_)};
  }

  // Of the two finest levels, which are there at the same time, and the picture's colours.
  double most_bytes(int width, int height, bool geometry) const {
    const double pixels = static_cast<double>(width) * height, finest = std::ldexp(pixels, 2 * over_);
    const double above = coarsest(width, height) > -over_ ? finest / 4 : 0;
    return above * static_cast<double>(Level::cell_bytes(geometry)) +
           finest * static_cast<double>(Level::cell_bytes(false)) + pixels * sizeof(std::array<double, 3>);
  }

  // The first number of a cell's samples: those of a pixel all have numbers of their own, unless the last cell of a
  // shifted row, which is beyond the film, lends its samples to the pixel before it. The finest level comes first,
  // and so has the numbers of a picture that is fully sampled, by control or grid.
  uint32_t first_index(int level, int x, int y) const {
    if (shared_) return 0;
    const int finer = std::max(0, -level), side = 1 << finer;
    // 4^(finer + 1) + ... + 4^over: cells in a pixel of the finer levels.
    uint32_t cell = ((4u << (2 * over_)) - (4u << (2 * finer))) / 3;
    cell += static_cast<uint32_t>(level > 0 ? level : (y & (side - 1)) * side + (x & (side - 1)));
    return cell * spp_;
  }

  // Samples of one thread, for cells in any number.
  class Queue {
   public:
    Queue(const Levels& levels, SampleTaker& taker, Level& level, int number)
        : levels_(levels), taker_(taker), level_(level), number_(number) {
      const size_t room = std::max<size_t>(kBatch / levels.spp_, 1) * levels.spp_;
      requests_.reserve(room);
      samples_.resize(room);
    }
    void add(int x, int y) {
      const LevelLattice& lattice = level_.lattice();
      const Film& film = taker_.film();
      SampleRequest request;
      request.x = lattice.sample_x(x, y);
      request.y = lattice.sample_y(y);
      // The picture is made of cells of the last level, and so textures are filtered for those, on all levels.
      request.footprint_px = std::ldexp(1.f, -levels_.over_);
      request.pixel_x = std::min(static_cast<int>(request.x), film.width() - 1);
      request.pixel_y = std::min(static_cast<int>(request.y), film.height() - 1);
      request.seed = taker_.options().seed;
      request.index = levels_.first_index(number_, x, y);
      for (uint32_t i = 0; i < levels_.spp_; ++i, ++request.index) requests_.push_back(request);
      cells_.push_back({x, y});
      if (requests_.size() == samples_.size()) flush();
    }
    void flush() {
      const std::span<Sample> samples = std::span(samples_).first(requests_.size());
      std::fill(samples.begin(), samples.end(), Sample{});
      if (taker_.take(requests_, samples))
        for (size_t i = 0; i < cells_.size(); ++i)
          level_.set(cells_[i][0], cells_[i][1], samples.subspan(i * levels_.spp_, levels_.spp_));
      requests_.clear();
      cells_.clear();
    }

   private:
    const Levels& levels_;
    SampleTaker& taker_;
    Level& level_;
    int number_;
    std::vector<SampleRequest> requests_;
    std::vector<Sample> samples_;
    std::vector<std::array<int, 2>> cells_;
  };

  // Interpolates, then samples what the level above asks for, or everything. What cannot be sampled, be it not valid
  // or be the render stopped, stays interpolated. Threads take whole rows of pixels, and so different ones; they go
  // through them in squares, so that rays at the same edge come together.
  void refine(SampleTaker& taker, Level& level, const Level* above, int number) const {
    const int width = level.lattice().width, height = level.lattice().height;
    const int rows = std::max(kBlock, 1 << std::max(0, -number));
    parallel_for((height + rows - 1) / rows, [&](int64_t band) {
      const int y0 = static_cast<int>(band) * rows, y1 = std::min(y0 + rows, height);
      for (int y = y0; y < y1 && above; ++y) level.interpolate_row(y, *above);
      if (taker.stopped()) return;
      Queue queue(*this, taker, level, number);
      for (int x0 = 0; x0 < width; x0 += kBlock)
        for (int y = y0; y < y1; ++y)
          for (int x = x0; x < std::min(x0 + kBlock, width); ++x)
            if (!above || above->reason_for(level.lattice(), x, y) != LevelReason::kNone) queue.add(x, y);
      queue.flush();
    });
    taker.end_pass();
  }

  // `level` is the finest one's, and not above 0.
  void resolve(const Level& finest, int level, RenderResult& result) const {
    const int width = result.film.width(), side = 1 << -level;
    result.colour.resize(result.film.pixels());
    parallel_for(result.film.height(), [&](int64_t y) {
      for (int x = 0; x < width; ++x) {
        std::array<double, 3> sum{};
        double weight = 0;
        for (int v = 0; v < side; ++v)
          for (int u = 0; u < side; ++u) {
            const Level::Weighted cell = finest.at_centre(x * side + u, static_cast<int>(y) * side + v);
            for (int c = 0; c < 3; ++c) sum[c] += cell.sum[c];
            weight += cell.weight;
          }
        for (int c = 0; c < 3 && weight > 0; ++c)
          result.colour[result.film.pixel(x, static_cast<int>(y))][c] = sum[c] / weight;
      }
    });
  }

  // Nothing above: all was sampled, for no reason.
  void tell_reasons(const Level& finest, int level, const Level* above, RenderResult& result) const {
    const int width = result.film.width(), side = 1 << -level;
    result.reasons.assign(3, std::vector<float>(result.film.pixels()));
    if (!above) return;
    parallel_for(result.film.height(), [&](int64_t row) {
      const int y = static_cast<int>(row);
      for (int x = 0; x < width; ++x) {
        std::array<int, 5> cells{};
        for (int v = y * side; v < (y + 1) * side; ++v)
          for (int u = x * side; u < (x + 1) * side; ++u)
            ++cells[static_cast<size_t>(above->reason_for(finest.lattice(), u, v))];
        const LevelReason red_green_blue[] = {LevelReason::kId, LevelReason::kColour, LevelReason::kPosition};
        for (size_t c = 0; c < 3; ++c)
          result.reasons[c][result.film.pixel(x, y)] =
              static_cast<float>(cells[static_cast<size_t>(red_green_blue[c])]) / static_cast<float>(side * side);
      }
    });
  }

  int under_, over_;
  uint32_t spp_;
  bool shared_, triangular_, last_is_square_;
  LevelThresholds thresholds_;
};

template <const StrategyInfo& kInfo>
StrategyEntry levels_entry() {
  return {kInfo, [](const StrategyValues& values, const std::string&) -> std::unique_ptr<Strategy> {
            return std::make_unique<Levels>(kInfo, values);
          }};
}

}  // namespace

const StrategyEntry& quad_strategy() {
  static const StrategyEntry entry = levels_entry<kQuad>();
  return entry;
}

const StrategyEntry& tri_strategy() {
  static const StrategyEntry entry = levels_entry<kTri>();
  return entry;
}

}  // namespace triad
