// SPDX-License-Identifier: Apache-2.0
// Functions by name, and means of sources by asking them for very many samples.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <triad/sampling/functions.hpp>
#include <vector>

namespace triad::test {

struct Box {
  double x0, y0, x1, y1;
};

inline double value_at(const Source& source, double x, double y) {
  SampleRequest request;
  request.x = x;
  request.y = y;
  Sample sample;
  source.eval({&request, 1}, {&sample, 1});
  return static_cast<double>(sample.rgb[0]);
}

// f's mean over [a, b], where f has steps and is even between: found by looking at `looks` places and halving between
// different ones. Steps closer together than two looks may be lost.
inline double mean_of_steps(const std::function<double(double)>& f, double a, double b, int looks) {
  double sum = 0, from = a, before = a, level = f(a);
  for (int i = 1; i <= looks; ++i) {
    const double here = a + (b - a) * i / looks;
    const double next = f(here);
    if (next != level) {
      double low = before, high = here;
      for (int halving = 0; halving < 45; ++halving) {
        const double middle = .5 * (low + high);
        (f(middle) == level ? low : high) = middle;
      }
      sum += level * (high - from);
      from = high;
      level = next;
    }
    before = here;
  }
  return (sum + level * (b - from)) / (b - a);
}

// The mean over a box of a source with steps, to within about 1 / lines^2 for each edge that crosses the lines at an
// angle: exact along `lines` rows (or columns).
inline double mean_by_lines(const Source& source, const Box& box, int lines, int looks, bool columns = false) {
  double sum = 0;
  for (int i = 0; i < lines; ++i) {
    const double share = (i + .5) / lines;
    const double x = box.x0 + share * (box.x1 - box.x0), y = box.y0 + share * (box.y1 - box.y0);
    sum += columns ? mean_of_steps([&](double t) { return value_at(source, x, t); }, box.y0, box.y1, looks)
                   : mean_of_steps([&](double t) { return value_at(source, t, y); }, box.x0, box.x1, looks);
  }
  return sum / lines;
}

// Composite Gauss-Legendre quadrature of 5 points (Abramowitz and Stegun, table 25.4): the mean of f over [a, b].
template <class Value>
Value mean_by_quadrature(const std::function<Value(double)>& f, double a, double b, int panels) {
  constexpr double kNode[3] = {0, .5384693101056831, .9061798459386640};
  constexpr double kWeight[3] = {.5688888888888889, .4786286704993665, .2369268850561891};
  const double half = .5 * (b - a) / panels;
  Value sum = 0;
  for (int p = 0; p < panels; ++p) {
    const double middle = a + (2 * p + 1) * half;
    sum += .5 * kWeight[0] * f(middle);
    for (int i = 1; i < 3; ++i) sum += .5 * kWeight[i] * (f(middle - half * kNode[i]) + f(middle + half * kNode[i]));
  }
  return sum / static_cast<double>(panels);
}

// A function of a picture of 160 x 90.
inline std::unique_ptr<Source> make(const std::string& text, int width = 160, int height = 90,
                                    const Cells& cells = {}) {
  return make_function(text, width, height, cells, "test");
}

inline double exact(const Source& source, const Box& box) {
  const auto rgb = source.integral(box.x0, box.y0, box.x1, box.y1).value();
  EXPECT_EQ(rgb[0], rgb[1]);
  EXPECT_EQ(rgb[0], rgb[2]);
  return rgb[0];
}

inline double gaussian(const Source& source, double x, double y, double sigma_px) {
  return source.filtered(x, y, {.gaussian_sigma_px = sigma_px}).value()[0];
}

// Of side `side_px`, with its middle at odd places of a picture of 160 x 90.
inline std::vector<Box> odd_boxes(double side_px) {
  std::vector<Box> boxes;
  for (const auto& [x, y] : {std::pair{80., 45.}, {81.37, 44.21}, {40.618, 61.73}, {131.9, 20.04}}) {
    const double half = .5 * side_px;
    boxes.push_back({x - half, y - .8 * half, x + half, y + .8 * half});
  }
  return boxes;
}

}  // namespace triad::test
