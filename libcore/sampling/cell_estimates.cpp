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
  std::array<double, 3> light{}, half_light{};
  for (int v = 0; v < cells.y; ++v)
    for (int u = 0; u < cells.x; ++u) {
      const size_t p = film.pixel(x * cells.x + u, y * cells.y + v);
      const double n = film.count(p), in_half = film.half_count(p);
      const std::array<double, 3> mean = film.mean(p), half_mean = film.half_mean(p);
      all += n;
      half += in_half;
      for (size_t c = 0; c < 3; ++c) {
        light[c] += n * mean[c];
        half_light[c] += in_half * half_mean[c];
      }
    }
  const double rest = all - half;
  if (half <= 0 || rest <= 0) return {kInfinity, kInfinity, kInfinity};
  std::array<double, 3> error;
  for (size_t c = 0; c < 3; ++c)
    error[c] = (half_light[c] / half - (light[c] - half_light[c]) / rest) * std::sqrt(half * rest) / all;
  return error;
}

double estimated_rmse(const Film& film, const Cells& cells) {
  const int width = film.width() / cells.x, height = film.height() / cells.y;
  std::vector<NeumaierSum> rows(static_cast<size_t>(height));
  parallel_for(height, [&](int64_t y) {
    for (int x = 0; x < width; ++x)
      for (const double error : estimated_error(film, cells, x, static_cast<int>(y)))
        rows[static_cast<size_t>(y)].add(error * error);
  });
  NeumaierSum total;
  for (const NeumaierSum& row : rows) total.merge(row);
  return std::sqrt(total.value() / (3. * width * height));
}

std::vector<std::array<double, 3>> filled_means(const Film& film, const Cells& cells) {
  std::vector<std::array<double, 3>> colour;
  for (size_t p = 0; p < film.pixels(); ++p)
    if (film.count(p) == 0) {
      colour.resize(film.pixels());
      break;
    }
  const auto around = [&](int x, int y, int reach_x, int reach_y) {
    std::array<double, 4> sum{};
    for (int v = std::max(0, y - reach_y); v <= std::min(film.height() - 1, y + reach_y); ++v)
      for (int u = std::max(0, x - reach_x); u <= std::min(film.width() - 1, x + reach_x); ++u) {
        const size_t p = film.pixel(u, v);
        const double n = film.count(p);
        for (size_t c = 0; c < 3; ++c) sum[c] += n * film.mean(p)[c];
        sum[3] += n;
      }
    return sum;
  };
  if (!colour.empty())
    parallel_for(film.height(), [&](int64_t row) {
      const int y = static_cast<int>(row), side = std::max(cells.x, cells.y);
      for (int x = 0; x < film.width(); ++x) {
        const size_t p = film.pixel(x, y);
        colour[p] = film.mean(p);
        std::array<double, 4> sum{};
        for (int reach = 1; film.count(p) == 0 && sum[3] == 0 && reach <= 2 * side; ++reach)
          sum = around(x, y, reach * cells.x / side, reach * cells.y / side);
        if (sum[3] > 0) colour[p] = {sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]};
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
