// SPDX-License-Identifier: Apache-2.0
// What a run pools of its metrics' maps, the variance that a metric may ask for, and layers of files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/pipeline/plugin_error.hpp>
#include <triad/pipeline/run.hpp>

using namespace triad;
namespace fs = std::filesystem;

namespace {

Image make_image(int width, int height, std::vector<std::string> channels, uint32_t state) {
  Image image;
  image.spec.width = width;
  image.spec.height = height;
  image.spec.colour_channels = channels[0] == "R" ? 3 : channels[0] == "Y" ? 1 : 0;
  image.spec.channels = std::move(channels);
  image.pixels.resize(image.row_floats() * static_cast<size_t>(height));
  for (float& value : image.pixels) {
    state = state * 1664525u + 1013904223u;
    value = static_cast<float>(state >> 8) * 0x1p-24f;
  }
  return image;
}

class PipelinePool : public testing::Test {
 protected:
  PipelinePool() {
    folder_ = fs::temp_directory_path() / ("triad_pool_" + std::to_string(getpid()) + "_" +
                                           testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  ~PipelinePool() override {
    set_thread_limit(0);
    fs::remove_all(folder_);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string store(const std::string& name, const Image& image) const {
    WriteOptions options;
    options.depth = Depth::kFloat;
    write_image(path(name), image, options);
    return path(name);
  }
  MetricResult judge(const std::string& test, const std::string& reference, const std::string& metric,
                     const std::function<void(RunRequest&)>& change = {}) const {
    RunRequest request;
    request.input.path = test;
    request.metrics = {{parse_metric(metric), {reference, {}}, "", ""}};
    request.pool = true;
    if (change) change(request);
    PluginHost host({TRIAD_TEST_STAGES, TRIAD_BINARY_DIR "/plugins"});
    const ColourConfig colours = ColourConfig::load();
    return triad::Run(std::move(request), host, colours).execute().metrics[0];
  }
  std::string refusal(const std::function<void()>& work) const {
    try {
      work();
    } catch (const Error& error) {
      return error.what();
    }
    ADD_FAILURE() << "nothing was refused";
    return "";
  }

  fs::path folder_;
};

double pooled(const MetricResult& result, const std::string& name) {
  for (const auto& score : result.pooled->scores)
    if (score.name == name) return score.value;
  ADD_FAILURE() << "no " << name;
  return NAN;
}

// The smallest value that is not exceeded by a share of `percent` of the weights.
double percentile(std::vector<std::pair<float, double>> values, int percent) {
  std::sort(values.begin(), values.end());
  double total = 0, running = 0;
  for (const auto& value : values) total += value.second;
  for (const auto& [value, weight] : values) {
    running += weight;
    if (running * 100 >= percent * total * (1 - 1e-12)) return static_cast<double>(value);
  }
  return NAN;
}

}  // namespace

TEST_F(PipelinePool, PoolsTheMapWhateverTheCut) {
  const Image a = make_image(57, 201, {"R", "G", "B"}, 1), b = make_image(57, 201, {"R", "G", "B"}, 2);
  const Image mask = make_image(57, 201, {"Y"}, 3);
  const std::string test = store("a.exr", a), reference = store("b.exr", b), weights = store("m.exr", mask);
  const CropRequest crop{5, 50, 20, 100};
  for (const bool cropped : {false, true})
    for (const bool masked : {false, true}) {
      std::vector<std::pair<float, double>> values;
      double mean = 0, weight_sum = 0, largest = -1;
      int max_x = 0, max_y = 0, max_channel = 0;
      for (int y = 0; y < 201; ++y)
        for (int x = 0; x < 57; ++x) {
          if (cropped && (x < 5 || x >= 25 || y < 50 || y >= 150)) continue;
          const double weight = masked ? std::round(static_cast<double>(mask.row(y)[x]) * 65535) / 65535 : 1;
          for (int c = 0; c < 3 && weight > 0; ++c) {
            const float error = std::abs(a.row(y)[3 * x + c] - b.row(y)[3 * x + c]);
            values.emplace_back(error, weight);
            mean += weight * static_cast<double>(error);
            weight_sum += weight;
            if (static_cast<double>(error) > largest) {
              largest = static_cast<double>(error);
              max_x = x;
              max_y = y;
              max_channel = c;
            }
          }
        }
      std::vector<MetricResult::Pooled> all;
      for (const auto& [threads, rows] : std::vector<std::pair<int, int>>{{1, 0}, {2, 1}, {7, 100}, {2, 1000}}) {
        set_thread_limit(threads);
        const MetricResult result = judge(test, reference, "error", [&, strip_rows = rows](RunRequest& request) {
          request.strip_rows = strip_rows;
          if (cropped) request.crop = crop;
          if (masked) request.mask = weights;
        });
        ASSERT_TRUE(result.pooled);
        EXPECT_EQ(result.pooled->values, values.size());
        EXPECT_NEAR(result.pooled->weight, weight_sum, 1e-12 * weight_sum);
        EXPECT_NEAR(pooled(result, "mean"), mean / weight_sum, 1e-13);
        EXPECT_EQ(pooled(result, "max"), largest);
        EXPECT_EQ(result.pooled->max_at.x, max_x);
        EXPECT_EQ(result.pooled->max_at.y, max_y);
        EXPECT_EQ(result.pooled->max_at.channel, max_channel);
        for (const int percent : {5, 25, 50, 75, 95, 99})
          EXPECT_EQ(pooled(result, "p" + std::to_string(percent)), percentile(values, percent)) << percent;
        // Uniform values on both sides: the error has density 2 (1 - e), and half of all error is above 1/2 the cube
        // root or so: weighted percentiles lie above plain ones.
        EXPECT_GT(pooled(result, "weighted-p50"), pooled(result, "p50"));
        EXPECT_EQ(result.pooled->scores[0].better, -1);  // of mae; bias has no better side
        all.push_back(*result.pooled);
      }
      for (const auto& one : all) {
        for (size_t s = 0; s < one.scores.size(); ++s) EXPECT_EQ(one.scores[s].value, all[0].scores[s].value);
        EXPECT_EQ(one.histogram.counts, all[0].histogram.counts);
      }
    }
}

TEST_F(PipelinePool, LeavesOutWhatIsNotFinite) {
  Image a = make_image(20, 30, {"Y"}, 1);
  const Image b = make_image(20, 30, {"Y"}, 2);
  a.row(7)[3] = NAN;
  const std::string test = store("a.exr", a), reference = store("b.exr", b);
  EXPECT_FALSE(judge(test, reference, "error").pooled);
  const auto with = [&](NanPolicy policy) {
    return judge(test, reference, "error", [&](RunRequest& request) { request.metric_nan = policy; }).pooled->values;
  };
  // Grey is taken as three equal channels.
  EXPECT_EQ(with(NanPolicy::kIgnore), 3 * 599u);
  EXPECT_EQ(with(NanPolicy::kZero), 3 * 600u);
}

TEST_F(PipelinePool, PoolsOnlyWhereThePlanSays) {
  Image a = make_image(20, 30, {"R", "G", "B", "variance.R", "variance.G", "variance.B"}, 1);
  const std::string test = store("a.exr", a);
  a.spec.channels.resize(6);
  EXPECT_EQ(judge(test, test, "spread").pooled->values, 20u * 30 * 3);
  EXPECT_EQ(judge(test, test, "spread:border=3").pooled->values, 14u * 24 * 3);
  EXPECT_FALSE(judge(test, test, "spread:border=-1").pooled);
  EXPECT_FALSE(judge(test, test, "spread", [](RunRequest& request) { request.pool = false; }).pooled);
  // Of the score that is bounded, not of the first.
  EXPECT_EQ(judge(test, test, "spread").pooled->scores[0].better, 1);
  EXPECT_THAT(refusal([&] {
                judge(test, test, "spread:border=-1",
                      [](RunRequest& request) { request.metrics[0].pooled_by_name = "--fail-above 'spread.p95=1'"; });
              }),
              testing::AllOf(testing::HasSubstr("--fail-above 'spread.p95=1'"), testing::HasSubstr("no map")));
  // A not-a-number in the border is nobody's business, elsewhere it is the plugin's mistake.
  EXPECT_NO_THROW(judge(test, test, "spread:border=3,nan=2"));
  try {
    judge(test, test, "spread:border=3,nan=3");
    ADD_FAILURE();
  } catch (const PluginError& error) {
    EXPECT_EQ(error.rule(), "map.not-a-number");
    EXPECT_THAT(error.what(), testing::HasSubstr("x 3, y 3"));
  }
}

TEST_F(PipelinePool, VarianceComesFromTheTestPicturesFile) {
  Image a = make_image(21, 150, {"R", "G", "B", "variance.R", "variance.G", "variance.B"}, 1);
  double mean = 0;
  for (int y = 0; y < 150; ++y)
    for (int x = 0; x < 21; ++x)
      for (int c = 3; c < 6; ++c) mean += static_cast<double>(a.row(y)[6 * x + c]) / (21 * 150 * 3);
  const std::string test = store("a.exr", a), plain = store("b.exr", make_image(21, 150, {"R", "G", "B"}, 2));
  for (const int rows : {0, 1, 100}) {
    const MetricResult result = judge(test, plain, "spread", [&](RunRequest& request) {
      request.strip_rows = rows;
      request.metric_space = "sRGB";  // which is not for the variance
    });
    EXPECT_NEAR(result.scores[1].value, mean, 1e-12);
    EXPECT_NEAR(pooled(result, "mean"), mean, 1e-12);
  }
  EXPECT_THAT(refusal([&] { judge(plain, test, "spread"); }),
              testing::AllOf(testing::HasSubstr(plain), testing::HasSubstr("--aov variance")));
  EXPECT_THAT(refusal([&] {
                judge(test, plain, "spread", [](RunRequest& request) { request.stages = {parse_stage("flip")}; });
              }),
              testing::HasSubstr("'flip'"));
  a.row(20)[6 * 4 + 5] = NAN;
  const std::string bad = store("c.exr", a);
  EXPECT_EQ(judge(bad, plain, "spread").nonfinite.nan, 1u);
  EXPECT_EQ(judge(bad, plain, "spread", [](RunRequest& request) { request.metric_nan = NanPolicy::kIgnore; })
                .pooled->values,
            uint64_t{21 * 150 - 1} * 3);
  // Of a layer: what lies beside the layer's own channels.
  a = make_image(21, 150, {"R", "G", "B", "l.R", "l.G", "l.B", "l.variance.R", "l.variance.G", "l.variance.B"}, 4);
  const std::string layered = store("d.exr", a);
  const auto layer = [](RunRequest& request) {
    request.input.read.layer = request.metrics[0].reference.read.layer = "l";
  };
  EXPECT_NEAR(judge(layered, layered, "spread", layer).scores[1].value, .5, .05);
  EXPECT_THAT(refusal([&] { judge(layered, layered, "spread"); }), testing::HasSubstr("variance.R"));
}

TEST_F(PipelinePool, LayersAreJudgedAsTheyAre) {
  const Image a = make_image(9, 11, {"R", "G", "B", "albedo.R", "albedo.G", "albedo.B", "N.X", "N.Y", "N.Z", "Z"}, 1);
  Image b = a;
  for (int y = 0; y < 11; ++y)
    for (int x = 0; x < 9; ++x) {
      b.row(y)[10 * x + 4] += .5f;   // albedo.G
      b.row(y)[10 * x + 6] -= .25f;  // N.X
      b.row(y)[10 * x + 9] += 2;     // Z
    }
  const std::string test = store("a.exr", a), reference = store("b.exr", b);
  const auto mae = [&](const std::string& layer, const std::string& space = "") {
    return judge(test, reference, "error",
                 [&](RunRequest& request) {
                   request.input.read.layer = request.metrics[0].reference.read.layer = layer;
                   request.metric_space = space;
                 })
        .scores[1]
        .value;
  };
  EXPECT_EQ(mae(""), 0);
  EXPECT_NEAR(mae("albedo"), .5 / 3, 1e-7);
  EXPECT_NEAR(mae("ALBEDO"), .5 / 3, 1e-7);
  EXPECT_NEAR(mae("N"), .25 / 3, 1e-7);
  EXPECT_NEAR(mae("Z"), 2, 1e-6);
  // Colour is converted to where it is compared, data is not.
  EXPECT_GT(std::abs(mae("albedo", "sRGB") - .5 / 3), 1e-3);
  EXPECT_NEAR(mae("N", "sRGB"), .25 / 3, 1e-7);
  EXPECT_NEAR(mae("Z", "sRGB"), 2, 1e-6);
  EXPECT_THAT(refusal([&] { mae("normals"); }),
              testing::AllOf(testing::HasSubstr(test), testing::HasSubstr("'Z', 'N', 'albedo'")));
}
