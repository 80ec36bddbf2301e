// SPDX-License-Identifier: Apache-2.0
// The numbers of box, crop and error against slow references and closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/stage_exercise.hpp>

namespace {

using testing::HasSubstr;
using triad::SyntheticPicture;

const triad::StageInfo& stage(const std::string& id) {
  static triad::PluginHost host({TRIAD_BINARY_DIR "/plugins"});
  return host.find(id);
}

struct Result {
  triad::StageInstance::Plan plan;
  triad::ExerciseOutcome outcome;
  triad::StageReports reports;
};
Result run(const std::string& id, const triad::ParamTexts& params, const std::vector<const SyntheticPicture*>& inputs,
           const triad::ExerciseOptions& options = {}) {
  triad::StageInstance instance(stage(id), params);
  std::vector<const triad_image*> images;
  for (const SyntheticPicture* picture : inputs) images.push_back(picture ? &picture->image : nullptr);
  const triad::Exercise exercise{&instance, instance.plan(images, std::vector<const triad::Metadata*>(images.size())),
                                 inputs};
  triad::ExerciseOutcome outcome = triad::run_exercise(exercise, options);
  return {exercise.plan, outcome, instance.reports()};
}
std::string error_of(const std::string& id, const triad::ParamTexts& params,
                     const std::vector<const SyntheticPicture*>& inputs) {
  try {
    run(id, params, inputs);
  } catch (const triad::Error& error) {
    return error.what();
  }
  return "";
}

SyntheticPicture constant(int width, int height, float value) {
  SyntheticPicture picture = triad::synthetic_picture(width, height, 3, {}, 1);
  std::fill(picture.pixels.begin(), picture.pixels.end(), value);
  return picture;
}

enum Score { kBias, kMae, kMse, kRmse, kMax, kPsnr };

}  // namespace

TEST(Box, AveragesWholeAndPartialBlocks) {
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 5}, {12, 8}, {13, 2}})
    for (const int channels : {1, 3, 4, 7})
      for (const auto& [x, y] : {std::pair{1, 1}, {3, 1}, {2, 2}, {5, 4}, {100, 100}}) {
        const SyntheticPicture in = triad::synthetic_picture(width, height, channels, {}, 7);
        const Result got =
            run("box", {{"x", std::to_string(x)}, {"y", std::to_string(y)}}, {&in}, {.borders = {0, 1}});
        const int out_width = (width + x - 1) / x, out_height = (height + y - 1) / y;
        ASSERT_EQ(got.plan.out.width, out_width);
        ASSERT_EQ(got.plan.out.height, out_height);
        EXPECT_DOUBLE_EQ(got.plan.out.pixel_aspect, static_cast<double>(x) / y);
        for (int oy = 0; oy < out_height; ++oy)
          for (int ox = 0; ox < out_width; ++ox)
            for (int c = 0; c < channels; ++c) {
              double sum = 0;
              int count = 0;
              for (int iy = oy * y; iy < std::min(oy * y + y, height); ++iy)
                for (int ix = ox * x; ix < std::min(ox * x + x, width); ++ix, ++count)
                  sum += static_cast<double>(in.pixels[static_cast<size_t>((iy * width + ix) * channels + c)]);
              ASSERT_EQ(got.outcome.pixels[static_cast<size_t>((oy * out_width + ox) * channels + c)],
                        static_cast<float>(sum / count));
            }
      }
}

TEST(Box, UsesUpTheCellsOfAWideRender) {
  const SyntheticPicture wide = triad::synthetic_picture(12, 4, 3, {3, 1}, 1);
  const Result standard = run("box", {{"x", "3"}}, {&wide});
  EXPECT_EQ(standard.plan.out.cells_x, 1);
  EXPECT_DOUBLE_EQ(standard.plan.out.pixel_aspect, 1);
  EXPECT_EQ(run("box", {{"x", "6"}, {"y", "2"}}, {&wide}).plan.out.cells_x, 1);
  EXPECT_EQ(run("box", {{"y", "2"}}, {&wide}).plan.out.cells_x, 3);
  EXPECT_THAT(error_of("box", {{"x", "2"}}, {&wide}), HasSubstr("x=2 cuts through the 3 cells"));
}

