// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <triad/base/error.hpp>
#include <triad/evaluation/noise_spectrum.hpp>
#include <triad/numeric/aligned.hpp>
#include <triad/numeric/fft.hpp>

namespace triad {
namespace {

using Complex = std::complex<double>;
constexpr int kLow = NoiseSums::kLow;
constexpr int kLeastStripRows = 64;

// Half a sample off the usual form: symmetric, and 1 for a single sample, where that is 0.
std::vector<double> hann(int n) {
  std::vector<double> window;
  for (int j = 0; j < n; ++j) window.push_back(.5 - .5 * std::cos(2 * std::numbers::pi * (j + .5) / n));
  return window;
}

// Beginnings of tiles of `tile` that cover `size`, neighbours at most half a tile apart, the last at the end.
std::vector<int> beginnings(int size, int tile) {
  if (size <= tile) return {0};
  const int64_t room = size - tile, hop = tile / 2, steps = (room + hop - 1) / hop;
  std::vector<int> begin;
  for (int64_t k = 0; k <= steps; ++k) begin.push_back(static_cast<int>((k * room + steps / 2) / steps));
  return begin;
}

// A column's length in memory begins on a line of the cache for every row.
int padded(int columns) {
  constexpr int kLine = kBufferAlignment_bytes / sizeof(Complex);
  return (columns + kLine - 1) / kLine * kLine;
}

}  // namespace

struct NoiseSpectrum::Work {
  explicit Work(const NoiseSpectrum& s)
      : rows(static_cast<size_t>(s.tile_x_)),
        columns(static_cast<size_t>(s.tile_y_), static_cast<size_t>(s.columns_)),
        line(static_cast<size_t>(s.tile_x_)),
        picture(static_cast<size_t>(s.tile_y_) * static_cast<size_t>(s.columns_)),
        window(picture.size()) {}
  RealFft<double> rows;
  ColumnFft<double> columns;
  AlignedBuffer<double> line;
  AlignedBuffer<Complex> picture, window;
  double window_energy = 0;
  bool has_window = false;  // `window` is that without weights, to be used again
};

NoiseSpectrum::NoiseSpectrum(int width, int height, int tile, int planes, double cut)
    : width_(width),
      height_(height),
      planes_(planes),
      tile_x_(std::min(tile, width)),
      tile_y_(std::min(tile, height)),
      strip_rows_(static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::max(kLeastStripRows, tile / 2))))),
      columns_(padded(tile_x_ / 2 + 1)) {
  if (width < 1 || height < 1 || tile < kLeastSpectrumTile_px || tile > kMostSpectrumTile_px || planes < 1 ||
      planes > kMostNoisePlanes || !(cut > 0))
    throw_internal("a noise spectrum of no sensible size");
  begin_x_ = beginnings(width, tile);
  begin_y_ = beginnings(height, tile);
  window_x_ = hann(tile_x_);
  window_y_ = hann(tile_y_);
  const int longer = std::max(tile_x_, tile_y_), half = tile_x_ / 2 + 1;
  bins_ = static_cast<int>(std::lround(longer * std::sqrt(.5))) + 1;
  count_.assign(kLow + 1, 0);
  frequency_.assign(kLow + 1, 0);
  for (int ky = 0; ky < tile_y_; ++ky)
    for (int kx = 0; kx < half; ++kx) {
      const double fx = static_cast<double>(kx) / tile_x_,
                   fy = static_cast<double>(std::min(ky, tile_y_ - ky)) / tile_y_;
      const double f = std::hypot(fx, fy), copies = kx == 0 || 2 * kx == tile_x_ ? 1 : 2;
      const auto bin = static_cast<int16_t>(std::lround(f * longer));
      bin_.push_back(bin);
      low_.push_back(f < cut);
      count_[static_cast<size_t>(bin)] += copies;
      frequency_[static_cast<size_t>(bin)] += copies * f;
      if (f < cut) count_[kLow] += copies;
    }
}

