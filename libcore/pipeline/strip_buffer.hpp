// SPDX-License-Identifier: Apache-2.0
// Rows of a picture on their way through a chain, with room for what the next stage wants to see beyond the
// picture's edges.
#pragma once

#include <triad/abi/triad_plugin.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace triad {

// Blocks of memory, 64-byte aligned, kept for the next strip: fresh pages cost more than the arithmetic of
// most stages. Thread-safe. Blocks may outlive their pool.
class BufferPool {
 public:
  // Uninitialised. Throws Error(kInput) when memory is short.
  std::shared_ptr<float> take(size_t floats);

 private:
  struct Shelf {
    std::mutex mutex;
    std::vector<std::pair<size_t, float*>> blocks;
    ~Shelf();
  };
  std::shared_ptr<Shelf> shelf_ = std::make_shared<Shelf>();
};

// Pixels beyond the picture that a buffer has room for, on each side.
struct Pads {
  int left = 0, right = 0, top = 0, bottom = 0;
  void cover(const Pads& other);
};

struct RowRange {
  int y0 = 0, y1 = 0;  // half open
  bool empty() const { return y1 <= y0; }
  void cover(RowRange other);  // the hull of both
  bool operator==(const RowRange&) const = default;
};

// Full-width rows [rows.y0, rows.y1) of a picture, interleaved float32.
class StripBuffer {
 public:
  StripBuffer() = default;
  StripBuffer(BufferPool& pool, RowRange rows, int width, int channels, const Pads& pads);

  RowRange rows() const { return rows_; }
  int width() const { return width_; }
  int channels() const { return channels_; }
  const Pads& pads() const { return pads_; }
  size_t stride() const { return stride_; }  // floats from a row to the next
  // Pixel 0 of row y; y may lie in the pads.
  float* row(int y) const {
    return origin_ + (static_cast<ptrdiff_t>(y) - rows_.y0) * static_cast<ptrdiff_t>(stride_);
  }
  explicit operator bool() const { return block_ != nullptr; }
  // Whether somebody else holds the same memory.
  bool shared() const { return block_.use_count() > 1; }
  void reset() { *this = StripBuffer(); }

  // The part `r`, which lies within rows and pads.
  triad_strip view(const triad_rect& r) const;

  static uint64_t bytes(RowRange rows, int width, int channels, const Pads& pads);

 private:
  std::shared_ptr<float> block_;
  float* origin_ = nullptr;
  RowRange rows_;
  int width_ = 0, channels_ = 0;
  size_t stride_ = 0;
  Pads pads_;
};

// The picture's rows that `need` refers to, overhang included, in a picture of `height` rows.
RowRange row_hull(const triad_rect& need, int height, int edge);
Pads overhang(const triad_rect& need, int width, RowRange rows);
// Fills what `need` has beyond the picture (beyond the buffer's rows and columns).
void fill_edges(StripBuffer& buffer, const triad_rect& need, int height, int edge);

// How many values are not numbers, and how many infinite.
struct NonFinite {
  uint64_t nan = 0, inf = 0;
  NonFinite& operator+=(const NonFinite& other);
  uint64_t total() const { return nan + inf; }
};
NonFinite count_nonfinite(const float* values, size_t count);
// Replaces them by 0.
NonFinite zero_nonfinite(float* values, size_t count);

}  // namespace triad
