// SPDX-License-Identifier: Apache-2.0
#include <triad/base/parallel.hpp>
#include <triad/display/eye.hpp>

namespace triad {

namespace {

// Linear RGB to what is blurred: opponent channels, whose gains cancel.
std::array<double, 9> channels_of(const Observer& observer, EyeSpace space) {
  std::array<double, 9> rows = opponent_matrix(observer);
  if (space == EyeSpace::kOpponent) return rows;
  const auto white = [&](size_t c) { return rows[3 * c] + rows[3 * c + 1] + rows[3 * c + 2]; };
  for (size_t c = 1; c < 3; ++c) {
    const double grey = white(c) / white(0);
    for (size_t d = 0; d < 3; ++d) rows[3 * c + d] -= grey * rows[d];
  }
  return rows;
}

}  // namespace

Eye::Eye(const Layout& layout, const Observer& observer, const PanelTorus::Shape& shape, EyeGrid grid, EyeSpace space)
    : torus_(layout, shape),
      grid_(grid),
      blur_(torus_.width(), torus_.height()),
      to_opponent_(channels_of(observer, space)),
      to_rgb_(inverse_3x3(to_opponent_)) {
  check_observer(observer);
  for (int c = 0; c < 3; ++c)
    transfer_[c] = blur_.remembered([torus = torus_, observer, c](size_t nx, double* values) {
      torus.transfer(observer, c, nx, values);
      const double flat = mtf(observer, c, 0);
      for (size_t ny = 0; ny <= torus.height() / 2; ++ny) values[ny] /= flat;
    });
}

uint64_t Eye::work_bytes() const {
  return blur_.workspace_bytes() +
         3 * static_cast<uint64_t>(width()) * static_cast<uint64_t>(torus_.rows()) * sizeof(double);
}

void Eye::look(const Light& light, float* rgb, ptrdiff_t stride) const {
  PlaneBlur::Workspace work(blur_);
  const size_t across = static_cast<size_t>(width()), cells = torus_.columns() / across;
  // [channel][fine row][column of the grid]
  std::vector<double> seen[3];
  for (size_t c = 0; c < 3; ++c) {
    seen[c].resize(across * torus_.rows());
    blur_.apply(
        [&](size_t y, double* row) {
          std::vector<double> shows(3 * torus_.width());
          light(y, shows.data());
          for (size_t k = 0; k < torus_.width(); ++k)
            row[k] = to_opponent_[3 * c] * shows[3 * k] + to_opponent_[3 * c + 1] * shows[3 * k + 1] +
                     to_opponent_[3 * c + 2] * shows[3 * k + 2];
        },
        transfer_[c], torus_.rows(),
        [&](size_t y, const double* row) {
          for (size_t x = 0; x < across; ++x) {
            double sum = 0;
            for (size_t i = 0; i < cells; ++i) sum += row[x * cells + i];
            seen[c][y * across + x] = sum / static_cast<double>(cells);
          }
        },
        work);
  }
  const size_t rows = torus_.rows() / static_cast<size_t>(height());
  parallel_for(height(), [&](int64_t y) {
    float* to = rgb + y * stride;
    for (size_t x = 0; x < across; ++x) {
      double opponent[3] = {};
      for (size_t c = 0; c < 3; ++c) {
        for (size_t i = 0; i < rows; ++i) opponent[c] += seen[c][(static_cast<size_t>(y) * rows + i) * across + x];
        opponent[c] /= static_cast<double>(rows);
      }
      for (size_t d = 0; d < 3; ++d)
        *to++ = static_cast<float>(to_rgb_[3 * d] * opponent[0] + to_rgb_[3 * d + 1] * opponent[1] +
                                   to_rgb_[3 * d + 2] * opponent[2]);
    }
  });
}

}  // namespace triad
