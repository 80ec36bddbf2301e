// SPDX-License-Identifier: Apache-2.0
// `triad study` of strategies: numbers that files give as well, folders that are gone on with, plans that cannot be
// run.
#include <cmath>
#include <fstream>
#include <triad/evaluation/study.hpp>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class StrategyStudy : public Cli {
 protected:
  // The runs of a plan, by the values of its axes with blanks between them.
  static std::map<std::string, Json> runs_of(const Json& results) {
    std::map<std::string, Json> runs;
    for (const Json& run : results.at("runs")) {
      std::string key;
      for (const auto& [name, value] : run.at("settings").items())
        key += (key.empty() ? "" : " ") + value.get<std::string>();
      runs[key] = run;
    }
    return runs;
  }
  std::map<std::string, Json> study(const std::string& plan) const {
    save_text(path("plan.toml"), plan);
    return runs_of(expect_success({"study", "plan.toml", "--json", "-"}).json());
  }
  // All that does not depend on the clock.
  static Json without_seconds(Json results) {
    for (Json& run : results.at("runs"))
      for (const char* part : {"median", "spread", "mean", "interval95", "values"})
        for (const char* name : {"seconds", "total-seconds", "filter-seconds", "plan-seconds"})
          run.at(part).erase(name);
    return results;
  }
};

TEST_F(StrategyStudy, FindsWhatFilesSay) {
  const auto render = [&](const std::string& out, std::vector<std::string> more) {
    more.insert(more.begin(), {"render", "thin-lines", "-o", out, "--size", "60x32"});
    expect_success(more);
  };
  render("truth.exr", {"--strategy", "sobol-owen:spp=64", "--cells", "rgb", "--seed", "9"});
  expect_success({"run", "truth.exr", "box:x=3", "-o", "mean.exr", "--depth", "float"});
  render("centre.exr", {"--strategy", "control", "--seed", "1"});
  render("wide-centre.exr", {"--strategy", "control", "--cells", "rgb", "--seed", "1"});
  render("grid.exr", {"--strategy", "grid:n=3", "--seed", "1"});
  render("cells.exr", {"--strategy", "sobol-owen:spp=4", "--cells", "rgb", "--seed", "1"});
  expect_success({"run", "cells.exr", "platt:layout=rgb,ppd=30", "-o", "shown.exr", "--depth", "float"});

  const auto runs = study(
      "work = 'strategy'\nrepeats = 1\nseeds = 2\n[fixed]\nsource = 'thin-lines'\nsize = '60x32'\nlayout = 'rgb'\n"
      "ppd = 30\nreference = 'truth.exr'\nmetric = 'error display'\n[[axis]]\nname = 'method'\nvalues = [\n"
      "{label = 'grid', strategy = 'grid:n=3'},\n"
      "{label = 'shown', strategy = 'sobol-owen:spp=4', cells = 'rgb', filter = "
      "'platt:layout={layout},ppd={ppd}'}]\n");
  for (const auto& [label, file] : std::map<std::string, std::string>{{"grid", "grid.exr"}, {"shown", "shown.exr"}}) {
    const auto score = [&](const std::string& reference, const std::string& metric, const std::string& name) {
      return compare({file, "--ref", reference, "-m", metric})[0]["scores"][name].get<double>();
    };
    const Json& values = runs.at(label).at("values");
    const auto second = [&](const std::string& name) { return values.at(name)[1].get<double>(); };  // of seed 1
    const std::string display = "display:layout=rgb,ppd=30";
    // The mean of three floats is rounded once more in the file.
    EXPECT_NEAR(second("rmse"), score("mean.exr", "error", "rmse"), 1e-8) << label;
    EXPECT_NEAR(second("display.rmse"), score("truth.exr", display, "rmse"), 1e-12) << label;
    EXPECT_NEAR(second("second.rmse"), score("centre.exr", "error", "rmse"), 1e-12) << label;
    EXPECT_NEAR(second("second.display.delta-e"), score("wide-centre.exr", display, "delta-e"), 1e-12) << label;
  }
  EXPECT_EQ(runs.at("grid").at("values").at("samples"), Json({60 * 32 * 9, 60 * 32 * 9}));
  EXPECT_EQ(runs.at("shown").at("values").at("samples"), Json({180 * 32 * 4, 180 * 32 * 4}));
  EXPECT_EQ(runs.at("shown").at("median").at("spp"), 12);
  EXPECT_EQ(runs.at("grid").at("median").at("camera rays"), 60 * 32 * 9);
  EXPECT_EQ(runs.at("grid").at("median").at("filter-seconds"), 0);
  EXPECT_GT(runs.at("shown").at("median").at("filter-seconds"), 0);
  EXPECT_LE(runs.at("shown").at("median").at("gap"), .01);
}

