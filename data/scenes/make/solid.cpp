// SPDX-License-Identifier: Apache-2.0
// Scenes in space, each for one effect. Metres.
#include <algorithm>

#include "shapes.hpp"

namespace make_scenes {
namespace {

// A floor of 2 n x 2 n tiles of 0.5 m, in two shapes.
void checker_floor(Gltf& gltf, int n, int light, int dark) {
  Shape tiles[2];
  for (int i = -n; i < n; ++i)
    for (int j = -n; j < n; ++j) {
      const double x = .5 * i, z = .5 * j;
      tiles[(i + j) & 1].quad({x, 0, z + .5}, {x + .5, 0, z + .5}, {x + .5, 0, z}, {x, 0, z});
    }
  gltf.place("light tiles", tiles[0], light);
  gltf.place("dark tiles", tiles[1], dark);
}

// A lamp of width x depth facing down.
Shape ceiling_lamp(double width, double depth) {
  Shape shape;
  shape.quad({-width / 2, 0, -depth / 2}, {width / 2, 0, -depth / 2}, {width / 2, 0, depth / 2},
             {-width / 2, 0, depth / 2});
  return shape;
}

// A bright wheel before black: thin spokes in space, lit from one side.
void wheel(const std::string& folder) {
  Gltf gltf("A wheel with thin spokes before black, lit by one direction of light");
  const int white = gltf.diffuse("enamel", {.9, .9, .9}), red = gltf.diffuse("tyre", {.8, .12, .08});
  gltf.place("tyre", torus(1, .05, 192, 24), red, {{"rotation", turn({0, 1, 0}, .5)}});
  Shape spokes = torus(.93, .015, 192, 12);
  for (int i = 0; i < 36; ++i) {  // crossed, as on a bicycle
    const double a = 2 * kPi * i / 36, b = a + (i % 2 == 0 ? 1.2 : -1.2);
    spokes.add(rod({.1 * std::cos(b), .1 * std::sin(b), i % 4 < 2 ? .06 : -.06},
                   {.93 * std::cos(a), .93 * std::sin(a), 0}, .0045, 12));
  }
  spokes.add(rod({0, 0, -.12}, {0, 0, .12}, .1, 48));
  gltf.place("spokes", spokes, white, {{"rotation", turn({0, 1, 0}, .5)}});
  gltf.light("sun", {{"type", "directional"}, {"intensity", 3}}, {{"rotation", turn({1, -1, 0}, .6)}});
  gltf.perspective({0, 0, 4.2}, {0, 0, 0}, .56);
  gltf.save(folder + "high-contrast-4.gltf");
}

// The classic box, made regular: 2 m wide, high and deep, centre of the floor at the origin, open in front
// (z = +1). The lamp, 0.5 x 0.5 m of radiance 15, hangs 1 mm below the ceiling. Blocks: 0.6 x 0.6 x 0.6 m turned by
// -17 degrees at (0.35, 0, 0.35), 0.6 x 1.2 x 0.6 m turned by 18 degrees at (-0.35, 0, -0.3). Camera at (0, 1, 4.9),
// 30 degrees high. All is diffuse.
void cornell(const std::string& folder) {
  Gltf gltf("The classic box, made regular: 2 m on each side, diffuse, one lamp of 0.5 m x 0.5 m and radiance 15");
  const int white = gltf.diffuse("white", {.73, .73, .73}), red = gltf.diffuse("red", {.65, .05, .05}),
            green = gltf.diffuse("green", {.12, .45, .15}), lamp = gltf.lamp("lamp", {15, 15, 15});
  Shape walls, left, right;
  walls.quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1});
  walls.quad({-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1});
  walls.quad({-1, 0, -1}, {1, 0, -1}, {1, 2, -1}, {-1, 2, -1});
  left.quad({-1, 0, 1}, {-1, 0, -1}, {-1, 2, -1}, {-1, 2, 1});
  right.quad({1, 0, -1}, {1, 0, 1}, {1, 2, 1}, {1, 2, -1});
  gltf.place("walls", walls, white);
  gltf.place("left wall", left, red);
  gltf.place("right wall", right, green);
  gltf.place("short block", box({.6, .6, .6}), white,
             {{"translation", {.35, .3, .35}}, {"rotation", turn({0, 1, 0}, -17 * kPi / 180)}});
  gltf.place("tall block", box({.6, 1.2, .6}), white,
             {{"translation", {-.35, .6, -.3}}, {"rotation", turn({0, 1, 0}, 18 * kPi / 180)}});
  gltf.place("lamp", ceiling_lamp(.5, .5), lamp, {{"translation", {0, 1.999, 0}}});
  gltf.perspective({0, 1, 4.9}, {0, 1, 0}, 30 * kPi / 180);
  gltf.save(folder + "cornell.gltf");
}

