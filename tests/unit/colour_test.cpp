// SPDX-License-Identifier: Apache-2.0
// Colour against closed-form formulas and published matrices.
#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>
#include <triad/base/error.hpp>
#include <triad/colour/colour.hpp>
#include <triad/colour/internal/evaluator.hpp>

using testing::AllOf;
using testing::HasSubstr;
using triad::ColourConfig;
using triad::ColourTransform;

namespace {

// IEC 61966-2-1, 5.2, in more digits than we compute with.
double srgb_decode(long double v) {
  const long double a = std::abs(v);
  const long double light = a <= .04045L ? a / 12.92L : std::pow((a + .055L) / 1.055L, 2.4L);
  return static_cast<double>(std::copysign(light, v));
}
double srgb_encode(long double v) {
  const long double a = std::abs(v);
  const long double code = a <= .0031308L ? a * 12.92L : 1.055L * std::pow(a, 1 / 2.4L) - .055L;
  return static_cast<double>(std::copysign(code, v));
}

const ColourConfig& bundled() {
  static const ColourConfig config = ColourConfig::load(TRIAD_SOURCE_DIR "/data/colour/config.ocio");
  return config;
}

std::array<float, 3> through(const ColourTransform& transform, float r, float g, float b) {
  std::array<float, 3> rgb{r, g, b};
  transform.apply(rgb.data(), 1, 3, -1);
  return rgb;
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const triad::Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "";
}

void expect_matrix(const std::string& from, const std::string& to, const std::array<double, 9>& published,
                   double digit) {
  const auto transform = bundled().transform(from, to);
  for (int c = 0; c < 3; ++c) {
    const auto column = through(transform, c == 0, c == 1, c == 2);
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(column[i], published[i * 3 + c], digit) << from << " to " << to << " " << i << c;
  }
}

// A configuration in a file that goes away with it.
class ConfigFile {
 public:
  explicit ConfigFile(const std::string& spaces, const std::string& roles = "default: lin")
      : path_(std::filesystem::temp_directory_path() / ("triad-colour-" + std::to_string(getpid()) + ".ocio")) {
    std::ofstream(path_) << "ocio_profile_version: 2\nroles: {" << roles << "}\nfile_rules:\n"
                         << "  - !<Rule> {name: Default, colorspace: default}\ndisplays:\n"
                         << "  d:\n    - !<View> {name: v, colorspace: default}\ncolorspaces:\n"
                         << spaces;
  }
  ~ConfigFile() { std::filesystem::remove(path_); }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

const std::string kTwoSpaces =
    "  - !<ColorSpace> {name: lin, aliases: [Linear Rec.709 (sRGB)]}\n"
    "  - !<ColorSpace> {name: codes, aliases: [sRGB - Texture], to_reference: !<ExponentWithLinearTransform> "
    "{gamma: 2.4, offset: 0.055, style: mirror}}\n";

}  // namespace

TEST(ColourCurve, MatchesStdPow) {
  for (const double p : {2.4, 1 / 2.4, 2.2, 1 / 2.2, 1. / 3}) {
    const triad::colour::PowerTable power(p);
    for (double x = 1e-37; x < 1e38; x *= 1.0137) ASSERT_NEAR(power(x) / std::pow(x, p), 1, 2e-10) << x << "^" << p;
    // The edges of the intervals and of the table.
    for (int i = 0; i <= 64; ++i) ASSERT_NEAR(power(1 + i / 64.) / std::pow(1 + i / 64., p), 1, 2e-10);
    for (const double x : {1e-310, 1e-45, 1e300}) ASSERT_EQ(power(x), std::pow(x, p));
  }
}

TEST(Colour, SrgbIsTheStandardsFormula) {
  const auto decode = bundled().transform("sRGB", "Linear"), encode = bundled().transform("Linear", "sRGB");
  for (int i = -70000; i <= 200000; i += 7) {
    const float v = static_cast<float>(i) / 65535.f;
    const float light = through(decode, v, v, v)[1], code = through(encode, v, v, v)[2];
    // Half a unit in the last place of float, and 1e-9 for the power.
    ASSERT_NEAR(light, srgb_decode(v), 6.1e-8 * std::abs(srgb_decode(v)) + 1e-12) << v;
    ASSERT_NEAR(code, srgb_encode(v), 6.1e-8 * std::abs(srgb_encode(v)) + 1e-12) << v;
  }
}

TEST(Colour, SpecialValuesKeepTheirKind) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  for (const auto& [from, to] :
       {std::pair{"sRGB", "Linear"}, std::pair{"Linear", "sRGB"}, std::pair{"Linear", "rec2020_bt1886"}}) {
    const auto transform = bundled().transform(from, to);
    EXPECT_EQ(through(transform, 0, 0, 0), (std::array<float, 3>{0, 0, 0}));
    EXPECT_TRUE(std::isnan(through(transform, nan, 0, 0)[0]));
    const auto one = through(transform, 1, 1, 1);
    for (const float v : one) EXPECT_NEAR(v, 1, 2e-7);
  }
  EXPECT_EQ(through(bundled().transform("sRGB", "Linear"), inf, -inf, 1)[0], inf);
  EXPECT_EQ(through(bundled().transform("sRGB", "Linear"), inf, -inf, 1)[1], -inf);
  EXPECT_GT(through(bundled().transform("Linear", "sRGB"), 1e-40f, 0, 0)[0], 0);
}

