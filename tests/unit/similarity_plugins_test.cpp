// SPDX-License-Identifier: Apache-2.0
// ssim, ms-ssim, pu-ssim and pu-psnr as a host sees them: their scores, maps, masks, and what they refuse.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/evaluation/pu21.hpp>
#include <triad/pipeline/plugin_host.hpp>
#include <triad/pipeline/stage_exercise.hpp>

#include "similarity_pictures.hpp"

namespace {

using similarity_pictures::Pair;
using testing::HasSubstr;
using triad::SyntheticPicture;

constexpr const char* kAll[] = {"ssim", "ms-ssim", "pu-ssim", "pu-psnr"};

SyntheticPicture picture(int width, int height, std::vector<float> pixels) {
  const int channels = static_cast<int>(pixels.size()) / (width * height);
  SyntheticPicture out = triad::synthetic_picture(width, height, channels, {}, 1);
  out.pixels = std::move(pixels);
  return out;
}
SyntheticPicture constant(int width, int height, float value) {
  return picture(width, height, std::vector<float>(static_cast<size_t>(width) * height * 3, value));
}

struct Result {
  triad_plan plan;
  std::vector<float> map;
  double score;
  triad::StageReports reports;
};
Result run(const std::string& id, const triad::ParamTexts& params, const std::vector<const SyntheticPicture*>& inputs,
           const triad::ExerciseOptions& options = {}) {
  static triad::PluginHost host({TRIAD_BINARY_DIR "/plugins"});
  triad::StageInstance instance(host.find(id), params);
  std::vector<const triad_image*> images;
  for (const SyntheticPicture* input : inputs) images.push_back(input ? &input->image : nullptr);
  const triad::Exercise exercise{&instance, instance.plan(images, std::vector<const triad::Metadata*>(images.size())),
                                 inputs};
  const triad::ExerciseOutcome outcome = triad::run_exercise(exercise, options);
  EXPECT_EQ(outcome.scores.size(), 1u);
  return {exercise.plan.plan, outcome.pixels, outcome.scores.at(0), instance.reports()};
}
Result run(const std::string& id, const triad::ParamTexts& params, const Pair& pair,
           const triad::ExerciseOptions& options = {}) {
  const SyntheticPicture test = picture(pair.width, pair.height, pair.test),
                         reference = picture(pair.width, pair.height, pair.reference);
  return run(id, params, {&test, &reference, nullptr}, options);
}
std::string error_of(const std::string& id, const std::vector<const SyntheticPicture*>& inputs) {
  try {
    run(id, {}, inputs);
  } catch (const triad::Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST(SimilarityPlugins, AgreeWithOtherPrograms) {
  for (const auto& row : similarity_pictures::kSsim) {
    const Pair pair = similarity_pictures::make(row.kind, row.width, row.height);
    EXPECT_NEAR(run("ssim", {}, pair).score, row.rgb, 1e-11) << row.kind;
    EXPECT_NEAR(run("ssim", {{"channels", "luma"}}, pair).score, row.luma, 1e-11) << row.kind;
  }
  for (const auto& row : similarity_pictures::kMsSsim) {
    const Pair pair = similarity_pictures::make(row.kind, row.width, row.height);
    EXPECT_NEAR(run("ms-ssim", {}, pair).score, row.rgb, 1e-11) << row.kind;
    EXPECT_NEAR(run("ms-ssim", {{"channels", "luma"}}, pair).score, row.luma, 1e-11) << row.kind;
  }
}

// Of a map over the pixels that are pooled.
TEST(SimilarityPlugins, TheMapsMeanIsTheScore) {
  const Pair pair = similarity_pictures::make("faint", 150, 77);
  for (const std::string id : {"ssim", "pu-ssim"}) {
    const Result got = run(id, {}, pair);
    const triad_rect pool = got.plan.pool;
    EXPECT_EQ(pool.x0, 5);
    EXPECT_EQ(pool.y0, 5);
    EXPECT_EQ(pool.x1, 145);
    EXPECT_EQ(pool.y1, 72);
    double sum = 0;
    for (int y = pool.y0; y < pool.y1; ++y)
      for (int x = pool.x0; x < pool.x1; ++x) sum += got.map[static_cast<size_t>(y) * 150 + x];
    EXPECT_NEAR(sum / (140 * 67), got.score, 1e-8) << id;
  }
}

TEST(SimilarityPlugins, SameBitsOnAnyThreadsWithAndWithoutAMap) {
  const Pair pair = similarity_pictures::make("blocks", 181, 300);
  for (const std::string id : kAll) {
    const Result one = run(id, {}, pair);
    const Result many = run(id, {}, pair, {.descending = true, .threads = 3});
    const Result bare = run(id, {}, pair, {.want_map = false});
    EXPECT_EQ(one.score, many.score) << id;
    EXPECT_EQ(one.map, many.map) << id;
    EXPECT_EQ(one.score, bare.score) << id;
    EXPECT_TRUE(bare.map.empty());
  }
}

TEST(SimilarityPlugins, AMaskWeightsTheMean) {
  const Pair pair = similarity_pictures::make("blocks", 40, 30);
  const SyntheticPicture test = picture(40, 30, pair.test), reference = picture(40, 30, pair.reference);
  std::vector<float> weights;
  for (int i = 0; i < 40 * 30; ++i) weights.push_back(i % 3 == 0 ? 0 : static_cast<float>(i % 5) / 5);
  const SyntheticPicture mask = picture(40, 30, weights);
  for (const std::string id : {"ssim", "pu-ssim"}) {
    const Result got = run(id, {}, {&test, &reference, &mask});
    double sum = 0, total = 0;
    for (int y = 5; y < 25; ++y)
      for (int x = 5; x < 35; ++x) {
        const double w = weights[static_cast<size_t>(y) * 40 + x];
        sum += w * static_cast<double>(got.map[static_cast<size_t>(y) * 40 + x]);
        total += w;
      }
    EXPECT_NEAR(got.score, sum / total, 1e-7) << id;
    EXPECT_NE(got.score, run(id, {}, pair).score) << id;
  }
  const Result psnr = run("pu-psnr", {}, {&test, &reference, &mask});
  double sum = 0, total = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) sum += weights[i] * std::pow(static_cast<double>(psnr.map[3 * i + c]), 2);
    total += 3 * static_cast<double>(weights[i]);
  }
  EXPECT_NEAR(psnr.score, 10 * std::log10(65536 / (sum / total)), 1e-5);
}

// What lies within the window of a pixel that counts is seen; what lies beyond, in a place left out, is not.
TEST(SimilarityPlugins, MaskedPlacesDoNotReachFurtherThanTheWindow) {
  const Pair pair = similarity_pictures::make("faint", 60, 20);
  Pair other = pair;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) other.test[(static_cast<size_t>(y) * 60 + x) * 3] = 1e30f;
  const SyntheticPicture test = picture(60, 20, pair.test), marred = picture(60, 20, other.test),
                         reference = picture(60, 20, pair.reference);
  std::vector<float> weights(60 * 20);
  for (size_t i = 0; i < weights.size(); ++i) weights[i] = i % 60 < 25 ? 0 : 1;
  const SyntheticPicture mask = picture(60, 20, weights);
  EXPECT_NEAR(run("ssim", {}, {&marred, &reference, &mask}).score, run("ssim", {}, {&test, &reference, &mask}).score,
              1e-12);
}

