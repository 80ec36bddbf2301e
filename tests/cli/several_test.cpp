// SPDX-License-Identifier: Apache-2.0
// Several pictures in one call, and outputs that must not get in each other's way.
#include <filesystem>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

class Several : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    std::filesystem::create_directories(folder_ / "a");
    std::filesystem::create_directories(folder_ / "b");
    save(path("a/x.exr"), constant(5, 4, {.5f, .25f, .125f}));
    save(path("b/x.exr"), constant(5, 4, {.5f, .5f, .5f}));
    save(path("ref.exr"), constant(5, 4, {.5f, .5f, .5f}));
  }
};

TEST_F(Several, MapsOfTheSameNameAreBothKept) {
  expect_success({"compare", "a/x.exr", "b/x.exr", "--ref", "ref.exr", "-m", "error", "--map", "maps/"});
  EXPECT_TRUE(exists("maps/x.error.exr"));
  EXPECT_TRUE(exists("maps/x.error-2.exr"));
}

TEST_F(Several, ExplainingMakesNoFolder) {
  expect_success({"run", "a/x.exr", "-m", "error", "--ref", "ref.exr", "--map", "maps/", "--explain"});
  EXPECT_FALSE(exists("maps"));
}

TEST_F(Several, OneBadPictureDoesNotLoseTheOthers) {
  save_text(path("bad.exr"), "no picture");
  const Outcome outcome = expect_status(
      2, {"compare", "a/x.exr", "bad.exr", "b/x.exr", "--ref", "ref.exr", "-m", "error", "--json", "r.json"});
  ASSERT_EQ(outcome.error_lines().size(), 1u) << outcome.err;
  EXPECT_NE(outcome.err.find("bad.exr"), std::string::npos);
  const auto results = nlohmann::json::parse(load_text(path("r.json"))).at("results");
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].at("test"), "a/x.exr");
  EXPECT_NEAR(results[0].at("scores").at("mae").get<double>(), (.25 + .375) / 3, 1e-9);
  EXPECT_EQ(results[1].at("scores").at("mae"), 0);
}

TEST_F(Several, ResultsDoNotReplaceWhatIsRead) {
  expect_refusal({"compare", "a/x.exr", "--ref", "ref.exr", "-m", "error", "--json", "./ref.exr"},
                 {"--json", "ref.exr"});
  expect_refusal({"compare", "a/x.exr", "--ref", "ref.exr", "-m", "error", "--csv", "b/../a/x.exr"}, {"--csv"});
  expect_refusal({"compare", "a/x.exr", "--ref", "ref.exr", "-m", "error", "--json", "r", "--csv", "r"},
                 {"--csv", "r"});
  expect_refusal({"compare", "a/x.exr", "--ref", "ref.exr", "-m", "error", "--map", "ref.exr"}, {"map", "ref.exr"});
}

TEST_F(Several, AnEmptyValueIsNotADefault) {
  for (const std::string option : {"--crop", "--mask", "--channels", "--json", "--from", "--max-memory"})
    expect_refusal({"compare", "a/x.exr", "--ref", "ref.exr", "-m", "error", option, ""}, {option, "empty"});
}

TEST_F(Several, ChannelsChooseInBothPicturesUnlessTheReferenceHasItsOwn) {
  // Green is .25 in the test and .5 in the reference; red is .5 in both.
  const auto mae = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"a/x.exr", "--ref", "ref.exr", "-m", "error", "--channels", "G"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return compare(arguments)[0].at("scores").at("mae").get<double>();
  };
  EXPECT_NEAR(mae({}), .25, 1e-9);
  save(path("ref.exr"), constant(5, 4, {.125f, .5f, .25f}));
  EXPECT_NEAR(mae({}), .25, 1e-9);
  EXPECT_NEAR(mae({"--ref-channels", "R"}), .125, 1e-9);
  EXPECT_NEAR(mae({"--ref-channels", "B"}), 0, 1e-9);
}

}  // namespace
}  // namespace cli
