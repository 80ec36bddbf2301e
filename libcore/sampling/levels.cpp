// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <triad/base/parallel.hpp>
#include <triad/numeric/widest.hpp>
#include <triad/sampling/levels.hpp>

namespace triad {
namespace {

constexpr float kNearest = 1e-30f;  // scene units; so that a hit at the viewer divides by no zero

int cells_along(int film_px, double cell_px) { return static_cast<int>(std::ceil(film_px / cell_px)); }

int floor_quarter(int n) { return n >> 2; }

// Two opposite neighbours of a cell: columns relative to it, and rows of which -1 is above.
struct Pair {
  int x1, y1, x2, y2;
};

std::span<const Pair> pairs_of(const LevelLattice& lattice, int row) {
  static constexpr Pair kSquare[] = {{-1, 0, 1, 0}, {0, -1, 0, 1}, {-1, -1, 1, 1}, {-1, 1, 1, -1}};
  // East and west, north-east and south-west, north-west and south-east; the cells above and below a shifted row
  // stand half a cell to the left.
  static constexpr Pair kEven[] = {{1, 0, -1, 0}, {0, -1, -1, 1}, {-1, -1, 0, 1}};
  static constexpr Pair kShifted[] = {{1, 0, -1, 0}, {1, -1, 0, 1}, {0, -1, 1, 1}};
  if (!lattice.shifted) return kSquare;
  return lattice.shift(row) ? std::span<const Pair>(kShifted) : std::span<const Pair>(kEven);
}

// What a row's neighbourhoods sum up to, over the pairs that count.
struct RowSums {
  explicit RowSums(int width) : all(static_cast<size_t>(width) * kSums) {}
  enum Sum { kRed, kGreen, kBlue, kPosition, kMixed, kOthers, kCount, kSums };
  float* of(Sum sum, int width) { return all.data() + static_cast<size_t>(sum) * static_cast<size_t>(width); }
  std::vector<float> all;
};

// sum[x] += weight[x] * |a - (b + c) / 2|
TRIAD_INLINE_BODY inline void add_differences(int width, const float* __restrict weight, const float* __restrict a,
                                              const float* __restrict b, const float* __restrict c,
                                              float* __restrict sum) {
  for (int x = 0; x < width; ++x) sum[x] += weight[x] * std::abs(a[x] - .5f * (b[x] + c[x]));
}

}  // namespace

LevelLattice::LevelLattice(int film_width, int film_height, double side_px, bool shift)
    : width(cells_along(film_width, side_px)),
      height(cells_along(film_height, side_px)),
      cell_px(side_px),
      shifted(shift) {}

Level::Level(const LevelLattice& lattice, bool geometry)
    : lattice_(lattice), geometry_(geometry), stride_(static_cast<size_t>(lattice.width) + 2) {
  for (int p = 0; p < (geometry ? kPlanes : kDistance); ++p) planes_[p].resize(cells());
  if (geometry) ids_.resize(cells());
}

bool Level::set(int x, int y, std::span<const Sample> samples) {
  std::array<double, 3> sum{};
  const Sample* first = nullptr;
  int valid = 0;
  for (const Sample& sample : samples) {
    if (!sample.valid) continue;
    if (!first) first = &sample;
    for (int c = 0; c < 3; ++c) sum[c] += sample.rgb[c];
    ++valid;
  }
  if (!first) return false;
  const size_t i = at(x, y);
  for (int c = 0; c < 3; ++c) planes_[kRed + c][i] = static_cast<float>(sum[c] / valid);
  plane(kKnown)[i] = 1;
  if (!geometry_) return true;
  const std::array<float, 3>& position = first->position;
  const bool hit = std::isfinite(first->distance) && std::isfinite(position[0]) && std::isfinite(position[1]) &&
                   std::isfinite(position[2]);
  plane(kHit)[i] = hit;
  plane(kDistance)[i] = hit ? std::max(first->distance, kNearest) : 0;
  for (int c = 0; c < 3; ++c) planes_[kX + c][i] = hit ? position[c] : 0;
  ids_[i] = first->object_id;
  return true;
}

void Level::repeat_border(int y) {
  const auto repeat = [&](auto& values) {
    if (values.empty()) return;
    values[at(-1, y)] = values[at(0, y)];
    values[at(lattice_.width, y)] = values[at(lattice_.width - 1, y)];
  };
  for (auto& values : planes_) repeat(values);
  repeat(ids_);
}

void Level::judge(const LevelThresholds& thresholds) {
  reasons_.resize(cells());
  parallel_for(lattice_.height, [&](int64_t y) { repeat_border(static_cast<int>(y)); });
  parallel_for(lattice_.height, [&](int64_t y) {
    const int row = static_cast<int>(y);
    judge_row(row, thresholds);
    reasons_[at(-1, row)] = reasons_[at(0, row)];
    reasons_[at(lattice_.width, row)] = reasons_[at(lattice_.width - 1, row)];
  });
}

void Level::judge_row(int y, const LevelThresholds& thresholds) {
  const int width = lattice_.width;
  const bool positions = geometry_ && thresholds.geometry, ids = geometry_ && thresholds.ids;
  RowSums sums(width);
  std::vector<float> weights(static_cast<size_t>(width));
  const size_t here = at(0, y);
  const auto row = [&](int dy) { return std::clamp(y + dy, 0, lattice_.height - 1); };
  const auto body = [&]() TRIAD_INLINE_BODY {
    for (const Pair& pair : pairs_of(lattice_, y)) {
      const size_t one = at(pair.x1, row(pair.y1)), two = at(pair.x2, row(pair.y2));
      float* const __restrict weight = weights.data();
      float* const __restrict count = sums.of(RowSums::kCount, width);
      const float *const known = plane(kKnown) + here, *const known1 = plane(kKnown) + one,
                         *const known2 = plane(kKnown) + two;
      for (int x = 0; x < width; ++x) {
        weight[x] = known[x] * known1[x] * known2[x];
        count[x] += weight[x];
      }
      for (int c = 0; c < 3; ++c)
        add_differences(width, weight, planes_[kRed + c].data() + here, planes_[kRed + c].data() + one,
                        planes_[kRed + c].data() + two, sums.of(static_cast<RowSums::Sum>(c), width));
      if (positions) {
        add_differences(width, weight, plane(kHit) + here, plane(kHit) + one, plane(kHit) + one,
                        sums.of(RowSums::kMixed, width));
        add_differences(width, weight, plane(kHit) + here, plane(kHit) + two, plane(kHit) + two,
                        sums.of(RowSums::kMixed, width));
        float* const __restrict sum = sums.of(RowSums::kPosition, width);
        for (int x = 0; x < width; ++x) {
          float squares = 0;
          for (int c = kX; c <= kZ; ++c) {
            const float* const values = planes_[c].data();
            const float difference = values[here + x] - .5f * (values[one + x] + values[two + x]);
            squares += difference * difference;
          }
          sum[x] += weight[x] * std::sqrt(squares);
        }
      }
      if (ids) {
        float* const others = sums.of(RowSums::kOthers, width);
        for (int x = 0; x < width; ++x)
          if (ids_[one + x] != ids_[here + x] || ids_[two + x] != ids_[here + x]) others[x] += weight[x];
      }
    }
  };
  run_widest(body);

  const float *const red = sums.of(RowSums::kRed, width), *const green = sums.of(RowSums::kGreen, width),
                     *const blue = sums.of(RowSums::kBlue, width),
                     *const position = sums.of(RowSums::kPosition, width),
                     *const mixed = sums.of(RowSums::kMixed, width), *const others = sums.of(RowSums::kOthers, width),
                     *const count = sums.of(RowSums::kCount, width);
  for (int x = 0; x < width; ++x) {
    LevelReason reason = LevelReason::kNone;
    const double most = std::max({red[x], green[x], blue[x]}), pairs = count[x];
    if (pairs == 0)
      reason = LevelReason::kUnknown;
    else if (most > thresholds.colour * pairs)
      reason = LevelReason::kColour;
    else if (positions && (mixed[x] > 0 || (plane(kHit)[here + x] > 0 &&
                                            position[x] > thresholds.position * pairs * plane(kDistance)[here + x])))
      reason = LevelReason::kPosition;
    else if (others[x] > 0)
      reason = LevelReason::kId;
    reasons_[here + x] = static_cast<uint8_t>(reason);
  }
}

void Level::interpolate_row(int y, const Level& above) {
  // In halves of this lattice's cells, and from the first centre above: rows and columns are between two of a quarter
  // of such a number, rounded down, and the next one.
  const int down = 2 * y - 1, height = above.lattice_.height;
  const int rows[2] = {std::clamp(floor_quarter(down), 0, height - 1),
                       std::clamp(floor_quarter(down) + 1, 0, height - 1)};
  const float g = static_cast<float>(down & 3) / 4;
  const int planes = geometry_ ? kPlanes : kDistance;
  for (int parity = 0; parity < 2; ++parity) {
    size_t starts[2];
    float f[2];
    for (int r = 0; r < 2; ++r) {
      const int across = 2 * parity - 1 + lattice_.shift(y) - 2 * above.lattice_.shift(rows[r]);
      starts[r] = above.at(floor_quarter(across), rows[r]);
      f[r] = static_cast<float>(across & 3) / 4;
    }
    const int count = (lattice_.width + 1 - parity) / 2;
    const float fa = f[0], fb = f[1];
    run_widest([&]() TRIAD_INLINE_BODY {
      for (int p = 0; p < planes; ++p) {
        const float* const __restrict a = above.planes_[p].data() + starts[0], * const __restrict b =
                                                                                   above.planes_[p].data() +
                                                                                   starts[1];
        float* const __restrict out = planes_[p].data() + at(parity, y);
        for (int k = 0; k < count; ++k) {
          const float upper = a[k] + fa * (a[k + 1] - a[k]), lower = b[k] + fb * (b[k + 1] - b[k]);
          out[2 * k] = upper + g * (lower - upper);
        }
      }
    });
  }
  const size_t here = at(0, y);
  for (int x = 0; x < lattice_.width; ++x) {
    const size_t i = here + static_cast<size_t>(x);
    float& known = plane(kKnown)[i];
    if (known > 0 && known < 1) {
      for (int c = kRed; c <= kBlue; ++c) planes_[c][i] /= known;
      known = 1;
    }
    if (!geometry_) continue;
    const size_t parent = above.parent(lattice_, x, y);
    float& hit = plane(kHit)[i];
    const float share = hit;
    hit = above.plane(kHit)[parent];
    for (int p = kDistance; p <= kZ; ++p) planes_[p][i] = hit > 0 ? planes_[p][i] / share : 0;
    ids_[i] = above.ids_[parent];
  }
}

}  // namespace triad
