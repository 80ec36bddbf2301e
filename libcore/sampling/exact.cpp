// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <chrono>
#include <mutex>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/exact.hpp>
#include <triad/sampling/strategy_base.hpp>

namespace triad {
namespace {

const StrategyInfo kInfo{
    "exact",
    "no samples: the filtered picture itself, of functions and pictures that know it",
    "What the other strategies try to find, to double precision, to judge them by. With filter=box it is the mean "
    "over "
    "each pixel, which every function but the strokes has, and every picture file. With filter=normal it is weighted "
    "by a normal distribution about the pixel's middle, cut nowhere, which straight edges, stripes, zone plates and "
    "the upright checkerboard have. Scenes have neither.",
    {choice_param("filter", "what each pixel is weighted by", {"box", "normal"}),
     {"sigma", "pixels, of filter=normal", 1e-3, 1e3, .5, true}}};

class Exact final : public StrategyBase {
 public:
  explicit Exact(const StrategyValues& values) : StrategyBase(kInfo, values) {}
  bool estimates_error() const override { return false; }
  uint64_t most_samples(int, int) const override { return 0; }

  RenderResult render(const Source& source, const RenderOptions& options) const override {
    if (options.until_rmse > 0) throw_usage("the strategy 'exact' has no error to stop at");
    FilmPlanes planes = options.planes;
    planes.error = planes.samples = false;
    if (planes != FilmPlanes{}) throw_usage("the strategy 'exact' takes no samples, and has no channels but colour");
    ExactOptions exact{.filter = {}, .stop = options.stop, .progress = options.progress};
    if (whole("filter") != 0) exact.filter = SeparableFilter{.gaussian_sigma_px = value("sigma")};
    const auto start = std::chrono::steady_clock::now();
    std::atomic<bool> stopped{false};
    exact.stop = [&] {
      if (options.stop && options.stop()) stopped = true;
      return stopped.load();
    };
    planes.samples = options.planes.samples;
    RenderResult result{.film = Film(source.width(), source.height(), planes), .passes = {}};
    result.colour = exact_picture(source, exact);
    result.complete = !stopped;
    result.passes.push_back({0, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()});
    return result;
  }
};

}  // namespace

std::vector<std::array<double, 3>> exact_picture(const Source& source, const ExactOptions& options) {
  const auto value = [&](int x, int y) {
    return options.filter ? source.filtered(x + .5, y + .5, *options.filter) : source.integral(x, y, x + 1, y + 1);
  };
  if (!value(0, 0))
    throw_usage(options.filter ? "this source has no closed form under that filter; take filter=box, or samples"
                               : "this source has no exact picture; take samples, as --strategy grid:n=16 does");
  const auto width = static_cast<size_t>(source.width());
  std::vector<std::array<double, 3>> picture(width * static_cast<size_t>(source.height()));
  std::mutex mutex;
  std::atomic<int64_t> done{0};
  parallel_for(source.height(), [&](int64_t y) {
    if (options.stop && options.stop()) return;
    for (size_t x = 0; x < width; ++x)
      picture[static_cast<size_t>(y) * width + x] = value(static_cast<int>(x), static_cast<int>(y)).value();
    ++done;
    if (!options.progress) return;
    const std::unique_lock lock(mutex, std::try_to_lock);
    if (lock) options.progress(static_cast<double>(done) / source.height());
  });
  return picture;
}

const StrategyEntry& exact_strategy() {
  static const StrategyEntry entry = strategy_entry<Exact>(kInfo);
  return entry;
}

}  // namespace triad
