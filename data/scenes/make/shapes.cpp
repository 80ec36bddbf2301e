// SPDX-License-Identifier: Apache-2.0
#include "shapes.hpp"

#include <map>
#include <stdexcept>

namespace make_scenes {

uint32_t Shape::vertex(Vec position, Vec normal, double u, double v) {
  positions.push_back(position);
  normals.push_back(normal);
  uvs.push_back({u, v});
  return static_cast<uint32_t>(positions.size() - 1);
}

void Shape::quad(Vec a, Vec b, Vec c, Vec d, int across, int along) {
  const Vec normal = unit(cross(b - a, d - a));
  const auto first = static_cast<uint32_t>(positions.size()), row = static_cast<uint32_t>(across + 1);
  for (int j = 0; j <= along; ++j)
    for (int i = 0; i <= across; ++i) {
      const double s = double(i) / across, t = double(j) / along;
      vertex((1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * d + s * c), normal, s, 1 - t);
    }
  for (uint32_t j = 0; j < static_cast<uint32_t>(along); ++j)
    for (uint32_t i = 0; i < static_cast<uint32_t>(across); ++i) {
      const uint32_t k = first + j * row + i;
      indices.insert(indices.end(), {k, k + 1, k + row + 1, k, k + row + 1, k + row});
    }
}

void Shape::add(const Shape& other, Vec offset) {
  const auto first = static_cast<uint32_t>(positions.size());
  for (const Vec& p : other.positions) positions.push_back(p + offset);
  normals.insert(normals.end(), other.normals.begin(), other.normals.end());
  uvs.insert(uvs.end(), other.uvs.begin(), other.uvs.end());
  for (const uint32_t i : other.indices) indices.push_back(first + i);
}

Shape box(Vec size, int cells) {
  const double x = size.x / 2, y = size.y / 2, z = size.z / 2;
  Shape shape;
  shape.quad({-x, -y, z}, {x, -y, z}, {x, y, z}, {-x, y, z}, cells, cells);
  shape.quad({x, -y, -z}, {-x, -y, -z}, {-x, y, -z}, {x, y, -z}, cells, cells);
  shape.quad({x, -y, z}, {x, -y, -z}, {x, y, -z}, {x, y, z}, cells, cells);
  shape.quad({-x, -y, -z}, {-x, -y, z}, {-x, y, z}, {-x, y, -z}, cells, cells);
  shape.quad({-x, y, z}, {x, y, z}, {x, y, -z}, {-x, y, -z}, cells, cells);
  shape.quad({-x, -y, -z}, {x, -y, -z}, {x, -y, z}, {-x, -y, z}, cells, cells);
  return shape;
}

Shape lathe(const std::vector<std::array<double, 2>>& profile, int around) {
  Shape shape;
  const size_t rings = profile.size();
  for (size_t j = 0; j < rings; ++j) {
    const auto& below = profile[j == 0 ? 0 : j - 1];
    const auto& above = profile[j + 1 == rings ? j : j + 1];
    const double dr = above[0] - below[0], dy = above[1] - below[1];
    for (int i = 0; i <= around; ++i) {
      const double a = 2 * kPi * (i % around) / around, c = std::cos(a), s = std::sin(a);
      // At a pole the profile turns back on itself: straight up or down is right there.
      const bool pole = profile[j][0] == 0;
      const Vec normal = pole ? Vec{0, j == 0 ? -1. : 1., 0} : unit(Vec{dy * c, -dr, dy * s});
      shape.vertex({profile[j][0] * c, profile[j][1], profile[j][0] * s}, normal, double(i) / around,
                   1 - double(j) / double(rings - 1));
    }
  }
  const auto row = static_cast<uint32_t>(around + 1);
  for (uint32_t j = 0; j + 1 < rings; ++j)
    for (uint32_t i = 0; i < static_cast<uint32_t>(around); ++i) {
      const uint32_t k = j * row + i;
      if (profile[j][0] > 0) shape.indices.insert(shape.indices.end(), {k, k + row + 1, k + 1});
      if (profile[j + 1][0] > 0) shape.indices.insert(shape.indices.end(), {k, k + row, k + row + 1});
    }
  return shape;
}

Shape sphere(double radius, int around, int down) {
  std::vector<std::array<double, 2>> profile;
  for (int j = 0; j <= down; ++j) {
    const double a = kPi * j / down;
    profile.push_back({j == 0 || j == down ? 0 : radius * std::sin(a), -radius * std::cos(a)});
  }
  Shape shape = lathe(profile, around);
  for (size_t i = 0; i < shape.positions.size(); ++i) shape.normals[i] = unit(shape.positions[i]);
  return shape;
}

Shape torus(double ring_radius, double tube_radius, int around, int across) {
  Shape shape;
  for (int j = 0; j <= across; ++j)
    for (int i = 0; i <= around; ++i) {
      const double a = 2 * kPi * (i % around) / around, b = 2 * kPi * (j % across) / across;
      const Vec out{std::cos(a), std::sin(a), 0}, normal = std::cos(b) * out + std::sin(b) * Vec{0, 0, 1};
      shape.vertex(ring_radius * out + tube_radius * normal, normal, double(i) / around, double(j) / across);
    }
  const auto row = static_cast<uint32_t>(around + 1);
  for (uint32_t j = 0; j < static_cast<uint32_t>(across); ++j)
    for (uint32_t i = 0; i < static_cast<uint32_t>(around); ++i) {
      const uint32_t k = j * row + i;
      shape.indices.insert(shape.indices.end(), {k, k + 1, k + row + 1, k, k + row + 1, k + row});
    }
  return shape;
}

Shape rod(Vec from, Vec to, double radius, int around) {
  const Vec along = unit(to - from);
  const Vec side = unit(cross(along, std::abs(along.y) < .9 ? Vec{0, 1, 0} : Vec{1, 0, 0})),
            other = cross(along, side);
  Shape shape;
  for (int end = 0; end < 2; ++end)
    for (int i = 0; i <= around; ++i) {
      const double a = 2 * kPi * (i % around) / around;
      const Vec normal = std::cos(a) * side + std::sin(a) * other;
      shape.vertex((end == 0 ? from : to) + radius * normal, normal, double(i) / around, end);
    }
  const auto row = static_cast<uint32_t>(around + 1);
  for (uint32_t i = 0; i < static_cast<uint32_t>(around); ++i)
    shape.indices.insert(shape.indices.end(), {i, i + 1, i + row + 1, i, i + row + 1, i + row});
  return shape;
}

Shape stroke(double x0, double y0, double x1, double y1, double width, double z) {
  const Vec along = unit(Vec{x1 - x0, y1 - y0, 0}), half{-along.y * width / 2, along.x * width / 2, 0};
  const Vec a{x0, y0, z}, b{x1, y1, z};
  Shape shape;
  shape.quad(a - half, b - half, b + half, a + half);
  return shape;
}

Shape ring(double x, double y, double inner, double outer, int around, double z) {
  Shape shape;
  const Vec centre{x, y, z};
  const auto count = static_cast<uint32_t>(around);
  for (const double radius : {outer, inner}) {
    if (radius == 0) shape.vertex(centre, {0, 0, 1});
    for (int i = 0; radius > 0 && i < around; ++i) {
      const double a = 2 * kPi * i / around;
      shape.vertex(centre + radius * Vec{std::cos(a), std::sin(a), 0}, {0, 0, 1});
    }
  }
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t next = (i + 1) % count;
    if (inner == 0) {
      shape.indices.insert(shape.indices.end(), {i, next, count});
    } else {
      shape.indices.insert(shape.indices.end(), {i, next, count + i, next, count + next, count + i});
    }
  }
  return shape;
}

