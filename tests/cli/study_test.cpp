// SPDX-License-Identifier: Apache-2.0
// `triad study` of filters: the claims about the constrained optimum, on small pictures of strokes, and plans that
// cannot be run.
#include <cmath>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

class FilterStudy : public Cli {
 protected:
  // Medians of every filter, by the filter's text and ppd.
  using Medians = std::map<std::pair<std::string, int>, std::map<std::string, double>>;

  Medians study(const std::string& fixed, const std::vector<int>& ppds, const std::vector<std::string>& filters) {
    const auto list = [](const auto& values, const auto& text) {
      std::string all;
      for (const auto& value : values) all += (all.empty() ? "" : ", ") + text(value);
      return "[" + all + "]";
    };
    save_text(path("plan.toml"),
              "work = 'filter'\nrepeats = 1\npareto = ['seconds', 'rmse']\nwithin = ['ppd']\n[fixed]\n" + fixed +
                  "\n[[axis]]\nname = 'ppd'\nvalues = " + list(ppds, [](int v) { return std::to_string(v); }) +
                  "\n[[axis]]\nname = 'filter'\nvalues = " +
                  list(filters, [](const std::string& v) { return "'" + v + "'"; }) + "\n");
    Medians medians;
    const auto results = expect_success({"study", "plan.toml", "--json", "-"}).json();
    for (const auto& run : results["runs"]) {
      auto& of = medians[{run["settings"]["filter"], std::stoi(run["settings"]["ppd"].get<std::string>())}];
      for (const auto& [name, value] : run["median"].items()) of[name] = value.get<double>();
    }
    EXPECT_EQ(medians.size(), ppds.size() * filters.size());
    return medians;
  }
};

const std::string kConstrained = "platt:layout={layout},ppd={ppd}";
const std::string kBox = "displaced-box:layout={layout}";
const std::string kClipped = "platt:layout={layout},ppd={ppd},range=clip,lambda=0,flat-field=free,engine=fft";
const std::string kAverage = "box:x={cells_x},y={cells_y}";

TEST_F(FilterStudy, OnStripesTheOptimumBeatsTheBoxAndTheClippedOptimumLosesToIt) {
  for (const std::string picture : {"strokes", "stems"}) {
    const auto by = study("picture = '" + picture +
                              "'\nsize = '160x90'\nspp = 16\nlayout = 'rgb'\n"
                              "metric = 'display:mode=rows'",
                          {40}, {kConstrained, kBox, kClipped, kAverage});
    const auto& best = by.at({kConstrained, 40});
    const auto& box = by.at({kBox, 40});
    const auto& clipped = by.at({kClipped, 40});
    EXPECT_NEAR(by.at({kAverage, 40}).at("ratio"), 1, 1e-6);
    EXPECT_EQ(box.at("box-ratio"), 1);
    EXPECT_NEAR(best.at("box-ratio"), best.at("rmse") / box.at("rmse"), 1e-12);
    EXPECT_LE(best.at("box-ratio"), .75) << picture;
    EXPECT_LE(best.at("ratio"), .2) << picture;
    EXPECT_LE(best.at("gap"), .01) << picture;
    EXPECT_GT(clipped.at("rmse"), 1.5 * box.at("rmse")) << picture;
    // The same order in a measure that the solver does not know.
    EXPECT_LT(best.at("delta-e"), box.at("delta-e")) << picture;
    EXPECT_LT(box.at("delta-e"), clipped.at("delta-e")) << picture;
    EXPECT_LT(box.at("delta-e"), by.at({kAverage, 40}).at("delta-e")) << picture;
  }
}

TEST_F(FilterStudy, OnQdOledItsOwnOptimumIsFarBelowFiltersForStripes) {
  const std::string stripes = "platt:layout=rgb,ppd={ppd}", stripes_box = "displaced-box:layout=rgb";
  const auto by =
      study("picture = 'strokes'\nsize = '160x90'\nspp = 16\nlayout = 'qd-oled'\nmetric = 'display:mode=plane'",
            {40, 67}, {kConstrained, kBox, stripes, stripes_box});
  for (const int ppd : {40, 67}) {
    const auto& best = by.at({kConstrained, ppd});
    EXPECT_LE(best.at("ratio"), ppd == 40 ? .35 : .22);
    EXPECT_LT(best.at("delta-e"), by.at({kBox, ppd}).at("delta-e"));
    for (const std::string& other : {stripes, stripes_box}) {
      EXPECT_GT(by.at({other, ppd}).at("ratio"), .6) << other;
      EXPECT_GT(by.at({other, ppd}).at("delta-e"), by.at({kBox, ppd}).at("delta-e")) << other;
    }
  }
}

