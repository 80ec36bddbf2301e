// SPDX-License-Identifier: Apache-2.0
// Memory for large arrays that are touched once from end to end.
#pragma once

#include <sys/mman.h>

#include <cstdlib>
#include <limits>
#include <new>

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

}  // namespace triad