TEST_F(StrategyStudy, KnowsExactPictures) {
  const auto runs = study(
      "work = 'strategy'\nrepeats = 1\nseeds = 3\n[fixed]\nsource = 'half-plane'\nsize = '64x64'\nreference = "
      "'exact'\n"
      "[[axis]]\nname = 'strategy'\nvalues = ['control', 'grid:n=16', 'random:spp=4']\n");
  const auto rmse = [&](const std::string& strategy) {
    return runs.at(strategy).at("mean").at("rmse").get<double>();
  };
  EXPECT_EQ(runs.at("control").at("mean").at("second.rmse"), 0);
  EXPECT_EQ(runs.at("control").at("mean").at("unchanged"), 1);
  EXPECT_LT(runs.at("grid:n=16").at("mean").at("unchanged").get<double>(), 1);
  EXPECT_LT(rmse("grid:n=16"), .1 * rmse("control"));
  EXPECT_LT(rmse("random:spp=4"), rmse("control"));
  // Deterministic points: no interval; random ones: Student's t of the three values, t(.975, 2) = 4.302653.
  EXPECT_EQ(runs.at("grid:n=16").at("interval95").at("rmse"), 0);
  const auto values = runs.at("random:spp=4").at("values").at("rmse").get<std::vector<double>>();
  const double mean = (values[0] + values[1] + values[2]) / 3;
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  EXPECT_GT(squares, 0);
  EXPECT_NEAR(runs.at("random:spp=4").at("interval95").at("rmse").get<double>(),
              4.302653 * std::sqrt(squares / 2 / 3), 1e-6 * mean);
}

constexpr const char* kLongPlan =
    "work = 'strategy'\nrepeats = 2\nseeds = 5\npareto = ['samples', 'rmse']\n[fixed]\nsize = '96x54'\n"
    "reference = 'sobol-owen:spp=16'\n[[axis]]\nname = 'source'\nvalues = ['cornell', 'strokes']\n"
    "[[axis]]\nname = 'strategy'\nvalues = ['sobol-owen:spp=4', 'grid:n=3', 'variance:spp=64']\n";

TEST_F(StrategyStudy, GoesOnWhereItWasKilled) {
  save_text(path("plan.toml"), kLongPlan);
  const Json whole = expect_success({"study", "plan.toml", "--json", "-"}).json();
  Options killed;
  killed.interrupt_signal = SIGKILL;
  killed.interrupt_when = [&] { return exists("out/runs/3-0002.json"); };
  expect_status(128 + SIGKILL, {"study", "plan.toml", "-o", "out"}, killed);
  EXPECT_FALSE(exists("out/results.json"));
  Options interrupted;
  interrupted.interrupt_when = [&] { return exists("out/runs/6-0001.json"); };
  expect_status(130, {"study", "plan.toml", "-o", "out"}, interrupted);
  std::map<std::string, std::string> kept;
  for (const auto& entry : fs::directory_iterator(path("out/runs")))
    kept[entry.path()] = load_text(entry.path().string());
  ASSERT_GE(kept.size(), 38u);  // 6 turns of 6, and two
  ASSERT_LT(kept.size(), 60u);

  const Json results = expect_success({"study", "plan.toml", "-o", "out", "--json", "-"}).json();
  EXPECT_EQ(without_seconds(results), without_seconds(whole));
  for (const auto& [file, text] : kept) EXPECT_EQ(load_text(file), text) << "run again";
  EXPECT_EQ(Json::parse(load_text(path("out/results.json"))), results);
  EXPECT_NE(load_text(path("out/table.txt")).find("best"), std::string::npos);
  for (const std::string& file : files()) EXPECT_EQ(file.find(".triad-"), std::string::npos) << file;
  EXPECT_TRUE(exists("out/pictures/004-strokes-grid-n=3.exr"));
  EXPECT_EQ(load(path("out/pictures/000-cornell-sobol-owen-spp=4.exr")).width, 96);
  // Whole, it is only read: to the last bit of the seconds.
  EXPECT_EQ(expect_success({"study", "plan.toml", "-o", "out", "--json", "-"}).json(), results);
}

