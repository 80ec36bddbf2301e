// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <triad/base/parallel.hpp>
#include <triad/colour/cielab.hpp>
#include <triad/display/s_cielab.hpp>
#include <triad/display/vision.hpp>

namespace triad {
namespace {

std::array<double, 9> product(const std::array<double, 9>& a, const std::array<double, 9>& b) {
  std::array<double, 9> out{};
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      for (size_t k = 0; k < 3; ++k) out[3 * i + j] += a[3 * i + k] * b[3 * k + j];
  return out;
}

}  // namespace

SCielab::SCielab(const std::array<double, 9>& rgb_to_xyz, const Shape& shape)
    : shape_(shape),
      blur_(shape.width, shape.height),
      rgb_to_opponent_(product(xyz_to_opponent(), rgb_to_xyz)),
      opponent_to_xyz_(inverse_3x3(xyz_to_opponent())) {
  for (size_t i = 0; i < 3; ++i) white_[i] = rgb_to_xyz[3 * i] + rgb_to_xyz[3 * i + 1] + rgb_to_xyz[3 * i + 2];
  for (int c = 0; c < 3; ++c)
    transfer_[c] = blur_.remembered([shape, c](size_t nx, double* values) {
      const double fx = static_cast<double>(nx) / static_cast<double>(shape.width) * shape.cells_per_degree_x;
      for (size_t ny = 0; ny <= shape.height / 2; ++ny) {
        const double fy = static_cast<double>(ny) / static_cast<double>(shape.height) * shape.cells_per_degree_y;
        values[ny] = scielab_metric_mtf(c, std::sqrt(fx * fx + fy * fy));
      }
    });
}

uint64_t SCielab::workspace_bytes() const {
  return blur_.workspace_bytes() + uint64_t{6} * shape_.columns * shape_.rows * sizeof(float);
}

SCielab::Workspace::Workspace(const SCielab& metric) : blur_(metric.blur_) {
  for (auto& picture : seen_)
    for (auto& channel : picture) channel.resize(metric.shape_.columns * metric.shape_.rows);
}

void SCielab::delta_e(const Light& test, const Light& reference, const RowSink& out, Workspace& work) const {
  const Light* const pictures[2] = {&test, &reference};
  for (size_t p = 0; p < 2; ++p)
    for (size_t c = 0; c < 3; ++c)
      blur_.apply(
          [&](size_t y, double* row) {
            std::vector<double> rgb(3 * shape_.width);
            (*pictures[p])(y, rgb.data());
            for (size_t k = 0; k < shape_.width; ++k)
              row[k] = rgb_to_opponent_[3 * c] * rgb[3 * k] + rgb_to_opponent_[3 * c + 1] * rgb[3 * k + 1] +
                       rgb_to_opponent_[3 * c + 2] * rgb[3 * k + 2];
          },
          transfer_[c], shape_.rows,
          [&](size_t y, const double* row) {
            std::vector<float>& seen = work.seen_[p][c];
            for (size_t k = 0; k < shape_.columns; ++k) seen[y * shape_.columns + k] = static_cast<float>(row[k]);
          },
          work.blur_);
  parallel_for(static_cast<int64_t>(shape_.rows), [&](int64_t y) {
    std::vector<double> values(shape_.columns);
    for (size_t k = 0; k < shape_.columns; ++k) {
      const size_t at = static_cast<size_t>(y) * shape_.columns + k;
      Lab lab[2];
      for (size_t p = 0; p < 2; ++p) {
        std::array<double, 3> xyz{};
        for (size_t i = 0; i < 3; ++i)
          for (size_t c = 0; c < 3; ++c)
            xyz[i] += opponent_to_xyz_[3 * i + c] * static_cast<double>(work.seen_[p][c][at]);
        lab[p] = xyz_to_lab(xyz, white_);
      }
      values[k] = cie76(lab[0], lab[1]);
    }
    out(static_cast<size_t>(y), values.data());
  });
}

}  // namespace triad
