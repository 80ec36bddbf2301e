// SPDX-License-Identifier: Apache-2.0
// What is pooled from error maps, thresholds on it, and layers, from outside.
#include <cmath>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

class Pool : public Cli {
 protected:
  // The error of pixel i of 100 is i / 128, exactly.
  void SetUp() override {
    Cli::SetUp();
    save(path("ramp.exr"), from_function(10, 10, 3, [](int x, int y, int) { return 1 + (10 * y + x) / 128.; }));
    save(path("flat.exr"), constant(10, 10, {1, 1, 1}));
  }
};

TEST_F(Pool, JsonHoldsWhatIsPooled) {
  const nlohmann::json pooled = compare({"ramp.exr", "--ref", "flat.exr", "-m", "error"})[0]["pooled"];
  const nlohmann::json& scores = pooled["scores"];
  EXPECT_EQ(scores["min"], 0);
  EXPECT_EQ(scores["max"], 99 / 128.);
  EXPECT_EQ(scores["mean"], 49.5 / 128);
  // 100 values, each three times: the first 5 are 5 % of them.
  EXPECT_EQ(scores["p5"], 4 / 128.);
  EXPECT_EQ(scores["p50"], 49 / 128.);
  EXPECT_EQ(scores["p99"], 98 / 128.);
  // The sum is 4950; 0 + ... + 70 = 2485 is the first beyond half of it, 0 + ... + 22 = 253 beyond 5 %.
  EXPECT_EQ(scores["weighted-p50"], 70 / 128.);
  EXPECT_EQ(scores["weighted-p5"], 22 / 128.);
  EXPECT_EQ(pooled["max-at"], nlohmann::json({9, 9}));
  EXPECT_EQ(pooled["min-at"], nlohmann::json({0, 0}));
  EXPECT_EQ(pooled["histogram"]["counts"].size(), 100u);
  double sum = 0;
  for (const nlohmann::json& count : pooled["histogram"]["counts"]) sum += count.get<double>();
  EXPECT_EQ(sum, 300);
}

TEST_F(Pool, ThresholdsNamePooledScores) {
  for (const std::string verb : {"compare", "run"}) {
    const auto judge = [&](const std::string& threshold, int status) {
      return expect_status(status, {verb, "ramp.exr", "--ref", "flat.exr", "-m", "error", "--fail-above", threshold});
    };
    EXPECT_NE(judge("error.p50=0.4", 0).out.find("p50 0.382812"), std::string::npos);
    EXPECT_NE(judge("error.p50=0.38", 1).err.find("error.p50 is 0.3828125, above 0.38"), std::string::npos);
    expect_refusal({verb, "ramp.exr", "--ref", "flat.exr", "-m", "error", "--fail-above", "error.p90=1"},
                   {"'error' has no score 'p90'", "'rmse'", "'p95'", "'weighted-p99'"});
  }
}

TEST_F(Pool, LayersByName) {
  Picture picture = noise(8, 6, 7);
  picture.channel_names = {"R", "G", "B", "albedo.R", "albedo.G", "albedo.B", "Z"};
  save(path("a.exr"), picture);
  for (size_t i = 3; i < picture.values.size(); i += 7) picture.values[i] += .5f;
  save(path("b.exr"), picture);
  const auto mae = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments{"b.exr", "--ref", "a.exr", "-m", "error"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return compare(arguments)[0]["scores"]["mae"].get<double>();
  };
  EXPECT_EQ(mae({}), 0);
  EXPECT_NEAR(mae({"--layer", "albedo"}), .5 / 3, 1e-6);
  EXPECT_EQ(mae({"--layer", "Z"}), 0);
  EXPECT_GT(mae({"--layer", "albedo", "--ref-channels", "R,G,B"}), .1);
  expect_refusal({"compare", "b.exr", "--ref", "a.exr", "-m", "error", "--layer", "normal"},
                 {".exr", "no layer 'normal'", "'Z', 'albedo'"});
  expect_refusal({"compare", "b.exr", "--ref", "a.exr", "-m", "error", "--layer", "Z", "--channels", "R"},
                 {"--layer", "--channels"});
}

}  // namespace
}  // namespace cli
