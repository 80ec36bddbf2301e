// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <triad/base/parallel.hpp>
#include <triad/colour/colour.hpp>
#include <triad/sampling/cell_estimates.hpp>

namespace triad {

std::array<double, 3> estimated_error(const Film& film, const Cells& cells, int x, int y) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double all = 0, half = 0;
  uint32_t left_out = 0;
  std::array<double, 3> light{}, half_light{};
  for (int v = 0; v < cells.y; ++v)
    for (int u = 0; u < cells.x; ++u) {
      const size_t p = film.pixel(x * cells.x + u, y * cells.y + v);
      left_out += film.left_out(p);
      const double n = film.count(p), in_half = film.half_count(p);
      const std::array<double, 3> mean = film.mean(p), half_mean = film.half_mean(p);
      all += n;
      half += in_half;
      for (size_t c = 0; c < 3; ++c) {
        light[c] += n * mean[c];
        half_light[c] += in_half * half_mean[c];
      }
    }
  if (all == 0 && left_out >= Film::kFewForNothing) return {};
  const double rest = all - half;
  if (half <= 0 || rest <= 0) return {kInfinity, kInfinity, kInfinity};
  std::array<double, 3> error;
  for (size_t c = 0; c < 3; ++c)
    error[c] = (half_light[c] / half - (light[c] - half_light[c]) / rest) * std::sqrt(half * rest) / all;
  return error;
}

namespace {

// Whether a rectangle of a film's pixels has samples.
class Filled {
 public:
  explicit Filled(const Film& film)
      : stride_(static_cast<size_t>(film.width()) + 1), sums_(stride_ * (static_cast<size_t>(film.height()) + 1)) {
    for (int y = 0; y < film.height(); ++y) {
      uint32_t in_row = 0;
      for (int x = 0; x < film.width(); ++x) {
        in_row += film.count(film.pixel(x, y)) > 0;
        sums_[at(x + 1, y + 1)] = sums_[at(x + 1, y)] + in_row;
      }
    }
  }
  // In [x0, x1) x [y0, y1).
  bool any(int x0, int y0, int x1, int y1) const {
    // What overflows in the sums does so in their difference, too.
    return sums_[at(x1, y1)] - sums_[at(x0, y1)] - sums_[at(x1, y0)] + sums_[at(x0, y0)] != 0;
  }

 private:
  size_t at(int x, int y) const { return static_cast<size_t>(y) * stride_ + static_cast<size_t>(x); }
  size_t stride_;
  std::vector<uint32_t> sums_;  // of pixels that have some, before a column and a row
};

struct Window {
  int x0, y0, x1, y1;
  // Around (x, y) on the film, so many cells to each side in the direction in which pixels have most of them.
  Window(const Film& film, const Cells& cells, int x, int y, int reach) {
    const int side = std::max(cells.x, cells.y), reach_x = reach * cells.x / side, reach_y = reach * cells.y / side;
    x0 = std::max(0, x - reach_x);
    y0 = std::max(0, y - reach_y);
    x1 = std::min(film.width(), x + reach_x + 1);
    y1 = std::min(film.height(), y + reach_y + 1);
  }
};

// The mean of the samples in the smallest window around a pixel that has any.
std::array<double, 3> mean_around(const Film& film, const Cells& cells, const Filled& filled, int x, int y) {
  const auto any = [&](int reach) {
    const Window w(film, cells, x, y, reach);
    return filled.any(w.x0, w.y0, w.x1, w.y1);
  };
  int without = 0, reach = 2 * std::max(cells.x, cells.y);
  if (!any(reach)) return {};
  while (reach - without > 1) {
    const int middle = (without + reach) / 2;
    (any(middle) ? reach : without) = middle;
  }
  const Window all(film, cells, x, y, reach), inner(film, cells, x, y, without);
  std::array<double, 3> sum{};
  double samples = 0;
  for (int v = all.y0; v < all.y1; ++v)
    for (int u = all.x0; u < all.x1; ++u) {
      if (u == inner.x0 && v >= inner.y0 && v < inner.y1) u = inner.x1;  // nothing is in there
      if (u == all.x1) break;
      const size_t p = film.pixel(u, v);
      const double n = film.count(p);
      if (n == 0) continue;
      const std::array<double, 3> mean = film.mean(p);
      for (size_t c = 0; c < 3; ++c) sum[c] += n * mean[c];
      samples += n;
    }
  return {sum[0] / samples, sum[1] / samples, sum[2] / samples};
}

}  // namespace

std::vector<std::array<double, 3>> filled_means(const Film& film, const Cells& cells) {
  std::vector<std::array<double, 3>> colour;
  for (size_t p = 0; p < film.pixels(); ++p)
    if (film.count(p) == 0) {
      colour.resize(film.pixels());
      break;
    }
  if (colour.empty()) return colour;
  const Filled filled(film);
  parallel_for(film.height(), [&](int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < film.width(); ++x) {
      const size_t p = film.pixel(x, y);
      colour[p] = film.count(p) > 0 ? film.mean(p) : mean_around(film, cells, filled, x, y);
    }
  });
  return colour;
}

NoiseSeen::NoiseSeen(double ppd) {
  Observer observer;
  observer.rgb_to_xyz = rec709_to_xyz();
  observer.ppd = ppd;
  to_opponent_ = opponent_matrix(observer);
  // Of white noise, the mean over frequencies below half a cycle a pixel of the squared transfer.
  constexpr int kSteps = 256;
  for (int c = 0; c < kOpponentChannels; ++c)
    for (int i = 0; i < kSteps; ++i) {
      const double transfer = mtf(observer, c, (i + .5) / kSteps * ppd / 2);
      passed_[static_cast<size_t>(c)] += transfer * transfer / kSteps;
    }
}

double NoiseSeen::operator()(const std::array<double, 3>& rgb) const {
  double energy = 0;
  for (size_t c = 0; c < kOpponentChannels; ++c) {
    const double error =
        to_opponent_[3 * c] * rgb[0] + to_opponent_[3 * c + 1] * rgb[1] + to_opponent_[3 * c + 2] * rgb[2];
    energy += passed_[c] * error * error;
  }
  return std::sqrt(energy);
}

}  // namespace triad
