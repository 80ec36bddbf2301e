// SPDX-License-Identifier: Apache-2.0
// The displayable optimum on small tori, from the definition: dense matrices over cells and drives, no tile
// frequencies and no iteration that the library shares. It judges RowSolver and PlaneSolver.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <numbers>
#include <triad/display/emission.hpp>
#include <triad/display/filter_design.hpp>
#include <vector>

namespace triad::reference {

// A wrapped picture of width x height pixels, whole tiles, at a phase of the panel. Drives are numbered
// channels() * (y * width + x) + channel; those that light nothing have no cost. Where the panel derives its white
// they are what the emitters show, white being channel 3; optimum() is not for those.
class DenseDisplay {
 public:
  DenseDisplay(const Layout& layout, const Observer& eye, const FilterOptions& options, int width, int height,
               int origin_x, int origin_y, const std::vector<double>& cells)
      : layout_(layout),
        eye_(eye),
        w_(width),
        h_(height),
        nx_(width * layout.cells_x),
        ny_(height * layout.cells_y),
        ox_(origin_x),
        oy_(origin_y) {
    const int N = nx_ * ny_, n = channels() * w_ * h_;
    const auto C = opponent_matrix(eye);
    const double tiles = static_cast<double>(w_ * h_) / (layout.tile_x * layout.tile_y);
    const Eigen::VectorXd box = box_drives(cells);
    start_ = box;
    std::vector<Eigen::MatrixXd> light;  // per channel: cells x drives
    for (int c = 0; c < 3; ++c) light.push_back(Eigen::MatrixXd::Zero(N, n));
    curvature_ = Eigen::MatrixXd::Zero(n, n);
    slope_ = Eigen::VectorXd::Zero(n);
    for_each_emitter([&](int drive, const Emitter& e, int px, int py) {
      double norm2 = 0, shares2 = 0;
      std::array<double, 3> colour{};
      for (size_t c = 0; c < 3; ++c) {
        for (size_t d = 0; d < 3; ++d) colour[c] += C[3 * c + d] * e.primary[d];
        norm2 += colour[c] * colour[c];
      }
      for (const EmitterCell& cell : e.cells) {
        const int k = at_cell((px - e.pixel_x) * layout.cells_x + cell.x, (py - e.pixel_y) * layout.cells_y + cell.y);
        for (size_t c = 0; c < 3; ++c) light[c](k, drive) += layout.pixel_cells() * colour[c] * cell.share;
        shares2 += cell.share * cell.share;
      }
      const double G = layout.pixel_cells();
      const double floor = options.lambda * options.lambda * G * G / layout.tile_cells() * shares2 * norm2 / tiles;
      curvature_(drive, drive) += floor;
      slope_(drive) += floor * box(drive);
      constant_ += floor * box(drive) * box(drive);
    });
    const Eigen::VectorXd smooth = options.exact_flat_fields ? smoothed(box) : Eigen::VectorXd::Zero(n);
    const Eigen::MatrixXd above =
        options.exact_flat_fields
            ? Eigen::MatrixXd(Eigen::MatrixXd::Identity(N, N) - circulant([&](int x, int y) {
                                return baseband(x, w_ / layout_.tile_x, layout_.cells_x * layout_.tile_x) *
                                       baseband(y, h_ / layout_.tile_y, layout_.cells_y * layout_.tile_y);
                              }))
            : Eigen::MatrixXd::Zero(N, N);
    for (int c = 0; c < 3; ++c) {
      const auto weight = circulant([&](int x, int y) {
        const double fx = std::min(x, nx_ - x) / static_cast<double>(nx_) * layout_.cells_x * eye_.ppd;
        const double fy = std::min(y, ny_ - y) / static_cast<double>(ny_) * layout_.cells_y * eye_.ppd;
        const double m = mtf(eye_, c, std::sqrt(fx * fx + fy * fy));
        return m * m;
      });
      Eigen::VectorXd target(N);
      for (int k = 0; k < N; ++k) {
        target[k] = 0;
        for (int d = 0; d < 3; ++d) target[k] += C[3 * c + d] * cells[static_cast<size_t>(3 * k + d)];
      }
      target += above * (light[c] * smooth);
      curvature_ += light[c].transpose() * weight * light[c] / N;
      slope_ += light[c].transpose() * weight * target / N;
      constant_ += target.dot(weight * target) / N;
    }
  }