// A floor of squares to the horizon: the test of every antialiasing method.
void checker_horizon(const std::string& folder) {
  Gltf gltf("Black and white squares of 1 m from under the eye to a horizon 2 km away");
  const int checker = gltf.texture(2, 2, std::string("\xff\xff\xff\0\0\0\0\0\0\xff\xff\xff", 12), true);
  const int floor = gltf.material("checker", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", checker}}}}},
                                              {"extensions", {{"KHR_materials_unlit", json::object()}}}});
  Shape shape;
  shape.has_uv = true;
  constexpr double kFar = 2000;  // metres; coordinates of the texture run once in 2 m
  shape.quad({-kFar, 0, kFar}, {kFar, 0, kFar}, {kFar, 0, -kFar}, {-kFar, 0, -kFar}, 16, 16);
  for (auto& uv : shape.uvs) uv = {uv[0] * kFar, uv[1] * kFar};
  gltf.place("floor", shape, floor, {{"rotation", turn({0, 1, 0}, .3)}});
  gltf.background({.35, .55, .9});
  gltf.perspective({0, 1.6, 0}, {0, 1.1, -4}, .8);
  gltf.save(folder + "checker-horizon.gltf");
}

void glass(const std::string& folder) {
  Gltf gltf("A ball, a hollow ball and a prism of glass on a floor of squares under a lamp");
  const int pale = gltf.diffuse("pale", {.75, .75, .72}), dark = gltf.diffuse("dark", {.1, .12, .2});
  const int clear = gltf.material(
      "glass",
      {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
       {"extensions",
        {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}, {"KHR_materials_ior", {{"ior", 1.5}}}}}});
  checker_floor(gltf, 10, pale, dark);
  gltf.place("ball", sphere(.5, 128, 64), clear, {{"translation", {-.75, .505, 0}}});
  Shape shell = sphere(.4, 128, 64), inside = sphere(.34, 128, 64);
  for (Vec& normal : inside.normals) normal = -1 * normal;
  for (size_t i = 0; i < inside.indices.size(); i += 3) std::swap(inside.indices[i + 1], inside.indices[i + 2]);
  shell.add(inside);
  gltf.place("hollow ball", shell, clear, {{"translation", {.45, .405, .45}}});
  gltf.place("prism", box({.5, .9, .5}), clear,
             {{"translation", {.6, .455, -.7}}, {"rotation", turn({0, 1, 0}, .5)}});
  gltf.place("lamp", ceiling_lamp(1.2, 1.2), gltf.lamp("lamp", {14, 13, 12}), {{"translation", {-.5, 3, .5}}});
  gltf.background({.35, .4, .5});
  gltf.perspective({.2, 1.5, 4}, {0, .42, 0}, .55);
  gltf.save(folder + "glass.gltf");
}

void mirror(const std::string& folder) {
  Gltf gltf("Balls from mirror to brushed metal on squares, before a flat mirror");
  const int pale = gltf.diffuse("pale", {.75, .72, .68}), dark = gltf.diffuse("dark", {.25, .06, .05});
  checker_floor(gltf, 10, pale, dark);
  const Shape ball = sphere(.42, 128, 64);
  const double roughness[] = {0, .15, .3, .5};
  const Vec colours[] = {{.97, .97, .97}, {1, .77, .34}, {.95, .64, .54}, {.6, .6, .65}};  // silver, gold, copper
  for (int i = 0; i < 4; ++i)
    gltf.place("ball " + std::to_string(i), ball, gltf.metal("metal " + std::to_string(i), colours[i], roughness[i]),
               {{"translation", {-1.5 + i, .42, .1 * i}}});
  Shape pane;
  pane.quad({-2.2, .02, 0}, {2.2, .02, 0}, {2.2, 1.7, 0}, {-2.2, 1.7, 0});
  gltf.place("flat mirror", pane, gltf.metal("mirror", {.95, .95, .95}, 0), {{"translation", {0, 0, -1.3}}});
  gltf.place("lamp", ceiling_lamp(1.5, 1.5), gltf.lamp("lamp", {10, 10, 9.5}), {{"translation", {.5, 3, 1}}});
  gltf.background({.3, .4, .6});
  gltf.perspective({0, 1.5, 4.6}, {0, .45, 0}, .55);
  gltf.save(folder + "mirror.gltf");
}

