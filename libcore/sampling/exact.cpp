// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <chrono>
#include <mutex>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/sampling/exact.hpp>
#include <triad/sampling/reconstruction.hpp>
#include <triad/sampling/strategy_base.hpp>

namespace triad {
namespace {

// "normal" after the reconstruction filters.
std::vector<std::string> filter_names() {
  std::vector<std::string> names = reconstruction_names();
  names.push_back("normal");
  return names;
}

const StrategyInfo kInfo{"exact",
                         "no samples: the filtered picture itself, of functions and pictures that know it",
                         "What the other strategies try to find, to double precision, to judge them by. Under the "
                         "filters box and box2 every "
                         "function but the strokes has it, and every picture file. Under all of them, flat, ramp, "
                         "and what stands upright: "
                         "half-plane, thin-line, stripes and checker at an angle of 0. Under normal, a normal "
                         "distribution of sigma 1/2 cut "
                         "nowhere, at other angles too, but for the checker; and the zone plate. Scenes have none.",
                         {choice_param("filter", "the reconstruction filter", filter_names()),
                          {"scale", "how many times as wide the filter is", .01, 100, 1, true}}};

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
    ExactOptions exact{.progress = options.progress};
    choose_filter(exact);
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

 private:
  void choose_filter(ExactOptions& exact) const {
    const double scale = value("scale");
    if (whole("filter") == reconstruction_names().size()) {
      exact.filter = SeparableFilter{.gaussian_sigma_px = .5 * scale};
      return;
    }
    const ReconstructionFilter filter(static_cast<ReconstructionKernel>(whole("filter")), scale);
    const bool is_box = filter.name() == "box" || filter.name() == "box2";
    if (is_box)
      exact.box_px = 2 * filter.radius_px();
    else
      exact.filter = SeparableFilter{.radius_px = filter.radius_px(),
                                     .cumulative = [filter](double t) { return filter.cumulative(t); }};
  }
};

}  // namespace

std::vector<std::array<double, 3>> exact_picture(const Source& source, const ExactOptions& options) {
  const auto value = [&](int x, int y) {
    const double left = x + .5 * (1 - options.box_px), top = y + .5 * (1 - options.box_px);
    return options.filter ? source.filtered(x + .5, y + .5, *options.filter)
                          : source.integral(left, top, left + options.box_px, top + options.box_px);
  };
  if (!value(0, 0))
    throw_usage(options.filter ? "this source has no closed form under that filter; take filter=box, or samples"
                               : "this source has no exact picture; take samples, as --strategy grid:n=16 does");
  const auto width = static_cast<size_t>(source.width());
  std::vector<std::array<double, 3>> picture(width * static_cast<size_t>(source.height()));
  std::mutex mutex;
  std::atomic<int64_t> done{0};
  parallel_for(source.height(), [&](int64_t y) {
    for (size_t x = 0; x < width; ++x) {
      if (options.stop && options.stop()) return;
      picture[static_cast<size_t>(y) * width + x] = value(static_cast<int>(x), static_cast<int>(y)).value();
    }
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