TEST_F(StrategyStudy, UsesReferencesAgain) {
  const auto plan = [](const std::string& strategy) {
    return "work = 'strategy'\nrepeats = 1\n[fixed]\nsource = 'strokes'\nsize = '32x18'\nreference = "
           "'random:spp=16'\nsecond = 'none'\n[[axis]]\nname = 'strategy'\nvalues = ['" +
           strategy + "']\n";
  };
  save_text(path("plan.toml"), plan("control"));
  expect_success({"study", "plan.toml", "-o", "one"});
  const double before = Json::parse(load_text(path("one/results.json")))["runs"][0]["median"]["rmse"];
  // A brighter picture in the place of the reference is seen: it is not drawn again.
  std::string reference;
  for (const auto& entry : fs::directory_iterator(path("one/references")))
    if (entry.path().extension() == ".exr") reference = entry.path();
  ASSERT_FALSE(reference.empty());
  Picture bright = load(reference);
  for (float& value : bright.values) value += 10;
  save(reference, bright);
  fs::remove(path("one/runs/0-0000.json"));
  expect_success({"study", "plan.toml", "-o", "one"});
  const double after = Json::parse(load_text(path("one/results.json")))["runs"][0]["median"]["rmse"];
  EXPECT_LT(before, 1);
  EXPECT_NEAR(after, 10, 1);
}

constexpr const char* kPicturePlan =
    "work = 'strategy'\nrepeats = 1\n[fixed]\nsource = 'source.exr'\nsize = '16x8'\nreference = 'exact-one.exr'\n"
    "[[axis]]\nname = 'strategy'\nvalues = ['control', 'grid:n=2']\n";

TEST_F(StrategyStudy, NoticesFilesThatHaveChanged) {
  save_text(path("plan.toml"), kPicturePlan);
  expect_success({"render", "strokes", "-o", "source.exr", "--size", "32x16"});
  expect_success({"render", "strokes", "-o", "exact-one.exr", "--size", "16x8", "--strategy", "grid:n=8"});
  expect_success({"study", "plan.toml", "-o", "out"});
  expect_success({"study", "plan.toml", "-o", "out"});
  for (const std::string file : {"source.exr", "exact-one.exr"}) {
    const std::string before = load_text(path(file));
    const int width = load(path(file)).width;
    expect_success({"render", "strokes", "-o", file, "--size",
                    std::to_string(width) + "x" + std::to_string(width / 2), "--strategy", "random:spp=2"});
    expect_refusal({"study", "plan.toml", "-o", "out"}, {"out", "'" + file + "' has changed"});
    save_text(path(file), before);
    expect_success({"study", "plan.toml", "-o", "out"});  // the same again, whatever its date
  }
}

TEST_F(StrategyStudy, DestroysNothingWithItsResults) {
  save_text(path("plan.toml"), kPicturePlan);
  expect_success({"render", "strokes", "-o", "source.exr", "--size", "32x16"});
  expect_success({"render", "strokes", "-o", "exact-one.exr", "--size", "16x8"});
  for (const std::string file : {"plan.toml", "./source.exr", "exact-one.exr", "out/plan.json", "out/table.txt"}) {
    if (file.starts_with("out")) expect_success({"study", "plan.toml", "-o", "out"});
    expect_refusal({"study", "plan.toml", "-o", "out", "--json", file}, {"--json", file, "overwrite"});
  }
}

