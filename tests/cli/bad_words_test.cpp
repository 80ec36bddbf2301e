// SPDX-License-Identifier: Apache-2.0
// Names that do not exist, values out of range, pictures that do not fit each other: one clear line each.
#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

class BadWords : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    save(path("in.exr"), noise(12, 4));
  }
  // `triad run in.exr ARGUMENTS... -o out.png` is refused.
  void expect_run_refused(const std::vector<std::string>& arguments, const std::vector<std::string>& words) {
    std::vector<std::string> all{"run", "in.exr"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    all.insert(all.end(), {"-o", "out.png"});
    expect_refusal(all, words);
  }
};

TEST_F(BadWords, SuggestsStages) {
  expect_run_refused({"plat"}, {"'plat'", "'platt'"});
  expect_run_refused({"blur"}, {"'blur'"});
  expect_refusal({"compare", "in.exr", "--ref", "in.exr", "-m", "eror"}, {"'eror'", "'error'"});
}

TEST_F(BadWords, SuggestsParameters) {
  expect_run_refused({"--cells", "3x1", "platt:lamda=1"}, {"platt", "'lamda'", "'lambda'"});
  expect_run_refused({"box:z=2"}, {"box", "'z'"});
  expect_refusal({"compare", "in.exr", "--ref", "in.exr", "-m", "display:pdp=40"}, {"display", "'pdp'", "'ppd'"});
}

TEST_F(BadWords, SaysWhatAValueMayBe) {
  expect_run_refused({"--cells", "3x1", "platt:layout=rbg"}, {"platt", "layout", "rbg", "bgr"});
  expect_run_refused({"--cells", "3x1", "platt:ppd=-1"}, {"platt", "ppd", "-1"});
  expect_run_refused({"--cells", "3x1", "platt:ppd=forty"}, {"platt", "ppd", "forty"});
  expect_run_refused({"--cells", "3x1", "platt:ppd=nan"}, {"platt", "ppd", "nan"});
  expect_run_refused({"box:x=0"}, {"box", "x", "0"});
  expect_run_refused({"box:x=1.5"}, {"box", "x", "1.5"});
  expect_run_refused({"box:x"}, {"box", "x"});
  expect_run_refused({"box:x=2,x=3"}, {"box", "x"});
  expect_run_refused({"box:x='2"}, {"unclosed"});
}

TEST_F(BadWords, ChecksOptions) {
  expect_run_refused({"--cells", "3"}, {"--cells", "'3'", "3x1"});
  expect_run_refused({"--cells", "0x1"}, {"--cells", "0x1"});
  expect_run_refused({"--depth", "12"}, {"--depth", "12", "16"});
  expect_run_refused({"--threads", "-1"}, {"--threads", "-1"});
  expect_run_refused({"--strip-rows", "many"}, {"--strip-rows", "many"});
  expect_run_refused({"--max-memory", "lots"}, {"--max-memory", "lots"});
  expect_run_refused({"--nan", "maybe"}, {"--nan", "maybe", "keep"});
  const std::vector<std::string> start{"compare", "in.exr", "--ref", "in.exr", "-m", "error"};
  for (const auto& [option, value] : std::vector<std::pair<std::string, std::string>>{{"--crop", "1,2,3"},
                                                                                      {"--crop", "0,0,0,4"},
                                                                                      {"--crop", "0,0,13,4"},
                                                                                      {"--crop", "-1,0,4,4"},
                                                                                      {"--nan", "keep"}}) {
    std::vector<std::string> arguments = start;
    arguments.insert(arguments.end(), {option, value});
    expect_refusal(arguments, {option, value});
  }
}

TEST_F(BadWords, SuggestsColourSpaces) {
  expect_run_refused({"--from", "srbg"}, {"--from", "srbg", "srgb"});
  expect_run_refused({"--to", "acescgg"}, {"--to", "acescgg", "acescg"});
  expect_refusal({"compare", "in.exr", "--ref", "in.exr", "-m", "error", "--ref-from", "rec"}, {"--ref-from", "rec"});
  Options options;
  options.environment["OCIO"] = "missing.ocio";
  expect_refusal({"run", "in.exr", "-o", "out.png"}, {"missing.ocio"}, options);
  expect_run_refused({"--ocio", "missing.ocio"}, {"missing.ocio"});
}

TEST_F(BadWords, ListsChannelsAndParts) {
  expect_run_refused({"--channels", "Q"}, {"in.exr", "'Q'", "R", "G", "B"});
  expect_run_refused({"--part", "left"}, {"in.exr", "'left'"});
  expect_run_refused({"--part", "1"}, {"in.exr", "1"});
}

TEST_F(BadWords, SaysWhichWidthsWouldDo) {
  save(path("eleven.exr"), noise(11, 4));
  for (const std::string stage : {"platt", "subpixel"}) {
    expect_refusal({"run", "eleven.exr", "--cells", "3x1", stage, "-o", "out.png"}, {stage, "11", "9", "12"});
    // Not a wide picture at all, as far as anybody knows.
    expect_refusal({"run", "in.exr", stage, "-o", "out.png"}, {stage, "--cells 3x1"});
  }
}

TEST_F(BadWords, ComparesOnlyWhatFits) {
  save(path("wider.exr"), noise(13, 4));
  save(path("taller.exr"), noise(12, 5));
  for (const std::string other : {"wider.exr", "taller.exr"})
    expect_refusal({"compare", other, "--ref", "in.exr", "-m", "error"},
                   {"error", "12x4", other == "wider.exr" ? "13x4" : "12x5"});
  expect_refusal({"compare", "wider.exr", "--ref", "in.exr", "--ref-cells", "3x1", "-m", "display"},
                 {"display", "13x4", "12x4"});
  save(path("mask.exr"), constant(3, 3, {1}));
  expect_refusal({"compare", "in.exr", "--ref", "in.exr", "-m", "error", "--mask", "mask.exr"},
                 {"mask.exr", "3x3", "12x4"});
}

TEST_F(BadWords, WantsWhatItNeeds) {
  expect_refusal({"compare", "in.exr", "-m", "error"}, {"--ref"});
  expect_refusal({"compare", "in.exr", "--ref", "in.exr"}, {"-m"});
  expect_refusal({"run"}, {"input", "triad run --help"});
  expect_run_refused({"-m", "error"}, {"--ref"});
  expect_refusal({"run", "in.exr", "box"}, {"-o"});
  expect_run_refused({"error"}, {"error", "-m"});  // a metric is not a filter
  expect_refusal({"compare", "in.exr", "--ref", "in.exr", "-m", "box"}, {"box"});
}

TEST_F(BadWords, AreNotToBlameForADefectivePlugin) {
  expect_refusal({"compare", "in.exr", "--ref", "in.exr", "-m", "not-a-score", "--plugin-path",
                  TRIAD_DEFECTIVE_PLUGIN, "--json", "out.json"},
                 {"'not-a-score'", TRIAD_DEFECTIVE_PLUGIN, "not a number"});
}

TEST_F(BadWords, KnowsItsFormats) {
  expect_refusal({"run", "in.exr", "-o", "out.xyz"}, {"out.xyz"});
  expect_refusal({"run", "in.exr", "-o", "out"}, {"out"});
  expect_refusal({"run", "in.exr", "-o", "out.jpg", "--depth", "half"}, {"out.jpg", "half"});
}

}  // namespace
}  // namespace cli