void depth_of_field(const std::string& folder) {
  Gltf gltf("Balls and small lamps from 2 m to 40 m; sharp at 4 m through a lens 8 cm across");
  const int pale = gltf.diffuse("pale", {.6, .6, .6}), dark = gltf.diffuse("dark", {.12, .12, .14});
  checker_floor(gltf, 20, pale, dark);
  const int red = gltf.diffuse("red", {.7, .1, .08}), blue = gltf.diffuse("blue", {.1, .2, .7});
  const Shape ball = sphere(.25, 96, 48);
  for (int i = 0; i < 7; ++i)
    gltf.place("ball " + std::to_string(i), ball, i % 2 == 0 ? red : blue,
               {{"translation", {-1.1 + .42 * i, .25, 3.2 - 1.1 * i}}});
  const int bulb = gltf.lamp("bulb", {60, 45, 25});
  const int mesh = gltf.mesh("bulb", sphere(.03, 24, 12), bulb);
  for (int i = 0; i < 24; ++i)
    gltf.node("bulb " + std::to_string(i), mesh,
              {{"translation", {-9 + .8 * i, 1.2 + .9 * std::sin(2.3 * i), -12. - (i * 7 % 10)}}});
  gltf.background({.12, .14, .2});
  gltf.light("moon", {{"type", "directional"}, {"intensity", 1.5}}, {{"rotation", turn({1, .5, 0}, -.9)}});
  gltf.perspective({0, .9, 5}, {0, .35, 1}, .6, {{"aperture_radius_m", .04}, {"focus_distance_m", 4}});
  gltf.save(folder + "depth-of-field.gltf");
}

void motion(const std::string& folder) {
  Gltf gltf("A ball in flight and a turning propeller; the shutter is open for 1/50 s");
  const int pale = gltf.diffuse("pale", {.7, .7, .7}), dark = gltf.diffuse("dark", {.2, .22, .25});
  checker_floor(gltf, 8, pale, dark);
  const int red = gltf.diffuse("red", {.8, .1, .06}), white = gltf.diffuse("white", {.85, .85, .85});
  gltf.place("resting ball", sphere(.3, 96, 48), white, {{"translation", {-1.4, .3, .3}}});
  const int flying = gltf.place("flying ball", sphere(.22, 96, 48), red);
  gltf.animate(flying, "translation", {0, .1}, {-1.2, .8, .9, 1.3, 1.4, .9}, 3);  // 25 m/s to the right
  Shape blades;
  for (int i = 0; i < 3; ++i) {
    const double a = 2 * kPi * i / 3, c = std::cos(a), s = std::sin(a);
    const Vec out{c, s, 0}, side{-s, c, 0}, thick{0, 0, .02};
    const Vec p = .1 * out - .09 * side, q = .75 * out - .12 * side, r = .75 * out + .12 * side,
              t = .1 * out + .09 * side;
    blades.quad(p + thick, q + thick, r + thick, t + thick);
    blades.quad(t - thick, r - thick, q - thick, p - thick);
  }
  blades.add(sphere(.13, 48, 24));
  const int propeller = gltf.place("propeller", blades, white, {{"translation", {1.35, 1.1, -.4}}});
  std::vector<double> times, turns;
  for (int i = 0; i <= 8; ++i) {  // 5 turns a second, in key frames a quarter turn apart
    times.push_back(.05 * i);
    turns.insert(turns.end(), {0, 0, std::sin(kPi * i / 4), std::cos(kPi * i / 4)});
  }
  gltf.animate(propeller, "rotation", times, turns, 4);
  gltf.place("lamp", ceiling_lamp(2, 2), gltf.lamp("lamp", {7, 7, 6.8}), {{"translation", {0, 3.5, 1}}});
  gltf.background({.4, .45, .55});
  gltf.perspective({0, 1.3, 4.5}, {0, .7, 0}, .6, {{"shutter_s", {.03, .05}}});
  gltf.save(folder + "motion.gltf");
}

