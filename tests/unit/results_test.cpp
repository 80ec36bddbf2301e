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
