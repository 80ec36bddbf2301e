// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/display/display_error.hpp>

namespace triad {
namespace {

SCielab::Shape scielab_shape(const PanelTorus& torus, double ppd) {
  return {torus.width(), torus.height(), torus.columns(), torus.rows(), ppd * torus.cells_x(), ppd * torus.cells_y()};
}

// Per pixel of a fine row: the mean over its cells of f(k), into sums[x].
template <class F>
void mean_over_cells(const PanelTorus& torus, double* sums, const F& f) {
  const size_t cells = static_cast<size_t>(torus.cells_x());
  for (size_t x = 0; x < static_cast<size_t>(torus.shape().width_px); ++x) {
    double sum = 0;
    for (size_t i = 0; i < cells; ++i) sum += f(x * cells + i);
    sums[x] = sum / static_cast<double>(cells);
  }
}

// The mean of the sums over the fine rows of each pixel: out[pixel * step].
void mean_over_rows(const PanelTorus& torus, const std::vector<double>& sums, double* out, size_t step) {
  const size_t width = static_cast<size_t>(torus.shape().width_px), cells = static_cast<size_t>(torus.cells_y());
  for (size_t y = 0; y < static_cast<size_t>(torus.shape().height_px); ++y)
    for (size_t x = 0; x < width; ++x) {
      double sum = 0;
      for (size_t i = 0; i < cells; ++i) sum += sums[(y * cells + i) * width + x];
      out[(y * width + x) * step] = sum / static_cast<double>(cells);
    }
}

bool inside(float v) { return v >= 0 && v <= 1; }

}  // namespace

DisplayError::DisplayError(const Layout& layout, const Observer& observer, int width_px, Edge edge, Range range)
    : DisplayError(layout, observer,
                   PanelTorus::Shape{.width_px = width_px, .height_px = 1, .edge = edge, .one_row = true}, range) {}

DisplayError::DisplayError(const Layout& layout, const Observer& observer, const PanelTorus::Shape& shape,
                           Range range, Target target)
    : torus_(layout, shape),
      range_(range),
      target_(target),
      blur_(torus_.width(), torus_.height()),
      scielab_(observer.rgb_to_xyz, scielab_shape(torus_, observer.ppd)),
      opponent_(opponent_matrix(observer)) {
  check_observer(observer);
  // Copies of all they need: the measure may be moved.
  for (int c = 0; c < 3; ++c)
    transfer_[c] = blur_.remembered(
        [torus = torus_, observer, c](size_t nx, double* values) { torus.transfer(observer, c, nx, values); });
}

uint64_t DisplayError::workspace_bytes() const {
  const uint64_t width = static_cast<uint64_t>(width_px());
  const uint64_t clamped = target_ == Target::kDrives ? 2 : 1;
  return blur_.workspace_bytes() + clamped * 3 * width * static_cast<uint64_t>(height_px()) * sizeof(float) +
         width * torus_.rows() * sizeof(double);
}

uint64_t DisplayError::perceived_workspace_bytes() const {
  return scielab_.workspace_bytes() + workspace_bytes() - blur_.workspace_bytes();
}

DisplayError::Workspace::Workspace(const DisplayError& measure)
    : blur_(measure.blur_), row_energies_(static_cast<size_t>(measure.width_px()) * measure.torus_.rows()) {}

DisplayError::PerceivedWorkspace::PerceivedWorkspace(const DisplayError& measure)
    : scielab_(measure.scielab_), row_sums_(static_cast<size_t>(measure.width_px()) * measure.torus_.rows()) {}

PictureView DisplayError::shown(const PictureView& test, std::vector<float>& clamped, int64_t& outside) const {
  if (range_ == Range::kUnbounded) return test;
  const size_t width = static_cast<size_t>(width_px());
  clamped.resize(3 * width * static_cast<size_t>(height_px()));
  float* to = clamped.data();
  for (int y = 0; y < height_px(); ++y) {
    const float* from = test.row(y);
    for (size_t x = 0; x < width; ++x, from += 3, to += 3) {
      outside += !(inside(from[0]) && inside(from[1]) && inside(from[2]));
      for (int d = 0; d < 3; ++d) to[d] = std::clamp(from[d], 0.f, 1.f);
    }
  }
  return {clamped.data(), static_cast<ptrdiff_t>(3 * width)};
}

Light DisplayError::meant(const PictureView& target, std::vector<float>& clamped, int64_t& outside) const {
  if (target_ == Target::kDrives) return torus_.panel(shown(target, clamped, outside));
  if (range_ == Range::kClip)
    for (int y = 0; y < static_cast<int>(torus_.rows()); ++y) {
      const float* cell = target.row(y);
      for (size_t k = 0; k < torus_.columns(); ++k, cell += 3)
        outside += !(inside(cell[0]) && inside(cell[1]) && inside(cell[2]));
    }
  return torus_.target(target, range_);
}

DisplayError::Clamped DisplayError::picture(const PictureView& test, const PictureView& target, double* energy,
                                            Workspace& work) const {
  Clamped clamped;
  const PictureView drives = shown(test, work.clamped_, clamped.test_pixels);
  const Light panel = torus_.panel(drives), meant = this->meant(target, work.clamped_target_, clamped.target_cells);
  for (size_t c = 0; c < 3; ++c) {
    blur_.apply(
        [&](size_t y, double* row) {
          std::vector<double> shows(3 * torus_.width()), should(3 * torus_.width());
          panel(y, shows.data());
          meant(y, should.data());
          for (size_t k = 0; k < torus_.width(); ++k) {
            row[k] = 0;
            for (size_t d = 0; d < 3; ++d) row[k] += opponent_[3 * c + d] * (shows[3 * k + d] - should[3 * k + d]);
          }
        },
        transfer_[c], torus_.rows(),
        [&](size_t y, const double* row) {
          mean_over_cells(torus_, &work.row_energies_[y * static_cast<size_t>(width_px())],
                          [&](size_t k) { return row[k] * row[k]; });
        },
        work.blur_);
    mean_over_rows(torus_, work.row_energies_, energy + c, 3);
  }
  return clamped;
}

DisplayError::Clamped DisplayError::row(const float* test, const float* target, double* energy,
                                        Workspace& workspace) const {
  if (torus_.rows() != 1) throw_internal("one row of a picture that has several");
  return picture({test, 0}, {target, 0}, energy, workspace);
}

void DisplayError::pixel_average(const PictureView& target, float* drives) const {
  const int cells_x = torus_.cells_x(), cells_y = torus_.cells_y();
  for (int y = 0; y < height_px(); ++y)
    for (int x = 0; x < width_px(); ++x)
      for (int d = 0; d < 3; ++d, ++drives) {
        double sum = 0;
        for (int v = 0; v < cells_y; ++v)
          for (int u = 0; u < cells_x; ++u) {
            const auto value =
                static_cast<double>(target.row(y * cells_y + v)[3 * (static_cast<ptrdiff_t>(x) * cells_x + u) + d]);
            sum += range_ == Range::kClip ? std::clamp(value, 0., 1.) : value;
          }
        *drives = static_cast<float>(sum / (cells_x * cells_y));
      }
}

void DisplayError::delta_e(const PictureView& test, const PictureView& target, double* delta_e,
                           PerceivedWorkspace& work) const {
  int64_t outside = 0;
  const PictureView drives = shown(test, work.clamped_, outside);
  scielab_.delta_e(
      torus_.panel(drives), meant(target, work.clamped_target_, outside),
      [&](size_t y, const double* values) {
        mean_over_cells(torus_, &work.row_sums_[y * static_cast<size_t>(width_px())],
                        [&](size_t k) { return values[k]; });
      },
      work.scielab_);
  mean_over_rows(torus_, work.row_sums_, delta_e, 1);
}

void DisplayTotals::add_pixels(const double* energies, const float* mask, int x0, int x1) {
  for (int x = x0; x < x1; ++x) {
    const double w = mask ? static_cast<double>(mask[x]) : 1;
    weight.add(w);
    for (int c = 0; c < 3; ++c) energy[c].add(w * energies[static_cast<ptrdiff_t>(x) * 3 + c]);
  }
}

void DisplayTotals::merge(const DisplayTotals& later) {
  for (int c = 0; c < 3; ++c) energy[c].merge(later.energy[c]);
  weight.merge(later.weight);
  clamped_test_pixels += later.clamped_test_pixels;
  clamped_target_cells += later.clamped_target_cells;
}

double DisplayTotals::rmse() const {
  return std::sqrt((energy[0].value() + energy[1].value() + energy[2].value()) / weight.value());
}

double DisplayTotals::share(int c) const {
  const double all = energy[0].value() + energy[1].value() + energy[2].value();
  return all > 0 ? energy[c].value() / all : 0;
}

void DeltaTotals::add(double delta_e, double w) {
  sum.add(w * delta_e);
  weight.add(w);
  const double bin = std::floor((std::log2(delta_e) - kLowestOctave) * kBinsPerOctave);  // -inf for 0
  bins[static_cast<int>(std::clamp(bin, 0., kBins - 1.))] += w;
}

void DeltaTotals::merge(const DeltaTotals& later) {
  sum.merge(later.sum);
  weight.merge(later.weight);
  for (int i = 0; i < kBins; ++i) bins[i] += later.bins[i];
}

double DeltaTotals::percentile(double p) const {
  double total = 0, below = 0;
  for (const double w : bins) total += w;
  for (int i = 0; i < kBins; ++i) {
    if (!(bins[i] > 0) || below + bins[i] < p * total) {
      below += bins[i];
      continue;
    }
    const double part = (p * total - below) / bins[i];  // of the bin's weight that does not exceed the answer
    return i == 0 ? 0 : std::exp2(kLowestOctave + (i + part) / kBinsPerOctave);
  }
  return 0;
}

int automatic_border_px(double ppd, int size_px) {
  return std::min(static_cast<int>(std::ceil(ppd / 5)), (size_px - 1) / 2);
}

}  // namespace triad
