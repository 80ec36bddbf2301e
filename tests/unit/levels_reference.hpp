// SPDX-License-Identifier: Apache-2.0
// quad and tri in an obvious version, which knows cells by their places alone.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <triad/sampling/source.hpp>
#include <vector>

namespace triad::test {

struct LevelSettings {
  bool tri = false, square = false;
  int under = 2, over = 0;
  double colour = .03, position = .03;
  bool ids = false;
  std::string text() const {
    return fmt::format("{}:under={},over={},colour={},position={},ids={}{}", tri ? "tri" : "quad", under, over,
                       colour, position, ids ? "on" : "off", square ? ",finest=square" : "");
  }
};

struct Cell {
  bool known = false, hit = false;
  std::array<double, 3> rgb{}, position{};
  double distance = 0;
  uint32_t id = 0;
};

struct Grid {
  int width, height;
  double side;
  bool shifted;
  std::vector<Cell> cells;

  Grid(const Source& source, double s, bool shift)
      : width(static_cast<int>(std::ceil(source.width() / s))),
        height(static_cast<int>(std::ceil(source.height() / s))),
        side(s),
        shifted(shift),
        cells(static_cast<size_t>(width * height)) {}
  double shift(int y) const { return shifted && y % 2 != 0 ? .5 : 0; }
  Cell& at(int x, int y) {
    return cells[static_cast<size_t>(std::clamp(y, 0, height - 1) * width + std::clamp(x, 0, width - 1))];
  }
  // In cells, from the film's corner.
  double place(int x, int y) const { return x + .5 + shift(y); }
  // Of the neighbour so far away, which may be outside: the cell repeated there.
  Cell& neighbour(int x, int y, double dx, int dy) {
    return at(static_cast<int>(std::lround(place(x, y) + dx - .5 - shift(y + dy + 2))), y + dy);
  }

  char reason(int x, int y, const LevelSettings& settings) {
    const Cell& a = at(x, y);
    std::vector<std::array<double, 4>> ways{{1, 0, -1, 0}};
    if (shifted)
      ways.insert(ways.end(), {{.5, -1, -.5, 1}, {-.5, -1, .5, 1}});
    else
      ways.insert(ways.end(), {{0, -1, 0, 1}, {1, -1, -1, 1}, {-1, -1, 1, 1}});
    std::array<double, 3> colour{};
    double position = 0;
    bool others = false;
    int pairs = 0;
    for (const auto& way : ways) {
      const Cell& b = neighbour(x, y, way[0], static_cast<int>(way[1]));
      const Cell& c = neighbour(x, y, way[2], static_cast<int>(way[3]));
      if (!a.known || !b.known || !c.known) continue;
      ++pairs;
      for (size_t i = 0; i < 3; ++i) colour[i] += std::abs(a.rgb[i] - (b.rgb[i] + c.rgb[i]) / 2);
      double squares = 0;
      for (size_t i = 0; i < 3; ++i) squares += std::pow(a.position[i] - (b.position[i] + c.position[i]) / 2, 2);
      if (a.hit != b.hit || a.hit != c.hit) position = std::numeric_limits<double>::infinity();
      if (a.hit) position += std::sqrt(squares) / a.distance;
      others = others || a.id != b.id || a.id != c.id;
    }
    if (pairs == 0) return '?';
    for (const double each : colour)
      if (each / pairs > settings.colour) return 'c';
    if (std::isfinite(settings.position) && position / pairs > settings.position) return 'p';
    return settings.ids && others ? 'i' : '-';
  }

