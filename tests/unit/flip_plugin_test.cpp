// SPDX-License-Identifier: Apache-2.0
// The stage `flip`: what it chooses by itself, what it pools and what it refuses. Errors are judged in flip_test.cpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/evaluation/flip_exposures.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/stage_exercise.hpp>

#include "flip_reference.hpp"

using testing::Each;
using testing::HasSubstr;
using triad::SyntheticPicture;

namespace {

struct Result {
  triad::StageInstance::Plan plan;
  std::vector<float> map;
  double mean = 0;
  triad::StageReports reports;
};
Result run(const triad::ParamTexts& params, const std::vector<const SyntheticPicture*>& inputs,
           const triad::ExerciseOptions& options = {}) {
  static triad::PluginHost host({TRIAD_BINARY_DIR "/plugins"});
  triad::StageInstance instance(host.find("flip"), params);
  std::vector<const triad_image*> images;
  for (const SyntheticPicture* picture : inputs) images.push_back(picture ? &picture->image : nullptr);
  const triad::Exercise exercise{&instance, instance.plan(images, std::vector<const triad::Metadata*>(images.size())),
                                 inputs};
  triad::ExerciseOutcome outcome = triad::run_exercise(exercise, options);
  return {exercise.plan, outcome.pixels, outcome.scores[0], instance.reports()};
}
std::string error_of(const triad::ParamTexts& params, const std::vector<const SyntheticPicture*>& inputs) {
  try {
    run(params, inputs);
  } catch (const triad::Error& error) {
    return error.what();
  }
  return "";
}

SyntheticPicture picture(int width, int height, uint32_t seed, bool codes = false, float scale = 1) {
  SyntheticPicture made = triad::synthetic_picture(width, height, 3, {}, seed);
  made.image.display_codes = codes;
  for (float& v : made.pixels) v *= scale;
  return made;
}
SyntheticPicture decoded(SyntheticPicture p) {
  p.image.display_codes = 0;
  for (float& v : p.pixels) v = static_cast<float>(flip_reference::decoded(static_cast<double>(v)));
  return p;
}
SyntheticPicture filled(int width, int height, float value) {
  SyntheticPicture made = picture(width, height, 1);
  std::fill(made.pixels.begin(), made.pixels.end(), value);
  return made;
}
flip_reference::Picture light(const SyntheticPicture& p) {
  flip_reference::Picture made{p.image.width, p.image.height, {}};
  for (size_t i = 0; i < p.pixels.size(); i += 3)
    made.pixels.push_back({static_cast<double>(p.pixels[i]), static_cast<double>(p.pixels[i + 1]),
                           static_cast<double>(p.pixels[i + 2])});
  return made;
}
double mean_of(const std::vector<float>& values) {
  long double sum = 0;
  for (const float v : values) sum += static_cast<long double>(v);
  return static_cast<double>(sum / static_cast<long double>(values.size()));
}
void expect_near(const std::vector<float>& a, const std::vector<double>& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(static_cast<double>(a[i]), b[i], tolerance) << i;
}

}  // namespace

TEST(FlipPluginTest, ChoosesLdrForCodesAndHdrForLight) {
  const SyntheticPicture test = picture(19, 8, 1, true), reference = picture(19, 8, 2, true);
  const SyntheticPicture test_light = decoded(test), reference_light = decoded(reference);
  const Result ldr = run({}, {&test, &reference, nullptr});
  EXPECT_EQ(ldr.plan.plan.passes, 1);
  EXPECT_EQ(ldr.reports.values.at("hdr"), 0);
  const auto expected = flip_reference::ldr(light(reference_light), light(test_light), 67.020645);
  expect_near(ldr.map, expected, 1e-6);
  EXPECT_NEAR(ldr.mean, mean_of(ldr.map), 1e-14);
  EXPECT_EQ(ldr.plan.plan.pool.x1, 19);
  // Light in mode=ldr is shown as a display's codes of it would be.
  expect_near(run({{"mode", "ldr"}}, {&test_light, &reference_light, nullptr}).map, expected, 1e-6);

  const Result hdr = run({}, {&test_light, &reference_light, nullptr});
  EXPECT_EQ(hdr.plan.plan.passes, 3);
  EXPECT_EQ(hdr.reports.values.at("hdr"), 1);
  const Result of_codes = run({{"mode", "hdr"}}, {&test, &reference, nullptr});
  expect_near(of_codes.map, {hdr.map.begin(), hdr.map.end()}, 2e-6);
  EXPECT_NEAR(of_codes.reports.values.at("start-exposure"), hdr.reports.values.at("start-exposure"), 1e-5);
}

