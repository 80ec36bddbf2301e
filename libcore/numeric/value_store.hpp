// SPDX-License-Identifier: Apache-2.0
// Numbers that are needed once more at the end: in memory while they are few, else in a temporary file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace triad {

// A heap of (value, weight) pairs, in no order. Thread-safe. The file lies in $TMPDIR, else /tmp, and has no name, so
// that nothing stays behind however the program ends. Its errors, a full disk among them, are Error(kInput) and say
// how many bytes are wanted.
class ValueStore {
 public:
  // weighted: each value has a weight, else none has. Up to keep_bytes stay in memory; values_expected is for
  // messages.
  ValueStore(bool weighted, uint64_t keep_bytes, uint64_t values_expected);
  ~ValueStore();

  struct Chunk {
    std::unique_ptr<uint32_t[]> values;
    std::unique_ptr<uint16_t[]> weights;  // none unless weighted
    size_t count = 0, capacity = 0;
  };
  static Chunk make_chunk(size_t capacity, bool weighted);
  // Takes the chunk over, or writes it and leaves its memory to be used again.
  void add(Chunk& chunk);

  uint64_t count() const { return count_; }
  bool spilled() const { return file_[0] >= 0; }
  // Calls use(values, weights or null, count) for all that `part` of `parts` holds, block by block; parts may be
  // visited at the same time, once all was added.
  void visit(int part, int parts, const std::function<void(const uint32_t*, const uint16_t*, size_t)>& use) const;

 private:
  void spill();
  void write(const Chunk& chunk, uint64_t at) const;

  const bool weighted_;
  const uint64_t keep_bytes_, expected_;
  std::mutex mutex_;
  std::vector<Chunk> chunks_;
  uint64_t held_bytes_ = 0, count_ = 0;
  int file_[2] = {-1, -1};  // values; weights
};

}  // namespace triad