TEST(Colour, DisplayCurvesOfWideGamuts) {
  const auto rec2020 = bundled().transform("rec2020_bt1886", "lin_rec2020");
  const auto p3 = bundled().transform("display_p3", "lin_p3d65");
  for (float v = -1; v < 2; v += .013f) {
    ASSERT_NEAR(through(rec2020, v, 0, .5f)[0], std::copysign(std::pow(std::abs(double{v}), 2.4), v),
                2e-7 * std::pow(std::abs(v), 2.4) + 1e-12);
    ASSERT_NEAR(through(p3, .5f, v, 0)[1], srgb_decode(v), 1.3e-7 * std::abs(srgb_decode(v)) + 1e-12);
  }
}

TEST(Colour, MatricesAreThePublishedOnes) {
  // ITU-R BT.2087-0 (inverse of its M2), four digits.
  expect_matrix("lin_rec2020", "lin_rec709", {1.6605, -.5876, -.0728, -.1246, 1.1329, -.0083, -.0182, -.1006, 1.1187},
                6e-5);
  // AMPAS ACES transforms, AP1 and AP0 to Rec.709 with Bradford adaptation, five digits.
  expect_matrix("acescg", "lin_rec709",
                {1.70505, -.62179, -.08326, -.13026, 1.14080, -.01055, -.02400, -.12897, 1.15297}, 6e-6);
  expect_matrix("aces2065_1", "lin_rec709",
                {2.52169, -1.13413, -.38756, -.27648, 1.37272, -.09624, -.01538, -.15298, 1.16835}, 6e-6);
  // AP0 to AP1 has the same white and so no adaptation: AMPAS TB-2014-004, ten digits there.
  expect_matrix("aces2065_1", "acescg",
                {1.4514393161, -.2365107469, -.2149285693, -.0765537734, 1.1762296998, -.0996759264, .0083161484,
                 -.0060324498, .9977163014},
                3e-7);

  const std::array<double, 9> srgb{.4124, .3576, .1805, .2126, .7152, .0722, .0193, .1192, .9505};  // IEC 61966-2-1
  const std::array<double, 9> p3{.48657, .26567, .19822, .22897, .69174,
                                 .07929, 0,      .04511, 1.04394};  // SMPTE EG 432-1
  const std::array<double, 3> bt2020_luma{.2627, .6780, .0593};     // ITU-R BT.2020-2, table 4
  for (int i = 0; i < 9; ++i) {
    EXPECT_NEAR(triad::rec709_to_xyz()[i], srgb[i], 6e-5);
    EXPECT_NEAR(bundled().rgb_to_xyz("lin_rec709")[i], triad::rec709_to_xyz()[i], 1e-15);
    EXPECT_NEAR(bundled().rgb_to_xyz("lin_p3d65")[i], p3[i], 6e-6);
  }
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(bundled().rgb_to_xyz("lin_rec2020")[3 + i], bt2020_luma[i], 6e-5);
}

TEST(Colour, EveryLinearSpaceHasTheSameWhite) {
  for (const auto& name : bundled().names()) {
    if (!bundled().is_linear(name)) continue;
    const auto m = bundled().rgb_to_xyz(name);
    EXPECT_NEAR(m[0] + m[1] + m[2], .3127 / .3290, 1e-12) << name;
    EXPECT_NEAR(m[3] + m[4] + m[5], 1, 1e-12) << name;
    EXPECT_NEAR(m[6] + m[7] + m[8], (1 - .3127 - .3290) / .3290, 1e-12) << name;
  }
}

