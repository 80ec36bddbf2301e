// SPDX-License-Identifier: Apache-2.0
// `triad convergence`: slopes, bias and equal errors of series whose pictures are made so that the answer is known.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

class Convergence : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    save(path("ref.exr"), constant(kSize, kSize, {.5f, .5f, .5f}));
  }

  // The mean of n samples of noise around the reference, `bias` off.
  Picture render(double n, double sigma, double bias, uint32_t seed) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    return from_function(kSize, kSize, 3,
                         [&](int, int, int) { return .5 + bias + sigma * normal(random) / std::sqrt(n); });
  }
  void make_series(const std::string& folder, double sigma, double bias, double seconds_per_sample = 0) const {
    std::filesystem::create_directories(folder_ / folder);
    for (int i = 0; i < 6; ++i) {
      const int n = 4 << (2 * i);
      Picture picture = render(n, sigma, bias, static_cast<uint32_t>(100 + i));
      if (seconds_per_sample > 0) picture.text["renderTimeSeconds"] = std::to_string(n * seconds_per_sample);
      save(path(folder + "/r_" + std::to_string(n) + "spp.exr"), picture);
    }
  }
  nlohmann::json findings(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "convergence");
    arguments.insert(arguments.end(), {"--ref", "ref.exr", "--json", "-"});
    return expect_success(arguments).json();
  }
  void expect_refused(std::vector<std::string> arguments, const std::vector<std::string>& words) const {
    arguments.insert(arguments.begin(), "convergence");
    arguments.insert(arguments.end(), {"--ref", "ref.exr"});
    expect_refusal(arguments, words);
  }

  static constexpr int kSize = 24;
};

TEST_F(Convergence, FindsSlopeAndEfficiencyOfPlainMonteCarlo) {
  make_series("a", .2, 0, .01);
  const nlohmann::json root = findings({"a"});
  EXPECT_EQ(root["metric"], "error");
  EXPECT_EQ(root["score"], "mse");
  ASSERT_EQ(root["series"].size(), 1u);
  const nlohmann::json& series = root["series"][0];
  ASSERT_EQ(series["pictures"].size(), 6u);
  for (const char* over : {"over_samples", "over_seconds"}) {
    EXPECT_NEAR(series[over]["slope"]["value"].get<double>(), -1, .05) << over;
    EXPECT_LT(series[over]["slope"]["low"], -1) << over;
    EXPECT_GT(series[over]["slope"]["high"], -1) << over;
  }
  EXPECT_EQ(series["floor"]["found"], false);
  EXPECT_EQ(series["floor"]["score"]["low"], 0);
  // mse = .04 / N, seconds = .01 N: efficiency 1 / .0004.
  EXPECT_NEAR(series["efficiency"]["value"].get<double>(), 2500, 100);
  for (const nlohmann::json& picture : series["pictures"]) {
    EXPECT_EQ(picture["samples_from"], "its name");
    EXPECT_EQ(picture["seconds_from"], "its metadata renderTimeSeconds");
    const double n = picture["samples"];
    EXPECT_NEAR(picture["score"].get<double>() * n, .04, .006);
    EXPECT_NEAR(picture["seconds"].get<double>(), .01 * n, 1e-5);
  }
  const nlohmann::json root_of = findings({"a", "--score", "rmse"});
  EXPECT_NEAR(root_of["series"][0]["over_samples"]["slope"]["value"].get<double>(), -.5, .025);
  EXPECT_EQ(root_of["series"][0]["over_samples"]["expected"], -.5);
}

TEST_F(Convergence, TellsBiasFromNoise) {
  make_series("a", .2, .02);
  const nlohmann::json floor = findings({"a"})["series"][0]["floor"];
  EXPECT_EQ(floor["found"], true);
  EXPECT_NEAR(floor["score"]["value"].get<double>(), .0004, .00002);
  const nlohmann::json root = findings({"a", "--score", "rmse"})["series"][0]["floor"];
  EXPECT_NEAR(root["score"]["value"].get<double>(), .02, .0005);
  const Outcome text = expect_success({"convergence", "a", "--ref", "ref.exr"});
  EXPECT_NE(text.out.find("bias: "), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("slope over samples"), std::string::npos) << text.out;
  EXPECT_EQ(
      expect_status(1, {"convergence", "a", "--ref", "ref.exr", "--fail-above", "floor-low=0"}).error_lines().size(),
      1u);
  expect_success({"convergence", "a", "--ref", "ref.exr", "--fail-above", "floor=1", "--fail-below", "slope=-2"});
}

