// SPDX-License-Identifier: Apache-2.0
// What quad and tri save on the bundled scenes, and what it costs in quality: samples, seconds, error against the
// filtered truth, and the share of pixels as in the full-resolution picture, which has one place of samples at the
// centre of each pixel of the finest level.
//   levels_bench [WIDTHxHEIGHT [TRUTH_SPP [RUNS]]] < tests/bench/levels_cases.txt
// with a case a line: SCENE EFFECTS SPP NOISE STRATEGY:key=value...; - for the effects that the scene calls for.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <ctime>
#include <iostream>
#include <map>
#include <raytracer/gltf_loader.hpp>
#include <raytracer/scene_source.hpp>
#include <sstream>
#include <triad/base/error.hpp>
#include <triad/sampling/render.hpp>

#include "measure.hpp"

using namespace triad;
using namespace triad::bench;

namespace {

// Linear light; 1/255 of full white, about what a picture editor's histogram of differences shows as not black.
constexpr double kSeen = 1. / 255;
constexpr int kSeeds = 3;

using Picture = std::vector<std::array<double, 3>>;

struct Run {
  Picture picture;
  uint64_t samples = 0;
  double seconds = 0, ray_seconds = 0;
};

Run render(const std::string& strategy, const Source& source, uint64_t seed) {
  RenderOptions options;
  options.seed = seed;
  const TimedSource timed(source);
  const double start_s = processor_s();
  const RenderResult result = make_strategy(strategy, "levels_bench")->render(timed, options);
  Run run{{}, result.samples, processor_s() - start_s - timed.clocks_s(), timed.inside_s()};
  for (size_t p = 0; p < result.film.pixels(); ++p) run.picture.push_back(result.mean(p));
  return run;
}

// Of values up to `most`: 1 for what a display shows of them.
double rmse(const Picture& a, const Picture& b, double most) {
  double sum = 0;
  for (size_t p = 0; p < a.size(); ++p)
    for (size_t c = 0; c < 3; ++c) {
      const double difference = std::min(a[p][c], most) - std::min(b[p][c], most);
      sum += difference * difference;
    }
  return std::sqrt(sum / (3 * static_cast<double>(a.size())));
}

double share_unchanged(const Picture& a, const Picture& b) {
  size_t same = 0;
  for (size_t p = 0; p < a.size(); ++p) {
    double most = 0;
    for (size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(a[p][c] - b[p][c]));
    same += most < kSeen;
  }
  return static_cast<double>(same) / static_cast<double>(a.size());
}

std::unique_ptr<raytracer::SceneSource> open_scene(const std::string& name, const std::string& effects,
                                                   const PictureSize& size, bool geometry) {
  raytracer::SourceOptions options;
  options.width = size.width;
  options.height = size.height;
  options.geometry = geometry;
  if (effects != "-") options.effects = raytracer::parse_effects(effects);
  const auto scene = std::make_shared<const raytracer::Scene>(
      raytracer::load_gltf(std::string(TRIAD_SOURCE_DIR "/data/scenes/") + name + ".gltf"));
  return raytracer::make_scene_source(scene, options);
}

void measure(const PictureSize& size, int truth_spp, int runs) {
  fmt::print("{:8} {:16} {:64} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}\n", "scene",
             "effects", "strategy", "samples", "of full", "rmse", "of full", "shown", "of full", "same", "dB",
             "seconds", "of full", "own");
  std::map<std::pair<std::string, std::string>, Picture> truths;
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string scene, effects, spp, noise, strategy;
    if (!(words >> scene >> effects >> spp >> noise >> strategy)) continue;
    const std::string common = ",spp=" + spp + ",noise=" + noise, tested = strategy + common;
    // Lights of the same kind as far as that can be: grid has one sample at each of its places, and own numbers.
    const size_t over = strategy.find("over=");
    const std::string full = over == std::string::npos
                                 ? "quad:under=0,position=inf" + common
                                 : "grid:n=" + std::to_string(1 << std::stoi(strategy.substr(over + 5)));
    const auto with = open_scene(scene, effects, size, true), without = open_scene(scene, effects, size, false);
    Picture& truth = truths[{scene, effects}];
    if (truth.empty()) truth = render("sobol-owen:spp=" + std::to_string(truth_spp), *without, 1000).picture;
    std::vector<double> seconds, full_seconds, same, to_full_db, own;
    std::vector<double> errors[2], full_errors[2];  // as they are, as shown
    uint64_t samples = 0, full_samples = 0;
    for (int i = 0; i < std::max(runs, kSeeds); ++i) {
      const Run a = render(full, *without, static_cast<uint64_t>(i % kSeeds)),
                b = render(tested, *with, static_cast<uint64_t>(i % kSeeds));
      seconds.push_back(b.seconds);
      own.push_back(1 - b.ray_seconds / b.seconds);
      full_seconds.push_back(a.seconds);
      if (i >= kSeeds) continue;
      samples += b.samples;
      full_samples += a.samples;
      for (int shown = 0; shown < 2; ++shown) {
        const double most = shown ? 1 : std::numeric_limits<double>::infinity();
        errors[shown].push_back(rmse(b.picture, truth, most));
        full_errors[shown].push_back(rmse(a.picture, truth, most));
      }
      same.push_back(share_unchanged(a.picture, b.picture));
      to_full_db.push_back(-20 * std::log10(rmse(a.picture, b.picture, 1)));
    }
    const double error = median(errors[0]), shown = median(errors[1]);
    fmt::print(
        "{:8} {:16} {:64} {:8} {:7.1f}% {:8.5f} {:7.1f}% {:8.5f} {:7.1f}% {:7.1f}% {:8.1f} {:8.4f} {:7.1f}% "
        "{:7.1f}%\n",
        scene, effects, tested, samples / kSeeds,
        100. * static_cast<double>(samples) / static_cast<double>(full_samples), error,
        100 * error / median(full_errors[0]), shown, 100 * shown / median(full_errors[1]), 100 * median(same),
        median(to_full_db), median(seconds), 100 * median(seconds) / median(full_seconds), 100 * median(own));
    std::cout.flush();
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    measure(parse_size(argc > 1 ? argv[1] : "400x225", "levels_bench"), argc > 2 ? std::stoi(argv[2]) : 1024,
            argc > 3 ? std::stoi(argv[3]) : kSeeds);
  } catch (const std::exception& error) {
    std::cerr << "levels_bench: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