TEST(Crop, CutsOutTheRectangle) {
  const SyntheticPicture in = triad::synthetic_picture(7, 5, 4, {}, 3);
  const Result got = run("crop", {{"x", "2"}, {"y", "1"}, {"w", "4"}, {"h", "3"}}, {&in}, {.borders = {0, 2}});
  ASSERT_EQ(got.plan.out.width, 4);
  ASSERT_EQ(got.plan.out.height, 3);
  EXPECT_EQ(got.plan.out.alpha, 3);
  for (int y = 0; y < 3; ++y)
    for (int i = 0; i < 4 * 4; ++i)
      EXPECT_EQ(got.outcome.pixels[static_cast<size_t>(y * 16 + i)],
                in.pixels[static_cast<size_t>(((y + 1) * 7 + 2) * 4 + i)]);
  EXPECT_EQ(run("crop", {{"x", "6"}, {"y", "4"}}, {&in}).outcome.pixels,
            std::vector<float>(in.pixels.end() - 4, in.pixels.end()));
}

TEST(Crop, RefusesWhatIsNotInside) {
  const SyntheticPicture in = triad::synthetic_picture(7, 5, 3, {}, 3);
  EXPECT_THAT(error_of("crop", {{"x", "7"}}, {&in}), HasSubstr("7x5"));
  EXPECT_THAT(error_of("crop", {{"x", "5"}, {"w", "3"}}, {&in}), HasSubstr("x=5,w=3"));
  EXPECT_THAT(error_of("crop", {{"y", "1"}, {"h", "2147483647"}}, {&in}), HasSubstr("7x5"));
  const SyntheticPicture wide = triad::synthetic_picture(12, 4, 3, {3, 1}, 1);
  EXPECT_THAT(error_of("crop", {{"x", "4"}}, {&wide}), HasSubstr("multiple of 3"));
  EXPECT_THAT(error_of("crop", {{"x", "3"}, {"w", "4"}}, {&wide}), HasSubstr("multiple of 3"));
  EXPECT_EQ(run("crop", {{"x", "3"}, {"w", "6"}}, {&wide}).plan.out.width, 6);
}

TEST(ErrorMetric, AgreesWithASlowReference) {
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 5}, {65, 3}, {200, 33}}) {
    SyntheticPicture test = triad::synthetic_picture(width, height, 3, {}, 1);
    const SyntheticPicture reference = triad::synthetic_picture(width, height, 3, {}, 2);
    const size_t worst = test.pixels.size() / 2;
    test.pixels[worst] = -3;
    long double bias = 0, absolute = 0, square = 0;
    std::vector<float> map;
    for (size_t i = 0; i < test.pixels.size(); ++i) {
      const long double d = static_cast<long double>(test.pixels[i]) - static_cast<long double>(reference.pixels[i]);
      bias += d;
      absolute += std::abs(d);
      square += d * d;
      map.push_back(std::abs(test.pixels[i] - reference.pixels[i]));
    }
    const auto n = static_cast<long double>(test.pixels.size());
    const Result got = run("error", {{"peak", "2"}}, {&test, &reference, nullptr}, {.borders = {0}});
    const auto& s = got.outcome.scores;
    const auto near = [](double value, long double expected) {
      EXPECT_LE(std::abs(value - static_cast<double>(expected)),
                4e-16 * std::abs(static_cast<double>(expected)) + 1e-16);
    };
    near(s[kBias], bias / n);
    near(s[kMae], absolute / n);
    near(s[kMse], square / n);
    near(s[kRmse], std::sqrt(square / n));
    EXPECT_NEAR(s[kPsnr], static_cast<double>(10 * std::log10(4 * n / square)), 1e-13);
    EXPECT_EQ(s[kMax], 3 + static_cast<double>(reference.pixels[worst]));
    EXPECT_EQ(got.reports.values.at("max-x"), static_cast<double>(worst / 3 % static_cast<size_t>(width)));
    EXPECT_EQ(got.reports.values.at("max-y"), static_cast<double>(worst / 3 / static_cast<size_t>(width)));
    EXPECT_EQ(got.reports.values.at("max-channel"), static_cast<double>(worst % 3));
    EXPECT_EQ(got.outcome.pixels, map);
  }
}

