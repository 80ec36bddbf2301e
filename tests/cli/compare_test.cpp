// SPDX-License-Identifier: Apache-2.0
// `triad compare`: scores that can be worked out by hand, reports, thresholds, crops, masks and maps.
#include <cmath>
#include <complex>
#include <limits>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

class Compare : public Cli {
 protected:
  static void expect_score(const nlohmann::json& result, const std::string& name, double value,
                           double tolerance = 1e-12) {
    ASSERT_TRUE(result["scores"].contains(name)) << result;
    ASSERT_TRUE(result["scores"][name].is_number()) << result;
    EXPECT_NEAR(result["scores"][name].get<double>(), value, tolerance * std::max(1., std::abs(value))) << name;
  }
};

TEST_F(Compare, ScoresConstantsAsTheyAreByHand) {
  save(path("a.exr"), constant(7, 5, {.25f, .25f, .25f}));
  save(path("b.exr"), constant(7, 5, {.5f, .5f, .5f}));
  const nlohmann::json results = compare({"a.exr", "--ref", "b.exr", "-m", "error"});
  ASSERT_EQ(results.size(), 1u);
  const nlohmann::json& result = results[0];
  expect_score(result, "bias", -.25);  // what the test picture lost
  expect_score(result, "mae", .25);
  expect_score(result, "mse", .0625);
  expect_score(result, "rmse", .25);
  expect_score(result, "max", .25);
  expect_score(result, "psnr", 10 * std::log10(1 / .0625));
  expect_score(result, "share-above", 1);
  EXPECT_EQ(result["scores"].size(), 7u) << result;
}

TEST_F(Compare, ScoresWhatDiffersInPlaces) {
  // Every third value differs by 1/4, every other third by -1/8: means over all values.
  save(path("a.exr"), from_function(8, 6, 3, [](int, int, int c) { return c == 0 ? .75 : c == 1 ? .375 : .5; }));
  save(path("b.exr"), constant(8, 6, {.5f, .5f, .5f}));
  const nlohmann::json result = compare({"a.exr", "--ref", "b.exr", "-m", "error"})[0];
  expect_score(result, "bias", .125 / 3);
  expect_score(result, "mae", .375 / 3);
  expect_score(result, "mse", (.0625 + .015625) / 3);
  expect_score(result, "rmse", std::sqrt((.0625 + .015625) / 3));
  expect_score(result, "max", .25);
}

TEST_F(Compare, WritesTheReportAsAgreed) {
  save(path("a.exr"), constant(4, 4, {.5f, .5f, .5f}));
  save(path("b.exr"), constant(4, 4, {.25f, .5f, .5f}));
  save(path("ref.exr"), constant(4, 4, {.5f, .5f, .5f}));
  expect_success(
      {"compare", "a.exr", "b.exr", "--ref", "ref.exr", "-m", "error", "-m", "error@again", "--json", "out.json"});
  const nlohmann::json results = nlohmann::json::parse(load_text(path("out.json")))["results"];
  ASSERT_EQ(results.size(), 4u);
  std::set<std::string> seen;
  for (const nlohmann::json& result : results) {
    for (const std::string key : {"test", "reference", "metric", "label", "parameters", "scores", "better", "reports",
                                  "nan", "inf", "seconds"})
      EXPECT_TRUE(result.contains(key)) << key;
    EXPECT_EQ(result["reference"], "ref.exr");
    EXPECT_EQ(result["metric"], "error");
    EXPECT_TRUE(result["parameters"].is_object());
    EXPECT_TRUE(result["reports"].is_object());
    EXPECT_EQ(result["nan"], 0);
    EXPECT_EQ(result["inf"], 0);
    EXPECT_GE(result["seconds"].get<double>(), 0);
    EXPECT_EQ(result["better"]["bias"], "zero");
    EXPECT_EQ(result["better"]["rmse"], "lower");
    EXPECT_EQ(result["better"]["psnr"], "higher");
    seen.insert(result["test"].get<std::string>() + " " + result["label"].get<std::string>());
    if (result["test"] == "a.exr") {
      EXPECT_EQ(result["scores"]["psnr"], "inf");
      EXPECT_EQ(result["scores"]["rmse"], 0);
    }
  }
  EXPECT_EQ(seen, (std::set<std::string>{"a.exr error", "a.exr again", "b.exr error", "b.exr again"}));
}

