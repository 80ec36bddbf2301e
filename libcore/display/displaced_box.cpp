// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/display/displaced_box.hpp>

namespace triad {
namespace {

BoxWindow window_from(double left, int length) {
  const double right = left + length;
  BoxWindow box;
  box.first_cell = static_cast<int>(std::floor(left));
  for (int cell = box.first_cell; cell < right; ++cell)
    box.weights.push_back((std::min(right, cell + 1.0) - std::max<double>(left, cell)) / length);
  return box;
}

// The white emitter of the same pixel, or -1.
int white_of(const Layout& layout, int pixel_x, int pixel_y) {
  for (size_t e = 0; e < layout.emitters.size(); ++e) {
    const Emitter& emitter = layout.emitters[e];
    if (emitter.channel == kWhiteChannel && emitter.pixel_x == pixel_x && emitter.pixel_y == pixel_y)
      return static_cast<int>(e);
  }
  return -1;
}

}  // namespace

BoxWindow displaced_box(const Layout& layout, int emitter) {
  const Emitter& e = layout.emitters[static_cast<size_t>(emitter)];
  return window_from(layout.derives_white ? e.pixel_x * layout.cells_x : e.centre_x() - .5 * layout.cells_x,
                     layout.cells_x);
}

BoxWindow displaced_box_rows(const Layout& layout, int emitter) {
  const Emitter& e = layout.emitters[static_cast<size_t>(emitter)];
  return window_from(layout.derives_white ? e.pixel_y * layout.cells_y : e.centre_y() - .5 * layout.cells_y,
                     layout.cells_y);
}

DisplacedBox::DisplacedBox(const Layout& layout) : tile_cells_x_(layout.cells_x * layout.tile_x) {
  for (size_t i = 0; i < layout.emitters.size(); ++i) {
    const Emitter& emitter = layout.emitters[i];
    const int e = static_cast<int>(i);
    windows_.push_back({displaced_box(layout, e), displaced_box_rows(layout, e), emitter.channel,
                        layout.derives_white ? white_of(layout, emitter.pixel_x, emitter.pixel_y) : -1});
    const Window& w = windows_.back();
    above_ = std::max(above_, -w.y.first_cell);
    below_ = std::max(below_, w.y.first_cell + static_cast<int>(w.y.weights.size()));
    left_ = std::max(left_, -w.x.first_cell);
    right_ = std::max(right_, w.x.first_cell + static_cast<int>(w.x.weights.size()));
  }
}

template <class Real>
void DisplacedBox::tiles(const Real* const* rows, int tiles, Real* drives, ptrdiff_t stride) const {
  const ptrdiff_t step = 3 * static_cast<ptrdiff_t>(tile_cells_x_);
  for (size_t e = 0; e < windows_.size(); ++e) {
    const Window& w = windows_[e];
    Real* out = drives + static_cast<ptrdiff_t>(e) * stride;
    std::fill_n(out, tiles, Real{0});
    if (w.channel == kWhiteChannel) continue;
    for (size_t j = 0; j < w.y.weights.size(); ++j)
      for (size_t i = 0; i < w.x.weights.size(); ++i) {
        const Real weight = static_cast<Real>(w.y.weights[j] * w.x.weights[i]);
        const Real* from = rows[above_ + w.y.first_cell + static_cast<int>(j)] +
                           3 * (w.x.first_cell + static_cast<ptrdiff_t>(i)) + w.channel;
        for (int t = 0; t < tiles; ++t) out[t] += weight * from[t * step];
      }
  }
  for (size_t white = 0; white < windows_.size(); ++white) {
    if (windows_[white].channel != kWhiteChannel) continue;
    Real* w = drives + static_cast<ptrdiff_t>(white) * stride;
    bool first = true;
    for (size_t e = 0; e < windows_.size(); ++e) {
      if (windows_[e].white != static_cast<int>(white) || e == white) continue;
      const Real* colour = drives + static_cast<ptrdiff_t>(e) * stride;
      for (int t = 0; t < tiles; ++t) w[t] = first ? colour[t] : std::min(w[t], colour[t]);
      first = false;
    }
    for (size_t e = 0; e < windows_.size(); ++e) {
      if (windows_[e].white != static_cast<int>(white) || e == white) continue;
      Real* colour = drives + static_cast<ptrdiff_t>(e) * stride;
      for (int t = 0; t < tiles; ++t) colour[t] -= w[t];
    }
  }
}

DriveOrder::DriveOrder(const Layout& layout)
    : tile_x_(layout.tile_x),
      tile_y_(layout.tile_y),
      emitter_(3 * static_cast<size_t>(tile_x_) * tile_y_, -1),
      white_(static_cast<size_t>(tile_x_) * tile_y_, -1) {
  for (size_t e = 0; e < layout.emitters.size(); ++e) {
    const Emitter& emitter = layout.emitters[e];
    const auto pixel = static_cast<size_t>(emitter.pixel_y * tile_x_ + emitter.pixel_x);
    (emitter.channel == kWhiteChannel ? white_[pixel] : emitter_[3 * pixel + static_cast<size_t>(emitter.channel)]) =
        static_cast<int>(e);
  }
  // A channel that a pixel's panel does not have says what the nearest emitter of that colour shows: the panel
  // ignores it, but other programs show it, and mirrored at a border it may come to lie where there is an emitter.
  const std::vector<int> own = emitter_;
  for (int y = 0; y < tile_y_; ++y)
    for (int x = 0; x < tile_x_; ++x)
      for (int c = 0; c < 3; ++c) {
        const auto pixel = static_cast<size_t>(y * tile_x_ + x);
        if (own[3 * pixel + static_cast<size_t>(c)] >= 0 || white_[pixel] >= 0) continue;
        int nearest = tile_x_ + tile_y_;
        for (size_t e = 0; e < layout.emitters.size(); ++e) {
          const Emitter& emitter = layout.emitters[e];
          const int far = std::abs(emitter.pixel_x - x) + std::abs(emitter.pixel_y - y);
          if (emitter.channel != c || far >= nearest) continue;
          nearest = far;
          emitter_[3 * pixel + static_cast<size_t>(c)] = static_cast<int>(e);
        }
      }
}

template <class Real, class Sample>
void DriveOrder::pixels(const Real* drives, ptrdiff_t stride, int tiles, int pixel_y, Sample* rgb) const {
  for (int x = 0; x < tile_x_; ++x)
    for (int c = 0; c < 3; ++c) {
      const auto pixel = static_cast<size_t>(pixel_y * tile_x_ + x);
      const int e = emitter_[3 * pixel + static_cast<size_t>(c)];
      const Real* from = e < 0 ? nullptr : drives + e * stride;
      const Real* white = white_[pixel] < 0 ? nullptr : drives + white_[pixel] * stride;
      Sample* to = rgb + 3 * x + c;
      const ptrdiff_t step = 3 * static_cast<ptrdiff_t>(tile_x_);
      if (white) {  // what rounding puts above 1 is 1
        for (int t = 0; t < tiles; ++t) {
          const Real sum = (from ? from[t] : Real{0}) + white[t];
          to[t * step] = static_cast<Sample>(sum > 1 && sum < 1 + Real{1e-5f} ? Real{1} : sum);
        }
      } else {
        for (int t = 0; t < tiles; ++t) to[t * step] = static_cast<Sample>(from ? from[t] : Real{0});
      }
    }
}

template void DisplacedBox::tiles(const float* const*, int, float*, ptrdiff_t) const;
template void DisplacedBox::tiles(const double* const*, int, double*, ptrdiff_t) const;
template void DriveOrder::pixels(const float*, ptrdiff_t, int, int, float*) const;
template void DriveOrder::pixels(const double*, ptrdiff_t, int, int, float*) const;
template void DriveOrder::pixels(const double*, ptrdiff_t, int, int, double*) const;

}  // namespace triad
