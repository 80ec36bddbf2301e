// SPDX-License-Identifier: Apache-2.0
// Scenes in a plane before black, seen without perspective. One unit is one pixel of a 400 x 225 picture, origin in
// the middle; all is unlit, so that every value lies in [0, 1] and a coverage is a value.
#include "shapes.hpp"

namespace make_scenes {
namespace {

constexpr double kHalfWidth = 200, kHalfHeight = 112.5;

struct Inks {
  int white, red, amber, green, cyan, blue;
  explicit Inks(Gltf& gltf)
      : white(gltf.unlit("white", {1, 1, 1})),
        red(gltf.unlit("red", {1, .08, .05})),
        amber(gltf.unlit("amber", {1, .55, .04})),
        green(gltf.unlit("green", {.1, .9, .2})),
        cyan(gltf.unlit("cyan", {.06, .8, 1})),
        blue(gltf.unlit("blue", {.15, .25, 1})) {}
  int coloured(int i) const {
    const int list[] = {red, amber, green, cyan, blue};
    return list[i % 5];
  }
};

void finish(Gltf& gltf, const std::string& path) {
  gltf.orthographic(kHalfHeight, kHalfWidth);
  gltf.save(path);
}

// Strokes at every angle: two fans that end before their strokes merge, half a pixel to two pixels wide.
void strokes(const std::string& folder) {
  Gltf gltf("Two fans of strokes, half a pixel to two pixels wide, before black");
  const Inks inks(gltf);
  Shape left;
  for (int i = 0; i < 72; ++i) {
    const double a = 2 * kPi * (i + .37) / 72, c = std::cos(a), s = std::sin(a), inner = 26 + 8 * (i % 2);
    left.add(stroke(-95 + inner * c, inner * s, -95 + 92 * c, 92 * s, .5 + .5 * (i % 4)));
  }
  gltf.place("white fan", left, inks.white);
  for (int colour = 0; colour < 5; ++colour) {
    Shape right;
    for (int i = colour; i < 60; i += 5) {
      const double a = 2 * kPi * (i + .19) / 60, c = std::cos(a), s = std::sin(a);
      right.add(stroke(100 + 24 * c, 24 * s, 100 + 90 * c, 90 * s, 1.3));
    }
    gltf.place("coloured fan", right, inks.coloured(colour));
  }
  finish(gltf, folder + "high-contrast-1.gltf");
}

// Discs of 1 to 40 pixels across, rings around some of them.
void discs(const std::string& folder) {
  Gltf gltf("Discs of 1 to 40 pixels across and thin rings before black");
  const Inks inks(gltf);
  Shape discs, rings;
  double x = -188;
  for (int i = 0; i < 14; ++i) {
    const double radius = .5 + i * i * .115;
    x += radius + 4;
    discs.add(ring(x, 62.3 - .31 * i, 0, radius, 64));
    x += radius + 4;
  }
  for (int i = 0; i < 16; ++i) rings.add(ring(-110, -38, 4 + 4 * i, 4 + 4 * i + .3 + .1 * i, 128));
  gltf.place("discs", discs, inks.white);
  gltf.place("rings", rings, inks.white);
  for (int colour = 0; colour < 5; ++colour) {
    Shape dots;
    for (int i = 0; i < 96; ++i)
      if (i % 5 == colour) {
        const double a = 2.39996323 * i, r = 7 * std::sqrt(i + .5);  // the golden angle: an even sunflower
        dots.add(ring(90 + r * std::cos(a), -38 + r * std::sin(a), 0, 1 + .02 * i, 32));
      }
    gltf.place("dots", dots, inks.coloured(colour));
  }
  finish(gltf, folder + "high-contrast-2.gltf");
}

// A grid turned by 7 degrees: the slow beat of its lines against the pixels.
void grid(const std::string& folder) {
  Gltf gltf("A grid of lines one pixel wide, eight pixels apart, turned by 7 degrees, before black");
  const Inks inks(gltf);
  Shape lines;
  for (int i = -10; i <= 10; ++i) {
    lines.add(stroke(8 * i, -86, 8 * i, 86, 1));
    lines.add(stroke(-86, 8 * i, 86, 8 * i, 1));
  }
  gltf.place("grid", lines, inks.white, {{"translation", {-98, 0, 0}}, {"rotation", turn({0, 0, 1}, 7 * kPi / 180)}});
  Shape squares;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j)
      if ((i + j) % 2 == 0) {
        const double x = (i - 6) * 13, y = (j - 6) * 13;
        squares.quad({x, y, 0}, {x + 13, y, 0}, {x + 13, y + 13, 0}, {x, y + 13, 0});
      }
  gltf.place("squares", squares, inks.white,
             {{"translation", {98, 0, 0}}, {"rotation", turn({0, 0, 1}, 7 * kPi / 180)}});
  finish(gltf, folder + "high-contrast-3.gltf");
}

// Lines nearly upright and nearly level, ever thinner, and bars ever closer.
void thin_lines(const std::string& folder) {
  Gltf gltf("Lines from two pixels to a sixteenth of a pixel wide, nearly upright and nearly level, and a sweep");
  const Inks inks(gltf);
  Shape upright, level, sweep;
  for (int i = 0; i < 24; ++i) {
    const double width = 2 * std::pow(1. / 32, i / 23.), x = -190 + 8 * i;
    upright.add(stroke(x, -20, x + 5, 105, width));
    level.add(stroke(12, 105 - 5.3 * i, 192, 101 - 5.2 * i, width));
  }
  double pitch = 8;
  for (double x = -190; x < 190; x += pitch, pitch = std::max(1., pitch * .975))
    sweep.quad({x, -105, 0}, {x + pitch / 2, -105, 0}, {x + pitch / 2, -40, 0}, {x, -40, 0});
  gltf.place("upright", upright, inks.white);
  gltf.place("level", level, inks.white);
  gltf.place("sweep", sweep, inks.white);
  finish(gltf, folder + "thin-lines.gltf");
}

// Letters of several heights, level and at angles.
void letters(const std::string& folder) {
  Gltf gltf("Text of strokes, 5 to 16 pixels high, level and turned");
  const Inks inks(gltf);
  const std::string fox = "THE QUICK BROWN FOX JUMPS OVER THE LAZY DOG";
  Shape white, coloured;
  const double heights[] = {9.4, 8, 6.5, 5};
  double y = 92;
  for (const double height : heights) {
    white.add(text(fox, -192, y, height, height * .13));
    y -= height + 8;
  }
  white.add(text("0123456789", -192, y - 14, 16, 1.6));
  for (int i = 0; i < 24; ++i) {
    const double a = 2 * kPi * i / 24 + .05;
    (i % 2 == 0 ? white : coloured)
        .add(text("EVERY ANGLE", 115 + 21 * std::cos(a), -34 + 21 * std::sin(a), 4.6, .75, a));
  }
  for (int i = 0; i < 5; ++i)
    white.add(text("A STROKE IS A BARGAIN", -188 + 2 * i, -34 - 16 * i, 8, 1, (2 * i - 6) * kPi / 180));
  gltf.place("white", white, inks.white);
  gltf.place("coloured", coloured, inks.amber);
  finish(gltf, folder + "text.gltf");
}

}  // namespace

void make_flat_scenes(const std::string& folder) {
  strokes(folder);
  discs(folder);
  grid(folder);
  thin_lines(folder);
  letters(folder);
}

}  // namespace make_scenes
