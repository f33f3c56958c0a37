// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Uses plain threads, because Embree's pool belongs to its devices. */

#include "basics/progress.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace programs {

/* Returns `requested`, or the number of hardware threads if `requested` is 0. */
inline unsigned threadCount(int requested) {
  return requested > 0 ? unsigned(requested) : std::max(1u, std::thread::hardware_concurrency());
}

/* Calls body(begin, end) for ranges of at most `chunk` > 0 indices that cover [0,n), in any order, on up to `threads`
 * threads including the calling one, fewer if the system refuses more. `body` must be thread-safe. Rethrows its first
 * exception. Throws Canceled after a cancellation. Leaves out ranges that have not begun by then. */
template<typename Body>
void parallelFor(size_t n, size_t chunk, unsigned threads, const Body& body) {
  const Cancellation* const cancellation = CancellationScope::current();
  std::atomic<size_t> next{0};
  std::exception_ptr failure;
  std::mutex mutex;
  auto work = [&] {
    const CancellationScope scope(cancellation);
    try {
      for (size_t begin; !cancelRequested() && (begin = next.fetch_add(chunk)) < n;)
        body(begin, std::min(begin + chunk, n));
    } catch (...) {
      std::lock_guard<std::mutex> lock(mutex);
      if (!failure) failure = std::current_exception();
      next = n;
    }
  };
  std::vector<std::thread> pool;
  try {
    for (unsigned i = 1; i < threads; i++) pool.emplace_back(work);
  } catch (const std::exception&) // a limit of the system
  {}
  work();
  for (std::thread& t : pool) t.join();
  if (failure) std::rethrow_exception(failure);
  throwIfCanceled();
}

} // namespace programs
