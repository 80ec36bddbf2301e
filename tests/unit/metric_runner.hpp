// SPDX-License-Identifier: Apache-2.0
// Runs a bundled metric over synthetic pictures.
#pragma once

#include <map>
#include <string>
#include <triad/base/error.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/stage_exercise.hpp>
#include <vector>

namespace metric_runner {

using triad::SyntheticPicture;

inline const triad::StageInfo& metric(const std::string& id) {
  static triad::PluginHost host({TRIAD_BINARY_DIR "/plugins"});
  return host.find(id);
}

struct Result {
  std::vector<double> scores;
  std::vector<float> map;
  std::map<std::string, double> reports;
};
inline Result run(const std::string& id, const triad::ParamTexts& params, const SyntheticPicture& test,
                  const SyntheticPicture& reference, const SyntheticPicture* mask = nullptr,
                  const triad::ExerciseOptions& options = {}) {
  triad::StageInstance instance(metric(id), params);
  const triad::Exercise exercise{
      &instance,
      instance.plan({&test.image, &reference.image, mask ? &mask->image : nullptr}, {nullptr, nullptr, nullptr}),
      {&test, &reference, mask}};
  const triad::ExerciseOutcome outcome = triad::run_exercise(exercise, options);
  return {outcome.scores, outcome.pixels, instance.reports().values};
}

inline std::string error_of(const std::string& id, const triad::ParamTexts& params, const SyntheticPicture& test,
                            const SyntheticPicture& reference, const SyntheticPicture* mask = nullptr) {
  try {
    run(id, params, test, reference, mask);
  } catch (const triad::Error& error) {
    return error.what();
  }
  return "";
}

inline SyntheticPicture noise(int width, int height, uint32_t seed, float low = 0, float high = 1, int channels = 3) {
  SyntheticPicture picture = triad::synthetic_picture(width, height, channels, {}, seed);
  for (float& v : picture.pixels) v = low + (high - low) * v;
  return picture;
}

inline SyntheticPicture constant(int width, int height, const std::vector<float>& colour) {
  SyntheticPicture picture = triad::synthetic_picture(width, height, static_cast<int>(colour.size()), {}, 1);
  for (size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] = colour[i % colour.size()];
  return picture;
}

}  // namespace metric_runner
