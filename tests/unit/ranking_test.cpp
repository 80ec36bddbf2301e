// SPDX-License-Identifier: Apache-2.0
// Which picture is best, which frame is worst, and how that is written.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <triad/evaluation/ranking.hpp>

namespace triad {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

MetricResult result_of(const std::string& test, const std::string& label, std::vector<MetricResult::Score> scores) {
  MetricResult result;
  result.test = test;
  result.reference = "ref.exr";
  result.metric = result.label = label;
  result.scores = std::move(scores);
  return result;
}

// A picture with the scores low (lower is better), high (higher is better) and off (nearer to zero is better).
JudgedPicture picture(const std::string& name, double low, double high, double off) {
  return {name,
          "ref.exr",
          "",
          0,
          {result_of(name, "m", {{"off", "", off, 0}, {"low", "", low, -1}, {"high", "dB", high, 1}})},
          ""};
}

JudgedPicture frame(int number, double low) {
  JudgedPicture made = picture("f." + std::to_string(number) + ".exr", low, 0, 0);
  made.sequence = "f.#.exr";
  made.frame = number;
  return made;
}

JudgedPicture broken(const std::string& name) { return {name, "ref.exr", "", 0, {}, "it is no picture"}; }

ChainItem metric(const std::string& label) {
  ChainItem item;
  item.id = item.label = label;
  return item;
}

std::vector<std::string> names(const Ranking& ranking) {
  std::vector<std::string> list;
  for (const auto& entry : ranking.entries) list.push_back(entry.name);
  return list;
}

std::vector<int> ranks(const Ranking& ranking) {
  std::vector<int> list;
  for (const auto& entry : ranking.entries) list.push_back(entry.rank);
  return list;
}

Ranking rank(const std::vector<JudgedPicture>& pictures, const std::string& score) {
  return rank_pictures(pictures, {metric("m")}, {score}, std::nullopt)[0];
}

TEST(Ranking, PutsTheBestFirstWhicheverWayTheScoreRuns) {
  const std::vector<JudgedPicture> pictures{picture("a", 3, 30, -.1), picture("b", 1, 10, .2),
                                            picture("c", 2, 20, -.3)};
  EXPECT_THAT(names(rank(pictures, "low")), ElementsAre("b", "c", "a"));
  EXPECT_THAT(names(rank(pictures, "high")), ElementsAre("a", "c", "b"));
  EXPECT_THAT(names(rank(pictures, "off")), ElementsAre("a", "b", "c"));
  EXPECT_THAT(ranks(rank(pictures, "off")), ElementsAre(1, 2, 3));
}

TEST(Ranking, SharesRanksAndPutsWhatHasNoScoreLast) {
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<JudgedPicture> pictures{broken("none"), picture("a", 1, inf, 0), picture("b", 1, 5, 0),
                                            picture("c", 2, inf, 0), picture("d", inf, -inf, 0)};
  EXPECT_THAT(names(rank(pictures, "low")), ElementsAre("a", "b", "c", "d", "none"));
  EXPECT_THAT(ranks(rank(pictures, "low")), ElementsAre(1, 1, 3, 4, 0));
  EXPECT_THAT(names(rank(pictures, "high")), ElementsAre("a", "c", "b", "d", "none"));
  EXPECT_THAT(ranks(rank(pictures, "high")), ElementsAre(1, 1, 3, 4, 0));
}

TEST(Ranking, RanksSequencesByTheirMeanAndFramesWorstFirst) {
  std::vector<JudgedPicture> pictures{frame(1, 2), frame(2, 9), frame(3, 4), picture("still", 4, 0, 0)};
  const Ranking ranking = rank(pictures, "low");
  EXPECT_THAT(names(ranking), ElementsAre("still", "f.#.exr"));
  EXPECT_EQ(ranking.entries[1].value, 5);
  EXPECT_THAT(ranking.entries[1].pictures, ElementsAre(1, 2, 0));
  // A frame that could not be compared is the worst, and not part of the mean.
  pictures.push_back(broken("f.4.exr"));
  pictures.back().sequence = "f.#.exr";
  pictures.back().frame = 4;
  EXPECT_THAT(rank(pictures, "low").entries[1].pictures, ElementsAre(4, 1, 2, 0));
  EXPECT_EQ(rank(pictures, "low").entries[1].value, 5);
}

// The mean of infinities of both signs is not a number: no place among the others, wherever it comes in.
TEST(Ranking, WhatIsNotANumberComesLast) {
  constexpr double kInf = std::numeric_limits<double>::infinity(), kNan = std::numeric_limits<double>::quiet_NaN();
  std::vector<JudgedPicture> pictures{frame(1, kInf), frame(2, -kInf)};
  for (int i = 0; i < 40; ++i) pictures.push_back(picture(std::to_string(i), i % 4 == 3 ? kNan : 100 - i, 0, 0));
  const Ranking ranking = rank_pictures(pictures, {metric("m")}, {"low"}, std::nullopt)[0];
  ASSERT_EQ(ranking.entries.size(), 41u);
  for (size_t e = 0; e < 30; ++e) {
    EXPECT_EQ(ranking.entries[e].rank, static_cast<int>(e) + 1);
    if (e > 0) {
      EXPECT_GT(*ranking.entries[e].value, *ranking.entries[e - 1].value);
    }
  }
  for (size_t e = 30; e < 41; ++e) {
    EXPECT_EQ(ranking.entries[e].rank, 0) << ranking.entries[e].name;
    EXPECT_TRUE(std::isnan(*ranking.entries[e].value)) << ranking.entries[e].name;
  }
  // Of frames it is the worst, as one without a score.
  const Ranking frames = rank_pictures({frame(1, 3), frame(2, kNan), frame(3, 7), frame(4, kNan), frame(5, 1)},
                                       {metric("m")}, {"low"}, std::nullopt)[0];
  EXPECT_THAT(frames.entries[0].pictures, ElementsAre(1, 3, 2, 0, 4));
}

TEST(Ranking, OneScoreCanDecideForAllMetrics) {
  std::vector<JudgedPicture> pictures{picture("a", 1, 0, 0), picture("b", 2, 0, 0)};
  pictures[0].results.push_back(result_of("a", "n", {{"x", "", 8, -1}}));
  pictures[1].results.push_back(result_of("b", "n", {{"x", "", 7, -1}}));
  const std::vector<ChainItem> metrics{metric("m"), metric("n")};
  const auto own = rank_pictures(pictures, metrics, {"low", "x"}, std::nullopt);
  EXPECT_THAT(names(own[0]), ElementsAre("a", "b"));
  EXPECT_THAT(names(own[1]), ElementsAre("b", "a"));
  EXPECT_EQ(own[1].by_text(), "x");
  const auto told = rank_pictures(pictures, metrics, {"low", "x"}, RankKey{"m", "low"});
  EXPECT_THAT(names(told[1]), ElementsAre("a", "b"));
  EXPECT_EQ(told[0].by_text(), "low");
  EXPECT_EQ(told[1].by_text(), "m.low");
}

TEST(Ranking, FindsPooledScoresBehindTheMetricsOwn) {
  MetricResult result = result_of("a", "m", {{"mean", "", 1, -1}});
  EXPECT_EQ(find_score(result, "p95"), nullptr);
  result.pooled.emplace();
  result.pooled->scores = {{"mean", "", 2, -1}, {"p95", "", 3, -1}};
  EXPECT_EQ(find_score(result, "mean")->value, 1);
  EXPECT_EQ(find_score(result, "p95")->value, 3);
  result.nonfinite_failed = true;  // then nothing of it counts
  result.scores.clear();
  EXPECT_EQ(find_score(result, "p95"), nullptr);
}

TEST(Ranking, TableIsCutAtTheTopAndMarksFailures) {
  const std::vector<JudgedPicture> pictures{picture("a", 3, 0, 0), picture("b", 1, 0, 0), picture("c", 2, 0, 0)};
  const auto rankings = rank_pictures(pictures, {metric("m")}, {"low"}, std::nullopt);
  const auto lines = [&](const TableOptions& options) {
    std::istringstream text(ranking_to_table(pictures, rankings, options));
    std::vector<std::string> list;
    for (std::string line; std::getline(text, line);) list.push_back(line);
    return list;
  };
  const auto all = lines({0, {}, {parse_threshold("m.low=2.5", true)}});
  ASSERT_EQ(all.size(), 5u);
  EXPECT_EQ(all[0], "m: best first by low");
  EXPECT_EQ(all[1], "  rank  picture  off  low  high dB");
  EXPECT_EQ(all[2], "     1  b          0    1        0");
  EXPECT_EQ(all[4], "     3  a          0    3        0  FAILED");
  const auto two = lines({2, {}, {}});
  ASSERT_EQ(two.size(), 5u);
  EXPECT_THAT(two[4], HasSubstr("1 more"));
}

TEST(Ranking, CsvHasALinePerPictureAndAColumnPerScore) {
  std::vector<JudgedPicture> pictures{picture("a,1", .5, 30, 0), broken("none")};
  pictures[0].results[0].pooled.emplace();
  pictures[0].results[0].pooled->scores = {{"low", "", 9, -1}, {"p95", "", .75, -1}};
  EXPECT_EQ(pictures_to_csv(pictures),
            "test,reference,sequence,frame,nan,inf,error,m.off,m.low,m.high,m.p95\r\n"
            "\"a,1\",ref.exr,,,0,0,,0,0.5,30,0.75\r\n"
            "none,ref.exr,,,,,it is no picture,,,,\r\n");
}

TEST(Ranking, JsonKeepsResultsAndAddsTheOrder) {
  const std::vector<JudgedPicture> pictures{frame(1, 2), frame(2, 4), picture("still", 1, 0, 0), broken("none")};
  const auto rankings = rank_pictures(pictures, {metric("m")}, {"low"}, std::nullopt);
  const auto json = nlohmann::json::parse(
      ranking_to_json(pictures, rankings, {{"map", "still", "m", "still.png", {{"m", 0, .5}}, "magma"}}));
  EXPECT_EQ(json["results"].size(), 3u);
  const auto& order = json["ranking"][0]["order"];
  ASSERT_EQ(order.size(), 3u);
  EXPECT_EQ(order[0]["test"], "still");
  EXPECT_EQ(order[0]["rank"], 1);
  EXPECT_EQ(order[1]["sequence"], "f.#.exr");
  EXPECT_EQ(order[1]["value"], 3);
  EXPECT_EQ(order[1]["worst-frame"], 2);
  EXPECT_TRUE(order[2]["rank"].is_null());
  EXPECT_EQ(json["sequences"][0]["frames"][0]["frame"], 2);
  EXPECT_EQ(json["sequences"][0]["mean"]["low"], 3);
  EXPECT_EQ(json["failed"][0]["error"], "it is no picture");
  EXPECT_EQ(json["files"][0]["scales"]["m"]["high"], .5);
}

}  // namespace
}  // namespace triad
