// SPDX-License-Identifier: Apache-2.0
// Rows of a picture's cells on the torus on which it is solved.
#pragma once

#include <algorithm>
#include <triad/display/displaced_box.hpp>
#include <triad/display/torus.hpp>
#include <triad/numeric/aligned.hpp>
#include <vector>

namespace triad {

// One row of cells of the ring, interleaved RGB, clamped to [0, 1] if asked, with a halo that repeats the ring at
// both ends.
template <class Real>
class RingRows {
 public:
  RingRows(const TorusAxis& axis, int left, int right, bool clamp) : left_(left), clamp_(clamp) {
    const int cells = axis.length_cells();
    for (int k = -left; k < cells + right; ++k) source_.push_back(3 * axis.cell_at(((k % cells) + cells) % cells));
    before_ = static_cast<size_t>(left + axis.before_px * axis.cells);
    inside_ = static_cast<size_t>(std::min(axis.size_px, axis.length_px() - axis.before_px)) * axis.cells;
  }

  size_t floats() const { return 3 * source_.size(); }
  // Where cell 0 lies in a buffer of floats() that fill() wrote.
  ptrdiff_t start() const { return 3 * static_cast<ptrdiff_t>(left_); }

  template <class Sample>
  void fill(const Sample* picture_row, Real* out) const {
    if (!clamp_) {
      for (size_t k = 0; k < source_.size(); ++k)
        for (size_t d = 0; d < 3; ++d)
          out[3 * k + d] = static_cast<Real>(picture_row[static_cast<size_t>(source_[k]) + d]);
      return;
    }
    const auto clamped = [](Sample v) { return static_cast<Real>(v < 0 ? Sample{0} : v > 1 ? Sample{1} : v); };
    const auto copy = [&](size_t from, size_t to) {
      for (size_t k = from; k < to; ++k)
        for (size_t d = 0; d < 3; ++d) out[3 * k + d] = clamped(picture_row[static_cast<size_t>(source_[k]) + d]);
    };
    copy(0, before_);
    for (size_t i = 0; i < 3 * inside_; ++i) out[3 * before_ + i] = clamped(picture_row[i]);
    copy(before_ + inside_, source_.size());
  }

 private:
  int left_;
  bool clamp_;
  size_t before_, inside_;
  std::vector<int> source_;  // of each cell: its place in the picture's row, times 3
};

// Elements from a plane to the next so that each begins on a cache line.
template <class T>
size_t aligned_stride(size_t n) {
  constexpr size_t kLine = kBufferAlignment_bytes / sizeof(T);
  return (n + kLine - 1) / kLine * kLine;
}

}  // namespace triad