  int channels() const { return layout_.derives_white ? 4 : 3; }
  // What the emitters show for the pixels of a picture.
  Eigen::VectorXd shown(const std::vector<double>& rgb) const {
    Eigen::VectorXd out(channels() * w_ * h_);
    for (int p = 0; p < w_ * h_; ++p) {
      const double* pixel = &rgb[static_cast<size_t>(3 * p)];
      const double white = layout_.derives_white ? std::min({pixel[0], pixel[1], pixel[2]}) : 0;
      for (int c = 0; c < 3; ++c) out[channels() * p + c] = pixel[c] - white;
      if (layout_.derives_white) out[channels() * p + 3] = white;
    }
    return out;
  }

  // The displaced box, from its definition: areas of overlap.
  const Eigen::VectorXd& start() const { return start_; }
  double value(const Eigen::VectorXd& a) const { return a.dot(curvature_ * a) - 2 * slope_.dot(a) + constant_; }

  // The least of value() over [0, 1]: coordinate descent finds which drives are at a bound, Newton steps the rest.
  Eigen::VectorXd optimum() const {
    const Eigen::Index n = start_.size();
    Eigen::VectorXd a = start_;
    for (int round = 0; round < 200; ++round) {
      for (int sweep = 0; sweep < 200; ++sweep)
        for (Eigen::Index i = 0; i < n; ++i)
          if (curvature_(i, i) > 0)
            a[i] = std::clamp(a[i] - (curvature_.row(i).dot(a) - slope_[i]) / curvature_(i, i), 0., 1.);
      std::vector<Eigen::Index> free;
      for (Eigen::Index i = 0; i < n; ++i)
        if (curvature_(i, i) > 0 && a[i] > 0 && a[i] < 1) free.push_back(i);
      const Eigen::Index f = static_cast<Eigen::Index>(free.size());
      Eigen::MatrixXd H(f, f);
      Eigen::VectorXd g(f);
      for (Eigen::Index i = 0; i < f; ++i) {
        g[i] = slope_[free[i]] - curvature_.row(free[i]).dot(a);
        for (Eigen::Index j = 0; j < f; ++j) H(i, j) = curvature_(free[i], free[j]);
      }
      const Eigen::VectorXd step = f ? Eigen::VectorXd(H.ldlt().solve(g)) : g;
      bool inside = true;
      for (Eigen::Index i = 0; i < f; ++i) inside = inside && a[free[i]] + step[i] >= 0 && a[free[i]] + step[i] <= 1;
      if (!inside) continue;
      for (Eigen::Index i = 0; i < f; ++i) a[free[i]] += step[i];
      if (optimality(a) < 1e-11) break;
    }
    return a;
  }
  // The least of value() with no bounds; drives that light nothing are 0.
  Eigen::VectorXd unbounded() const {
    Eigen::MatrixXd H = curvature_;
    for (Eigen::Index i = 0; i < H.rows(); ++i)
      if (!(H(i, i) > 0)) H(i, i) = 1;
    Eigen::VectorXd a = Eigen::VectorXd::Zero(slope_.size());
    const auto factor = H.ldlt();
    for (int round = 0; round < 3; ++round) a += factor.solve(slope_ - H * a);
    return a;
  }
  // How far a is from optimal: the largest gradient that could still be followed. 0 exactly at the optimum.
  double optimality(const Eigen::VectorXd& a) const {
    const Eigen::VectorXd gradient = curvature_ * a - slope_;
    double worst = 0;
    for (Eigen::Index i = 0; i < a.size(); ++i) {
      const double g = a[i] <= 0 ? std::min(gradient[i], 0.) : a[i] >= 1 ? std::max(gradient[i], 0.) : gradient[i];
      worst = std::max(worst, std::abs(g));
    }
    return worst;
  }

 private:
  static int mod(int a, int n) { return ((a % n) + n) % n; }
  int at_cell(int x, int y) const { return mod(y, ny_) * nx_ + mod(x, nx_); }

  // body(drive, emitter, pixel x, pixel y) for every emitter of the panel under the picture.
  template <class Body>
  void for_each_emitter(const Body& body) const {
    for (int y = 0; y < h_; ++y)
      for (int x = 0; x < w_; ++x)
        for (const Emitter& e : layout_.emitters)
          if (mod(x + ox_, layout_.tile_x) == e.pixel_x && mod(y + oy_, layout_.tile_y) == e.pixel_y)
            body(channels() * (y * w_ + x) + e.channel, e, x, y);
  }