// Points "xy" of the grid, joined; a blank lifts the pen.
static const std::map<char, std::string>& font() {
  static const std::map<char, std::string> glyphs{{'A', "002640 1333"},
                                                  {'B', "00063645443303 3342413000"},
                                                  {'C', "4536160501103041"},
                                                  {'D', "00062644422000"},
                                                  {'E', "46060040 0333"},
                                                  {'F', "460600 0333"},
                                                  {'G', "45361605011030414323"},
                                                  {'H', "0006 4046 0343"},
                                                  {'I', "1030 2026 1636"},
                                                  {'J', "4641301001"},
                                                  {'K', "0006 4602 1340"},
                                                  {'L', "060040"},
                                                  {'M', "0006234640"},
                                                  {'N', "00064046"},
                                                  {'O', "103041453616050110"},
                                                  {'P', "00063645443303"},
                                                  {'Q', "103041453616050110 2240"},
                                                  {'R', "00063645443303 2340"},
                                                  {'S', "453616050413334241301001"},
                                                  {'T', "0646 2026"},
                                                  {'U', "060110304146"},
                                                  {'V', "062046"},
                                                  {'W', "0610243046"},
                                                  {'X', "0046 0640"},
                                                  {'Y', "062346 2320"},
                                                  {'Z', "06460040"},
                                                  {'0', "103041453616050110"},
                                                  {'1', "152620 1030"},
                                                  {'2', "05163645440040"},
                                                  {'3', "064623334241301001"},
                                                  {'4', "30360242"},
                                                  {'5', "460603334241301001"},
                                                  {'6', "36160501103041423303"},
                                                  {'7', "064610"},
                                                  {'8', "13334445361605041302011030414233"},
                                                  {'9', "10304145361605041343"},
                                                  {' ', ""}};
  return glyphs;
}

Shape text(const std::string& words, double x, double y, double height, double width, double angle_rad) {
  const double unit_size = height / 6, c = std::cos(angle_rad), s = std::sin(angle_rad);
  constexpr double kAdvance = 5.6;  // grid units from letter to letter
  Shape shape;
  for (size_t i = 0; i < words.size(); ++i) {
    const std::string& glyph = font().at(words[i]);
    const auto point = [&](size_t at) {
      const double u = unit_size * (double(i) * kAdvance + (glyph[at] - '0')), v = unit_size * (glyph[at + 1] - '0');
      return std::array{x + c * u - s * v, y + s * u + c * v};
    };
    for (size_t at = 0; at + 1 < glyph.size();) {
      if (glyph[at] == ' ') {
        ++at;
        continue;
      }
      if (at + 3 < glyph.size() && glyph[at + 2] != ' ') {  // longer by half a width at each end, for the joints
        const auto a = point(at), b = point(at + 2);
        const double dx = b[0] - a[0], dy = b[1] - a[1], more = width / 2 / std::hypot(dx, dy);
        shape.add(stroke(a[0] - more * dx, a[1] - more * dy, b[0] + more * dx, b[1] + more * dy, width));
      }
      at += 2;
    }
  }
  return shape;
}

json turn(Vec axis, double angle_rad) {
  const Vec v = std::sin(angle_rad / 2) * unit(axis);
  return {v.x, v.y, v.z, std::cos(angle_rad / 2)};
}

}  // namespace make_scenes