TEST(SimilarityPlugins, EqualPicturesScoreBest) {
  const SyntheticPicture same = triad::synthetic_picture(180, 177, 3, {}, 7);
  for (const std::string id : {"ssim", "ms-ssim", "pu-ssim"})
    for (const std::string channels : {"rgb", "luma"})
      EXPECT_EQ(run(id, {{"channels", channels}}, {&same, &same, nullptr}).score, 1.0) << id << channels;
  EXPECT_EQ(run("pu-psnr", {}, {&same, &same, nullptr}).score, INFINITY);
}

TEST(SimilarityPlugins, PuPsnrIsItsClosedForm) {
  const SyntheticPicture one = constant(7, 5, 1), tenth = constant(7, 5, .1f);
  // 256.383897 and 123.647484 at 100 and 10 nits; 420.096921 at 1000.
  const Result got = run("pu-psnr", {}, {&one, &tenth, nullptr});
  EXPECT_NEAR(got.score, 20 * std::log10(256 / (256.383897 - 123.647484)), 1e-7);
  for (const float v : got.map) EXPECT_NEAR(v, 256.383897 - 123.647484, 2e-5);
  EXPECT_EQ(got.map.size(), 7u * 5 * 3);
  EXPECT_EQ(got.reports.values.at("white"), 100);
  const triad::ParamTexts bright{{"white", "1000"}, {"channels", "luma"}};
  const Result luma = run("pu-psnr", bright, {&one, &tenth, nullptr});
  EXPECT_NEAR(luma.score, 20 * std::log10(256 / (420.096921 - 256.383897)), 1e-6);
  EXPECT_EQ(luma.map.size(), 7u * 5);
  // Luminance of red alone; its two other channels are black, at 0.
  SyntheticPicture red = constant(3, 3, 0);
  for (size_t i = 0; i < red.pixels.size(); i += 3) red.pixels[i] = 1;
  const SyntheticPicture black = constant(3, 3, 0);
  EXPECT_NEAR(run("pu-psnr", {}, {&red, &black, nullptr}).score, 20 * std::log10(256 / (256.383897 / std::sqrt(3))),
              1e-7);
  EXPECT_NEAR(run("pu-psnr", {{"channels", "luma"}}, {&red, &black, nullptr}).score,
              20 * std::log10(256 / triad::pu21(100 * red.image.rgb_to_xyz[3])), 1e-6);
}

