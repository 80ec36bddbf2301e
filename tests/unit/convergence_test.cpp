// SPDX-License-Identifier: Apache-2.0
// Fits of convergence against closed forms, and what names, headers, records and tables tell of a render's cost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <triad/base/error.hpp>
#include <triad/evaluation/convergence.hpp>
#include <triad/evaluation/render_cost.hpp>

using namespace triad;
using testing::HasSubstr;

namespace {

std::string message_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

std::vector<CostedError> falling(int count, double factor, double rate, double floor = 0) {
  std::vector<CostedError> points;
  for (int i = 0; i < count; ++i) {
    const double n = std::pow(4., i);
    points.push_back({n, floor + factor * std::pow(n, -rate)});
  }
  return points;
}

TEST(PowerLaw, GivesTheIntervalThatHandCalculationGives) {
  // Logarithms of cost -1, 0, 1; residuals d (1, -2, 1) change neither slope nor mean: sum of squares 6 d^2 with one
  // degree of freedom, standard error of the slope d sqrt(6) / sqrt(2), t(.975, 1) = 12.7062.
  const double d = .01, slope = -.9, middle = std::log(.02);
  std::vector<CostedError> points;
  for (const auto& [x, r] : {std::pair{-1., d}, {0., -2 * d}, {1., d}})
    points.push_back({std::exp(x), std::exp(middle + slope * x + r)});
  const PowerLaw law = fit_power_law(points);
  EXPECT_NEAR(law.slope.value, slope, 1e-12);
  EXPECT_NEAR(law.intercept, middle, 1e-12);
  EXPECT_NEAR(law.scatter, d * std::sqrt(6.), 1e-12);
  EXPECT_NEAR(law.slope.high - slope, 12.7062 * d * std::sqrt(3.), 1e-6);
  EXPECT_NEAR(slope - law.slope.low, 12.7062 * d * std::sqrt(3.), 1e-6);
  EXPECT_NEAR(law.cost_at(law.error_at(2.5)), 2.5, 1e-12);
}

TEST(ErrorFloor, FindsWhatWasPutInAndNothingElse) {
  for (const double rate : {.5, 1., 1.5}) {
    const ErrorFloor with = fit_floor(falling(6, .3, rate, 1e-4), rate),
                     free = fit_floor(falling(6, .3, rate, 1e-4), {});
    for (const ErrorFloor& fit : {with, free}) {
      EXPECT_TRUE(fit.found()) << rate;
      EXPECT_NEAR(fit.floor.value, 1e-4, 1e-8) << rate;
      EXPECT_NEAR(fit.floor.low, 1e-4, 1e-7) << rate;
      EXPECT_NEAR(fit.floor.high, 1e-4, 1e-7) << rate;
      EXPECT_NEAR(fit.variance, .3, 1e-5) << rate;
      EXPECT_NEAR(fit.rate, rate, 1e-5) << rate;
    }
    for (const ErrorFloor& fit : {fit_floor(falling(6, .3, rate), rate), fit_floor(falling(6, .3, rate), {})}) {
      EXPECT_FALSE(fit.found()) << rate;
      EXPECT_EQ(fit.floor.low, 0) << rate;
      EXPECT_LT(fit.floor.high, 1e-6) << rate;
      EXPECT_NEAR(fit.rate, rate, 1e-5) << rate;
    }
  }
}

TEST(ErrorFloor, IsTheLeastSumOfSquares) {
  // With scatter, no neighbour of the fit has a smaller sum, and at the interval's ends it is (1 + t^2 / 4) times as
  // large: t(.975, 4) = 2.7764.
  std::vector<CostedError> points = falling(6, .3, 1, 1e-3);
  const double factors[] = {1.04, .97, 1.02, .95, 1.03, .99};
  for (size_t i = 0; i < 6; ++i) points[i].error *= factors[i];
  const auto sum = [&](double floor, double variance) {
    double total = 0;
    for (const CostedError& p : points) {
      const double r = std::log(p.error / (floor + variance / p.cost));
      total += r * r;
    }
    return total;
  };
  const auto best_at = [&](double floor) {  // over a fine grid of variances
    double best = 1e300;
    for (double v = .2; v < .4; v += 1e-5) best = std::min(best, sum(floor, v));
    return best;
  };
  const ErrorFloor fit = fit_floor(points, 1);
  const double least = sum(fit.floor.value, fit.variance);
  for (const double f : {.999, 1.001}) {
    EXPECT_GT(sum(fit.floor.value * f, fit.variance), least);
    EXPECT_GT(sum(fit.floor.value, fit.variance * f), least);
  }
  EXPECT_NEAR(fit.scatter, std::sqrt(least / 4), 1e-9);
  for (const double end : {fit.floor.low, fit.floor.high})
    EXPECT_NEAR(best_at(end) / least, 1 + 2.7764 * 2.7764 / 4, 1e-3);
}

TEST(Outlier, IsTheOneWithTheWrongNumber) {
  std::vector<CostedError> points = falling(7, .5, 1);
  const double factors[] = {1.01, .98, 1.02, 1, .99, 1.01, .99};
  for (size_t i = 0; i < 7; ++i) points[i].error *= factors[i];
  EXPECT_FALSE(find_outlier(points));
  points[3].cost = 256;  // truly 64
  const auto odd = find_outlier(points);
  ASSERT_TRUE(odd);
  EXPECT_EQ(odd->point, 3u);
  EXPECT_NEAR(odd->expected_cost, 64, 3);
  points.resize(4);
  EXPECT_FALSE(find_outlier(points)) << "four points leave too little to judge by";
}

TEST(Outlier, SaysARoughCostHoweverLarge) {
  EXPECT_EQ(rough_cost(64.4), "64");
  EXPECT_EQ(rough_cost(123456), "123456");
  EXPECT_EQ(rough_cost(.0372), "0.037");
  EXPECT_EQ(rough_cost(3e25), "3e+25");
  EXPECT_EQ(rough_cost(std::numeric_limits<double>::infinity()), "inf");
  EXPECT_EQ(rough_cost(std::numeric_limits<double>::quiet_NaN()), "nan");
}

TEST(CostRatio, IsTheDistanceOfTheLines) {
  const PowerLaw a = fit_power_law(falling(5, 1, 1)), b = fit_power_law(falling(5, 3, 1)),
                 half = fit_power_law(falling(5, 1, .5));
  EXPECT_NEAR(cost_ratio(a, b, .02).value, 3, 1e-9);
  EXPECT_NEAR(cost_ratio(a, b, .02).low, 3, 1e-6);
  EXPECT_NEAR(cost_ratio(b, a, .02).value, 1 / 3., 1e-9);
  EXPECT_NEAR(cost_ratio(a, half, .02).value, 50, 1e-6);  // (1 / .02)^2 over 1 / .02
  EXPECT_TRUE(std::isnan(cost_ratio(a, fit_power_law({{1, 1}, {2, 2}, {4, 3}}), .02).value));
  const auto common = common_errors(falling(4, 1, 1), falling(4, .1, 1));
  ASSERT_TRUE(common);
  EXPECT_DOUBLE_EQ(common->first, 1 / 64.);
  EXPECT_DOUBLE_EQ(common->second, .1);
  EXPECT_FALSE(common_errors(falling(3, 1, 1), falling(3, 1e-3, 1)));
}

TEST(CostRatio, HasTheIntervalOfInverseRegression) {
  // Both with logarithms of cost -1, 0, 1 and residuals d (1, -2, 1): variance 6 d^2 / slope^2 (1/3 + x^2 / 2) each
  // at x from the middle, two degrees of freedom together, t(.975, 2) = 4.3027.
  const double d = .01;
  const auto series = [&](double factor) {
    std::vector<CostedError> points;
    for (const auto& [x, r] : {std::pair{-1., d}, {0., -2 * d}, {1., d}})
      points.push_back({std::exp(x), std::exp(-x + r) * factor});
    return fit_power_law(points);
  };
  const double x = .5, half = 4.3027 * std::sqrt(2 * 6 * d * d * (1 / 3. + x * x / 2));
  const PowerLaw law = series(1);
  const Interval ratio = cost_ratio(law, law, std::exp(-x));
  EXPECT_NEAR(ratio.value, 1, 1e-12);
  EXPECT_NEAR(std::log(ratio.high), half, 1e-5);
  EXPECT_NEAR(std::log(ratio.low), -half, 1e-5);
}

TEST(RenderCostOfName, ReadsUnitsAndTheLastNumber) {
  struct Case {
    std::string name;
    std::optional<double> samples, seconds;
  };
  const std::optional<double> none;
  for (const Case& c : {Case{"cornell_64spp.exr", 64, none},
                        {"out/2024/cornell-0064.exr", 64, none},
                        {"cornell64spp.exr", 64, none},
                        {"spp128_room.png", 128, none},
                        {"room-samples=16.exr", 16, none},
                        {"room_16-samples.exr", 16, none},
                        {"ROOM_16SPP.EXR", 16, none},
                        {"cornell_64_12.5s.exr", 64, 12.5},
                        {"cornell_12.5s.exr", none, 12.5},
                        {"cornell_64spp_250ms.exr", 64, .25},
                        {"cornell_64spp_3min.exr", 64, 180},
                        {"cornell_time-90_8spp.exr", 8, 90},
                        {"64spp_2.exr", 64, none},
                        {"room.0256.exr", 256, none},
                        {"scene2.exr", none, none},
                        {"room_800x600.exr", none, none},
                        {"room_64_final.exr", none, none},
                        {"room.exr", none, none}}) {
    const RenderCost cost = cost_from_name(c.name);
    EXPECT_EQ(cost.samples, c.samples) << c.name;
    EXPECT_EQ(cost.seconds, c.seconds) << c.name;
  }
  EXPECT_THAT(message_of([] { cost_from_name("a_64spp_32spp.exr"); }),
              HasSubstr("a_64spp_32spp.exr: its name tells two"));
  EXPECT_THAT(message_of([] { cost_from_name("a_0spp.exr"); }), HasSubstr("above 0"));
  EXPECT_THAT(message_of([] { cost_from_name("a.0000.exr"); }), HasSubstr("above 0"));
}

ImageSpec with_metadata(const std::vector<std::pair<std::string, std::string>>& entries) {
  ImageSpec spec;
  spec.width = 20;
  spec.height = 10;
  for (const auto& [key, value] : entries) spec.metadata.set(key, value);
  return spec;
}

TEST(RenderCostOfMetadata, KnowsWhatRenderersWrite) {
  const auto cost = [](const std::vector<std::pair<std::string, std::string>>& entries) {
    return cost_from_metadata("a.exr", with_metadata(entries));
  };
  EXPECT_EQ(cost({{"triad:samples", "12800"}}).samples, 64);
  EXPECT_EQ(cost({{"samplesPerPixel", "32"}, {"renderTimeSeconds", "1.5"}}).samples, 32);
  EXPECT_EQ(cost({{"samplesPerPixel", "32"}, {"renderTimeSeconds", "1.5"}}).seconds, 1.5);
  EXPECT_EQ(cost({{"cycles.ViewLayer.samples", "128"}, {"RenderTime", "01:02.50"}}).samples, 128);
  EXPECT_EQ(cost({{"cycles.ViewLayer.samples", "128"}, {"RenderTime", "01:02.50"}}).seconds, 62.5);
  EXPECT_EQ(cost({{"RenderTime", "2:01:02.50"}}).seconds, 7262.5);
  EXPECT_EQ(cost({{"cycles.ViewLayer.render_time", "00:04.25"}}).seconds, 4.25);
  EXPECT_EQ(cost({{"spp", "8"}, {"seconds", "3"}}).samples, 8);
  EXPECT_EQ(cost({{"spp", "8"}, {"triad:samples", "12800"}}).samples, 64);
  EXPECT_FALSE(cost({{"Artist", "x"}}).samples);
  for (const std::string bad : {"many", "0", "-3", "nan", "inf", ""})
    EXPECT_THAT(message_of([&] {
                  cost({{"triad:samples", bad}});
                }),
                testing::AllOf(HasSubstr("a.exr"), HasSubstr("triad:samples"), HasSubstr("'" + bad + "'")));
  EXPECT_THAT(message_of([&] { cost({{"RenderTime", "soon"}}); }), HasSubstr("no time above 0"));
  EXPECT_THAT(message_of([&] {
                cost({{"cycles.A.samples", "16"}, {"cycles.B.samples", "32"}});
              }),
              testing::AllOf(HasSubstr("16"), HasSubstr("32")));
}

TEST(RenderCostOfRecord, IsTriadsOwn) {
  const ImageSpec spec = with_metadata({});
  const RenderCost cost =
      cost_from_record(R"({"strategy":"x","samples":1600,"seconds":{"load":9,"render":2.5}})", spec);
  EXPECT_EQ(cost.samples, 8);
  EXPECT_EQ(cost.seconds, 2.5);
  for (const char* other : {"", "{", "[1]", R"({"samples":3})", R"({"strategy":"x","samples":"3"})"})
    EXPECT_FALSE(cost_from_record(other, spec).samples) << other;
}

TEST(RenderCost, ThatContradictsItselfNamesBothNumbers) {
  RenderCost name{64, {}, "its name", ""}, header{32, 2, "its metadata spp", "its metadata seconds"};
  EXPECT_THAT(message_of([&] { combined_cost("a.exr", name, header); }),
              testing::AllOf(HasSubstr("a.exr"), HasSubstr("its name says 64"), HasSubstr("spp 32")));
  header.samples = 63.7;  // an adaptive render's mean
  EXPECT_EQ(combined_cost("a.exr", name, header).samples, 64);
  EXPECT_EQ(combined_cost("a.exr", name, header).seconds, 2);
  EXPECT_EQ(combined_cost("a.exr", {}, header).samples, 63.7);
}

class Table : public testing::Test {
 protected:
  Table() { std::filesystem::create_directories(folder_); }
  ~Table() override { std::filesystem::remove_all(folder_); }
  CostTable table(const std::string& text) {
    std::ofstream(folder_ / "t.csv", std::ios::binary) << text;
    return CostTable((folder_ / "t.csv").string());
  }
  std::filesystem::path folder_ = std::filesystem::path(testing::TempDir()) / ("costs-" + std::to_string(getpid()));
};

TEST_F(Table, FindsARowByPathOrName) {
  const CostTable costs =
      table("seconds,file,samples\r\n1.5,a.exr,16\r\n,sub/b.exr,32\r\n2,\"c,\"\"d.exr\",\r\n3,other/b.exr,64\n");
  EXPECT_EQ(costs.find("anywhere/a.exr").samples, 16);
  EXPECT_EQ(costs.find("anywhere/a.exr").seconds, 1.5);
  EXPECT_EQ(costs.find((folder_ / "sub/b.exr").string()).samples, 32);
  EXPECT_FALSE(costs.find((folder_ / "sub/b.exr").string()).seconds);
  EXPECT_EQ(costs.find("c,\"d.exr").seconds, 2);
  EXPECT_THAT(message_of([&] { costs.find("b.exr"); }), HasSubstr("several rows"));
  EXPECT_THAT(message_of([&] { costs.find("e.exr"); }), testing::AllOf(HasSubstr("t.csv"), HasSubstr("'e.exr'")));
}

TEST_F(Table, ThatIsWrongNamesTheRow) {
  EXPECT_THAT(message_of([&] { table(""); }), HasSubstr("must name the columns"));
  EXPECT_THAT(message_of([&] { table("file,when\na,1\n"); }), HasSubstr("must name the columns"));
  EXPECT_THAT(message_of([&] { table("file,samples\na,1\nb,many\n"); }), HasSubstr("row 3: 'many'"));
  EXPECT_THAT(message_of([&] { table("file,samples\na,0\n"); }), HasSubstr("row 2: '0'"));
  EXPECT_THAT(message_of([&] { table("file,samples\na\n"); }), HasSubstr("row 2: 1 columns"));
  EXPECT_THAT(message_of([&] { table("file,samples\na,1\na,2\n"); }), HasSubstr("already"));
  EXPECT_THAT(message_of([&] { table("file,samples\n\"a,1\n"); }), HasSubstr("does not end"));
}

}  // namespace