TEST_F(StrategyStudy, MakesWhatIsMissingAgain) {
  save_text(path("plan.toml"),
            "work = 'strategy'\nrepeats = 1\n[fixed]\nsource = 'strokes'\nsize = '16x8'\nreference = 'random:spp=4'\n"
            "[[axis]]\nname = 'strategy'\nvalues = ['control', 'grid:n=2']\n");
  const auto study = [&] { return expect_success({"study", "plan.toml", "-o", "out", "--json", "-"}).json(); };
  const Json first = study();
  const std::string picture = path("out/pictures/001-grid-n=2.exr"), before = load_text(picture);
  fs::remove(picture);
  EXPECT_EQ(without_seconds(study()), without_seconds(first));
  EXPECT_EQ(load_text(picture), before);
  // Facts of a reference without their number.
  for (const auto& entry : fs::directory_iterator(path("out/references")))
    if (entry.path().extension() == ".json") {
      Json facts = Json::parse(load_text(entry.path().string()));
      facts["rmse"] = nullptr;
      save_text(entry.path().string(), facts.dump());
    }
  fs::remove_all(path("out/runs"));
  EXPECT_EQ(without_seconds(study()), without_seconds(first));
}

TEST_F(StrategyStudy, TellsFiltersWhoseCellsTheyAre) {
  const auto runs = study(
      "work = 'strategy'\nrepeats = 1\n[fixed]\nsource = 'strokes'\nsize = '16x8'\nreference = 'grid'\nsecond = "
      "'none'\ncells = 'qd-oled'\nfilter = 'platt:ppd=30'\n[[axis]]\nname = 'strategy'\nvalues = ['grid:n=2']\n");
  EXPECT_EQ(runs.at("grid:n=2").at("median").at("samples"), 16 * 8 * 4 * 4);
}

