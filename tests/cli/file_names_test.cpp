// SPDX-License-Identifier: Apache-2.0
// Names of files that are no UTF-8, as those of Latin-1 systems: JSON stays valid, and the file can be told.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

using testing::HasSubstr;

const std::string kName = "gr\xfcn.exr", kShown = "gr\\xfcn.exr";
const std::string kOther = "gr\xf6n.exr", kOtherShown = "gr\\xf6n.exr";

class FileNames : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    std::ofstream(path(kName)) << "";
    if (!exists(kName)) GTEST_SKIP() << "this file system takes UTF-8 only";
    save(path("ref.exr"), noise(8, 8, 3, 1));
    save(path(kName), noise(8, 8, 3, 2));
    save(path(kOther), noise(8, 8, 3, 3));
  }
};

TEST_F(FileNames, AreKnownInTheResultsOfCompare) {
  const nlohmann::json results =
      expect_success({"compare", kName, kOther, "--ref", "ref.exr", "-m", "error", "--json", "-"}).json();
  EXPECT_EQ(results["results"][0]["test"], kShown);
  EXPECT_EQ(results["results"][1]["test"], kOtherShown);
  EXPECT_EQ(expect_success({"compare", "ref.exr", "--ref", kName, "-m", "error", "--json", "-"})
                .json()["results"][0]["reference"],
            kShown);
}

TEST_F(FileNames, AreKnownInTheRecordsOfRunAndInfo) {
  const nlohmann::json run =
      expect_success({"run", kName, "-m", "error", "--ref", kOther, "-o", "\xe4.exr", "--json", "-"}).json();
  EXPECT_EQ(run["results"][0]["test"], kShown);
  EXPECT_EQ(run["results"][0]["reference"], kOtherShown);
  EXPECT_THAT(run.dump(), HasSubstr("\"\\\\xe4.exr\""));
  const nlohmann::json info = expect_success({"info", kName, kOther, "--json"}).json();
  EXPECT_EQ(info["files"][0]["file"], kShown);
  EXPECT_EQ(info["files"][1]["file"], kOtherShown);
}

TEST_F(FileNames, AreKnownInConvergence) {
  std::filesystem::create_directory(folder_ / "r\xe4nders");
  for (int k = 0; k < 5; ++k) {
    const double size = std::exp2(-.5 * k);
    const Picture reference = noise(8, 8, 3, 1), random = noise(8, 8, 3, static_cast<uint32_t>(9 + k));
    save(path("r\xe4nders/a\xfc_" + std::to_string(1 << k) + "spp.exr"),
         from_function(8, 8, 3, [&](int x, int y, int c) {
           return static_cast<double>(reference.at(x, y, c)) + size * (static_cast<double>(random.at(x, y, c)) - .5);
         }));
  }
  const Outcome outcome = triad({"convergence", "r\xe4nders", "--ref", "ref.exr", "--json", "-"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.json().dump(), HasSubstr(R"(r\\xe4nders/a\\xfc_16spp.exr)"));
}

TEST_F(FileNames, ReportsFindTheirPictures) {
  expect_success({"compare", kName, "--ref", kOther, "-m", "error", "--json", "s\xfc.json", "-q"});
  const Outcome outcome = triad({"report", "s\xfc.json"});
  if (outcome.err.find("TRIAD_VIEWER") != std::string::npos) GTEST_SKIP() << "built without the viewer";
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string page = load_text(path("s\xfc.html"));
  EXPECT_THAT(page, HasSubstr(R"("name":"gr\\xfcn.exr")"));
  EXPECT_EQ(page.find('\xfc'), std::string::npos);  // no UTF-8 has this byte
}

}  // namespace
}  // namespace cli