TEST(SimilarityPlugins, PuTakesTheWhiteThatAPictureStates) {
  SyntheticPicture one = constant(12, 12, 1), tenth = constant(12, 12, .1f);
  one.image.white_nits = 100;
  tenth.image.white_nits = 1000;
  EXPECT_GT(run("pu-ssim", {}, {&one, &tenth, nullptr}).score, .999999);
  EXPECT_GT(run("pu-psnr", {}, {&one, &tenth, nullptr}).score, 100);
  EXPECT_LT(run("pu-psnr", {{"white", "100"}}, {&one, &tenth, nullptr}).score, 10);
}

TEST(SimilarityPlugins, PuSsimIsSsimOfItsValues) {
  // A constant of 10 nits against one of 100: only the luminance term, with L = 256.
  const SyntheticPicture a = constant(13, 11, .1f), b = constant(13, 11, 1);
  const double x = 123.647484, y = 256.383897, c1 = 2.56 * 2.56;
  for (const std::string channels : {"rgb", "luma"})
    EXPECT_NEAR(run("pu-ssim", {{"channels", channels}}, {&a, &b, nullptr}).score,
                (2 * x * y + c1) / (x * x + y * y + c1), 1e-7);
}

TEST(SimilarityPlugins, ReportEachScale) {
  const Result got = run("ms-ssim", {}, similarity_pictures::make("blocks", 203, 190));
  double product = 1;
  for (int k = 1; k <= 5; ++k) {
    const double mean = got.reports.values.at("scale-" + std::to_string(k));
    EXPECT_GT(mean, .9);
    EXPECT_LT(mean, 1);
    product *= std::pow(mean, std::array{.0448, .2856, .3001, .2363, .1333}[static_cast<size_t>(k - 1)]);
  }
  EXPECT_NEAR(product, got.score, 1e-3);  // of the means over channels, not the mean over channels
}

TEST(SimilarityPlugins, RefuseWhatTheyCannotJudge) {
  const SyntheticPicture small = constant(10, 30, 1), large = constant(200, 175, 1), other = constant(200, 176, 1);
  for (const std::string id : {"ssim", "pu-ssim"})
    EXPECT_THAT(error_of(id, {&small, &small, nullptr}), HasSubstr("10x30; at least 11x11 pixels are needed"));
  EXPECT_THAT(error_of("ms-ssim", {&large, &large, nullptr}),
              HasSubstr("200x175; at least 176x176 pixels are needed"));
  for (const std::string id : kAll)
    EXPECT_THAT(error_of(id, {&large, &other, nullptr}), HasSubstr("is 200x175, the reference 200x176"));
  SyntheticPicture mask = picture(200, 176, std::vector<float>(200 * 176, 0));
  for (const std::string id : kAll)
    EXPECT_THAT(error_of(id, {&other, &other, &mask}), HasSubstr("every pixel is left out"));
  // Weights only where no window lies inside.
  for (int x = 0; x < 200; ++x) mask.pixels[static_cast<size_t>(x)] = 1;
  EXPECT_THAT(error_of("ssim", {&other, &other, &mask}), HasSubstr("too near the edge"));
  SyntheticPicture bad = other;
  bad.pixels[3 * (50 * 200 + 50)] = NAN;
  for (const std::string id : kAll)
    EXPECT_THAT(error_of(id, {&bad, &other, nullptr}), HasSubstr("not a number")) << id;
}