  Eigen::VectorXd box_drives(const std::vector<double>& cells) const {
    if (layout_.derives_white) {  // the pixels' averages
      std::vector<double> rgb(static_cast<size_t>(3 * w_ * h_));
      for (int k = 0; k < nx_ * ny_; ++k)
        for (int c = 0; c < 3; ++c)
          rgb[static_cast<size_t>(3 * (k / nx_ / layout_.cells_y * w_ + k % nx_ / layout_.cells_x) + c)] +=
              cells[static_cast<size_t>(3 * k + c)] / layout_.pixel_cells();
      return shown(rgb);
    }
    Eigen::VectorXd out = Eigen::VectorXd::Zero(channels() * w_ * h_);
    for_each_emitter([&](int drive, const Emitter& e, int px, int py) {
      const double cx = (px - e.pixel_x) * layout_.cells_x + e.centre_x();
      const double cy = (py - e.pixel_y) * layout_.cells_y + e.centre_y();
      const auto overlap = [](double centre, int size, int cell) {
        return std::max(0., std::min(centre + .5 * size, cell + 1.) - std::max<double>(centre - .5 * size, cell)) /
               size;
      };
      for (int y = -2 * ny_; y < 3 * ny_; ++y)
        for (int x = -2 * nx_; x < 3 * nx_; ++x) {
          const double share = overlap(cx, layout_.cells_x, x) * overlap(cy, layout_.cells_y, y);
          if (share > 0) out[drive] += share * cells[static_cast<size_t>(3 * at_cell(x, y) + e.channel)];
        }
    });
    return out;
  }

  // Drives of the same emitter in all tiles, through the window of 1.5 px.
  Eigen::VectorXd smoothed(const Eigen::VectorXd& box) const {
    const auto line = [](int tiles, int tile_px) {
      std::vector<double> kernel(static_cast<size_t>(tiles));
      for (int t = 0; t < tiles; ++t)
        for (int m = 0; m < tiles; ++m) {
          const double phase = 2 * std::numbers::pi * 1.5 * std::min(m, tiles - m) / (tiles * tile_px);
          kernel[t] += std::exp(-.5 * phase * phase) * std::cos(2 * std::numbers::pi * t * m / tiles) / tiles;
        }
      return kernel;
    };
    const int tx = w_ / layout_.tile_x, ty = h_ / layout_.tile_y;
    const auto kx = line(tx, layout_.tile_x), ky = line(ty, layout_.tile_y);
    Eigen::VectorXd out = Eigen::VectorXd::Zero(box.size());
    for (int y = 0; y < h_; ++y)
      for (int x = 0; x < w_; ++x)
        for (int v = 0; v < ty; ++v)
          for (int u = 0; u < tx; ++u)
            for (int c = 0; c < channels(); ++c)
              out[channels() * (y * w_ + x) + c] +=
                  kx[u] * ky[v] *
                  box[channels() * (mod(y - v * layout_.tile_y, h_) * w_ + mod(x - u * layout_.tile_x, w_)) + c];
    return out;
  }

  static double baseband(int n, int tiles, int aliases) {
    const int low = std::min(n, tiles * aliases - n);
    return aliases == 1 || 2 * low < tiles ? 1 : 2 * low == tiles ? .5 : 0;
  }

  // The matrix over cells that multiplies frequency (x, y) by f(x, y).
  template <class F>
  Eigen::MatrixXd circulant(const F& f) const {
    const int N = nx_ * ny_;
    std::vector<double> kernel(static_cast<size_t>(N)), value(static_cast<size_t>(N));
    for (int y = 0; y < ny_; ++y)
      for (int x = 0; x < nx_; ++x) value[static_cast<size_t>(y * nx_ + x)] = f(x, y);
    for (int ky = 0; ky < ny_; ++ky)
      for (int kx = 0; kx < nx_; ++kx) {
        double sum = 0;
        for (int y = 0; y < ny_; ++y)
          for (int x = 0; x < nx_; ++x)
            sum += value[static_cast<size_t>(y * nx_ + x)] *
                   std::cos(2 * std::numbers::pi *
                            (static_cast<double>(kx * x % nx_) / nx_ + static_cast<double>(ky * y % ny_) / ny_));
        kernel[static_cast<size_t>(ky * nx_ + kx)] = sum / N;
      }
    Eigen::MatrixXd out(N, N);
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j)
        out(i, j) = kernel[static_cast<size_t>(at_cell(i % nx_ - j % nx_, i / nx_ - j / nx_))];
    return out;
  }

  Layout layout_;
  Observer eye_;
  int w_, h_, nx_, ny_, ox_, oy_;
  Eigen::MatrixXd curvature_;
  Eigen::VectorXd slope_, start_;
  double constant_ = 0;
};

}  // namespace triad::reference
