// SPDX-License-Identifier: Apache-2.0
// Memory for large arrays that are touched once from end to end.
#pragma once

#include <sys/mman.h>

#include <cstdlib>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>

namespace triad {

// An allocator for containers of pictures. Asks for pages of 2 MB where the system has them (Linux: transparent huge
// pages), which spares a 50 MB array 12,000 page faults of a microsecond each. Small arrays are as usual.
template <class T>
struct HugePageAllocator {
  using value_type = T;
  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}

  T* allocate(size_t n) {
    constexpr size_t kPage_bytes = size_t{1} << 21;
    if (n > std::numeric_limits<size_t>::max() / 2 / sizeof(T)) throw std::bad_alloc();
    const size_t bytes = n * sizeof(T);
    if (bytes < 2 * kPage_bytes) return allocated(std::malloc(bytes));
    void* memory = std::aligned_alloc(kPage_bytes, (bytes + kPage_bytes - 1) / kPage_bytes * kPage_bytes);
#ifdef MADV_HUGEPAGE
    if (memory) madvise(memory, bytes, MADV_HUGEPAGE);  // a wish: refused, nothing is lost
#endif
    return allocated(memory);
  }
  void deallocate(T* memory, size_t) { std::free(memory); }
  bool operator==(const HugePageAllocator&) const { return true; }

 private:
  static T* allocated(void* memory) {
    if (!memory) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
};

// The same for vectors whose elements begin as zero bytes: fresh pages are that already, and nobody clears them a
// second time. Only for a vector that is resized once, from empty: room that was used before is not cleared.
template <class T>
struct ZeroPageAllocator {
  static_assert(std::is_trivially_copyable_v<T>);
  using value_type = T;
  ZeroPageAllocator() = default;
  template <class U>
  ZeroPageAllocator(const ZeroPageAllocator<U>&) {}

  T* allocate(size_t n) {
    if (n > std::numeric_limits<size_t>::max() / 2 / sizeof(T)) throw std::bad_alloc();
    const size_t bytes = mapped_bytes(n);
    if (bytes == 0) {
      if (void* memory = std::calloc(n, sizeof(T))) return static_cast<T*>(memory);
      throw std::bad_alloc();
    }
    // Whole huge pages out of a longer piece; its ends go back.
    void* const piece =
        mmap(nullptr, bytes + kPage_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (piece == MAP_FAILED) throw std::bad_alloc();
    const size_t over = reinterpret_cast<uintptr_t>(piece) % kPage_bytes, head = over == 0 ? 0 : kPage_bytes - over;
    char* const memory = static_cast<char*>(piece) + head;
    if (head > 0) munmap(piece, head);
    if (head < kPage_bytes) munmap(memory + bytes, kPage_bytes - head);
#ifdef MADV_HUGEPAGE
    madvise(memory, bytes, MADV_HUGEPAGE);
#endif
    return reinterpret_cast<T*>(memory);
  }
  void deallocate(T* memory, size_t n) {
    if (const size_t bytes = mapped_bytes(n))
      munmap(memory, bytes);
    else
      std::free(memory);
  }
  template <class U>
  void construct(U*) {}  // zero bytes are its value
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
  }
  bool operator==(const ZeroPageAllocator&) const { return true; }

 private:
  static constexpr size_t kPage_bytes = size_t{1} << 21;
  // 0: few enough for the heap. What is left beyond whole huge pages is in small ones if it is less than half of one,
  // for which the system would have to clear all of it.
  static size_t mapped_bytes(size_t n) {
    constexpr size_t kSmall_bytes = size_t{1} << 16;  // a multiple of the pages of any system
    const size_t bytes = n * sizeof(T), unit = bytes % kPage_bytes < kPage_bytes / 2 ? kSmall_bytes : kPage_bytes;
    return bytes < kPage_bytes ? 0 : (bytes + unit - 1) / unit * unit;
  }
};

}  // namespace triad