TEST(Colour, RoundTripsBetweenAllSpaces) {
  const auto names = bundled().names();
  for (const auto& from : names)
    for (const auto& to : names) {
      if (bundled().is_data(from) || bundled().is_data(to)) continue;
      const auto there = bundled().transform(from, to), back = bundled().transform(to, from);
      EXPECT_EQ(there.identity(), from == to);
      float pixels[] = {.1f, .7f, .4f, .9f, .02f, .3f, .5f, .5f, .5f, .03f, .03f, 1};
      const std::vector<float> before(std::begin(pixels), std::end(pixels));
      there.apply(pixels, 4, 3, -1);
      back.apply(pixels, 4, 3, -1);
      for (size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(pixels[i], before[i], 3e-6) << from << " to " << to;
    }
}

TEST(Colour, AlphaIsDividedOutOfCurvesOnly) {
  const auto encode = bundled().transform("Linear", "sRGB"), matrix = bundled().transform("acescg", "Linear");
  ASSERT_FALSE(encode.identity());
  // Five channels: colour, something, alpha; the something stays.
  float pixels[] = {.1f, .2f, .05f, 7, .5f, .1f, .2f, .05f, 7, 0, .1f, .2f, .05f, 7, 1};
  encode.apply(pixels, 3, 5, 4);
  const float colour[] = {.1f, .2f, .05f};
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(pixels[c], srgb_encode(colour[c] / .5L) * .5, 5e-8);
    EXPECT_NEAR(pixels[5 + c], srgb_encode(colour[c]), 5e-8);
    EXPECT_NEAR(pixels[10 + c], srgb_encode(colour[c]), 5e-8);
  }
  for (int i = 0; i < 3; ++i) EXPECT_EQ(pixels[i * 5 + 3], 7);
  EXPECT_EQ(pixels[4], .5f);
  float with[] = {.1f, .2f, .05f, .3f};
  matrix.apply(with, 1, 4, 3);
  const auto without = through(matrix, .1f, .2f, .05f);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(with[c], without[c]);
}

TEST(Colour, NamesAliasesAndRoles) {
  const auto& config = bundled();
  EXPECT_EQ(config.lin_rec709(), "lin_rec709");
  EXPECT_EQ(config.srgb(), "srgb");
  for (const char* name :
       {"Linear", "linear", "lin_srgb", "scene_linear", "Rec709", "Utility - Linear - sRGB", "default"})
    EXPECT_EQ(config.resolve(name), "lin_rec709") << name;
  for (const char* name : {"sRGB", "SRGB", "sRGB - Texture", "color_picking"})
    EXPECT_EQ(config.resolve(name), "srgb") << name;
  EXPECT_EQ(config.resolve("ACES - ACEScg"), "acescg");
  EXPECT_EQ(config.resolve("ACES2065-1"), "aces2065_1");
  EXPECT_EQ(config.resolve("nonsense"), "");
  EXPECT_EQ(config.resolve(""), "");
  EXPECT_THAT(error_of([&] { config.require("acesgc", "--from"); }),
              AllOf(HasSubstr("--from"), HasSubstr("did you mean 'acescg'?")));
  EXPECT_THROW(config.transform("lin_rec709", "nonsense"), triad::Error);
  EXPECT_TRUE(config.transform("sRGB", "srgb_texture").identity());
  EXPECT_TRUE(config.is_data("raw"));
  EXPECT_FALSE(config.is_linear("raw"));
  EXPECT_TRUE(config.transform("raw", "srgb").identity());
  EXPECT_EQ(config.linear_sibling("srgb"), "lin_rec709");
  EXPECT_EQ(config.linear_sibling("display_p3"), "lin_p3d65");
  EXPECT_EQ(config.linear_sibling("rec2020_bt1886"), "lin_rec2020");
  EXPECT_EQ(config.linear_sibling("acescg"), "acescg");
  EXPECT_THAT(config.origin(), HasSubstr("config.ocio"));
}

TEST(Colour, ChromaticitiesFindTheirSpace) {
  const auto& config = bundled();
  const std::pair<const char*, std::array<float, 8>> published[] = {
      {"lin_rec709", {.64f, .33f, .30f, .60f, .15f, .06f, .3127f, .3290f}},
      {"lin_p3d65", {.68f, .32f, .265f, .69f, .15f, .06f, .3127f, .3290f}},
      {"lin_rec2020", {.708f, .292f, .17f, .797f, .131f, .046f, .3127f, .3290f}},
      {"acescg", {.713f, .293f, .165f, .83f, .128f, .044f, .32168f, .33767f}},
      {"aces2065_1", {.7347f, .2653f, 0, 1, .0001f, -.077f, .32168f, .33767f}}};
  for (const auto& [name, xy] : published) {
    EXPECT_EQ(config.match_chromaticities(xy), name);
    const auto stated = config.chromaticities(name);
    for (int i = 0; i < 8; ++i) EXPECT_NEAR(stated[i], xy[i], 1e-7) << name;
    auto other = xy;
    other[2] += .01f;
    EXPECT_EQ(config.match_chromaticities(other), "");
  }
  EXPECT_EQ(config.match_chromaticities({}), "");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(config.match_chromaticities({nan, nan, nan, nan, nan, nan, nan, nan}), "");
}