int NoiseSpectrum::last_row(int y0, int y1) const {
  int last = std::min(height_, y1 + 1);  // the neighbours below
  for (const int begin : begin_y_)
    if (begin >= y0 && begin < y1) last = std::max(last, begin + tile_y_);
  return last;
}

uint64_t NoiseSpectrum::work_bytes() const {
  return sizeof(double) * static_cast<uint64_t>(tile_x_) +
         2 * sizeof(Complex) * static_cast<uint64_t>(tile_y_) * static_cast<uint64_t>(columns_);
}

void NoiseSpectrum::add(const NoiseRows& rows, int y0, int y1, NoiseSums& sums) const {
  add_lags(rows, y0, std::min(y1, height_), sums);
  Work work(*this);
  for (const int y : begin_y_)
    if (y >= y0 && y < y1)
      for (const int x : begin_x_) add_tile(rows, x, y, work, sums);
}

void NoiseSpectrum::add_lags(const NoiseRows& rows, int y0, int y1, NoiseSums& sums) const {
  for (int y = y0; y < y1; ++y) {
    const size_t at = static_cast<size_t>(y - rows.y0) * static_cast<size_t>(width_);
    const double* w = rows.weight ? rows.weight + at : nullptr;
    const bool below = y + 1 < height_;
    for (int p = 0; p < planes_; ++p) {
      const double *d = rows.plane[static_cast<size_t>(p)] + at, *next = d + width_;
      // Sums over one row are plain: they lose no more than 1e-12 of it.
      double value = 0, square = 0, weight = 0, xp = 0, xs = 0, xw = 0, yp = 0, ys = 0, yw = 0;
      for (int x = 0; x < width_; ++x) {
        const double own = w ? w[x] : 1;
        weight += own;
        value += own * d[x];
        square += own * d[x] * d[x];
        if (x + 1 < width_) {
          const double both = w ? own * w[x + 1] : 1;
          xp += both * d[x] * d[x + 1];
          xs += both * (d[x] + d[x + 1]);
          xw += both;
        }
        if (below) {
          const double both = w ? own * w[x + width_] : 1;
          yp += both * d[x] * next[x];
          ys += both * (d[x] + next[x]);
          yw += both;
        }
      }
      if (p == 0) sums.weight.add(weight);
      sums.value[p].add(value);
      sums.square[p].add(square);
      sums.x[p].product.add(xp);
      sums.x[p].sum.add(xs);
      sums.x[p].weight.add(xw);
      sums.y[p].product.add(yp);
      sums.y[p].sum.add(ys);
      sums.y[p].weight.add(yw);
    }
  }
}

// values: the plane's first row is y_offset rows above the tile's; nullptr: 1 everywhere.
void NoiseSpectrum::transform(const double* values, const double* weights, int x0, int y_offset, Work& work,
                              bool window) const {
  AlignedBuffer<Complex>& out = window ? work.window : work.picture;
  double energy = 0;
  for (int y = 0; y < tile_y_; ++y) {
    const size_t at = static_cast<size_t>(y + y_offset) * static_cast<size_t>(width_) + static_cast<size_t>(x0);
    for (int x = 0; x < tile_x_; ++x) {
      const auto i = static_cast<size_t>(x);
      double v = window_x_[i] * window_y_[static_cast<size_t>(y)];
      if (weights) v *= weights[at + i];
      if (window) energy += v * v;
      work.line[i] = values ? v * values[at + i] : v;
    }
    work.rows.forward(work.line.data(), out.data() + static_cast<size_t>(y) * static_cast<size_t>(columns_));
  }
  work.columns.forward(out.data());
  if (window) work.window_energy = energy;
}

