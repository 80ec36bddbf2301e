// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <triad/base/error.hpp>
#include <triad/base/random.hpp>
#include <triad/sampling/lattice.hpp>

namespace triad {

Lattice::Lattice(SampleTaker& taker, int bits, bool with_centres, double gamma)
    : taker_(taker),
      bits_(bits),
      width_(taker.film().width()),
      height_(taker.film().height()),
      encode_(gamma),
      slots_(1024) {
  if (int64_t{std::max(width_, height_)} << bits > INT32_MAX)
    throw_input("a picture of " + std::to_string(width_) + "x" + std::to_string(height_) +
                " pixels is too large to be divided " + std::to_string(bits) + " times; take a smaller depth");
  corners_.resize(border(0, height_ + 1));
  borders_.resize(corners_.size());
  if (with_centres) centres_.resize(taker.film().pixels());
}

SampleRequest Lattice::request(LatticePoint point) const {
  const int32_t x = std::min(point.x >> bits_, width_ - 1), y = std::min(point.y >> bits_, height_ - 1);
  const int32_t inside_x = point.x - (x << bits_), inside_y = point.y - (y << bits_);
  const double unit = 1. / side();
  // A point first seen by cells of 2^-k of a pixel is a multiple of that.
  const int32_t least_bit = inside_x | inside_y | side();
  const auto footprint = static_cast<float>((least_bit & -least_bit) * unit);
  const auto index =
      static_cast<uint32_t>(inside_y) * static_cast<uint32_t>(side() + 1) + static_cast<uint32_t>(inside_x);
  return {point.x * unit, point.y * unit, footprint, x, y, index, taker_.options().seed};
}

bool Lattice::ask_corners() {
  const auto columns = static_cast<size_t>(width_ + 1), width = static_cast<size_t>(width_);
  const auto take = [&](std::vector<PovColour>& colours, size_t row, int32_t offset) {
    return ask_many(
        taker_, colours.size(),
        [&](size_t i) {
          const auto x = static_cast<int32_t>(i % row), y = static_cast<int32_t>(i / row);
          return request({(x << bits_) + offset, (y << bits_) + offset});
        },
        [&](size_t i, const Sample& sample) { colours[i] = encode_(sample); });
  };
  return take(corners_, columns, 0) && take(centres_, width, side() / 2);
}

// The points of a pixel are asked for together, so those that differ in their first three binary digits only share a
// group of slots, which is a few lines of the processor's cache.
size_t Lattice::slot(LatticePoint point) const {
  const int shift = std::max(0, bits_ - 3), digits = 7 << shift;
  const uint64_t key =
      uint64_t{static_cast<uint32_t>(point.y & ~digits)} << 32 | static_cast<uint32_t>(point.x & ~digits);
  const auto inside = static_cast<uint64_t>((point.y & digits) >> shift << 3 | (point.x & digits) >> shift);
  const size_t mask = slots_.size() - 1;
  size_t at = (mix_bits(key) ^ inside) & mask;
  // Odd, and so comes to every slot; to another group, where this one may well be full.
  while (slots_[at].index != kNone && slots_[at].point != point) at = (at + 65) & mask;
  return at;
}

const PovColour* Lattice::find(LatticePoint point) const {
  const int32_t mask = side() - 1, x = point.x & mask, y = point.y & mask;
  if ((x | y) == 0) return &corner(point.x >> bits_, point.y >> bits_);
  if (!centres_.empty() && x == side() / 2 && y == x)
    return &centres_[taker_.film().pixel(point.x >> bits_, point.y >> bits_)];
  const uint32_t index = slots_[slot(point)].index;
  return index == kNone ? nullptr : &between_[index];
}

void Lattice::grow() {
  std::vector<Slot> old(2 * slots_.size());
  old.swap(slots_);
  for (const Slot& each : old)
    if (each.index != kNone) slots_[slot(each.point)] = each;
}

void Lattice::forget_above(int pixel_y) {
  std::vector<Slot> old(slots_.size());
  old.swap(slots_);
  std::vector<PovColour> kept;
  for (const Slot& each : old) {
    if (each.index == kNone || each.point.y < pixel_y << bits_) continue;
    slots_[slot(each.point)] = {each.point, static_cast<uint32_t>(kept.size())};
    kept.push_back(between_[each.index]);
  }
  between_.assign(kept.begin(), kept.end());
}

bool Lattice::ask(std::vector<LatticePoint>& points) {
  const size_t before = between_.size();
  size_t fresh = 0;
  for (const LatticePoint point : points) {
    if (2 * (before + fresh + 1) > slots_.size()) grow();
    Slot& found = slots_[slot(point)];
    if (found.index != kNone) continue;
    found = {point, static_cast<uint32_t>(before + fresh)};
    points[fresh++] = point;
  }
  points.resize(fresh);
  between_.resize(before + fresh);
  const bool all = ask_many(
      taker_, fresh, [&](size_t i) { return request(points[i]); },
      [&](size_t i, const Sample& sample) { between_[before + i] = encode_(sample); });
  const int32_t mask = side() - 1;
  for (const LatticePoint point : points) {
    const bool upper = (point.y & mask) == 0, left = (point.x & mask) == 0;
    if (upper || left) borders_[border(point.x >> bits_, point.y >> bits_)] |= upper ? 1 : 2;
  }
  return all;
}

}  // namespace triad