TEST(FlipPluginTest, TakesExposuresFromTheReferencesMedianAndLargestLuminance) {
  for (const auto& [width, height] : {std::pair{21, 13}, {20, 13}, {1, 1}}) {
    const SyntheticPicture part = picture(width, height, 1, false, 30);
    SyntheticPicture reference = picture(width, height, 2);
    for (float& v : reference.pixels) v = 10 * v * v * v * v;
    std::vector<float> luminances;
    for (size_t i = 0; i < reference.pixels.size(); i += 3)
      luminances.push_back(triad::flip_luminance(&reference.pixels[i]));
    std::sort(luminances.begin(), luminances.end());
    // .85 of ACES is a root of .16002 x^2 - .2829 x - .119.
    const double bright = (.2829 + std::sqrt(.2829 * .2829 + 4 * .16002 * .119)) / (2 * .16002);
    const double start = std::log2(bright / static_cast<double>(luminances.back()));
    const double stop = std::log2(bright / static_cast<double>(luminances[luminances.size() / 2]));
    for (const std::vector<int>& borders : {std::vector<int>{0}, {0, 1, 5}}) {
      const Result got = run({}, {&part, &reference, nullptr}, {.borders = borders});
      EXPECT_NEAR(got.reports.values.at("start-exposure"), start, 1e-5);
      EXPECT_NEAR(got.reports.values.at("stop-exposure"), stop, 1e-5);
      EXPECT_EQ(got.reports.values.at("count"), std::max(2., std::ceil(stop - start)));
    }
    const Result half = run({{"stop", "1.5"}, {"count", "3"}}, {&part, &reference, nullptr});
    EXPECT_EQ(half.plan.plan.passes, 2);
    EXPECT_NEAR(half.reports.values.at("start-exposure"), start, 1e-5);
    EXPECT_EQ(half.reports.values.at("stop-exposure"), 1.5);
    EXPECT_EQ(half.reports.values.at("count"), 3);
    const Result other = run({{"start", "-9"}}, {&part, &reference, nullptr});
    EXPECT_NEAR(other.reports.values.at("stop-exposure"), stop, 1e-5);
  }
}

TEST(FlipPluginTest, MapsErrorsOrTheExposureOfTheWorst) {
  const SyntheticPicture test = picture(30, 9, 1, false, 8), reference = picture(30, 9, 2, false, 8);
  const triad::ParamTexts params{
      {"start", "-5"}, {"stop", "1"}, {"count", "4"}, {"tonemapper", "hable"}, {"ppd", "20"}};
  const auto expected =
      flip_reference::hdr(light(reference), light(test), 20, flip_reference::ToneMapper::kHable, {-5, -3, -1, 1});
  const Result errors = run(params, {&test, &reference, nullptr});
  EXPECT_EQ(errors.plan.plan.passes, 1);
  expect_near(errors.map, expected.errors, 2e-6);
  triad::ParamTexts exposure = params;
  exposure.emplace("map", "exposure");
  const Result stops = run(exposure, {&test, &reference, nullptr});
  expect_near(stops.map, expected.stops, 0);
  EXPECT_EQ(stops.mean, errors.mean);
  EXPECT_EQ(stops.plan.plan.pool.x1, 0);
  EXPECT_EQ(run(params, {&test, &reference, nullptr}, {.want_map = false}).mean, errors.mean);
}

TEST(FlipPluginTest, GivesTheSameHoweverThePictureIsCut) {
  const SyntheticPicture test = picture(811, 37, 1, false, 8), reference = picture(811, 37, 2, false, 8);
  const Result whole = run({{"ppd", "30"}}, {&test, &reference, nullptr});
  EXPECT_NEAR(whole.mean, mean_of(whole.map), 1e-14);
  const Result cut = run({{"ppd", "30"}}, {&test, &reference, nullptr},
                         {.borders = {0, 3, 4, 20}, .descending = true, .threads = 3});
  EXPECT_EQ(cut.map, whole.map);
  EXPECT_NEAR(cut.mean, whole.mean, 1e-14);
}

