// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <triad/base/error.hpp>
#include <triad/evaluation/results.hpp>

using namespace triad;

namespace {
MetricResult sample() {
  MetricResult result;
  result.test = "a,\"b\".exr";
  result.reference = "r.exr";
  result.metric = "error";
  result.label = "e";
  result.parameters = {{"peak", "1"}};
  result.scores = {{"rmse", "", .1, -1}, {"psnr", "dB", INFINITY, 1}, {"bias", "", -.25, 0}};
  result.reports.values["max-x"] = 3;
  result.nonfinite = {2, 1};
  result.seconds = .5;
  return result;
}
}  // namespace

TEST(Results, AsJson) {
  const auto json = nlohmann::json::parse(results_to_json({sample()}));
  const auto& r = json.at("results").at(0);
  EXPECT_EQ(r.at("test"), "a,\"b\".exr");
  EXPECT_EQ(r.at("scores").at("rmse"), .1);
  EXPECT_EQ(r.at("scores").at("psnr"), "inf");
  EXPECT_EQ(r.at("better").at("rmse"), "lower");
  EXPECT_EQ(r.at("better").at("psnr"), "higher");
  EXPECT_EQ(r.at("better").at("bias"), "zero");
  EXPECT_EQ(r.at("parameters").at("peak"), "1");
  EXPECT_EQ(r.at("reports").at("max-x"), 3);
  EXPECT_EQ(r.at("nan"), 2);
  EXPECT_EQ(r.at("inf"), 1);
  EXPECT_EQ(r.at("seconds"), .5);
  EXPECT_EQ(results_to_json({}), "{\n  \"results\": []\n}\n");
  MetricResult odd = sample();
  odd.test = "\xff.exr";
  EXPECT_NO_THROW(nlohmann::json::parse(results_to_json({odd})));
}

TEST(Results, AsCsv) {
  EXPECT_EQ(results_to_csv({sample()}),
            "test,reference,metric,label,score,value,better,nan,inf,seconds\r\n"
            "\"a,\"\"b\"\".exr\",r.exr,error,e,rmse,0.1,lower,2,1,0.5\r\n"
            "\"a,\"\"b\"\".exr\",r.exr,error,e,psnr,inf,higher,2,1,0.5\r\n"
            "\"a,\"\"b\"\".exr\",r.exr,error,e,bias,-0.25,zero,2,1,0.5\r\n");
}

TEST(Results, Thresholds) {
  const auto above = [](const char* text) { return parse_threshold(text, true); };
  EXPECT_THAT(failed_thresholds({above("e.rmse=.05")}, {sample()}),
              testing::ElementsAre("a,\"b\".exr: e.rmse is 0.1, above 0.05"));
  EXPECT_THAT(failed_thresholds({above("e.rmse=.1"), above("x.rmse=0"), above("e.psnr=inf")}, {sample()}),
              testing::IsEmpty());
  EXPECT_THAT(
      failed_thresholds({parse_threshold("e.bias=-.2", false), parse_threshold("e.psnr=50", false)}, {sample()}),
      testing::ElementsAre("a,\"b\".exr: e.bias is -0.25, below -0.2"));
  for (const char* bad : {"", "rmse", "rmse=1", "e.rmse", ".rmse=1", "e.=1", "e.rmse=x", "e.rmse=nan"})
    EXPECT_THROW(parse_threshold(bad, true), Error) << bad;
}

namespace {
MetricResult pooled_sample() {
  MetricResult result = sample();
  result.pooled.emplace();
  result.pooled->scores = {{"mean", "", .5, -1}, {"p95", "", .75, -1}, {"rmse", "", 9, -1}};
  result.pooled->min_at = {1, 2, 0};
  result.pooled->max_at = {3, 4, 2};
  result.pooled->histogram = {0, 2, {5, 7}};
  result.pooled->values = 12;
  result.pooled->weight = 11.5;
  return result;
}
}  // namespace