  Cell between(double x_px, double y_px) {
    Cell result;
    double weights = 0, hits = 0;
    const int row = static_cast<int>(std::floor(y_px / side - .5));
    for (int v = row; v <= row + 1; ++v) {
      const int y = std::clamp(v, 0, height - 1);
      const double across = x_px / side - .5 - shift(y);
      const int column = static_cast<int>(std::floor(across));
      for (int x = column; x <= column + 1; ++x) {
        const Cell& cell = at(x, y);
        const double weight = (1 - std::abs(across - x)) * (1 - std::abs(y_px / side - .5 - v));
        if (!cell.known || weight == 0) continue;
        weights += weight;
        for (size_t i = 0; i < 3; ++i) result.rgb[i] += weight * cell.rgb[i];
        if (!cell.hit) continue;
        hits += weight;
        result.distance += weight * cell.distance;
        for (size_t i = 0; i < 3; ++i) result.position[i] += weight * cell.position[i];
      }
    }
    const Cell& above = parent(x_px, y_px);
    result.known = weights > 0;
    result.hit = above.hit;
    result.id = above.id;
    for (size_t i = 0; i < 3; ++i) {
      result.rgb[i] = weights > 0 ? result.rgb[i] / weights : 0;
      result.position[i] = above.hit ? result.position[i] / hits : 0;
    }
    result.distance = above.hit ? result.distance / hits : 0;
    return result;
  }
  std::array<int, 2> parent_place(double x_px, double y_px) const {
    const int y = static_cast<int>(std::floor(y_px / side));
    return {std::clamp(static_cast<int>(std::floor(x_px / side - shift(y))), 0, width - 1), y};
  }
  Cell& parent(double x_px, double y_px) {
    const auto [x, y] = parent_place(x_px, y_px);
    return at(x, y);
  }
};

struct Expected {
  std::vector<uint32_t> counts;
  std::vector<std::array<double, 3>> colour;
  std::vector<char> reasons;  // of a picture without cells above its own
};

inline Expected expected(const Source& source, const LevelSettings& settings) {
  const int width = source.width(), height = source.height();
  Expected result;
  result.counts.resize(static_cast<size_t>(width * height));
  const double finest = std::ldexp(1., -settings.over);
  double side = std::ldexp(1., settings.under);
  while (side > 1 && side > std::min(width, height)) side /= 2;
  std::optional<Grid> above;
  for (;; side /= 2) {
    Grid grid(source, side, settings.tri && !(settings.square && side == finest));
    result.reasons.clear();
    for (int y = 0; y < grid.height; ++y)
      for (int x = 0; x < grid.width; ++x) {
        const double px = grid.place(x, y) * side, py = (y + .5) * side;
        char reason = '0';
        if (above) {
          const auto [u, v] = above->parent_place(px, py);
          reason = above->reason(u, v, settings);
          grid.at(x, y) = above->between(px, py);
        }
        result.reasons.push_back(reason);
        if (reason == '-') continue;
        const int u = std::min(static_cast<int>(px), width - 1), v = std::min(static_cast<int>(py), height - 1);
        const SampleRequest request{px, py, static_cast<float>(finest), u, v, 0, 0};
        Sample sample;
        source.eval({&request, 1}, {&sample, 1});
        if (!sample.valid) continue;
        ++result.counts[static_cast<size_t>(v * width + u)];
        Cell cell{true, std::isfinite(sample.distance), {}, {}, 0, sample.object_id};
        for (size_t i = 0; i < 3; ++i) cell.rgb[i] = sample.rgb[i];
        for (size_t i = 0; i < 3 && cell.hit; ++i) cell.position[i] = sample.position[i];
        if (cell.hit) cell.distance = sample.distance;
        grid.at(x, y) = cell;
      }
    above = grid;
    if (side == finest) break;
  }
  const int n = 1 << settings.over;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::array<double, 3> total{};
      double weight = 0;
      for (int v = y * n; v < (y + 1) * n; ++v)
        for (int u = x * n; u < (x + 1) * n; ++u)
          for (const int left : {0, 1}) {
            const Cell& cell = above->at(above->shift(v) > 0 ? u - left : u, v);
            if (!cell.known) continue;
            weight += 1;
            for (size_t i = 0; i < 3; ++i) total[i] += cell.rgb[i];
          }
      for (double& each : total) each = weight > 0 ? each / weight : 0;
      result.colour.push_back(total);
    }
  return result;
}

}  // namespace triad::test