TEST(Colour, AUsersConfiguration) {
  const ConfigFile file(kTwoSpaces +
                        "  - !<ColorSpace> {name: log, to_reference: !<LogTransform> {base: 2, direction: inverse}}\n"
                        "  - !<ColorSpace> {name: half, to_reference: !<MatrixTransform> {matrix: [.5, 0, 0, 0, 0, "
                        ".5, 0, 0, 0, 0, .5, 0, 0, 0, 0, 1]}}\n");
  const auto config = ColourConfig::load(file.path());
  EXPECT_EQ(config.lin_rec709(), "lin");
  EXPECT_EQ(config.srgb(), "codes");
  EXPECT_EQ(config.resolve("Linear"), "lin");
  EXPECT_EQ(config.resolve("lin_rec709"), "lin");
  EXPECT_EQ(config.resolve("sRGB"), "codes");
  EXPECT_EQ(config.origin(), file.path());
  EXPECT_NEAR(through(config.transform("codes", "lin"), .5f, 0, 0)[0], srgb_decode(.5), 2e-8);
  EXPECT_FALSE(config.is_linear("log"));
  EXPECT_TRUE(config.is_linear("half"));
  // OpenColorIO's own processor does this one: light is 2 to the power of the code.
  const auto decode = config.transform("log", "lin");
  float pixels[8] = {-1, -2, -3, .5f, -1, -2, -3, 0};
  decode.apply(pixels, 2, 4, 3);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(pixels[c], std::exp2(-(c + 1) / .5) * .5, 1e-6);
    EXPECT_NEAR(pixels[4 + c], std::exp2(-(c + 1.)), 1e-6);
  }
  // Many pixels at once are the same as one by one.
  std::vector<float> many(10000 * 3), single;
  for (size_t i = 0; i < many.size(); ++i) many[i] = -static_cast<float>(i % 997) / 100;
  single = many;
  decode.apply(many.data(), 10000, 3, -1);
  for (size_t i = 0; i < 10000; ++i) decode.apply(single.data() + i * 3, 1, 3, -1);
  EXPECT_EQ(many, single);
}

TEST(Colour, ConfigurationsThatWillNotDo) {
  const auto load_error = [](const std::string& path) { return error_of([&] { ColourConfig::load(path); }); };
  EXPECT_THAT(load_error("/nowhere/config.ocio"), HasSubstr("/nowhere/config.ocio"));
  EXPECT_THAT(load_error("/tmp"), HasSubstr("is a folder"));
  const ConfigFile without("  - !<ColorSpace> {name: lin}\n");
  EXPECT_THAT(load_error(without.path()),
              AllOf(HasSubstr(without.path()), HasSubstr("no linear Rec.709"), HasSubstr("alias")));
  const ConfigFile linear_only("  - !<ColorSpace> {name: lin, aliases: [lin_srgb]}\n");
  EXPECT_THAT(load_error(linear_only.path()), HasSubstr("no sRGB"));
  std::ofstream(linear_only.path()) << "ocio_profile_version: 2\nroles: [";
  EXPECT_THAT(load_error(linear_only.path()), HasSubstr(linear_only.path()));
}

TEST(Colour, TheEnvironmentNamesAConfiguration) {
  const ConfigFile file(kTwoSpaces);
  setenv("OCIO", file.path().c_str(), 1);
  EXPECT_EQ(ColourConfig::load().origin(), file.path());
  EXPECT_EQ(ColourConfig::load(TRIAD_SOURCE_DIR "/data/colour/config.ocio").lin_rec709(), "lin_rec709");
  setenv("OCIO", "", 1);
  EXPECT_THAT(ColourConfig::load().origin(), HasSubstr("data/colour/config.ocio"));
  unsetenv("OCIO");
}

TEST(Colour, OneConfigurationServesManyThreads) {
  const auto config = ColourConfig::load(TRIAD_SOURCE_DIR "/data/colour/config.ocio");
  const auto names = config.names();
  std::vector<std::thread> threads;
  std::vector<double> sums(4);
  for (size_t t = 0; t < sums.size(); ++t)
    threads.emplace_back([&, t] {
      for (const auto& from : names)
        for (const auto& to : names) sums[t] += through(config.transform(from, to), .2f, .5f, .7f)[1];
    });
  for (auto& thread : threads) thread.join();
  for (const double sum : sums) EXPECT_EQ(sum, sums[0]);
}