void NoiseSpectrum::add_tile(const NoiseRows& rows, int x0, int y0, Work& work, NoiseSums& sums) const {
  const int offset = y0 - rows.y0, half = tile_x_ / 2 + 1;
  if (rows.weight || !work.has_window) transform(nullptr, rows.weight, x0, offset, work, true);
  work.has_window = !rows.weight;
  if (!(work.window_energy > 0)) return;
  sums.energy.add(work.window_energy);
  for (int p = 0; p < planes_; ++p) {
    transform(rows.plane[static_cast<size_t>(p)], rows.weight, x0, offset, work, false);
    size_t i = 0;
    for (int ky = 0; ky < tile_y_; ++ky) {
      const size_t at = static_cast<size_t>(ky) * static_cast<size_t>(columns_);
      for (int kx = 0; kx < half; ++kx, ++i) {
        const Complex v = work.picture[at + static_cast<size_t>(kx)], w = work.window[at + static_cast<size_t>(kx)];
        const double copies = kx == 0 || 2 * kx == tile_x_ ? 1 : 2;
        const double power = copies * std::norm(v);
        const double cross = copies * (v.real() * w.real() + v.imag() * w.imag());
        const double window = p == 0 ? copies * std::norm(w) : 0;
        const auto add_to = [&](int bin) {
          sums.power[bin] += power;
          sums.cross[p][bin] += cross;
          sums.window[bin] += window;
        };
        add_to(bin_[i]);
        if (low_[i]) add_to(kLow);
      }
    }
  }
}

void NoiseSpectrum::merge(NoiseSums& into, const NoiseSums& later) {
  for (int b = 0; b <= kLow; ++b) {
    into.power[b] += later.power[b];
    into.window[b] += later.window[b];
    for (int p = 0; p < kMostNoisePlanes; ++p) into.cross[p][b] += later.cross[p][b];
  }
  into.energy.merge(later.energy);
  into.weight.merge(later.weight);
  const auto merge_lag = [](NoiseSums::Lag& a, const NoiseSums::Lag& b) {
    a.product.merge(b.product);
    a.sum.merge(b.sum);
    a.weight.merge(b.weight);
  };
  for (int p = 0; p < kMostNoisePlanes; ++p) {
    into.value[p].merge(later.value[p]);
    into.square[p].merge(later.square[p]);
    merge_lag(into.x[p], later.x[p]);
    merge_lag(into.y[p], later.y[p]);
  }
}

NoiseResult NoiseSpectrum::finish(const NoiseSums& sums) const {
  const double weight = sums.weight.value();
  if (!(weight > 0)) throw_internal("a noise spectrum of no pixel");
  NoiseResult result;
  double mean[kMostNoisePlanes] = {}, raw = 0;
  for (int p = 0; p < planes_; ++p) {
    mean[p] = sums.value[p].value() / weight;
    raw += sums.square[p].value() / weight;
    result.variance += sums.square[p].value() / weight - mean[p] * mean[p];
  }
  // A constant difference leaves only what rounding made of it.
  constexpr double kRounding = 1e-13;
  const bool constant = !(result.variance > kRounding * raw);
  const auto power_of = [&](int bin) {
    double power = sums.power[bin];
    for (int p = 0; p < planes_; ++p) power += mean[p] * (mean[p] * sums.window[bin] - 2 * sums.cross[p][bin]);
    return constant ? 0 : std::max(0., power);
  };
  if (constant) {
    result.variance = 0;
  } else {
    double x = 0, y = 0;
    const auto covariance = [&](const NoiseSums::Lag& lag, double m) {
      const double w = lag.weight.value();
      return w > 0 ? (lag.product.value() - m * lag.sum.value()) / w + m * m : 0;
    };
    for (int p = 0; p < planes_; ++p) {
      x += covariance(sums.x[p], mean[p]);
      y += covariance(sums.y[p], mean[p]);
    }
    result.lag_x = x / result.variance;
    result.lag_y = y / result.variance;
  }
  double total = 0;
  const double energy = sums.energy.value();
  for (int b = 0; b < bins_; ++b) {
    const auto i = static_cast<size_t>(b);
    if (count_[i] == 0) continue;
    const double power = power_of(b);
    total += power;
    result.frequency.push_back(frequency_[i] / count_[i]);
    result.power.push_back(energy > 0 ? power / (energy * planes_ * count_[i]) : 0);
  }
  result.low_share = total > 0 ? power_of(kLow) / total : 0;
  result.white_share = count_[kLow] / (static_cast<double>(tile_x_) * tile_y_);
  result.variance /= planes_;
  return result;
}

}  // namespace triad