// A card of 64 x 64 pixels: ramps, squares of 1 to 8 pixels, a frame.
std::string test_card() {
  std::string pixels;
  const auto put = [&pixels](int r, int g, int b) {
    for (const int v : {r, g, b}) pixels += static_cast<char>(v);
  };
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const int size = 1 << (x / 16), level = (x / size + y / size) % 2 == 0 ? 235 : 20;
      if (x == 0 || y == 0 || x == 63 || y == 63) {
        put(255, 255, 255);
      } else if (y < 32) {
        put(level, level, level);
      } else if (y < 48) {
        put(x * 4, x * 4, x * 4);
      } else {
        put(x * 4, 255 - x * 4, (y - 48) * 16);
      }
    }
  return pixels;
}

void texture(const std::string& folder) {
  Gltf gltf("A test card, near and far, smooth and sharp, repeated and mirrored; leaves cut out by alpha");
  const std::string card = test_card();
  std::string leaf;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      const double u = (x - 15.5) / 16, v = (y - 15.5) / 16, width = .55 * (1 - v * v);
      const bool vein = std::abs(u) < .05;
      leaf += static_cast<char>(vein ? 150 : 40);
      leaf += static_cast<char>(vein ? 200 : 120);
      leaf += static_cast<char>(40);
      leaf += static_cast<char>(std::abs(u) < width ? 255 : 0);
    }
  constexpr int kMirror = 33648;
  const int smooth = gltf.texture(64, 64, card, false), sharp = gltf.texture(64, 64, card, true),
            mirrored = gltf.texture(64, 64, card, false, kMirror), leaves = gltf.texture(32, 32, leaf, false, 33071);
  const auto printed = [&gltf](const char* name, int index, json transform) {
    json use = {{"index", index}};
    if (!transform.empty()) {
      gltf.require("KHR_texture_transform");
      use["extensions"]["KHR_texture_transform"] = std::move(transform);
    }
    return gltf.material(
        name, {{"pbrMetallicRoughness", {{"baseColorTexture", use}, {"metallicFactor", 0}, {"roughnessFactor", 1}}},
               {"extensions", {{"KHR_materials_ior", {{"ior", 1}}}}}});
  };
  Shape floor, panel;
  floor.has_uv = panel.has_uv = true;
  floor.quad({-6, 0, 4}, {6, 0, 4}, {6, 0, -20}, {-6, 0, -20});
  panel.quad({-.5, 0, 0}, {.5, 0, 0}, {.5, 1, 0}, {-.5, 1, 0});
  gltf.place("floor", floor, printed("floor", smooth, {{"scale", {12, 24}}}));
  gltf.place("sharp card", panel, printed("sharp card", sharp, json::object()), {{"translation", {-1.3, .05, 0}}});
  gltf.place("mirrored card", panel, printed("mirrored card", mirrored, {{"scale", {2, 2}}}),
             {{"translation", {-.35, .05, -.2}}, {"rotation", turn({0, 1, 0}, .3)}});
  gltf.place("turned card", panel,
             printed("turned card", smooth, {{"rotation", kPi / 6}, {"offset", {.2, .1}}, {"scale", {.7, .7}}}),
             {{"translation", {.8, .05, .1}}, {"rotation", turn({0, 1, 0}, -.3)}});
  const int green = gltf.material(
      "leaf", {{"pbrMetallicRoughness",
                {{"baseColorTexture", {{"index", leaves}}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}},
               {"alphaMode", "MASK"},
               {"doubleSided", true},
               {"extensions", {{"KHR_materials_ior", {{"ior", 1}}}}}});
  const int mesh = gltf.mesh("leaf", panel, green);
  for (int i = 0; i < 7; ++i)
    gltf.node("leaf " + std::to_string(i), mesh,
              {{"translation", {1.55 + .12 * (i % 3), .1 + .2 * i, .2 - .1 * i}},
               {"rotation", turn({.3, 1, .2 * i - .5}, .7 * i)},
               {"scale", {.5, .5, .5}}});
  gltf.light("sun", {{"type", "directional"}, {"intensity", 2.6}}, {{"rotation", turn({1, .6, 0}, -.8)}});
  gltf.background({.5, .6, .75});
  gltf.perspective({0, 1.2, 4}, {.1, .5, 0}, .6);
  gltf.save(folder + "texture.gltf");
}

}  // namespace

void make_solid_scenes(const std::string& folder) {
  wheel(folder);
  cornell(folder);
  checker_horizon(folder);
  glass(folder);
  mirror(folder);
  depth_of_field(folder);
  motion(folder);
  texture(folder);
}

}  // namespace make_scenes
