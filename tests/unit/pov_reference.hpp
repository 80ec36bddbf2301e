// SPDX-License-Identifier: Apache-2.0
// POV-Ray's methods as their descriptions read: one thing after the other, every sample looked up in a map, nothing
// remembered that can be found out again.
#pragma once

#include <cmath>
#include <map>
#include <set>
#include <triad/sampling/source.hpp>
#include <vector>

namespace triad::test::pov {

struct Colour {
  std::array<float, 3> rgb{};
  bool known = false;
};
using Point = std::pair<int, int>;  // x, y in units of a lattice

struct Settings {
  int depth = 3, n = 3;
  double threshold = .3, gamma = 2.5;
  bool by_area = false, along_lines = false, with_centre = false, scanline = false;
};

struct Picture {
  std::vector<std::array<double, 3>> colour;
  std::vector<uint32_t> count;  // of the samples that are valid, where they lie
  uint64_t samples = 0;
};

inline Colour ask(const Source& source, double x, double y) {
  const SampleRequest request{x, y};
  Sample sample;
  source.eval({&request, 1}, {&sample, 1});
  return {sample.rgb, sample.valid};
}

inline std::array<float, 3> encoded(const Colour& colour, double gamma) {
  std::array<float, 3> v;
  for (int c = 0; c < 3; ++c) v[c] = std::pow(std::max(0.f, colour.rgb[c]), static_cast<float>(1 / gamma));
  return v;
}

// The sum of the channels' ranges over those that are known; for two, the sum of absolute differences.
inline double spread(const std::vector<Colour>& colours, double gamma) {
  std::vector<std::array<float, 3>> known;
  for (const Colour& colour : colours)
    if (colour.known) known.push_back(encoded(colour, gamma));
  if (known.empty()) return 0;
  std::array<float, 3> range{};
  for (const auto& a : known)
    for (const auto& b : known)
      for (int c = 0; c < 3; ++c) range[c] = std::max(range[c], std::abs(a[c] - b[c]));
  return range[0] + range[1] + range[2];
}

inline Picture pov1(const Source& source, const Settings& settings) {
  const int width = source.width(), height = source.height(), n = settings.n;
  Picture picture;
  std::vector<Colour> now(static_cast<size_t>(width * height));
  std::vector<bool> done(now.size());
  picture.colour.resize(now.size());
  picture.count.resize(now.size());
  const auto supersample = [&](int x, int y) {
    const auto p = static_cast<size_t>(y * width + x);
    if (done[p]) return;
    done[p] = true;
    std::array<double, 3> sum{};
    uint32_t count = 0;
    const auto add = [&](const Colour& colour) {
      if (!colour.known) return;
      ++count;
      for (int c = 0; c < 3; ++c) sum[c] += colour.rgb[c];
    };
    add(now[p]);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) add(ask(source, x + (i + .5) / n, y + (j + .5) / n));
    picture.samples += static_cast<uint64_t>(n) * static_cast<uint64_t>(n);
    picture.count[p] = count;
    if (count == 0) return;
    now[p].known = true;
    for (int c = 0; c < 3; ++c) {
      picture.colour[p][c] = sum[c] / count;
      now[p].rgb[c] = static_cast<float>(picture.colour[p][c]);
    }
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto p = static_cast<size_t>(y * width + x), left = p - 1, up = p - static_cast<size_t>(width);
      now[p] = ask(source, x + .5, y + .5);
      ++picture.samples;
      picture.count[p] = now[p].known;
      if (now[p].known)
        for (int c = 0; c < 3; ++c) picture.colour[p][c] = now[p].rgb[c];
      const auto differs = [&](size_t other) {
        return spread({now[other], now[p]}, settings.gamma) >= settings.threshold;
      };
      const bool from_left = x > 0 && differs(left), from_up = y > 0 && differs(up);
      if (from_left) supersample(x - 1, y);
      if (from_up) supersample(x, y - 1);
      if (from_left || from_up) supersample(x, y);
    }
  return picture;
}

// pov2 to pov5 on all samples that there are.
class Tree {
 public:
  Tree(const Source& source, const Settings& settings)
      : source_(source), settings_(settings), side_(1 << std::max(1, settings.depth)) {}

