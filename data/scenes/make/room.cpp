// SPDX-License-Identifier: Apache-2.0
// An interior of some 100,000 triangles from few meshes in many places. 6 m wide, 3 m high, 5 m deep; the floor's
// centre is the origin; the camera stands in a corner.
#include "shapes.hpp"

namespace make_scenes {
namespace {

class Room {
 public:
  Room()
      : gltf_("A room of 6 m x 3 m x 5 m with a table, chairs, shelves of books, vases and lamps"),
        white_(gltf_.diffuse("plaster", {.78, .76, .72})),
        wood_(gltf_.diffuse("wood", {.42, .26, .14})),
        dark_(gltf_.diffuse("dark wood", {.16, .09, .05})),
        cloth_(gltf_.diffuse("cloth", {.18, .28, .4})),
        clay_(gltf_.diffuse("clay", {.55, .25, .15})),
        steel_(gltf_.metal("steel", {.7, .7, .72}, .25)),
        glow_(gltf_.lamp("lamp", {28, 25, 20})),
        window_(gltf_.lamp("window", {4.5, 5.2, 6})) {}

  void make(const std::string& path) {
    shell();
    table({.3, 0, -.2});
    shelves({-2.75, 0, -.9});
    vases();
    sofa({1.9, 0, -1.9});
    lamps();
    gltf_.perspective({2.6, 1.65, 2.3}, {-.6, .8, -.8}, .85);
    gltf_.save(path);
  }

 private:
  void shell() {
    Shape walls, floor;
    constexpr double kX = 3, kY = 3, kZ = 2.5;
    floor.quad({-kX, 0, kZ}, {kX, 0, kZ}, {kX, 0, -kZ}, {-kX, 0, -kZ}, 40, 40);
    walls.quad({-kX, kY, -kZ}, {kX, kY, -kZ}, {kX, kY, kZ}, {-kX, kY, kZ}, 24, 24);
    walls.quad({-kX, 0, -kZ}, {kX, 0, -kZ}, {kX, kY, -kZ}, {-kX, kY, -kZ}, 24, 24);
    walls.quad({kX, 0, kZ}, {-kX, 0, kZ}, {-kX, kY, kZ}, {kX, kY, kZ}, 24, 24);
    walls.quad({-kX, 0, kZ}, {-kX, 0, -kZ}, {-kX, kY, -kZ}, {-kX, kY, kZ}, 24, 24);
    walls.quad({kX, 0, -kZ}, {kX, 0, kZ}, {kX, kY, kZ}, {kX, kY, -kZ}, 24, 24);
    gltf_.place("floor", floor, dark_);
    gltf_.place("walls", walls, white_);
    Shape pane;
    pane.quad({-.8, -.6, 0}, {.8, -.6, 0}, {.8, .6, 0}, {-.8, .6, 0});
    gltf_.place("window", pane, window_, {{"translation", {.4, 1.7, -2.49}}});
  }

  void table(Vec at) {
    const int leg = gltf_.mesh("leg", rod({0, 0, 0}, {0, .72, 0}, .03, 48), steel_);
    const int top = gltf_.mesh("table top", box({1.8, .05, .9}, 16), wood_);
    gltf_.node("table top", top, {{"translation", {at.x, .745, at.z}}});
    for (const double x : {-.8, .8})
      for (const double z : {-.38, .38}) gltf_.node("table leg", leg, {{"translation", {at.x + x, 0, at.z + z}}});
    const int seat = gltf_.mesh("seat", box({.42, .05, .42}, 8), wood_);
    const int back = gltf_.mesh("chair back", box({.42, .45, .03}, 8), wood_);
    const int chair_leg = gltf_.mesh("chair leg", rod({0, 0, 0}, {0, .45, 0}, .018, 32), steel_);
    for (int i = 0; i < 6; ++i) {
      const double side = i < 3 ? 1 : -1, x = at.x + (i % 3 - 1) * .58, z = at.z + side * .62;
      gltf_.node("seat", seat, {{"translation", {x, .46, z}}});
      gltf_.node("chair back", back, {{"translation", {x, .75, z + side * .2}}});
      for (const double dx : {-.18, .18})
        for (const double dz : {-.18, .18})
          gltf_.node("chair leg", chair_leg, {{"translation", {x + dx, 0, z + dz}}});
    }
    const int bowl = gltf_.mesh("bowl", lathe(bowl_profile(), 64), clay_);
    gltf_.node("bowl", bowl, {{"translation", {at.x, .771, at.z}}});
    const int fruit = gltf_.mesh("fruit", sphere(.045, 32, 16), gltf_.diffuse("fruit", {.75, .35, .04}));
    for (int i = 0; i < 6; ++i)
      gltf_.node("fruit", fruit,
                 {{"translation", {at.x + .065 * std::cos(i * 1.05), .825, at.z + .065 * std::sin(i * 1.05)}}});
  }