TEST_F(FilterStudy, TakesFilesScenesAndKnobs) {
  save(path("wide.exr"), noise(60, 20), "float");
  expect_success({"run", "wide.exr", "--cells", "3x1", "-o", "marked.exr"});
  save_text(path("plan.toml"),
            "work = 'filter'\nrepeats = 1\n[fixed]\nsize = '24x16'\nspp = 1\nlayout = 'rgb'\nppd = 40\n"
            "filter = 'platt:ppd={ppd},iterations={iterations},tolerance=0'\n[[axis]]\nname = 'picture'\n"
            "values = ['marked.exr', 'high-contrast-1']\n[[axis]]\nname = 'iterations'\nvalues = [0, 3]\n");
  const auto runs = expect_success({"study", "plan.toml", "--json", "-"}).json()["runs"];
  ASSERT_EQ(runs.size(), 4u);
  for (const auto& run : runs) {
    const bool none = run["settings"]["iterations"] == "0";
    EXPECT_EQ(run["median"]["iterations"], none ? 0 : 3);
    if (none) {
      EXPECT_NEAR(run["median"]["box-ratio"].get<double>(), 1, 1e-5);  // where the iteration starts
    }
    EXPECT_GT(run["median"]["seconds"], 0);
    EXPECT_FALSE(run.contains("pareto"));
  }
  // The same numbers as by files.
  expect_success({"run", "marked.exr", "platt:iterations=3,tolerance=0", "-o", "out.exr", "--depth", "float"});
  const auto scores = compare({"out.exr", "--ref", "marked.exr", "-m", "display"})[0]["scores"];
  EXPECT_NEAR(runs[1]["median"]["rmse"].get<double>(), scores["rmse"].get<double>(), 1e-12);
}

TEST_F(FilterStudy, MarksThePareto) {
  save_text(
      path("plan.toml"),
      "work = 'filter'\nrepeats = 1\npareto = ['rmse']\nmeasure = ['ratio']\n[fixed]\npicture = 'stems'\nsize = "
      "'80x40'\nspp = 4\nlayout = 'rgb'\nppd = 40\n[[axis]]\nname = 'filter'\nvalues = ['box:x=3', 'platt']\n");
  const auto json = expect_success({"study", "plan.toml", "--json", "-"}).json();
  EXPECT_EQ(json["runs"][0]["pareto"], false);
  EXPECT_EQ(json["runs"][1]["pareto"], true);
  const std::string table = expect_success({"study", "plan.toml"}).out;
  EXPECT_NE(table.find("best"), std::string::npos);
  EXPECT_EQ(std::count(table.begin(), table.end(), '*'), 1) << table;
}

TEST_F(FilterStudy, RefusesWhatCannotBeRun) {
  const auto refuse = [&](const std::string& fixed, const std::string& filter,
                          const std::vector<std::string>& words) {
    save_text(path("plan.toml"), "work = 'filter'\nrepeats = 1\n[fixed]\n" + fixed +
                                     "\n[[axis]]\nname = 'filter'\nvalues = ['" + filter + "']\n");
    expect_refusal({"study", "plan.toml"}, words);
  };
  const std::string good = "picture = 'stems'\nsize = '16x8'\nspp = 1\nlayout = 'rgb'\nppd = 40\n";
  refuse(good + "camera = 'x'\n", "platt", {"plan.toml", "'camera'", "scenes"});
  refuse("picture = 'stem'\nsize = '16x8'\nspp = 1\nlayout = 'rgb'\nppd = 40\n", "platt",
         {"plan.toml", "stem", "'stems'", "cornell"});
  refuse("picture = 'stems'\nsize = '16'\nspp = 1\nlayout = 'rgb'\nppd = 40\n", "platt", {"plan.toml", "400x225"});
  refuse("picture = 'stems'\nsize = '16x8'\nlayout = 'rgb'\nppd = 40\n", "platt", {"plan.toml", "spp"});
  refuse("picture = 'stems'\nsize = '16x8'\nspp = 1\nppd = 40\n", "platt", {"plan.toml", "layout"});
  refuse("picture = 'stems'\nsize = '16x8'\nspp = 1\nlayout = 'rbg'\nppd = 40\n", "platt", {"rbg"});
  refuse(good, "plat", {"plat"});
  refuse(good, "platt:ppd=0", {"plan.toml", "ppd"});
  refuse(good, "platt:taps={taps}", {"plan.toml", "taps"});
  refuse(good, "write:a.exr platt", {"plan.toml", "writes"});
  refuse(good, " ", {"plan.toml", "filter"});
  refuse(good, "box:x=1", {"plan.toml", "box:x=1"});
  refuse(good + "pdd = 40\n", "platt", {"plan.toml", "pdd", "ppd"});
  refuse(good + "metric = 'disply'\n", "platt", {"disply"});
  refuse(good + "metric = 'display:mode=row'\n", "platt", {"plan.toml", "mode"});
}

}  // namespace
}  // namespace cli
