// SPDX-License-Identifier: Apache-2.0
// Large arrays that begin as zero bytes.
#pragma once

#include <cstddef>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>

namespace triad {

// Zero bytes, aligned for any type, of which large pieces lie in pages of 2 MB where the system has them. Fresh pages
// are zero already, and nobody clears them a second time. A piece of a few megabytes that is given back is kept for
// the next of its size: to clear it takes less than the system takes for fresh pages, which it clears, too, and maps
// and unmaps (up to 8 MB each, 32 MB in all, until the process ends); renders of one size after another have films of
// one size. Throws std::bad_alloc. Thread-safe.
void* take_zero_pages(size_t bytes);
// `bytes` as when it was taken.
void give_back_zero_pages(void* memory, size_t bytes) noexcept;

// An allocator for vectors whose elements begin as zero bytes. Only for a vector that is resized once, from empty:
// room that was used before is not cleared.
template <class T>
struct ZeroPageAllocator {
  static_assert(std::is_trivially_copyable_v<T>);
  using value_type = T;
  ZeroPageAllocator() = default;
  template <class U>
  ZeroPageAllocator(const ZeroPageAllocator<U>&) {}

  T* allocate(size_t n) {
    if (n > std::numeric_limits<size_t>::max() / 2 / sizeof(T)) throw std::bad_alloc();
    return static_cast<T*>(take_zero_pages(n * sizeof(T)));
  }
  void deallocate(T* memory, size_t n) { give_back_zero_pages(memory, n * sizeof(T)); }
  template <class U>
  void construct(U*) {}  // zero bytes are its value
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
  }
  bool operator==(const ZeroPageAllocator&) const { return true; }
};

}  // namespace triad
