// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <triad/base/error.hpp>
#include <triad/base/text.hpp>
#include <triad/pipeline/edge.hpp>
#include <triad/pipeline/strip_buffer.hpp>

namespace triad {
namespace {
constexpr size_t kAlignment = 64;            // bytes: a cache line, and the widest vector
constexpr size_t kShelfBlocks = 64;          // more are given back to the system
constexpr uint32_t kExponent = 0x7f800000u;  // all ones: not finite (IEEE 754 binary32)

bool is_nonfinite(float value) { return (std::bit_cast<uint32_t>(value) & kExponent) == kExponent; }
}  // namespace

BufferPool::Shelf::~Shelf() {
  for (const auto& [size, block] : blocks) std::free(block);
}

std::shared_ptr<float> BufferPool::take(size_t floats) {
  // Sizes are rounded up to 64 KiB so that strips of nearly the same height share their blocks.
  const size_t bytes = (std::max<size_t>(floats, 1) * sizeof(float) + 0xffff) / 0x10000 * 0x10000;
  float* block = nullptr;
  {
    const std::lock_guard lock(shelf_->mutex);
    const auto found = std::find_if(shelf_->blocks.begin(), shelf_->blocks.end(),
                                    [&](const auto& entry) { return entry.first == bytes; });
    if (found != shelf_->blocks.end()) {
      block = found->second;
      shelf_->blocks.erase(found);
    }
  }
  if (!block) block = static_cast<float*>(std::aligned_alloc(kAlignment, bytes));
  if (!block) throw_input("out of memory: a strip of " + format_bytes(bytes) + " could not be had; try --max-memory");
  return {block, [shelf = std::weak_ptr<Shelf>(shelf_), bytes](float* done) {
            if (const auto held = shelf.lock()) {
              const std::lock_guard lock(held->mutex);
              if (held->blocks.size() < kShelfBlocks) {
                held->blocks.emplace_back(bytes, done);
                return;
              }
            }
            std::free(done);
          }};
}

void Pads::cover(const Pads& other) {
  left = std::max(left, other.left);
  right = std::max(right, other.right);
  top = std::max(top, other.top);
  bottom = std::max(bottom, other.bottom);
}

void RowRange::cover(RowRange other) {
  if (other.empty()) return;
  if (empty()) {
    *this = other;
    return;
  }
  y0 = std::min(y0, other.y0);
  y1 = std::max(y1, other.y1);
}

StripBuffer::StripBuffer(BufferPool& pool, RowRange rows, int width, int channels, const Pads& pads)
    : rows_(rows), width_(width), channels_(channels), pads_(pads) {
  stride_ = (static_cast<size_t>(pads.left) + width + pads.right) * channels;
  const size_t height = static_cast<size_t>(pads.top) + (rows.y1 - rows.y0) + pads.bottom;
  block_ = pool.take(stride_ * height);
  origin_ = block_.get() + pads.top * stride_ + static_cast<size_t>(pads.left) * channels;
}

uint64_t StripBuffer::bytes(RowRange rows, int width, int channels, const Pads& pads) {
  const uint64_t across = static_cast<uint64_t>(pads.left) + width + pads.right;
  const uint64_t down = static_cast<uint64_t>(pads.top) + std::max(0, rows.y1 - rows.y0) + pads.bottom;
  return across * down * channels * sizeof(float);
}

triad_strip StripBuffer::view(const triad_rect& r) const {
  triad_strip strip{};
  strip.struct_size = sizeof strip;
  strip.channels = channels_;
  strip.r = r;
  strip.data = row(r.y0) + static_cast<ptrdiff_t>(r.x0) * channels_;
  strip.row_bytes = static_cast<int64_t>(stride_ * sizeof(float));
  return strip;
}

RowRange row_hull(const triad_rect& need, int height, int edge) {
  RowRange hull{std::max(need.y0, 0), std::min(need.y1, height)};
  if (hull.y1 <= hull.y0) hull = {0, 0};
  const auto add = [&](int64_t y) {
    const int row = static_cast<int>(edge_index(edge, y, height));
    if (row >= 0) hull.cover({row, row + 1});
  };
  // Beyond one period the same rows come again.
  const int64_t period = 2 * static_cast<int64_t>(height);
  for (int64_t y = std::max<int64_t>(need.y0, -period); y < std::min(0, need.y1); ++y) add(y);
  for (int64_t y = std::max(height, need.y0); y < std::min<int64_t>(need.y1, height + period); ++y) add(y);
  if (hull.empty()) hull = {0, 1};  // a need wholly outside a zero edge still needs a buffer
  return hull;
}

Pads overhang(const triad_rect& need, int width, RowRange rows) {
  return {std::max(0, -need.x0), std::max(0, need.x1 - width), std::max(0, rows.y0 - need.y0),
          std::max(0, need.y1 - rows.y1)};
}

void fill_edges(StripBuffer& buffer, const triad_rect& need, int height, int edge) {
  const int channels = buffer.channels(), width = buffer.width();
  const size_t pixel = sizeof(float) * channels;
  const RowRange rows = buffer.rows();
  const auto fill = [&](int y, int x) {
    float* target = buffer.row(y) + static_cast<ptrdiff_t>(x) * channels;
    const int from = static_cast<int>(edge_index(edge, x, width));
    if (from < 0)
      std::memset(target, 0, pixel);
    else
      std::memcpy(target, buffer.row(y) + static_cast<ptrdiff_t>(from) * channels, pixel);
  };
  for (int y = std::max(rows.y0, need.y0); y < std::min(rows.y1, need.y1); ++y) {
    for (int x = need.x0; x < std::min(0, need.x1); ++x) fill(y, x);
    for (int x = std::max(width, need.x0); x < need.x1; ++x) fill(y, x);
  }
  // Whole rows, their side pads included, and so only after those: take the row that stands in and pad it too.
  const auto fill_row = [&](int y) {
    const int from = static_cast<int>(edge_index(edge, y, height));
    float* target = buffer.row(y) + static_cast<ptrdiff_t>(need.x0) * channels;
    if (from < rows.y0 || from >= rows.y1) {
      std::memset(target, 0, static_cast<size_t>(need.x1 - need.x0) * pixel);
      return;
    }
    if (from >= need.y0 && from < need.y1) {
      std::memcpy(target, buffer.row(from) + static_cast<ptrdiff_t>(need.x0) * channels,
                  static_cast<size_t>(need.x1 - need.x0) * pixel);
      return;
    }
    for (int x = need.x0; x < need.x1; ++x) {
      const int column = static_cast<int>(edge_index(edge, x, width));
      float* out = buffer.row(y) + static_cast<ptrdiff_t>(x) * channels;
      if (column < 0)
        std::memset(out, 0, pixel);
      else
        std::memcpy(out, buffer.row(from) + static_cast<ptrdiff_t>(column) * channels, pixel);
    }
  };
  for (int y = need.y0; y < std::min(need.y1, rows.y0); ++y) fill_row(y);
  for (int y = std::max(need.y0, rows.y1); y < need.y1; ++y) fill_row(y);
}

NonFinite& NonFinite::operator+=(const NonFinite& other) {
  nan += other.nan;
  inf += other.inf;
  return *this;
}

NonFinite count_nonfinite(const float* values, size_t count) {
  NonFinite found;
  // Most rows have none: look at whole blocks first, which compiles to a few vector instructions.
  constexpr size_t kBlock = 4096;
  for (size_t begin = 0; begin < count; begin += kBlock) {
    const size_t end = std::min(count, begin + kBlock);
    uint32_t any = 0;
    for (size_t i = begin; i < end; ++i) any |= is_nonfinite(values[i]) ? 1u : 0u;
    if (!any) continue;
    for (size_t i = begin; i < end; ++i) {
      if (!is_nonfinite(values[i])) continue;
      (values[i] != values[i] ? found.nan : found.inf) += 1;
    }
  }
  return found;
}

NonFinite zero_nonfinite(float* values, size_t count) {
  const NonFinite found = count_nonfinite(values, count);
  if (found.total())
    for (size_t i = 0; i < count; ++i)
      if (is_nonfinite(values[i])) values[i] = 0;
  return found;
}

}  // namespace triad