  static std::vector<std::array<double, 2>> bowl_profile() {
    std::vector<std::array<double, 2>> profile;
    for (int i = 0; i <= 16; ++i) {  // outside, from the foot to the rim
      const double a = kPi / 2 * i / 16;
      profile.push_back({.04 + .12 * std::sin(a), .1 * (1 - std::cos(a))});
    }
    for (int i = 16; i >= 0; --i) {  // inside, 5 mm within, back to the middle
      const double a = kPi / 2 * i / 16;
      profile.push_back({i == 0 ? 0 : .155 * std::sin(a), .105 - .1 * std::cos(a)});
    }
    return profile;
  }

  void shelves(Vec at) {
    const int board = gltf_.mesh("board", box({.35, .03, 2.2}, 8), wood_);
    const int side = gltf_.mesh("shelf side", box({.35, 2.2, .03}, 8), wood_);
    for (int i = 0; i < 6; ++i) gltf_.node("board", board, {{"translation", {at.x, .05 + .42 * i, at.z}}});
    for (const double z : {-1.1, 1.1}) gltf_.node("shelf side", side, {{"translation", {at.x, 1.1, at.z + z}}});
    const Vec colours[] = {{.5, .1, .08}, {.1, .25, .4}, {.2, .35, .15}, {.6, .5, .3}, {.15, .12, .18}};
    std::vector<int> books;
    for (const Vec& colour : colours) {
      const std::string name = "book " + std::to_string(books.size());
      books.push_back(gltf_.mesh(name, box({.2, 1, 1}, 2), gltf_.diffuse(name, colour)));
    }
    uint32_t state = 1997;  // a linear congruential generator: the same books every time
    const auto chance = [&state] {
      state = state * 1664525u + 1013904223u;
      return (state >> 8) / 16777216.;
    };
    for (int shelf = 0; shelf < 5; ++shelf)
      for (double z = at.z - 1.05; z < at.z + 1.02;) {
        const double thick = .02 + .04 * chance(), high = .22 + .12 * chance();
        const auto which = static_cast<size_t>(chance() * 5);
        gltf_.node("book", books[which],
                   {{"translation", {at.x + .03 * chance(), .066 + .42 * shelf + high / 2, z + thick / 2}},
                    {"scale", {1, high, thick - .003}}});
        z += thick + (chance() > .94 ? .12 : 0);
      }
  }

  void vases() {
    std::vector<std::array<double, 2>> profile;
    for (int i = 0; i <= 40; ++i) {
      const double t = i / 40.;
      profile.push_back({i == 0 ? 0 : .05 + .11 * std::sin(kPi * std::pow(t, .7)) + .02 * t, .55 * t});
    }
    const int vase = gltf_.mesh("vase", lathe(profile, 72), clay_);
    const double places[][3] = {{-2.4, 0, 1.6}, {2.5, 0, -.6}, {-1.2, 0, -2.1}, {-2.5, 0, 2.1}};
    for (const auto& p : places) gltf_.node("vase", vase, {{"translation", {p[0], p[1], p[2]}}});
    const int ball = gltf_.mesh("steel ball", sphere(.16, 64, 32), steel_);
    gltf_.node("steel ball", ball, {{"translation", {-1.5, .16, -1.7}}});
    gltf_.node("steel ball", ball, {{"translation", {-.9, .16, -2}}, {"scale", {.8, .8, .8}}});
  }

  void sofa(Vec at) {
    const int seat = gltf_.mesh("sofa seat", box({.62, .2, .78}, 12), cloth_);
    const int back = gltf_.mesh("sofa back", box({.62, .55, .2}, 12), cloth_);
    const int pillow = gltf_.mesh("pillow", sphere(.5, 48, 24), clay_);
    for (int i = 0; i < 3; ++i) {
      const double x = at.x - .645 + .645 * i;
      gltf_.node("sofa seat", seat, {{"translation", {x, .43, at.z + .03}}});
      gltf_.node("sofa back", back, {{"translation", {x, .78, at.z - .3}}, {"rotation", turn({1, 0, 0}, -.15)}});
    }
    for (const double side : {-1, 1})
      gltf_.node("pillow", pillow,
                 {{"translation", {at.x + side * .75, .7, at.z - .08}},
                  {"rotation", turn({1, 0, 0}, -.4)},
                  {"scale", {.42, .42, .16}}});
    gltf_.place("sofa base", box({1.95, .3, .85}, 10), cloth_, {{"translation", {at.x, .17, at.z}}});
  }

  void lamps() {
    const int shade = gltf_.mesh("shade", torus(.16, .035, 64, 24), steel_);
    const int bulb = gltf_.mesh("bulb", sphere(.09, 16, 8), glow_);  // few triangles: each is a light of its own
    const int cord = gltf_.mesh("cord", rod({0, 0, 0}, {0, .9, 0}, .006, 12), dark_);
    for (const double x : {-.3, .9}) {
      gltf_.node("bulb", bulb, {{"translation", {x, 2, -.2}}});
      gltf_.node("shade", shade, {{"translation", {x, 2.03, -.2}}, {"rotation", turn({1, 0, 0}, kPi / 2)}});
      gltf_.node("cord", cord, {{"translation", {x, 2.09, -.2}}});
    }
  }

  Gltf gltf_;
  int white_, wood_, dark_, cloth_, clay_, steel_, glow_, window_;
};

}  // namespace

void make_room(const std::string& folder) { Room().make(folder + "room.gltf"); }

}  // namespace make_scenes