TEST_F(Convergence, ComparesAtEqualError) {
  make_series("slow", .2, 0, .03);
  make_series("fast", .1, 0, .01);  // a quarter of the samples, a twelfth of the seconds
  for (const auto& arguments : {std::vector<std::string>{"fast", "slow"}, {"fast", "--against", "slow"}}) {
    const nlohmann::json root = findings(arguments);
    ASSERT_EQ(root["equal_error"].size(), 1u);
    const nlohmann::json& equal = root["equal_error"][0];
    EXPECT_EQ(equal["first"], "fast");
    EXPECT_EQ(equal["other"], "slow");
    ASSERT_EQ(equal["at"].size(), 3u);
    for (const nlohmann::json& at : equal["at"]) {
      EXPECT_NEAR(at["samples"]["value"].get<double>(), 4, .4);
      EXPECT_NEAR(at["seconds"]["value"].get<double>(), 12, 1.2);
      EXPECT_LT(at["seconds"]["low"], at["seconds"]["value"]);
      EXPECT_GT(at["seconds"]["high"], at["seconds"]["value"]);
    }
  }
  expect_status(1,
                {"convergence", "slow", "--against", "fast", "--ref", "ref.exr", "--fail-below", "seconds-ratio=1"});
  expect_success({"convergence", "fast", "--against", "slow", "--ref", "ref.exr", "--fail-below", "seconds-ratio=1"});
}

TEST_F(Convergence, TakesSamplesFromATable) {
  for (const auto& [name, n] : {std::pair{"x", 4}, {"y", 16}, {"z", 64}})
    save(path(std::string(name) + ".exr"), render(n, .2, 0, static_cast<uint32_t>(n)));
  save_text(path("costs.csv"), "file,samples,seconds\r\nz.exr,64,6.5\r\nx.exr,4,.5\r\ny.exr,16,2\r\n");
  const nlohmann::json pictures =
      findings({"x.exr", "y.exr", "z.exr", "--samples-from", "costs.csv"})["series"][0]["pictures"];
  EXPECT_EQ(pictures[0]["samples"], 4);
  EXPECT_EQ(pictures[2]["seconds"], 6.5);
  expect_refused({"x.exr", "y.exr", "z.exr"}, {"x.exr", "no samples", "--samples-from"});
  expect_refused({"x.exr", "y.exr", "ref.exr", "--samples-from", "costs.csv"}, {"ref.exr", "reference"});
  save_text(path("costs.csv"), "file,samples\r\nx.exr,4\r\ny.exr,16\r\n");
  expect_refused({"x.exr", "y.exr", "z.exr", "--samples-from", "costs.csv"}, {"costs.csv", "'z.exr'"});
  expect_refused({"x.exr", "y.exr", "z.exr", "--samples-from", "nmae"}, {"'nmae'", "metadata"});
}

TEST_F(Convergence, WritesALinePerPicture) {
  make_series("a", .2, 0, .01);
  const Outcome outcome = expect_success({"convergence", "a", "--ref", "ref.exr", "--csv", "-"});
  EXPECT_EQ(outcome.out.find("series,file,samples,seconds,mse,squared_error,efficiency\r\na,a/r_4spp.exr,4,0.04,"),
            0u)
      << outcome.out;
  EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 7);
}

TEST_F(Convergence, WarnsOfANumberThatTheErrorContradicts) {
  make_series("a", .2, 0);
  std::filesystem::remove(folder_ / "a/r_64spp.exr");
  save(path("a/r_64spp.exr"), render(4, .2, 0, 7));
  const Outcome outcome = expect_status(0, {"convergence", "a", "--ref", "ref.exr"});
  ASSERT_EQ(outcome.error_lines().size(), 1u) << outcome.err;
  EXPECT_NE(outcome.err.find("r_64spp.exr"), std::string::npos);
  EXPECT_NE(outcome.err.find("says 64 samples"), std::string::npos) << outcome.err;
}

TEST_F(Convergence, WarnsOfAnErrorThatRises) {
  for (const int n : {4, 16, 64}) save(path("r_" + std::to_string(n) + ".exr"), render(256. / n, .2, 0, 5));
  const Outcome outcome = expect_status(0, {"convergence", "r_4.exr", "r_16.exr", "r_64.exr", "--ref", "ref.exr"});
  EXPECT_NE(outcome.err.find("rises with samples"), std::string::npos) << outcome.err;
}

TEST_F(Convergence, RefusesWhatIsNoSeries) {
  make_series("a", .2, 0);
  std::filesystem::create_directories(folder_ / "empty");
  expect_refused({"empty"}, {"empty", "no picture"});
  expect_refused({"a/r_4spp.exr", "a/r_16spp.exr"}, {"2 pictures", "3 or more"});
  expect_refused({"a/r_4spp.exr", "a/r_16spp.exr", "a/../a/r_4spp.exr"}, {"twice", "a/r_4spp.exr"});
  expect_refused({"a/r_4spp.exr", "a/r_16spp.exr", "gone_64spp.exr"}, {"gone_64spp.exr"});

  save(path("a/r_8spp.exr"), constant(kSize, kSize - 1, {0, 0, 0}));
  expect_refused({"a"}, {"a/r_8spp.exr", "24x23", "24x24"});
  save(path("a/r_8spp.exr"), constant(kSize, kSize, {.5f, .5f, .5f}));
  expect_refused({"a"}, {"a/r_8spp.exr", "mse is 0", "ref.exr"});
  std::filesystem::remove(folder_ / "a/r_8spp.exr");
  std::filesystem::copy_file(folder_ / "a/r_16spp.exr", folder_ / "a/r_8spp.exr");
  expect_refused({"a"}, {"a/r_8spp.exr", "a/r_16spp.exr", "exactly the error"});
  std::filesystem::remove(folder_ / "a/r_8spp.exr");
  std::filesystem::copy_file(folder_ / "ref.exr", folder_ / "a/ref_9999.exr");
  expect_refusal({"convergence", "a", "--ref", "a/ref_9999.exr"}, {"a/ref_9999.exr", "reference"});
}