TEST_F(Compare, WritesCsv) {
  save(path("a.exr"), constant(4, 4, {.25f, .25f, .25f}));
  save(path("ref.exr"), constant(4, 4, {.5f, .5f, .5f}));
  const std::string csv =
      expect_success({"compare", "a.exr", "--ref", "ref.exr", "-m", "error@plain", "--csv", "-"}).out;
  for (const std::string word :
       {"test", "reference", "metric", "label", "a.exr", "ref.exr", "plain", "bias", "-0.25", "0.0625"})
    EXPECT_NE(csv.find(word), std::string::npos) << word << " is not in:\n" << csv;
  // Every line has as many fields as the first.
  std::istringstream lines(csv);
  std::string line;
  std::set<long> commas;
  while (std::getline(lines, line)) commas.insert(std::count(line.begin(), line.end(), ','));
  EXPECT_EQ(commas.size(), 1u) << csv;
}

TEST_F(Compare, FailsAboveAndBelow) {
  save(path("a.exr"), constant(4, 4, {.25f, .25f, .25f}));
  save(path("ref.exr"), constant(4, 4, {.5f, .5f, .5f}));
  const auto status = [&](const std::vector<std::string>& limits) {
    std::vector<std::string> arguments{"compare", "a.exr", "--ref", "ref.exr", "-m", "error", "-m", "error@named"};
    arguments.insert(arguments.end(), limits.begin(), limits.end());
    return triad(arguments).status;
  };
  EXPECT_EQ(status({"--fail-above", "error.rmse=.25"}), 0);  // .25 is not above .25
  EXPECT_EQ(status({"--fail-above", "error.rmse=.2499"}), 1);
  EXPECT_EQ(status({"--fail-above", "named.mse=.06"}), 1);
  EXPECT_EQ(status({"--fail-below", "named.psnr=12"}), 0);
  EXPECT_EQ(status({"--fail-below", "named.psnr=12.1"}), 1);
  EXPECT_EQ(status({"--fail-above", "error.rmse=1", "--fail-below", "error.bias=0"}), 1);
  EXPECT_EQ(status({"--fail-above", "error.rmse=1", "--fail-below", "error.bias=-1"}), 0);
  const std::vector<std::string> start{"compare", "a.exr", "--ref", "ref.exr", "-m", "error", "--fail-above"};
  for (const auto& [limit, words] :
       std::map<std::string, std::vector<std::string>>{{"eror.rmse=1", {"--fail-above", "eror", "error"}},
                                                       {"error.rsme=1", {"--fail-above", "rsme", "rmse"}},
                                                       {"error.rmse", {"--fail-above", "error.rmse"}},
                                                       {"error.rmse=abc", {"--fail-above", "abc"}}}) {
    std::vector<std::string> arguments = start;
    arguments.push_back(limit);
    expect_refusal(arguments, words);
  }
}

TEST_F(Compare, PoolsInsideCropAndMask) {
  // The left half differs by 1/4, the right half by 1/2.
  save(path("a.exr"), from_function(8, 4, 3, [](int x, int, int) { return x < 4 ? .75 : 1.; }));
  save(path("ref.exr"), constant(8, 4, {.5f, .5f, .5f}));
  save(path("mask.png"), from_function(8, 4, 1, [](int x, int y, int) { return x >= 4 && y < 2 ? 1 : 0; }), "uint8");
  const std::vector<std::string> all{"a.exr", "--ref", "ref.exr", "-m", "error"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = all;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return compare(arguments)[0];
  };
  expect_score(with({}), "mae", .375);
  expect_score(with({"--crop", "0,0,4,4"}), "mae", .25);
  expect_score(with({"--crop", "3,1,2,3"}), "mae", .375);
  expect_score(with({"--mask", "mask.png"}), "mae", .5);
  expect_score(with({"--crop", "5,1,3,3"}), "mse", .25);
}

TEST_F(Compare, MapsTheWholePicture) {
  save(path("a.exr"), from_function(8, 4, 3, [](int x, int, int) { return x == 5 ? .75 : .5; }));
  save(path("ref.exr"), constant(8, 4, {.5f, .5f, .5f}));
  expect_success({"compare", "a.exr", "--ref", "ref.exr", "-m", "error", "--crop", "0,0,2,2", "--map", "map.exr"});
  const Picture map = load(path("map.exr"));
  ASSERT_EQ(map.width, 8);
  ASSERT_EQ(map.height, 4);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 8; ++x) EXPECT_NEAR(map.at(x, y, 0), x == 5 ? .25 : 0, 1e-3) << x << "," << y;
}