TEST(Results, PooledScoresBesideOwn) {
  const auto json = nlohmann::json::parse(results_to_json({pooled_sample()})).at("results").at(0);
  EXPECT_EQ(json.at("pooled").at("scores").at("p95"), .75);
  EXPECT_EQ(json.at("pooled").at("min-at"), nlohmann::json({1, 2}));
  EXPECT_EQ(json.at("pooled").at("max-at"), nlohmann::json({3, 4}));
  EXPECT_EQ(json.at("pooled").at("max-channel"), 2);
  EXPECT_EQ(json.at("pooled").at("values"), 12);
  EXPECT_EQ(json.at("pooled").at("weight"), 11.5);
  EXPECT_EQ(json.at("pooled").at("histogram").at("high"), 2);
  EXPECT_EQ(json.at("pooled").at("histogram").at("counts"), nlohmann::json({5, 7}));
  EXPECT_FALSE(nlohmann::json::parse(results_to_json({sample()})).at("results").at(0).contains("pooled"));

  const std::string csv = results_to_csv({pooled_sample()});
  EXPECT_THAT(csv, testing::HasSubstr(",e,p95,0.75,lower,2,1,0.5\r\n"));
  // Its own score of that name goes before.
  EXPECT_THAT(csv, testing::HasSubstr(",e,rmse,0.1,"));
  EXPECT_THAT(csv, testing::Not(testing::HasSubstr(",e,rmse,9,")));

  EXPECT_THAT(results_to_table({pooled_sample()}), testing::Not(testing::HasSubstr("p95")));
  EXPECT_THAT(results_to_table({pooled_sample()}, {{"", "p95"}}), testing::HasSubstr("p95 0.75"));
  EXPECT_THAT(results_to_table({pooled_sample()}, {{"e", "p95"}}), testing::HasSubstr("p95 0.75"));
  EXPECT_THAT(results_to_table({pooled_sample()}, {{"other", "p95"}}), testing::Not(testing::HasSubstr("p95")));
}

TEST(Results, ThresholdsOnPooledScores) {
  const auto above = [](const char* text) { return parse_threshold(text, true); };
  EXPECT_THAT(failed_thresholds({above("e.p95=.7"), above("e.p95=.75")}, {pooled_sample()}),
              testing::ElementsAre("a,\"b\".exr: e.p95 is 0.75, above 0.7"));
  EXPECT_THAT(failed_thresholds({above("e.rmse=1")}, {pooled_sample()}), testing::IsEmpty());
  EXPECT_THAT(
      failed_thresholds({above("e.weighted-p95=1")}, {pooled_sample()}),
      testing::ElementsAre(testing::HasSubstr("e.weighted-p95 has no value: the metric's map holds negative")));
  EXPECT_THAT(failed_thresholds({above("e.p95=1")}, {sample()}),
              testing::ElementsAre(testing::HasSubstr("e.p95 has no value")));

  PluginHost host({TRIAD_BINARY_DIR "/plugins"});
  const std::vector<ChainItem> metrics{parse_metric("error@e")};
  EXPECT_NO_THROW(check_threshold_names({above("e.p95=1"), above("e.rmse=1")}, metrics, host));
  try {
    check_threshold_names({above("e.p96=1")}, metrics, host);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("'psnr'"), testing::HasSubstr("'weighted-p99'")));
  }
  // What a threshold names is pooled and shown; what the metric has itself is not.
  const std::vector<Threshold> thresholds{above("e.max=1"), above("e.p95=1")};
  const auto named = named_pooled_scores("p50", thresholds, metrics, host);
  ASSERT_EQ(named.size(), 2u);
  EXPECT_EQ(named[0].label, "");
  EXPECT_EQ(named[0].score, "p50");
  EXPECT_EQ(named[1].label, "e");
  EXPECT_EQ(named[1].score, "p95");
  EXPECT_EQ(pooled_by_threshold("e", named, thresholds), "--fail-above 'e.p95=1'");
  EXPECT_EQ(pooled_by_threshold("f", named, thresholds), "");
  EXPECT_EQ(named_pooled_scores("all", {}, metrics, host).size(), pooled_score_names().size());
  EXPECT_TRUE(named_pooled_scores("", {}, metrics, host).empty());
  EXPECT_THROW(named_pooled_scores("p50,p51", {}, metrics, host), Error);
}
