// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/display/display_error.hpp>

namespace triad {
namespace {

int checked_width(const Layout& layout, const Observer& observer, int width_px, Edge edge) {
  require_rows(layout);
  check_observer(observer);
  ring_px(width_px, edge);  // throws
  return width_px;
}

}  // namespace

DisplayError::DisplayError(const Layout& layout, const Observer& observer, int width_px, Edge edge, Range range)
    : layout_(layout),
      width_px_(checked_width(layout, observer, width_px, edge)),
      ring_px_(ring_px(width_px, edge)),
      range_(range),
      ring_(static_cast<size_t>(ring_px_) * layout.cells_x) {
  const auto opponent = opponent_matrix(observer);
  std::copy(opponent.begin(), opponent.end(), opponent_);
  for (int o = 0; o < 3; ++o) {
    const Emitter& emitter = layout_.emitters[layout_.emitter_of(o)];
    for (int c = 0; c < 3; ++c) {
      emission_[o][c] = 0;
      for (int d = 0; d < 3; ++d) emission_[o][c] += layout_.cells_x * opponent_[3 * c + d] * emitter.primary[d];
    }
  }
  const double ring_cells = static_cast<double>(ring_.size());
  for (int c = 0; c < 3; ++c) {
    weights_[c] = AlignedBuffer<double>(ring_.spectrum_size());
    for (size_t n = 0; n < ring_.spectrum_size(); ++n) {
      const double f_cpd = static_cast<double>(n) / ring_cells * layout_.cells_x * observer.ppd;
      weights_[c][n] = mtf(observer, c, f_cpd) / ring_cells;
    }
  }
}

DisplayError::Workspace::Workspace(const DisplayError& measure) : spectrum_(measure.ring_.spectrum_size()) {
  for (auto& plane : error_) plane = AlignedBuffer<double>(measure.ring_.size());
}

DisplayError::Clamped DisplayError::row(const float* test, const float* target, double* energy,
                                        Workspace& work) const {
  const int S = layout_.cells_x, cells = S * width_px_;
  Clamped clamped;
  // The target's light, negative; on a mirrored ring the second half is the first one backwards.
  for (int k = 0; k < cells; ++k) {
    double rgb[3];
    bool outside = false;
    for (int d = 0; d < 3; ++d) {
      rgb[d] = static_cast<double>(target[3 * static_cast<ptrdiff_t>(k) + d]);
      if (range_ == Range::kClip && !(rgb[d] >= 0 && rgb[d] <= 1)) {
        outside = true;
        rgb[d] = std::clamp(rgb[d], 0., 1.);
      }
    }
    clamped.target_cells += outside;
    for (int c = 0; c < 3; ++c) {
      const double light = opponent_[3 * c] * rgb[0] + opponent_[3 * c + 1] * rgb[1] + opponent_[3 * c + 2] * rgb[2];
      work.error_[c][static_cast<size_t>(k)] = -light;
      if (ring_px_ > width_px_) work.error_[c][ring_.size() - 1 - static_cast<size_t>(k)] = -light;
    }
  }
  // The panel's light. Drives are mirrored by pixels: the panel goes on, it does not turn round.
  for (int x = 0; x < width_px_; ++x) {
    bool outside = false;
    for (int o = 0; o < 3; ++o) {
      double drive = static_cast<double>(test[3 * static_cast<ptrdiff_t>(x) + o]);
      if (range_ == Range::kClip && !(drive >= 0 && drive <= 1)) {
        outside = true;
        drive = std::clamp(drive, 0., 1.);
      }
      for (const EmitterCell& cell : layout_.emitters[layout_.emitter_of(o)].cells)
        for (int c = 0; c < 3; ++c) {
          const double light = emission_[o][c] * cell.share * drive;
          work.error_[c][static_cast<size_t>(x) * S + cell.x] += light;
          if (ring_px_ > width_px_) work.error_[c][static_cast<size_t>(ring_px_ - 1 - x) * S + cell.x] += light;
        }
    }
    clamped.test_pixels += outside;
  }

  for (int c = 0; c < 3; ++c) {
    ring_.forward(work.error_[c].data(), work.spectrum_.data());
    for (size_t n = 0; n < ring_.spectrum_size(); ++n) work.spectrum_[n] *= weights_[c][n];
    ring_.inverse(work.spectrum_.data(), work.error_[c].data());
    for (int x = 0; x < width_px_; ++x) {
      double sum = 0;
      for (int i = 0; i < S; ++i) {
        const double seen = work.error_[c][static_cast<size_t>(x) * S + i];
        sum += seen * seen;
      }
      energy[static_cast<ptrdiff_t>(x) * 3 + c] = sum / S;
    }
  }
  return clamped;
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

int automatic_border_px(double ppd, int width_px) {
  return std::min(static_cast<int>(std::ceil(ppd / 5)), (width_px - 1) / 2);
}

}  // namespace triad