  Picture render() {
    const int width = source_.width(), height = source_.height();
    for (int y = 0; y <= height; ++y)
      for (int x = 0; x <= width; ++x) take({x * side_, y * side_});
    for (int y = 0; settings_.with_centre && y < height; ++y)
      for (int x = 0; x < width; ++x) take({x * side_ + side_ / 2, y * side_ + side_ / 2});
    Picture picture;
    const auto all_pixels = [&](const auto& body) {
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) body(x, y);
    };
    if (settings_.scanline) {
      all_pixels([&](int x, int y) {
        for (std::set<Point> wanted{{}}; !wanted.empty();) {
          wanted.clear();
          const auto colour = divide(x, y, wanted);
          if (wanted.empty()) picture.colour.push_back(colour);
          for (const Point& point : wanted) take(point);
        }
      });
    } else {
      for (std::set<Point> wanted{{}}; !wanted.empty();) {
        wanted.clear();
        picture.colour.clear();
        all_pixels([&](int x, int y) { picture.colour.push_back(divide(x, y, wanted)); });
        for (const Point& point : wanted) take(point);
      }
    }
    picture.count.resize(picture.colour.size());
    picture.samples = samples_.size();
    for (const auto& [point, colour] : samples_) {
      const int x = std::min(width - 1, point.first / side_), y = std::min(height - 1, point.second / side_);
      picture.count[static_cast<size_t>(y * width + x)] += colour.known;
    }
    return picture;
  }

 private:
  struct Cell {
    int x, y, side;
    Colour corner[4];  // upper left, upper right, lower left, lower right
    Colour centre{};
  };

  void take(Point point) {
    samples_[point] =
        ask(source_, static_cast<double>(point.first) / side_, static_cast<double>(point.second) / side_);
  }
  const Colour* find(Point point) const {
    const auto found = samples_.find(point);
    return found == samples_.end() ? nullptr : &found->second;
  }
  Colour mean_of(const Colour& a, const Colour& b) const {
    if (!a.known) return b;
    if (!b.known) return a;
    Colour mean{{}, true};
    for (int c = 0; c < 3; ++c) mean.rgb[c] = (a.rgb[c] + b.rgb[c]) / 2;
    return mean;
  }
  double apart(const Colour& a, const Colour& b) const { return spread({a, b}, settings_.gamma); }
  // Of the cell's edge between two of its corners.
  double along(const Cell& cell, int a, int b) const {
    if (!settings_.along_lines) return apart(cell.corner[a], cell.corner[b]);
    std::vector<Colour> all{cell.corner[a], cell.corner[b]};
    const int step_x = b - a == 1, step_y = b - a == 2;
    for (int k = 1; k < cell.side; ++k)
      if (const Colour* found =
              find({cell.x + (a & 1) * cell.side + k * step_x, cell.y + (a / 2) * cell.side + k * step_y}))
        all.push_back(*found);
    return spread(all, settings_.gamma);
  }
  double difference(const Cell& cell) const {
    double most = std::max(apart(cell.corner[0], cell.corner[3]), apart(cell.corner[1], cell.corner[2]));
    for (const auto& [a, b] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}}) most = std::max(most, along(cell, a, b));
    for (const Colour& corner : cell.corner) most = std::max(most, apart(corner, cell.centre));
    return most;
  }

  std::array<double, 3> divide(int pixel_x, int pixel_y, std::set<Point>& wanted) const {
    Cell root{pixel_x * side_, pixel_y * side_, side_, {}, {}};
    for (int k = 0; k < 4; ++k) root.corner[k] = *find({root.x + (k & 1) * side_, root.y + (k / 2) * side_});
    if (settings_.with_centre) root.centre = *find({root.x + side_ / 2, root.y + side_ / 2});
    std::vector<Cell> level{root}, leaves;
    double area = 1;
    for (int depth = 0; depth < settings_.depth && !level.empty(); ++depth) {
      const auto goes_on = [&](const Cell& cell) { return difference(cell) * area >= settings_.threshold; };
      for (double before = 2; settings_.by_area && area < before;) {
        before = area;
        double still = 0;
        for (const Cell& cell : level)
          if (goes_on(cell)) still += static_cast<double>(cell.side) * cell.side / side_ / side_;
        if (still == 0) break;
        area = still;
      }
      std::vector<Cell> next, rest;
      bool waits = false;
      for (Cell cell : level) {
        if (!goes_on(cell)) {
          rest.push_back(cell);
          continue;
        }
        const int half = cell.side / 2;
        const auto need = [&](Point point) {
          if (find(point)) return true;
          wanted.insert(point);
          waits = true;
          return false;
        };
        const bool centred = need({cell.x + half, cell.y + half});
        if (centred) cell.centre = *find({cell.x + half, cell.y + half});
        if (!centred && settings_.along_lines) continue;
        Colour grid[3][3];  // [y][x]
        grid[1][1] = cell.centre;
        for (int k = 0; k < 4; ++k) grid[k / 2 * 2][k % 2 * 2] = cell.corner[k];
        for (const auto& [a, b] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}}) {
          const int x = (a & 1) + (b & 1), y = a / 2 + b / 2;
          const Point middle{cell.x + x * half, cell.y + y * half};
          const double most =
              std::max({along(cell, a, b), apart(cell.corner[a], cell.centre), apart(cell.corner[b], cell.centre)});
          if (!settings_.along_lines || most * area >= settings_.threshold) need(middle);
          const Colour* found = find(middle);
          grid[y][x] = found ? *found : mean_of(cell.corner[a], cell.corner[b]);
        }
        for (int y = 0; y < 2; ++y)
          for (int x = 0; x < 2; ++x)
            next.push_back({cell.x + x * half,
                            cell.y + y * half,
                            half,
                            {grid[y][x], grid[y][x + 1], grid[y + 1][x], grid[y + 1][x + 1]},
                            {}});
      }
      if (waits) return {};
      leaves.insert(leaves.end(), rest.begin(), rest.end());
      level = next;
    }
    leaves.insert(leaves.end(), level.begin(), level.end());
    return mean(leaves);
  }

  std::array<double, 3> mean(const std::vector<Cell>& leaves) const {
    std::array<double, 3> sum{};
    double total = 0;
    for (const Cell& cell : leaves) {
      std::array<double, 3> of_cell{};
      double weight = 0;
      const auto add = [&](const Colour& colour, double by) {
        if (!colour.known) return;
        weight += by;
        for (int c = 0; c < 3; ++c) of_cell[c] += by * colour.rgb[c];
      };
      const bool whole = settings_.with_centre && cell.side == side_;
      for (const Colour& corner : cell.corner) add(corner, whole ? 3. / 16 : 1. / 4);
      if (whole) add(cell.centre, 1. / 4);
      if (weight == 0) continue;
      const double area = static_cast<double>(cell.side) * cell.side;
      total += area;
      for (int c = 0; c < 3; ++c) sum[c] += area * of_cell[c] / weight;
    }
    if (total > 0)
      for (double& each : sum) each /= total;
    return sum;
  }

  const Source& source_;
  const Settings settings_;
  const int side_;
  std::map<Point, Colour> samples_;
};

}  // namespace triad::test::pov