TEST(FlipPluginTest, WeighsByTheMask) {
  const SyntheticPicture test = picture(100, 12, 1, false, 8), reference = picture(100, 12, 2, false, 8);
  SyntheticPicture mask = triad::synthetic_picture(100, 12, 1, {}, 3);
  for (float& w : mask.pixels) w = w < .4f ? 0 : w;
  const triad::ParamTexts fixed{{"start", "-3"}, {"stop", "0"}};
  const Result all = run(fixed, {&test, &reference, nullptr}), some = run(fixed, {&test, &reference, &mask});
  EXPECT_EQ(some.map, all.map);
  double error = 0, weight = 0;
  for (size_t i = 0; i < mask.pixels.size(); ++i) {
    error += static_cast<double>(mask.pixels[i]) * static_cast<double>(all.map[i]);
    weight += static_cast<double>(mask.pixels[i]);
  }
  EXPECT_NEAR(some.mean, error / weight, 1e-14);

  // Exposures follow from what is not left out.
  SyntheticPicture bright = reference;
  mask.pixels[7] = 0;
  bright.pixels[3 * 7] = 1e6f;
  EXPECT_NEAR(run({}, {&test, &bright, &mask}).reports.values.at("start-exposure"),
              run({}, {&test, &reference, &mask}).reports.values.at("start-exposure"), 1e-6);
  std::fill(mask.pixels.begin(), mask.pixels.end(), 0.f);
  EXPECT_THAT(error_of({}, {&test, &reference, &mask}), HasSubstr("every pixel is left out"));
  EXPECT_THAT(error_of(fixed, {&test, &reference, &mask}), HasSubstr("every pixel is left out"));
}

TEST(FlipPluginTest, SaysWhatToDoAboutABlackReference) {
  const SyntheticPicture black = filled(9, 5, 0), grey = filled(9, 5, .5f);
  SyntheticPicture mostly = black;
  mostly.pixels[0] = 1;
  EXPECT_THAT(error_of({}, {&grey, &black, nullptr}),
              testing::AllOf(HasSubstr("largest"), HasSubstr("start= and stop=")));
  EXPECT_THAT(error_of({}, {&grey, &mostly, nullptr}),
              testing::AllOf(HasSubstr("median"), HasSubstr("start= and stop=")));
  EXPECT_THAT(error_of({{"stop", "3"}}, {&grey, &black, nullptr}), HasSubstr("largest"));
  EXPECT_EQ(error_of({{"stop", "5"}}, {&grey, &mostly, nullptr}), "");
  EXPECT_GT(run({{"start", "0"}, {"stop", "3"}}, {&grey, &black, nullptr}).mean, .5);
}

TEST(FlipPluginTest, RefusesWhatItCannotDo) {
  const SyntheticPicture a = filled(4, 2, .5f), b = filled(5, 2, .5f), codes = picture(4, 2, 1, true);
  EXPECT_THAT(error_of({}, {&a, &b, nullptr}), testing::AllOf(HasSubstr("4x2"), HasSubstr("5x2")));
  EXPECT_THAT(error_of({{"start", "bright"}}, {&a, &a, nullptr}), HasSubstr("start=bright"));
  EXPECT_THAT(error_of({{"stop", "nan"}}, {&a, &a, nullptr}), HasSubstr("stop=nan"));
  EXPECT_THAT(error_of({{"start", "2"}, {"stop", "1"}}, {&a, &a, nullptr}), HasSubstr("above the last"));
  EXPECT_THAT(error_of({{"start", "50"}}, {&a, &a, nullptr}), HasSubstr("above the last"));
  EXPECT_THAT(error_of({{"map", "exposure"}}, {&codes, &codes, nullptr}), HasSubstr("mode=hdr"));
  EXPECT_THAT(error_of({{"ppd", "0"}}, {&a, &a, nullptr}), HasSubstr("ppd"));
}
