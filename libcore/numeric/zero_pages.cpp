// SPDX-License-Identifier: Apache-2.0
#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <triad/numeric/zero_pages.hpp>
#include <vector>

namespace triad {
namespace {

constexpr size_t kHuge_bytes = size_t{1} << 21, kSmall_bytes = size_t{1} << 16;  // a multiple of any system's pages
// Of a piece that is kept: what caches hold is cleared soon, and of more the system clears pages on all threads,
// where they are first touched, sooner than one thread could. And in all.
constexpr size_t kMostEach_bytes = size_t{8} << 20, kMostKept_bytes = 4 * kMostEach_bytes;

// 0: few enough for the heap. What is left beyond whole huge pages is in small ones if it is less than half of one,
// for which the system would have to clear all of it.
size_t mapped_bytes(size_t bytes) {
  const size_t unit = bytes % kHuge_bytes < kHuge_bytes / 2 ? kSmall_bytes : kHuge_bytes;
  return bytes < kHuge_bytes ? 0 : (bytes + unit - 1) / unit * unit;
}

// Pieces that were given back. Never destroyed: films may outlive it.
class Kept {
 public:
  static Kept& instance() {
    static Kept* const kept = new Kept;
    return *kept;
  }
  // Null: there is none of that size. Not cleared.
  void* take(size_t bytes) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(pieces_.begin(), pieces_.end(), [&](const Piece& p) { return p.bytes == bytes; });
    if (found == pieces_.end()) return nullptr;
    void* const memory = found->memory;
    pieces_.erase(found);
    bytes_ -= bytes;
    return memory;
  }
  // False: it is too large.
  bool keep(void* memory, size_t bytes) noexcept {
    if (bytes > kMostEach_bytes) return false;
    const std::lock_guard lock(mutex_);
    while (bytes_ + bytes > kMostKept_bytes || pieces_.size() == kMost) {
      munmap(pieces_.front().memory, pieces_.front().bytes);
      bytes_ -= pieces_.front().bytes;
      pieces_.erase(pieces_.begin());
    }
    pieces_.push_back({memory, bytes});
    bytes_ += bytes;
    return true;
  }

 private:
  static constexpr size_t kMost = 16;
  struct Piece {
    void* memory;
    size_t bytes;
  };
  Kept() { pieces_.reserve(kMost); }
  std::mutex mutex_;
  std::vector<Piece> pieces_;
  size_t bytes_ = 0;
};

}  // namespace

void* take_zero_pages(size_t bytes) {
  const size_t mapped = mapped_bytes(bytes);
  if (mapped == 0) {
    if (void* memory = std::calloc(std::max<size_t>(1, bytes), 1)) return memory;
    throw std::bad_alloc();
  }
  if (void* const memory = Kept::instance().take(mapped)) {
    std::memset(memory, 0, bytes);
    return memory;
  }
  // Whole huge pages out of a longer piece; its ends go back.
  void* const piece = mmap(nullptr, mapped + kHuge_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (piece == MAP_FAILED) throw std::bad_alloc();
  const size_t over = reinterpret_cast<uintptr_t>(piece) % kHuge_bytes, head = over == 0 ? 0 : kHuge_bytes - over;
  char* const memory = static_cast<char*>(piece) + head;
  if (head > 0) munmap(piece, head);
  if (head < kHuge_bytes) munmap(memory + mapped, kHuge_bytes - head);
#ifdef MADV_HUGEPAGE
  madvise(memory, mapped, MADV_HUGEPAGE);  // a wish: refused, nothing is lost
#endif
  return memory;
}

void give_back_zero_pages(void* memory, size_t bytes) noexcept {
  const size_t mapped = mapped_bytes(bytes);
  if (mapped == 0)
    std::free(memory);
  else if (!Kept::instance().keep(memory, mapped))
    munmap(memory, mapped);
}

}  // namespace triad
