// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <triad/base/error.hpp>
#include <triad/base/file.hpp>
#include <triad/display/filter_design.hpp>
#include <triad/display/layout.hpp>
#include <triad/display/vision.hpp>

#include "display_reference.hpp"
#include "layouts.hpp"

using testing::HasSubstr;

namespace {

const std::string kFolder = TRIAD_SOURCE_DIR "/data/layouts/";

std::string message_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const triad::Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

// The shipped file with one text replaced.
std::string with(const std::string& from, const std::string& to, const std::string& file = "rgb.toml") {
  std::string text = triad::read_text_file(kFolder + file);
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST(Layout, StripesAreWhatTheirNamesSay) {
  setenv("TRIAD_DATA", TRIAD_SOURCE_DIR "/data", 1);
  for (const std::string name : {"rgb", "bgr"}) {
    const triad::Layout layout = triad::load_layout(name);
    EXPECT_EQ(layout.name, name);
    EXPECT_TRUE(layout.is_rows());
    EXPECT_EQ(layout.pixel_cells(), 3);
    EXPECT_EQ(layout.tile_cells(), 3);
    for (int o = 0; o < 3; ++o) {
      const triad::Emitter& emitter = layout.emitters[layout.emitter_of(o)];
      for (int d = 0; d < 3; ++d) EXPECT_EQ(emitter.primary[d], d == o);
      EXPECT_EQ(emitter.centre_x(), (name == "rgb" ? o : 2 - o) + .5);
      EXPECT_EQ(emitter.centre_y(), .5);
    }
  }
  EXPECT_THAT(triad::layout_names(), testing::UnorderedElementsAreArray(triad::reference::kLayoutNames));
  EXPECT_EQ(triad::load_layout(kFolder + "bgr.toml").name, "bgr");
}

TEST(Layout, ThoseThatAreNotStripesAreWhatTheirNamesSay) {
  using triad::reference::layout;
  EXPECT_FALSE(layout("vrgb").has_independent_rows());
  for (const char* name : {"vrgb", "vbgr"})
    for (int o = 0; o < 3; ++o) {
      const triad::Layout panel = layout(name);
      EXPECT_EQ(panel.emitters[panel.emitter_of(o)].centre_y(), (name[1] == 'r' ? o : 2 - o) + .5) << name;
    }
  for (const char* name : {"qd-oled", "qd-oled-fine"}) {
    const triad::Layout panel = layout(name);
    const double centres[3][2] = {{.25, .75}, {.5, .25}, {.75, .75}};  // of a pixel's width and height
    for (int o = 0; o < 3; ++o) {
      const triad::Emitter& emitter = panel.emitters[panel.emitter_of(o)];
      EXPECT_NEAR(emitter.centre_x() / panel.cells_x, centres[o][0], 1e-12) << name;
      EXPECT_NEAR(emitter.centre_y() / panel.cells_y, centres[o][1], 1e-12) << name;
    }
  }
  const triad::Layout white = layout("rwbg");
  EXPECT_TRUE(white.derives_white && white.has_independent_rows() && !white.is_rows());
  EXPECT_EQ(white.emitters[1].channel, triad::kWhiteChannel);
  EXPECT_EQ(layout("pentile-rgbg").emitters.size(), 8u);
  EXPECT_EQ(layout("rgb-delta").emitters[5].centre_x(), 8);  // in the next tile
}

TEST(Layout, TheBoxIsAPixelWideAroundTheEmitter) {
  const triad::Layout rgb = triad::load_layout(kFolder + "rgb.toml");
  for (int e = 0; e < 3; ++e) {
    const triad::BoxWindow box = triad::displaced_box(rgb, e);
    EXPECT_EQ(box.first_cell, e - 1);
    EXPECT_EQ(box.weights, std::vector<double>(3, 1. / 3));
  }
  // An emitter across two of four cells: its box starts in the middle of nothing, on a cell's edge.
  triad::Layout wide = rgb;
  wide.cells_x = 4;
  wide.emitters[0].cells = {{0, 0, .75}, {1, 0, .25}};
  const triad::BoxWindow box = triad::displaced_box(wide, 0);  // centre .75, from -1.25 to 2.75
  EXPECT_EQ(box.first_cell, -2);
  ASSERT_EQ(box.weights.size(), 5u);
  EXPECT_DOUBLE_EQ(box.weights[0], .25 / 4);
  EXPECT_DOUBLE_EQ(box.weights[1], .25);
  EXPECT_DOUBLE_EQ(box.weights[4], .75 / 4);
}

TEST(Layout, BadFilesGetAClearLine) {
  const auto error = [](const std::string& text) { return message_of([&] { triad::parse_layout(text, "x.toml"); }); };
  EXPECT_EQ(error(triad::read_text_file(kFolder + "rgb.toml")), "nothing was thrown");
  EXPECT_THAT(error("name = "), HasSubstr("layout 'x.toml': line 1"));
  EXPECT_THAT(error(""), HasSubstr("name must be a text"));
  EXPECT_THAT(error(with("tile_pixels", "tile_pixel")), HasSubstr("did you mean 'tile_pixels'?"));
  EXPECT_THAT(error(with("[3, 1]", "[3, 17]")), HasSubstr("1 to 16"));
  EXPECT_THAT(error(with("[3, 1]", "[3]")), HasSubstr("2 finite numbers"));
  EXPECT_THAT(error(with("[1, 0, 0]", "[1, nan, 0]")), HasSubstr("finite"));
  EXPECT_THAT(error(with("[1, 0, 0]", "[.5, 0, 0]")), HasSubstr("line"));
  EXPECT_THAT(error(with("[1, 0, 0]", "[0.5, 0, 0]")), HasSubstr("primaries sum to (0.5, 1, 1): each must be 1"));
  EXPECT_THAT(error(with("[0, 0, 1.0]", "[0, 0, 0.9]")), HasSubstr("sum to 0.9"));
  EXPECT_THAT(error(with("[[0, 0, 1.0]]", "[[0, 0, 0.5], [0, 0, 0.5]]")), HasSubstr("twice"));
  EXPECT_THAT(error(with("channel = \"r\"", "channel = \"w\"")), HasSubstr("\"r\", \"g\" or \"b\""));
  EXPECT_THAT(error(with("pixel = [0, 0]", "pixel = [1, 0]")), HasSubstr("pixel is 1"));
  // Two emitters of one channel; a colour that nothing gives; shares below zero; a tile of nothing; a million cells.
  EXPECT_THAT(error(with("channel = \"r\"", "channel = \"g\"")),
              HasSubstr("emitter 2: emitter 1 has the same pixel"));
  EXPECT_THAT(error(with("[1, 0, 0]", "[0, 0, 0]")), HasSubstr("primary is black"));
  EXPECT_THAT(error(with("[[0, 0, 1.0]]", "[[0, 0, 0.5], [3, 0, 0.5]]")), HasSubstr("the same emitter of the next"));
  std::string swapped = with("[1, 0, 0]", "[0, 2, 0]");  // then back, with red's and green's light exchanged
  swapped.replace(swapped.find("[0, 1, 0]"), 9, "[1, 0, 0]");
  swapped.replace(swapped.find("[0, 2, 0]"), 9, "[0, 1, 0]");
  EXPECT_THAT(error(swapped), HasSubstr("channel \"r\" drives emitters whose primaries sum to (0, 1, 0)"));
  EXPECT_THAT(error(with("[[0, 0, 1.0]]", "[[0, 0, 1.5], [1, 0, -0.5]]")),
              HasSubstr("share is -0.5: must be above 0"));
  EXPECT_THAT(error(with("tile_pixels = [1, 1]", "tile_pixels = [0, 1]")), HasSubstr("tile_pixels is 0"));
  EXPECT_THAT(error(with("[3, 1]", "[1000, 1000]")), HasSubstr("pixel_cells is 1000"));
  EXPECT_THAT(error(with("min(r, g, b)", "max(r, g, b)", "rwbg.toml")), HasSubstr("derive is 'w=max(r,g,b)'"));
  EXPECT_THAT(error(with("derive = ", "# ", "rwbg.toml")), HasSubstr("channel is 'w'"));
  EXPECT_THAT(error(with("[1, 1, 1]", "[1, 1, 0.9]", "rwbg.toml")), HasSubstr("the primary of w must be the sum"));
  EXPECT_THAT(error(with("channel = \"w\"", "channel = \"r\"", "rwbg.toml")), HasSubstr("same pixel and channel"));
  EXPECT_THAT(error("name='x'\nsummary='y'\npixel_cells=[1,1]\ntile_pixels=[1,1]\n"), HasSubstr("[[emitter]]"));
}

TEST(Layout, UnknownNamesGetTheNearest) {
  setenv("TRIAD_DATA", TRIAD_SOURCE_DIR "/data", 1);
  EXPECT_THAT(message_of([] { triad::load_layout("rbg"); }), HasSubstr("unknown layout 'rbg' (did you mean 'rgb'?)"));
  EXPECT_THAT(message_of([] { triad::load_layout("/nowhere/x.toml"); }), HasSubstr("/nowhere/x.toml"));
}

TEST(Layout, WhatIsNotStripesIsNotFilteredByRows) {
  triad::Layout layout = triad::load_layout(kFolder + "rgb.toml");
  layout.emitters[0].cells = {{-1, 0, 1}};
  EXPECT_THAT(message_of([&] { triad::FilterDesign(layout, triad::reference::observer(40), 4); }),
              HasSubstr("layout 'rgb' does not consist of vertical stripes"));
}

TEST(Vision, MatchesTheFormulasAtPointsWorkedOutByHand) {
  triad::Observer eye = triad::reference::observer(40);
  // Sums of the weights at 0.
  EXPECT_NEAR(triad::mtf(eye, 0, 0), 1.117686, 1e-15);
  EXPECT_NEAR(triad::mtf(eye, 1, 0), 1, 1e-15);
  EXPECT_NEAR(triad::mtf(eye, 2, 0), 1, 1e-15);
  // Where pi sigma f = 1 for the narrower Gaussian, the wider ones have exp(-(ratio of spreads)^2).
  EXPECT_NEAR(triad::mtf(eye, 0, 1 / (std::numbers::pi * .0283)),
              1.00327 * std::exp(-1) + .114416 * std::exp(-std::pow(.133 / .0283, 2)), 1e-14);
  EXPECT_NEAR(triad::mtf(eye, 1, 1 / (std::numbers::pi * .0392)), .6167 * std::exp(-1), 1e-10);
  EXPECT_NEAR(triad::mtf(eye, 2, 1 / (std::numbers::pi * .0536)), .5681 * std::exp(-1), 1e-10);
  EXPECT_EQ(triad::mtf(eye, 1, 1e6), 0);

  eye.csf = triad::Csf::kKolpatzikBouman;
  // .525 ln 11 + 3.91 = 5.16889...
  EXPECT_NEAR(triad::mtf(eye, 0, 5.168895), std::exp(-1), 1e-6);
  EXPECT_NEAR(triad::mtf(eye, 1, 1 / .419), std::exp(-1), 1e-15);
  EXPECT_EQ(triad::mtf(eye, 2, 3.), triad::mtf(eye, 1, 3.));
}

TEST(Vision, WhiteIsNearlyNeutralAndTheGainsAreApplied) {
  triad::Observer eye = triad::reference::observer(40);
  const auto gained = triad::opponent_matrix(eye);
  eye.gains = triad::ChannelGains::kRaw;
  const auto raw = triad::opponent_matrix(eye);
  for (int d = 0; d < 3; ++d) {
    EXPECT_EQ(gained[d], raw[d]);
    EXPECT_DOUBLE_EQ(gained[3 + d], 7.5 * raw[3 + d]);
    EXPECT_DOUBLE_EQ(gained[6 + d], 2.5 * raw[6 + d]);
  }
  // White is XYZ (.9505, 1, 1.089): .2787336*.9505 + .7218031 - .106552*1.089 and so on, by hand.
  EXPECT_NEAR(raw[0] + raw[1] + raw[2], .870705, 1e-6);
  EXPECT_NEAR(raw[3] + raw[4] + raw[5], -.052730, 1e-6);
  EXPECT_NEAR(raw[6] + raw[7] + raw[8], .037418, 1e-6);
  // Red is redder than green, blue bluer than yellow.
  EXPECT_LT(raw[3], raw[4]);
  EXPECT_GT(raw[8], raw[6] + raw[7]);
}

TEST(Vision, RefusesObserversThatSeeNothing) {
  for (const double ppd : {0., -1., .5, 20000., static_cast<double>(NAN)}) {
    const auto eye = triad::reference::observer(ppd);
    EXPECT_THROW(triad::check_observer(eye), triad::Error) << ppd;
  }
  auto eye = triad::reference::observer(40);
  eye.rgb_to_xyz = {1, 1, 1, 1, 1, 1, 1, 1, 1};
  EXPECT_THROW(triad::check_observer(eye), triad::Error);
}