TEST_F(Compare, TreatsNotNumbersAsTold) {
  save(path("a.exr"), from_function(6, 2, 3, [](int x, int y, int) {
         return x > 1 || y > 0 ? .75 : x == 0 ? std::nan("") : HUGE_VAL;
       }));
  save(path("ref.exr"), constant(6, 2, {.5f, .5f, .5f}));
  const std::vector<std::string> start{"compare", "a.exr", "--ref", "ref.exr", "-m", "error", "--json", "-"};
  // Unless told, the comparison fails, and there are no scores to be taken for real ones.
  const Outcome failed = expect_status(1, start);
  EXPECT_EQ(failed.error_lines().size(), 1u) << failed.err;
  EXPECT_NE(failed.err.find("a.exr"), std::string::npos) << failed.err;
  const nlohmann::json counted = failed.json()["results"][0];
  EXPECT_TRUE(counted["scores"].empty()) << counted;
  EXPECT_EQ(counted["nan"], 3);
  EXPECT_EQ(counted["inf"], 3);
  const auto with = [&](const std::string& policy) {
    std::vector<std::string> arguments = start;
    arguments.insert(arguments.end(), {"--nan", policy});
    return expect_status(0, arguments).json()["results"][0];
  };
  const nlohmann::json ignored = with("ignore"), zeroed = with("zero");
  expect_score(ignored, "mae", .25);
  expect_score(zeroed, "mae", (10 * .25 + 2 * .5) / 12);
  for (const nlohmann::json& result : {ignored, zeroed}) {
    EXPECT_EQ(result["nan"], 3) << result;
    EXPECT_EQ(result["inf"], 3) << result;
  }
}

// A white panel is a carrier of one cycle a pixel, and nothing else: red, green and blue take turns. At 10 pixels a
// degree it can be seen, and its error has a closed form: 2 * sum over c of W_c(10 cpd) * |sum over d of C_cd w^d|^2
// with w a third of a turn, since the carrier is there at the frequencies N/3 and 2N/3.
TEST_F(Compare, SeesTheStripesOfAWhitePanelFromNearBy) {
  constexpr double kXyz[3][3] = {
      {.4123908, .3575843, .1804808}, {.2126390, .7151687, .0721923}, {.0193308, .1191948, .9505322}};
  constexpr double kOpponent[3][3] = {
      {.2787336, .7218031, -.1065520}, {-.4487736, .2898056, .0771569}, {.0859513, -.5899859, .5011089}};
  constexpr double kGain[3] = {1, 7.5, 2.5};
  constexpr double kWeight[3][2] = {{1.00327, .114416}, {.6167, .3833}, {.5681, .4319}};
  constexpr double kSigma_deg[3][2] = {{.0283, .133}, {.0392, .494}, {.0536, .386}};
  constexpr double kFrequency_cpd = 10;
  double energy = 0;
  for (int c = 0; c < 3; ++c) {
    std::complex<double> carrier = 0;
    for (int d = 0; d < 3; ++d) {
      double response = 0;
      for (int i = 0; i < 3; ++i) response += kGain[c] * kOpponent[c][i] * kXyz[i][d];
      carrier += response * std::polar(1., 2 * M_PI * d / 3);
    }
    double mtf = 0;
    for (int g = 0; g < 2; ++g)
      mtf += kWeight[c][g] * std::exp(-std::pow(M_PI * kSigma_deg[c][g] * kFrequency_cpd, 2));
    energy += 2 * mtf * mtf * std::norm(carrier);
  }
  save(path("shown.exr"), constant(40, 6, {1, 1, 1}));
  save(path("wide.exr"), constant(120, 6, {1, 1, 1}));
  for (const std::string edge : {"", ",edge=wrap,border=0"}) {
    const nlohmann::json result =
        compare({"shown.exr", "--ref", "wide.exr", "--ref-cells", "3x1", "-m", "display:ppd=10" + edge})[0];
    expect_score(result, "rmse", std::sqrt(energy), 2e-6);  // the matrix above has seven digits
  }
}

TEST_F(Compare, ReadsAnEncodedPictureAsTheLightItIs) {
  // 188/255 in sRGB is .5028865 of light; the reference says .5 in linear light.
  save(path("shown.png"), constant(4, 4, {188 / 255.f, 188 / 255.f, 188 / 255.f}), "uint8");
  save(path("ref.exr"), constant(4, 4, {.5f, .5f, .5f}));
  const nlohmann::json result = compare({"shown.png", "--ref", "ref.exr", "-m", "error"})[0];
  expect_score(result, "bias", srgb_decode(188 / 255.) - .5, 2e-5);
}

}  // namespace
}  // namespace cli