TEST_F(Convergence, RefusesSamplesThatContradictEachOther) {
  for (const int n : {4, 16, 64}) {
    Picture picture = render(n, .2, 0, static_cast<uint32_t>(n));
    picture.text["triad:samples"] = std::to_string((n == 16 ? 32 : n) * kSize * kSize);
    save(path("r_" + std::to_string(n) + "spp.exr"), picture);
    save(path("s_" + std::to_string(n) + ".exr"), render(n, .2, 0, static_cast<uint32_t>(n)));
  }
  expect_refused({"r_4spp.exr", "r_16spp.exr", "r_64spp.exr"},
                 {"r_16spp.exr", "its name says 16", "triad:samples 32"});
  EXPECT_EQ(findings({"r_4spp.exr", "r_16spp.exr", "r_64spp.exr", "--samples-from",
                      "name"})["series"][0]["pictures"][1]["samples"],
            16);
  EXPECT_EQ(findings({"r_4spp.exr", "r_16spp.exr", "r_64spp.exr", "--samples-from",
                      "metadata"})["series"][0]["pictures"][1]["samples"],
            32);
  save(path("s_0.exr"), render(4, .2, 0, 9));
  expect_refused({"s_4.exr", "s_16.exr", "s_0.exr"}, {"s_0.exr", "above 0"});
  save(path("t_4.exr"), render(4, .2, 0, 9));
  save(path("u_4.exr"), render(4, .2, 0, 10));
  expect_refused({"s_4.exr", "t_4.exr", "u_4.exr"}, {"4 samples per pixel", "different"});
}

TEST_F(Convergence, RefusesWrongWords) {
  make_series("a", .2, 0);
  expect_refused({"a", "--score", "mes"}, {"'mes'", "did you mean 'mse'"});
  expect_refused({"a", "--score", "psnr"}, {"no error"});
  expect_refused({"a", "--rate", "0"}, {"--rate '0'"});
  expect_refused({"a", "--score-is", "cubed"}, {"'cubed'", "'squared'"});
  expect_refused({"a", "--fail-above", "slop=1"}, {"'slop'", "did you mean 'slope'"});
  expect_refused({"a", "--fail-above", "slope"}, {"NAME=VALUE"});
  expect_refused({"a", "--json", "a/r_4spp.exr"}, {"--json", "another file"});
  expect_refused({"a", "-m", "erorr"}, {"erorr"});
  expect_refused({"a", "--fail-above", "seconds-ratio=1"}, {"second series"});
  Picture broken = render(4, .2, 0, 1);
  broken.values[5] = NAN;
  save(path("a/r_4spp.exr"), broken);
  expect_refused({"a"}, {"a/r_4spp.exr", "1 NaN", "--nan ignore"});
  EXPECT_EQ(findings({"a", "--nan", "ignore"})["series"][0]["pictures"].size(), 6u);
}

TEST_F(Convergence, ReadsItsOwnRendersAndTheirRecords) {
  expect_success({"render", "cornell", "-o", "truth.exr", "--size", "24x14", "--spp", "512", "--seed", "9"});
  std::filesystem::create_directories(folder_ / "own");
  for (const std::string spp : {"2", "8", "32"})
    expect_success({"render", "cornell", "-o", "own/" + spp + "x.exr", "--size", "24x14", "--strategy",
                    "random:spp=" + spp, "--json", "own/" + spp + "x.json"});
  const nlohmann::json root = expect_success({"convergence", "own", "--ref", "truth.exr", "--json", "-"}).json();
  const nlohmann::json& series = root["series"][0];
  for (const nlohmann::json& picture : series["pictures"]) {
    EXPECT_EQ(picture["samples_from"], "its metadata triad:samples");
    EXPECT_EQ(picture["seconds_from"], "the record of its render");
    EXPECT_EQ(picture["file"], "own/" + std::to_string(picture["samples"].get<int>()) + "x.exr");
  }
  EXPECT_NEAR(series["over_samples"]["slope"]["value"].get<double>(), -1, .25);
}

}  // namespace
}  // namespace cli
