// SPDX-License-Identifier: Apache-2.0
// Memory for vector code and FFTs: always aligned alike, so that always the same instructions run on it.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>

namespace triad {

inline constexpr size_t kBufferAlignment_bytes = 64;  // one cache line, and the widest vector of x86-64

// A zeroed array of `size` numbers whose first element lies on a 64-byte boundary. Moves, does not copy.
// Throws std::bad_alloc, also where the size in bytes overflows.
template <class T>
class AlignedBuffer {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  AlignedBuffer() = default;
  explicit AlignedBuffer(size_t size) : size_(size) {
    if (size > std::numeric_limits<size_t>::max() / 2 / sizeof(T)) throw std::bad_alloc();
    // Rounded up to whole lines: a vector that holds the last element stays inside.
    const size_t bytes =
        (size * sizeof(T) + kBufferAlignment_bytes - 1) / kBufferAlignment_bytes * kBufferAlignment_bytes;
    data_.reset(static_cast<T*>(::operator new (bytes, std::align_val_t{kBufferAlignment_bytes})));
    std::uninitialized_value_construct_n(data_.get(), size);
  }

  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  size_t size() const { return size_; }
  T& operator[](size_t i) { return data_.get()[i]; }
  const T& operator[](size_t i) const { return data_.get()[i]; }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }

 private:
  struct Free {
    void operator()(T* p) const { ::operator delete (p, std::align_val_t{kBufferAlignment_bytes}); }
  };
  std::unique_ptr<T, Free> data_;
  size_t size_ = 0;
};

}  // namespace triad
