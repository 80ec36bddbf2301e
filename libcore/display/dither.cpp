// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/base/error.hpp>
#include <triad/base/parallel.hpp>
#include <triad/display/dither.hpp>
#include <triad/numeric/plane_blur.hpp>

namespace triad {
namespace {

constexpr double kFollowed_deg = .15;  // past most of the luminance kernel, and the inner part of the colours'
constexpr int kLeastRadius_px = 3, kMostAutomaticRadius_px = 10, kMostRadius_px = 16;
// Tiles of one colour of a 2 x 2 chessboard are farther apart than any radius: they can be decided at once.
constexpr int kTile_px = 48;
// A value this near to a level is that level, decoded by somebody else: below the finest step of 16 bits.
constexpr double kSameLevel = 0x1p-22;
static_assert(kTile_px > 2 * kMostRadius_px);

// Bayer's matrix, in 64ths: bits of x ^ y and y interleaved, the lowest one first.
double bayer(int x, int y) {
  int value = 0;
  for (int bit = 0; bit < 3; ++bit) value = value << 2 | ((x ^ y) >> bit & 1) << 1 | (y >> bit & 1);
  return (value + .5) / 64;
}

// IEC 61966-2-1.
double srgb_to_linear(double v) { return v <= .04045 ? v / 12.92 : std::pow((v + .055) / 1.055, 2.4); }

template <class Decode>
StoredLevels levels_of(int bits, const Decode& decode) {
  if (bits < 1 || bits > 16) throw_usage("bits=" + std::to_string(bits) + ": 1 to 16 are possible");
  StoredLevels out;
  const double most = (1 << bits) - 1;
  for (int k = 0; k <= static_cast<int>(most); ++k) {
    out.levels.push_back(static_cast<double>(static_cast<float>(decode(k / most))));  // as pictures hold them
    if (k > 0) out.limits.push_back(decode((k - .5) / most));
  }
  return out;
}

// The panel as drives act on it one by one: where it derives a white, a channel's light is taken to cover its whole
// pixel, for which emitter a step lights depends on the other channels.
Layout by_channels(const Layout& layout) {
  if (!layout.derives_white) return layout;
  Layout out = layout;
  out.derives_white = false;
  out.emitters.clear();
  for (int i = 0; i < layout.tile_x * layout.tile_y; ++i)
    for (int channel = 0; channel < 3; ++channel) {
      Emitter emitter;
      emitter.primary[static_cast<size_t>(channel)] = 1;
      emitter.pixel_x = i % layout.tile_x;
      emitter.pixel_y = i / layout.tile_x;
      emitter.channel = channel;
      for (int k = 0; k < layout.pixel_cells(); ++k)
        emitter.cells.push_back({emitter.pixel_x * layout.cells_x + k % layout.cells_x,
                                 emitter.pixel_y * layout.cells_y + k / layout.cells_x, 1. / layout.pixel_cells()});
      out.emitters.push_back(emitter);
    }
  return out;
}

// The level nearest to a value of 0 .. 1.
double nearest_level(const std::vector<double>& levels, double value) {
  const auto above = std::lower_bound(levels.begin(), levels.end(), value);
  if (above == levels.begin()) return levels.front();
  if (above == levels.end()) return levels.back();
  return *above - value < value - *(above - 1) ? *above : *(above - 1);
}

}  // namespace

StoredLevels srgb_levels(int bits) { return levels_of(bits, srgb_to_linear); }
StoredLevels linear_levels(int bits) {
  return levels_of(bits, [](double v) { return v; });
}

PanelDither::PanelDither(const Layout& layout, const Observer& observer, int origin_x_px, int origin_y_px,
                         StoredLevels levels, const DitherOptions& options)
    : radius_(options.radius_px > 0 ? options.radius_px
                                    : std::clamp(static_cast<int>(std::ceil(kFollowed_deg * observer.ppd)),
                                                 kLeastRadius_px, kMostAutomaticRadius_px)),
      tile_x_(layout.tile_x),
      tile_y_(layout.tile_y),
      origin_x_(((origin_x_px % tile_x_) + tile_x_) % tile_x_),
      origin_y_(((origin_y_px % tile_y_) + tile_y_) % tile_y_),
      passes_(options.passes),
      mode_(options.mode),
      levels_(std::move(levels)) {
  check_observer(observer);
  if (options.radius_px < 0 || options.radius_px > kMostRadius_px)
    throw_usage("radius=" + std::to_string(options.radius_px) + ": 0 to " + std::to_string(kMostRadius_px) +
                " px are possible");
  if (passes_ < 1 || passes_ > 16) throw_usage("passes=" + std::to_string(passes_) + ": 1 to 16 are possible");
  if (mode_ != Dither::kPerceptual) return;

  const Layout panel = by_channels(layout);
  const int reach = 2 * radius_ + 1, phases = tile_x_ * tile_y_;
  const auto tiles = [&](int tile) { return (4 * reach + tile - 1) / tile * tile; };
  const int side_x = tiles(tile_x_), side_y = tiles(tile_y_);
  const PanelTorus torus(panel, {side_x, side_y, 0, 0, Edge::kWrap, false});
  const PlaneBlur blur(torus.width(), torus.height());
  PlaneBlur::Workspace work(blur);
  const auto opponent = opponent_matrix(observer);
  const int nx = static_cast<int>(torus.width()), ny = static_cast<int>(torus.height());
  const auto cell_at = [&](int x, int y) {
    return static_cast<size_t>((y + ny) % ny) * static_cast<size_t>(nx) + static_cast<size_t>((x + nx) % nx);
  };
  kernels_.resize(static_cast<size_t>(phases) * 9 * reach * reach);
  std::vector<double> seen(torus.width() * torus.height()), sums(kernels_.size());
  // The pixel in the middle, at each phase of the tile.
  const int middle_x = side_x / 2 / tile_x_ * tile_x_, middle_y = side_y / 2 / tile_y_ * tile_y_;
  for (const Emitter& from : panel.emitters)
    for (size_t c = 0; c < 3; ++c) {
      const auto light_of = [&](const Emitter& e) {
        double sum = 0;
        for (size_t d = 0; d < 3; ++d) sum += opponent[3 * c + d] * e.primary[d];
        return sum * panel.pixel_cells();
      };
      std::vector<double> plane(seen.size());
      for (const EmitterCell& cell : from.cells)
        plane[cell_at(middle_x * panel.cells_x + cell.x, middle_y * panel.cells_y + cell.y)] +=
            light_of(from) * cell.share;
      blur.apply([&](size_t y, double* row) { std::copy_n(&plane[y * torus.width()], nx, row); },
                 [&](size_t n, double* values) {
                   torus.transfer(observer, static_cast<int>(c), n, values);
                   for (size_t m = 0; m <= torus.height() / 2; ++m) values[m] *= values[m];
                 },
                 torus.height(), [&](size_t y, const double* row) { std::copy_n(row, nx, &seen[y * torus.width()]); },
                 work);
      const int x0 = middle_x + from.pixel_x, y0 = middle_y + from.pixel_y;
      const size_t first = static_cast<size_t>((from.pixel_y * tile_x_ + from.pixel_x) * 3 + from.channel);
      for (const Emitter& to : panel.emitters)
        for (int dy = -radius_; dy <= radius_; ++dy)
          for (int dx = -radius_; dx <= radius_; ++dx) {
            const int x = x0 + dx, y = y0 + dy;
            if (x % tile_x_ != to.pixel_x || y % tile_y_ != to.pixel_y) continue;
            double shared = 0;
            for (const EmitterCell& cell : to.cells)
              shared +=
                  cell.share *
                  seen[cell_at((x - to.pixel_x) * panel.cells_x + cell.x, (y - to.pixel_y) * panel.cells_y + cell.y)];
            sums[((first * 3 + static_cast<size_t>(to.channel)) * reach + static_cast<size_t>(dy + radius_)) * reach +
                 static_cast<size_t>(dx + radius_)] += light_of(to) * shared;
          }
    }
  std::transform(sums.begin(), sums.end(), kernels_.begin(), [](double v) { return static_cast<float>(v); });
}

const float* PanelDither::kernel(int phase, int channel) const {
  const size_t reach = static_cast<size_t>(2 * radius_ + 1);
  return kernels_.data() + static_cast<size_t>(phase * 3 + channel) * 3 * reach * reach;
}

// Planes with a margin of the radius all round, so that a step's surroundings are always there.
struct PanelDither::Picture {
  int width, height;
  size_t stride, plane;
  std::vector<float> drives, steps, gradients;  // steps: level - drive as decided so far; planes of the 3 channels
  Picture(int w, int h, int radius)
      : width(w),
        height(h),
        stride(static_cast<size_t>(w) + 2 * static_cast<size_t>(radius)),
        plane(stride * (static_cast<size_t>(h) + 2 * static_cast<size_t>(radius))),
        drives(3 * static_cast<size_t>(w) * static_cast<size_t>(h)),
        steps(drives.size()),
        gradients(3 * plane) {}
};

uint64_t PanelDither::work_bytes(int width_px, int height_px) const {
  if (mode_ != Dither::kPerceptual) return 0;
  const auto w = static_cast<uint64_t>(width_px), h = static_cast<uint64_t>(height_px);
  const auto margin = static_cast<uint64_t>(2 * radius_);
  return (6 * w * h + 3 * (w + margin) * (h + margin)) * sizeof(float);
}

void PanelDither::decide_tile(Picture& p, int tile_x, int tile_y, bool first) const {
  const size_t reach = static_cast<size_t>(2 * radius_ + 1);
  const size_t own = static_cast<size_t>(radius_) * reach + static_cast<size_t>(radius_);  // a kernel's middle
  for (int y = tile_y * kTile_px; y < std::min(p.height, (tile_y + 1) * kTile_px); ++y)
    for (int x = tile_x * kTile_px; x < std::min(p.width, (tile_x + 1) * kTile_px); ++x) {
      const int phase = (y + origin_y_) % tile_y_ * tile_x_ + (x + origin_x_) % tile_x_;
      for (int channel = 0; channel < 3; ++channel) {
        const size_t i = 3 * (static_cast<size_t>(y) * static_cast<size_t>(p.width) + static_cast<size_t>(x)) +
                         static_cast<size_t>(channel);
        const float* shared = kernel(phase, channel);
        const double energy = static_cast<double>(shared[static_cast<size_t>(channel) * reach * reach + own]);
        const auto drive = static_cast<double>(p.drives[i]);
        const auto above = std::lower_bound(levels_.levels.begin(), levels_.levels.end(), drive);
        double step = *above - drive;
        if (step > 0) {
          const double down = *(above - 1) - drive;
          if (energy > 0) {
            const auto now = static_cast<double>(p.steps[i]);
            const auto gradient = static_cast<double>(
                p.gradients[static_cast<size_t>(channel) * p.plane + (static_cast<size_t>(y) + radius_) * p.stride +
                            static_cast<size_t>(x) + radius_]);
            const auto change = [&](double to) { return (to - now) * (2 * gradient + (to - now) * energy); };
            if (change(down) < change(step)) step = down;
          } else if (drive < levels_.limits[static_cast<size_t>(above - levels_.levels.begin()) - 1]) {
            step = down;
          }
        }
        const auto moved = static_cast<float>(step) - p.steps[i];
        if (moved == 0 || (energy == 0 && !first)) continue;
        p.steps[i] = static_cast<float>(step);
        for (size_t d = 0; d < 3; ++d)
          for (size_t dy = 0; dy < reach; ++dy) {
            float* to = &p.gradients[d * p.plane + (static_cast<size_t>(y) + dy) * p.stride + static_cast<size_t>(x)];
            const float* from = shared + (d * reach + dy) * reach;
            for (size_t dx = 0; dx < reach; ++dx) to[dx] += moved * from[dx];
          }
      }
    }
}

void PanelDither::apply(const PictureView& drives, int width_px, int height_px, float* out,
                        ptrdiff_t out_stride) const {
  const auto nearest = [&](double drive) {
    return levels_.levels[static_cast<size_t>(std::upper_bound(levels_.limits.begin(), levels_.limits.end(), drive) -
                                              levels_.limits.begin())];
  };
  const auto each = [&](const auto& value) {
    parallel_for(height_px, [&](int64_t y) {
      const float* from = drives.row(static_cast<int>(y));
      float* to = out + y * out_stride;
      for (int x = 0; x < width_px; ++x)
        for (int d = 0; d < 3; ++d, ++from, ++to)
          *to = static_cast<float>(value(std::clamp(static_cast<double>(*from), 0., 1.), x, static_cast<int>(y), d));
    });
  };
  const auto exact = [&](double drive) {
    const double level = nearest_level(levels_.levels, drive);
    return std::abs(drive - level) < kSameLevel ? level : drive;
  };
  if (mode_ == Dither::kNone) return each([&](double drive, int, int, int) { return nearest(drive); });
  if (mode_ == Dither::kOrdered)
    return each([&](double value, int x, int y, int) {
      const double drive = exact(value);
      const auto above = std::lower_bound(levels_.levels.begin(), levels_.levels.end(), drive);
      if (*above == drive) return drive;
      const double below = *(above - 1);
      return (drive - below) / (*above - below) > bayer(x % 8, y % 8) ? *above : below;
    });

  Picture p(width_px, height_px, radius_);
  each([&](double drive, int x, int y, int d) {
    return p.drives[3 * (static_cast<size_t>(y) * static_cast<size_t>(width_px) + static_cast<size_t>(x)) +
                    static_cast<size_t>(d)] = static_cast<float>(exact(drive));
  });
  const int across = (width_px + kTile_px - 1) / kTile_px, down = (height_px + kTile_px - 1) / kTile_px;
  for (int pass = 0; pass < passes_; ++pass)
    for (int colour = 0; colour < 4; ++colour) {
      const int columns = (across + 1 - colour % 2) / 2, rows = (down + 1 - colour / 2) / 2;
      parallel_for(int64_t{columns} * rows, [&](int64_t i) {
        decide_tile(p, static_cast<int>(i % columns) * 2 + colour % 2, static_cast<int>(i / columns) * 2 + colour / 2,
                    pass == 0);
      });
    }
  each([&](double drive, int x, int y, int d) {
    const size_t i = 3 * (static_cast<size_t>(y) * static_cast<size_t>(width_px) + static_cast<size_t>(x)) +
                     static_cast<size_t>(d);
    // To the level itself: the step was rounded to float.
    return nearest_level(levels_.levels, drive + static_cast<double>(p.steps[i]));
  });
}

}  // namespace triad