TEST(ErrorMetric, OfIdenticalPicturesIsZeroAndInfinitePsnr) {
  const SyntheticPicture picture = triad::synthetic_picture(9, 4, 3, {}, 1);
  const auto s = run("error", {}, {&picture, &picture, nullptr}).outcome.scores;
  EXPECT_THAT(std::vector<double>(s.begin(), s.begin() + 5), testing::Each(0.0));
  EXPECT_EQ(s[kPsnr], HUGE_VAL);
}

TEST(ErrorMetric, PoolsByTheWeightsOfTheMask) {
  const SyntheticPicture zero = constant(4, 2, 0);
  SyntheticPicture test = constant(4, 2, 1), mask = triad::synthetic_picture(4, 2, 1, {}, 1);
  std::fill(mask.pixels.begin(), mask.pixels.end(), 0.0f);
  // One pixel of value 1 with weight 1, one of value 3 with weight .5, and one left out that is not a number.
  mask.pixels[1] = 1;
  mask.pixels[6] = .5f;
  std::fill_n(test.pixels.begin() + 6 * 3, 3, 3.0f);
  test.pixels[0] = NAN;
  const auto s = run("error", {}, {&test, &zero, &mask}).outcome.scores;
  EXPECT_DOUBLE_EQ(s[kBias], (1 + .5 * 3) / 1.5);
  EXPECT_DOUBLE_EQ(s[kMse], (1 + .5 * 9) / 1.5);
  EXPECT_EQ(s[kMax], 3);
  std::fill(mask.pixels.begin(), mask.pixels.end(), 0.0f);
  EXPECT_THAT(error_of("error", {}, {&test, &zero, &mask}), HasSubstr("every pixel is left out"));
}

TEST(ErrorMetric, RefusesWhatCannotBeCompared) {
  const SyntheticPicture a = constant(4, 2, 0), b = constant(5, 2, 0);
  EXPECT_THAT(error_of("error", {}, {&a, &b, nullptr}), testing::AllOf(HasSubstr("4x2"), HasSubstr("5x2")));
  SyntheticPicture bad = a;
  bad.pixels[4] = NAN;
  bad.pixels[5] = HUGE_VALF;
  EXPECT_THAT(error_of("error", {}, {&bad, &a, nullptr}), HasSubstr("2 values"));
}

// The sums of 10^9 pixels, merged as a host would, from one strip's that is counted often.
TEST(ErrorMetric, KeepsTwelveDigitsOverAThousandMillionPixels) {
  const SyntheticPicture test = constant(100, 10, .1f), zero = constant(100, 10, 0);
  triad::StageInstance instance(stage("error"), {});
  const auto plan = instance.plan({&test.image, &zero.image, nullptr}, {nullptr, nullptr, nullptr});
  std::vector<double> strip_state(plan.plan.state_bytes / 8), total(strip_state.size());
  const triad_rect r{0, 0, 100, 10};
  const auto view = [&](const SyntheticPicture& p) {
    return triad_strip{sizeof(triad_strip), 3, r, const_cast<float*>(p.pixels.data()), 100 * 3 * sizeof(float)};
  };
  const triad_strip a = view(test), b = view(zero);
  instance.strip(0, r, {&a, &b, nullptr}, nullptr, strip_state.data());
  for (int i = 0; i < 1'000'000; ++i) instance.merge(0, total.data(), strip_state.data());
  const auto s = instance.end_pass(0, total.data());
  const double d = static_cast<double>(.1f);
  EXPECT_NEAR(s[kBias] / d, 1, 1e-14);
  EXPECT_NEAR(s[kMae] / d, 1, 1e-14);
  EXPECT_NEAR(s[kMse] / (d * d), 1, 1e-14);
}
