// SPDX-License-Identifier: Apache-2.0
// What theory says of a picture that a renderer made: data/pictures/strokes-wide.exr, by POV-Ray.
#include "cli.hpp"
#include "pictures.hpp"

namespace cli {
namespace {

class RealRender : public Cli {
 protected:
  const std::string wide_ = TRIAD_SOURCE_DIR "/data/pictures/strokes-wide.exr";
  const std::string optimum_ = "platt:engine=fft,lambda=0,flat-field=free,edge=wrap,range=";

  // The display error of `triad run WIDE STAGE`, on rows whose ends meet and with no pixel left out.
  double error_of(const std::string& stage, const std::string& range) {
    expect_success({"run", wide_, stage, "-o", "shown.exr", "--depth", "float"});
    return compare(
        {"shown.exr", "--ref", wide_, "-m", "display:edge=wrap,border=0,range=" + range})[0]["scores"]["rmse"];
  }
};

TEST_F(RealRender, IsWideByItsOwnHeader) {
  const Outcome outcome = expect_success({"info", wide_});
  EXPECT_NE(outcome.out.find("3x1"), std::string::npos) << outcome.out;
  expect_success({"run", wide_, "platt", "-o", "out.png"});
  EXPECT_EQ(load(path("out.png")).width, 400);
}

TEST_F(RealRender, HasItsLeastErrorAtTheUnboundedOptimum) {
  const double optimum = error_of(optimum_ + "unbounded", "unbounded");
  for (const std::string stage : {"box:x=3", "subpixel", "platt", "platt:lambda=0.001,edge=wrap,range=unbounded"})
    EXPECT_GT(error_of(stage, "unbounded"), optimum) << stage;
  // Clipped to what a display can show, the same filter is worse than the plain average.
  EXPECT_GT(error_of(optimum_ + "clip", "clip"), error_of("box:x=3", "clip"));
}

// The optimum is a minimum: whichever way its picture is changed, the error grows.
TEST_F(RealRender, HasAMinimumAtTheUnboundedOptimum) {
  const double optimum = error_of(optimum_ + "unbounded", "unbounded");
  Picture best = load(path("shown.exr"));
  best.text.clear();
  const Picture change = noise(400, 225, 3, 5);
  for (const float step : {.01f, -.01f}) {
    Picture changed = best;
    for (size_t i = 0; i < changed.values.size(); ++i) changed.values[i] += step * change.values[i];
    save(path("changed.exr"), changed);
    const nlohmann::json result =
        compare({"changed.exr", "--ref", wide_, "-m", "display:edge=wrap,border=0,range=unbounded"})[0];
    EXPECT_GT(result["scores"]["rmse"].get<double>(), optimum) << step;
  }
}

}  // namespace
}  // namespace cli
