// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Results of many rays. New memory costs a page fault per 4 KiB, which takes longer than tracing some rays: large
 * arrays ask for pages of 2 MiB, as NumPy does for its own. Elements are not initialized, so that the threads that
 * write them are the first to touch them. */

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <sys/mman.h>
#include <type_traits>

namespace programs::python {

template<typename T>
class LargeArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

public:
  LargeArray() = default;

  /* Throws std::bad_alloc. */
  explicit LargeArray(size_t n) : memory(allocate(n * sizeof(T))), count(n) {}

  size_t size() const { return count; }
  T* data() { return static_cast<T*>(memory.get()); }
  const T* data() const { return static_cast<const T*>(memory.get()); }
  T* begin() { return data(); }
  const T* begin() const { return data(); }
  const T* end() const { return data() + count; }
  T& operator[](size_t i) { return data()[i]; }
  const T& operator[](size_t i) const { return data()[i]; }

private:
  static constexpr size_t largePage = size_t(1) << 21;

  static void* allocate(size_t bytes) {
    const size_t alignment = bytes >= 2 * largePage ? largePage : 64;
    const size_t rounded = (bytes + alignment) / alignment * alignment; // never 0
    void* const memory = std::aligned_alloc(alignment, rounded);
    if (!memory) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
    if (alignment == largePage) madvise(memory, rounded, MADV_HUGEPAGE); // otherwise it is only slower
#endif
    return memory;
  }

  struct Free {
    void operator()(void* memory) const { std::free(memory); }
  };

  std::unique_ptr<void, Free> memory;
  size_t count = 0;
};

} // namespace programs::python