TEST_F(StrategyStudy, RefusesWhatCannotBeRun) {
  const auto refuse = [&](const std::string& fixed, const std::string& strategy,
                          const std::vector<std::string>& words, const std::vector<std::string>& more = {}) {
    save_text(path("plan.toml"), "work = 'strategy'\nrepeats = 1\n[fixed]\n" + fixed +
                                     "\n[[axis]]\nname = 'strategy'\nvalues = ['control', '" + strategy + "']\n");
    std::vector<std::string> arguments{"study", "plan.toml"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_refusal(arguments, words);
  };
  const std::string good = "source = 'strokes'\nsize = '16x8'\nreference = 'grid'\n";
  refuse(good, "gird", {"plan.toml", "gird", "grid"});
  refuse(good, "grid:m=2", {"plan.toml", "'m'"});
  refuse(good, "grid:n={k}", {"plan.toml", "'k'", "missing"});
  refuse("source = 'stroke'\nsize = '16x8'\nreference = 'grid'\n", "grid", {"plan.toml", "stroke", "'strokes'"});
  refuse("source = 'no.gltf'\nsize = '16x8'\nreference = 'grid'\n", "grid", {"no.gltf"});
  refuse("source = 'strokes'\nreference = 'grid'\n", "grid", {"plan.toml", "'size'"});
  refuse("source = 'strokes'\nsize = '16x8'\n", "grid", {"plan.toml", "'reference'"});
  refuse("source = 'strokes'\nsize = '16x8'\nreference = 'exact'\n", "grid", {"plan.toml", "strokes", "sobol-owen"});
  refuse("source = 'strokes'\nsize = '16x8'\nreference = 'truth.exr'\n", "grid", {"truth.exr"});
  refuse(good + "sorce = 'strokes'\n", "grid", {"plan.toml", "sorce", "source"});
  refuse(good + "metric = 'display'\nlayout = 'rgb'\n", "grid", {"plan.toml", "'ppd'"});
  refuse(good + "metric = 'box'\n", "grid", {"plan.toml", "box", "filter"});
  refuse(good + "metric = 'errror'\n", "grid", {"errror"});
  refuse(good + "cells = '3'\n", "grid", {"cells", "'3'"});
  refuse(good + "filter = 'plat'\n", "grid", {"plat"});
  refuse(good + "filter = 'write:x.exr'\n", "grid", {"plan.toml", "writes"});
  refuse("source = 'cornell'\nsize = '16x8'\nreference = 'grid'\nbounces = -1\n", "grid",
         {"plan.toml", "bounces", "1000"});
  refuse(good + "seed = 1\n", "grid", {"--seeds", "seed"}, {"--seeds", "2"});
  refuse(good + "effects = 'none'\n", "grid", {"plan.toml", "'effects'", "scenes"});
  refuse(good + "metric = 'errror'\n", "grid", {"plan.toml", "errror"});
  // Before a sample is taken: the folder is not even made.
  const std::vector<std::string> out{"-o", "out"};
  refuse(good, "exact", {"plan.toml", "strokes", "exact integral"}, out);
  refuse(good + "second = 'exact'\n", "grid", {"plan.toml", "strokes", "exact integral"}, out);
  refuse(good + "cells = '3x1'\n", "grid", {"plan.toml", "48x8", "16x8", "box:x=3"}, out);
  refuse(good + "filter = 'box:x=2'\n", "grid", {"plan.toml", "box:x=2"}, out);
  refuse(good + "cells = '3x1'\nfilter = 'box:x=3'\n", "per-subpixel", {"plan.toml", "per-subpixel", "cells"}, out);
  expect_success({"render", "strokes", "-o", "large.exr", "--size", "32x16"});
  refuse("source = 'strokes'\nsize = '16x8'\nreference = 'large.exr'\n", "grid",
         {"plan.toml", "large.exr", "32x16", "16x8"}, out);
  save_text(path("work.toml"), "work = 'strategi'\n[[axis]]\nname = 'a'\nvalues = [1]\n");
  expect_refusal({"study", "work.toml"}, {"work.toml", "strategi", "'strategy'"});
}

TEST_F(StrategyStudy, RefusesFoldersOfOtherStudies) {
  const std::string plan =
      "work = 'strategy'\nrepeats = 1\n[fixed]\nsource = 'strokes'\nsize = '16x8'\nreference = 'grid'\n[[axis]]\n"
      "name = 'strategy'\nvalues = ['control']\n";
  save_text(path("plan.toml"), plan);
  expect_success({"study", "plan.toml", "-o", "out"});
  expect_refusal({"study", "plan.toml", "-o", "out", "--repeats", "2"}, {"out", "repeats", "'1'", "'2'"});
  expect_refusal({"study", "plan.toml", "-o", "out", "--threads", "1000"}, {"out", "threads"}, {});
  save_text(path("plan.toml"), plan + "[[axis]]\nname = 'layout'\nvalues = ['rgb']\n");
  expect_refusal({"study", "plan.toml", "-o", "out"}, {"out", "'layout'"});
  expect_refusal({"study", "plan.toml", "-o", "."}, {"not empty"});
  expect_refusal({"study", "plan.toml", "-o", "plan.toml"}, {"plan.toml", "is a file"});
  Options nobody;
  nobody.as_nobody = true;
  fs::create_directories(path("closed"));
  fs::permissions(path("closed"),
                  fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read | fs::perms::others_exec);
  expect_refusal({"study", "plan.toml", "-o", "closed/out"}, {"closed/out", "Permission denied"}, nobody);
}

// Names, parameters, layouts and chains of the plans that come with the program: all is looked at before a run.
TEST_F(StrategyStudy, BundledPlansCanBeRun) {
  for (const auto& entry : fs::directory_iterator(fs::path(TRIAD_SOURCE_DIR) / "data/studies")) {
    const std::string text = load_text(entry.path().string());
    if (text.find("work = \"strategy\"") == std::string::npos) continue;
    Options interrupted;
    interrupted.interrupt_when = [&, out = entry.path().stem().string()] { return exists(out + "/plan.json"); };
    expect_status(130, {"study", entry.path().string(), "-o", entry.path().stem().string()}, interrupted);
  }
}

}  // namespace
}  // namespace cli
